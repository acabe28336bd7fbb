"""Machine code in this process: an object file is linked into memory, and its entry called with arrays."""

import ctypes
import functools
import itertools
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from vibrocap.numerics.compiler.kinds import FLOATS, INT, INTS, Kind
from vibrocap.numerics.compiler.machine import BUSY, _initialised

ENTRY = "kernel_entry"
TYPES = {FLOATS: np.dtype(np.float64), INTS: np.dtype(np.int64)}
NUMBERS = itertools.count()
LINKER: list[Any] = []


class NoObject(ValueError):
    """What should be an object file of a kernel and is none, or none for this computer."""


class Compiled:
    """A compiled kernel. It is called like the plain one, by any number of threads at once, which all run meanwhile.

    The code stays in memory as long as this object lives. Raises NoObject for code that cannot be linked.
    """

    def __init__(self, code: bytes, arguments: tuple[Kind, ...] = (FLOATS, INTS, FLOATS, INT)):
        with BUSY:
            if not LINKER:
                _initialised(False)
                LINKER.append(llvm.create_lljit_compiler())
            name = f"kernel_{next(NUMBERS)}"
            library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process().export_symbol(ENTRY)
            try:
                self._tracker = library.link(LINKER[0], name)
                address = self._tracker[ENTRY]
            except (RuntimeError, KeyError) as error:
                raise NoObject(f"is no object file of a kernel: {error}") from None
        kinds = [ctypes.c_void_p if kind in TYPES else ctypes.c_int64 for kind in arguments]
        self._call = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds)(address)
        self._types = tuple(TYPES.get(kind) for kind in arguments)

    def __call__(self, *arguments: Any) -> int:
        if len(arguments) != len(self._types):
            raise TypeError(f"a kernel takes {len(self._types)} arguments, not {len(arguments)}")
        return self._call(*map(_passed, arguments, self._types))

    def bound_to(self, *arrays: np.ndarray) -> Callable[[int], int]:
        """The same with its arrays given, which must live as long: a call then takes its last argument alone."""
        return functools.partial(self._call, *map(_passed, arrays, self._types))


def _passed(argument: Any, kind: np.dtype | None) -> int:
    """An int, or the address of an array."""
    if kind is None:
        return int(argument)
    if argument.dtype != kind or not argument.flags.c_contiguous or argument.ndim != 1:
        raise TypeError(f"a kernel takes flat arrays of {kind}, not {argument.ndim}-D {argument.dtype}")
    return argument.__array_interface__["data"][0]
