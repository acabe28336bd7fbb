"""One motion as C: the functions of its kernel, and the memory with which it begins."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.compiler import c_source
from vibrocap.numerics.kernel.memory_layout import EVENT_HEAD, PIECE_HEAD, Layout
from vibrocap.numerics.run.motion import begun_memory, linked_motion, series_order

PIECES, EVENTS = 64, 64  # that the trace holds; when it is full, the caller reads and clears it


@dataclasses.dataclass(frozen=True)
class ExportedMotion:
    """The C of a kernel and what it is given.

    text: of `PREFIX_advance(floats, ints, trace, steps)`, see `compiler/c_text.py`
    floats, ints, trace: the memory at the start, as `Layout` says
    """

    layout: Layout
    text: str
    floats: np.ndarray
    ints: np.ndarray
    trace: np.ndarray

    @property
    def constants(self) -> dict[str, int]:
        """Places and sizes of the memory, by name; PIECE_HEAD and EVENT_HEAD are numbers before series and states."""
        return {**self.layout.constants(), "PIECE_HEAD": PIECE_HEAD, "EVENT_HEAD": EVENT_HEAD}


def exported_motion(
    equations: Any,
    parameters: Sequence[float],
    initial: Sequence[float],
    period: float,
    periods: float,
    tolerance: float,
    max_events_per_period: int,
    max_steps: int,
    prefix: str,
) -> ExportedMotion:
    """The motion of `recorded_run(..., literal=True)` as C; all names begin with `prefix`."""
    layout, text = linked_motion(equations, series_order(tolerance))
    text.check()
    limits, room = (max_events_per_period, max_steps), (PIECES, EVENTS)
    memory = begun_memory(equations, layout, parameters, initial, period, periods, tolerance, limits, room)
    written = layout.rows  # of the trace: the states at the start, and the table of a drive at its end
    memory[2][written : int(memory[1][layout.places["TABLE"]])] = 0.0
    return ExportedMotion(layout, c_source(text, "advance", prefix), *memory)
