"""The processor for which machine code is made, how it is made, and how it is called.

The way there is LLVM's: passes, then an object file, which is linked into the memory of this process and its entry
called with arrays.

Kernels are made by LLVM's O1 behind an inliner that puts functions called once in the place of their calls. Measured
for LM in lanes (AVX-512, LLVM 22, CPU seconds of passes + code): so 0.68 + 0.50, by O1 alone 0.97 + 0.52, by O2
1.19 + 0.53. The kernels run equally fast, with the same bits in 71 of 72: which product is fused depends on the
blocks that passes leave. Inlining only smaller functions, or passes over one function alone, would save a fifth to a
half of it, but changed the last places of motions with six laws; without unrolled loops sweeps take 3 to 8 % longer.
"""

import contextlib
import ctypes
import dataclasses
import functools
import itertools
import os
import re
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from vibrocap.arguments import SettingError
from vibrocap.numerics.compiler.kinds import FLOATS, INT, INTS, Kind

BUSY = threading.RLock()  # LLVM's options are those of the whole process
# First line of a text that is made by O1: quickly, put together; or small, for a page. Others take O2 as they are.
SHORT, SMALL = "; by few passes\n", "; small\n"
_FUNCTION = re.compile(r"^(define internal [^@\n]*(@[\w.]+)\([^\n]*)\{$", re.MULTILINE)
_CALL = re.compile(r"call [^@\n]*(@[\w.]+)\(")
ENTRY = "kernel_entry"
TYPES = {FLOATS: np.dtype(np.float64), INTS: np.dtype(np.int64)}
NUMBERS = itertools.count()
NAMED = ("VIBROCAP_CPU_NAME", "VIBROCAP_CPU_FEATURES")
# Makes an object file for a triple, a processor and its features.
TRIAL = """
import sys
import llvmlite.binding as llvm
llvm.initialize_native_target()
llvm.initialize_native_asmprinter()
triple, processor, features = sys.argv[1:]
machine = llvm.Target.from_triple(triple).create_target_machine(cpu=processor, features=features)
machine.emit_object(llvm.parse_assembly("define void @nothing() { ret void }"))
"""
LINKER: list[Any] = []


@dataclasses.dataclass(frozen=True)
class Target:
    """What machine code is made for."""

    triple: str
    processor: str
    features: str

    @property
    def lanes(self) -> int:
        """8 where registers hold eight doubles (AVX-512), else 4."""
        return 8 if "+avx512f" in self.features.split(",") else 4

    @property
    def name(self) -> str:
        """All that decides which machine code is made, LLVM's version included."""
        version = ".".join(str(part) for part in llvm.llvm_version_info)
        return f"{self.triple} {self.processor} {self.features} LLVM {version} llvmlite {_llvmlite_version()}"


def _llvmlite_version() -> str:
    import llvmlite

    return llvmlite.__version__


@functools.cache
def host() -> Target:
    """This computer, or what VIBROCAP_CPU_NAME and VIBROCAP_CPU_FEATURES say of it.

    Raises SettingError for a processor, or features, for which LLVM makes no code as they are written. It says so on
    stderr alone, and may end the process, so it is asked in another one (60 ms).
    """
    settings = {name: value for name in NAMED if (value := os.environ.get(name)) is not None}
    name, features = (settings.get(setting) for setting in NAMED)
    if features is None:
        features = "" if name else llvm.get_host_cpu_features().flatten()
    target = Target(llvm.get_process_triple(), name or llvm.get_host_cpu_name(), features)
    if settings:
        command = [sys.executable, "-P", "-c", TRIAL, target.triple, target.processor, features]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode or done.stderr:
            setting = " and ".join(f"{name}={value}" for name, value in settings.items())
            reason = (done.stderr.splitlines() or ["it makes no code"])[0]
            raise SettingError(setting, f"should name a processor in LLVM's words, such as haswell; LLVM: {reason}")
    return target


def code_made_for() -> dict[str, str]:
    """What decides, beside its text, which machine code a kernel becomes here: the processor and LLVM."""
    target = host()
    there = sorted(feature[1:] for feature in target.features.split(",") if feature.startswith("+"))
    version = ".".join(str(part) for part in llvm.llvm_version_info)
    return {
        "processor": f"{target.processor} ({target.triple})",
        "features": " ".join(there),
        "llvm": f"{version} of llvmlite {_llvmlite_version()}",
    }


@functools.cache
def _initialised(all_targets: bool) -> None:
    if all_targets:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    else:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()


def _machine(target: Target) -> Any:
    """LLVM's target machine."""
    _initialised(target.triple != llvm.get_process_triple())
    kind = llvm.Target.from_triple(target.triple)
    reloc = "static" if target.triple.startswith("wasm") else "pic"  # a module's memory begins at 0
    return kind.create_target_machine(
        cpu=target.processor, features=target.features, opt=3, reloc=reloc, codemodel="default"
    )


@contextlib.contextmanager
def instructions_in_the_order_written() -> Iterator[None]:
    """Within this context LLVM leaves the instructions of a block in the order of the source.

    The series are written in an order in which few numbers wait; LLVM's scheduler of machine instructions, which counts
    latencies, makes more of them wait, in memory, and the series cost an eighth more. LLVM knows this as an option of
    the whole process only, so it is set for as long as machine code is made, by one thread at a time.
    """
    with BUSY:
        llvm.set_option("", "-enable-misched=false")
        try:
            yield
        finally:
            llvm.set_option("", "-enable-misched=true")  # as without


def optimised(text: str, target: Target) -> tuple[Any, Any]:
    """(module, machine): LLVM's text after all passes. To be called within `instructions_in_the_order_written`."""
    machine = _machine(target)
    head = f'target datalayout = "{machine.target_data}"\ntarget triple = "{target.triple}"\n'
    short, small = text.startswith(SHORT), text.startswith(SMALL)
    module = llvm.parse_assembly(head + (called_once_marked(text) if short else text), llvm.create_context())
    options = llvm.create_pipeline_tuning_options(speed_level=1 if short or small else 2)
    options.loop_vectorization = True
    options.slp_vectorization = False
    if small:
        options.loop_vectorization, options.inlining_threshold = False, 0
    builder = llvm.create_pass_builder(machine, options)
    if short:
        first = llvm.create_new_module_pass_manager()
        first.add_always_inliner_pass()
        first.add_global_dead_code_eliminate_pass()
        first.run(module, builder)
    passes = builder.getModulePassManager()
    passes.run(module, builder)
    return module, machine


def called_once_marked(text: str) -> str:
    """The same, in which functions called once are marked to be put in the place of their call."""
    calls = Counter(_CALL.findall(text))

    def marked(match: re.Match[str]) -> str:
        if match[2].startswith("@slow_jet_"):  # long, and asked for by few motions
            return f"{match[1]}noinline optsize {{"
        alone = calls[match[2]] == 1 and "noinline" not in match[1]
        return f"{match[1]}alwaysinline {{" if alone else match[0]

    return _FUNCTION.sub(marked, text)


def object_code(text: str, target: Target) -> bytes:
    """The object file of a module in LLVM's language."""
    with instructions_in_the_order_written():
        module, machine = optimised(text, target)
        return machine.emit_object(module)


def assembly(text: str, target: Target) -> str:
    """The same as text in the language of the processor's assembler."""
    with instructions_in_the_order_written():
        module, machine = optimised(text, target)
        return machine.emit_assembly(module)


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
