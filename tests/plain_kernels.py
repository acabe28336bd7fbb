"""Kernels as plain Python, for tests that call or replace their functions, and for motions too short to compile."""

import contextlib
import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import numpy as np

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.codegen.source import generated_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.numerics.expressions.structure import traits
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import Linked, compiled_kernel, entry_of, linked_source, motion_recipe, plain_kernel
from vibrocap.numerics.run import driven_run, ensemble, motion, stepper, stored_motion


@dataclasses.dataclass(frozen=True)
class PlainKernel:
    """The functions of a linked kernel by name, its layout, and the memory of its lanes."""

    names: dict[str, Any]
    layout: Layout
    equations: Equations
    text: str
    floats: np.ndarray
    ints: np.ndarray

    def __getitem__(self, name: str) -> Any:
        return self.names[name]

    def place(self, name: str, lane: int = 0) -> int:
        """Where an entry of a lane begins."""
        return self.names[name] + lane

    def series(self, row: int, lane: int = 0) -> np.ndarray:
        """Taylor coefficients of one row of a lane."""
        lanes, length = self.layout.lanes, self.layout.order + 1
        start = self.names["SERIES"] + row * length * lanes + lane
        return self.floats[start : start + length * lanes : lanes]

    def fill(self, entry: str, values: Any, lane: int = 0) -> None:
        """Put numbers into an entry of a lane."""
        start, lanes = self.names[entry] + lane, self.layout.lanes
        for i, value in enumerate(np.atleast_1d(values)):
            (self.ints if entry in INT_ENTRIES else self.floats)[start + i * lanes] = value


INT_ENTRIES = frozenset(motion.memory.INT_ENTRIES)


def kernel_of(system: vc.System, order: int = 12, lanes: int = 1) -> PlainKernel:
    """The kernel of a system, with the parameters of the system in every lane."""
    recorded = equations(system)
    has = dataclasses.replace(traits(recorded), coefficients=0, slow=())
    layout = Layout(**vars(has), lanes=lanes, order=order)
    text = linked_source(generated_source(recorded, layout), motion_recipe(layout))
    kernel = PlainKernel(plain_kernel(text), layout, recorded, text, *layout.allocated())
    for lane in range(lanes):
        set_lane(kernel, system, lane)
    return kernel


def set_lane(kernel: PlainKernel, system: vc.System, lane: int) -> None:
    """Give a lane the parameters and scales of a system of the kernel's form."""
    parameters = parameter_values(system)
    kernel.fill("PARAMETER", parameters, lane)
    kernel.fill("SCALE", evaluate(kernel.equations.scales, 0.0, [], 1.0, parameters), lane)
    kernel["forget"](kernel.floats, lane)
    kernel.fill("PERIOD", system.drive.period, lane)


@contextlib.contextmanager
def running_on(kernel: PlainKernel, **replaced: Callable) -> Iterator[None]:
    """Within this context `simulate` runs on the plain kernel, with some of its functions replaced."""
    originals = {name: kernel.names[name] for name in replaced}
    kernel.names.update(replaced)
    try:
        entry = (kernel.layout, kernel["advance"])
        with (
            mock.patch.object(motion, "kernel", return_value=entry),
            mock.patch.object(motion, "series_order", return_value=kernel.layout.order),
        ):
            yield
    finally:
        kernel.names.update(originals)


class EitherKernel:
    """A kernel in two forms: plain Python in tests marked `plain`, whatever ran before, and compiled in all others.

    text: writes it; compiled: makes the machine code of a text, when the first test that is not so marked asks
    """

    plain = False  # whether a test marked `plain` runs now

    def __init__(self, text: Callable[[], Linked], entry: str, compiled: Callable[[Callable[[], Linked]], Callable]):
        self._text, self._entry, self._make = functools.cache(text), entry, compiled
        if not EitherKernel.plain:
            self._compiled = compiled(self._text)

    @functools.cached_property
    def _plain(self) -> Callable:
        return plain_kernel(self._text())[self._entry or entry_of(self._text())]

    @functools.cached_property
    def _compiled(self) -> Callable:
        return self._make(self._text)

    def __call__(self, *arguments: Any) -> int:
        if not EitherKernel.plain:
            return self._compiled(*arguments)
        with np.errstate(all="ignore"):  # as machine code does
            return self._plain(*arguments)

    def bound_to(self, *arrays: np.ndarray) -> Callable[[int], int]:
        return functools.partial(self, *arrays) if EitherKernel.plain else self._compiled.bound_to(*arrays)


def in_either_form(patch: Any) -> None:
    """From now on motions, ensembles, steppers and laws under a motion run on `EitherKernel`."""
    kept = motion.kept_kernel

    def kernel(text: Linked, literal: bool = False, entry: str = "") -> EitherKernel:
        return EitherKernel(lambda: text, entry, lambda text: compiled_kernel(text(), literal, entry))

    def kernel_of_records(text: Callable[[], Linked], *records: Any, literal: bool = False) -> EitherKernel:
        return EitherKernel(text, "", lambda text: kept(text, *records, literal=literal))

    for module in (motion, ensemble):
        patch.setattr(module, "kept_kernel", kernel_of_records)
    for module in (driven_run, stepper, stored_motion):
        patch.setattr(module, "compiled_kernel", kernel)
