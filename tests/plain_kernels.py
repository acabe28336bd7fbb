"""A kernel as plain Python, for tests that call its functions one by one, replace one, or run it with fixed steps."""

import contextlib
import dataclasses
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
from vibrocap.numerics.linker import linked_source, motion_recipe, plain_kernel
from vibrocap.numerics.run import motion


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
