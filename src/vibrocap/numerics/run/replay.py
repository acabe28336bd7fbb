"""Replays a stored motion through the hooks of an ensemble: what is measured then is measured by the same code."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.codegen.source import Integrands
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import plain_kernel
from vibrocap.numerics.run.budget import Budget, EnsembleStart, MotionStart, prepared_memory
from vibrocap.numerics.run.ensemble import ensemble_source
from vibrocap.numerics.run.results import RunResults


def replayed(
    equations: Equations,
    parameters: Sequence[float],
    motion: Any,
    budget: Budget,
    integrands: Integrands | None = None,
    switch_times: Sequence[np.ndarray] = (),
) -> RunResults:
    """The result of a motion, as an ensemble with this budget, of its whole periods, would have written it.

    motion: a `Trajectory`
    switch_times: when each guard of the machine fell to zero
    """
    layout, kernel = _hooks(equations, motion.series.order, integrands)
    start = MotionStart(equations, parameters, motion.sections[0], motion.period)
    tables = EnsembleStart(equations, np.array([parameters]), motion.sections[:1]).tables
    trace = np.concatenate((np.zeros(layout.result_size), tables.ravel()))
    place, states, length = layout.places, layout.states, layout.order + 1
    floats, ints = prepared_memory(
        layout,
        budget,
        STATUS=codes.DONE,
        **start.entries,
        WHOLE_PERIODS=int(budget.periods),
        TABLE_START=layout.result_size,
        SEGMENT_COUNT=tables.shape[1],
    )
    kernel["begin_drive"](floats, ints, trace, 0, 0)
    kernel["on_period"](floats, ints, trace, 0)
    methods = motion.piece_implicit.astype(int).tolist()
    jumps = [*motion.piece_jumps, 0.0] if equations.impact >= 0 else [0.0] * len(methods)  # at the end of each piece
    lengths, sides = motion.piece_length.tolist(), motion.piece_sides
    pieces = enumerate(zip(lengths, sides, methods, jumps, motion.series[:], strict=True))
    doubtful = _near_lift_off(motion, tuple(equations.true_loads)) if layout.watched else np.empty((0, 0))
    count, last, time, until = place["PERIOD_COUNT"], place["WHOLE_PERIODS"], place["TIME"], kernel["UNTIL"]
    while ints[count] < ints[last]:
        number, (h, side, method, jump, coefficients) = next(pieces)
        layout.put(floats, ints, {"SIDE": side})
        ints[place["STIFF"]] = method
        if ints[place["WINDOW_START"]] >= 0:
            layout.put(floats, ints, {"SERIES": coefficients[:states, :length].ravel()})
            kernel["on_piece"](floats, ints, trace, 0, h)
            for load in range(layout.watched):
                if doubtful[load, number]:
                    kernel["look_at_load"](floats, ints, 0, load, h)
        if jump != 0.0:
            kernel["on_jump"](floats, ints, 0, jump)
        remaining = floats[until] - floats[time]
        floats[time] += h
        near = remaining - h <= 2.0 * EPSILON * motion.period  # as in `one_step.next_mode`
        if near and not kernel["at_corner"](floats, ints, trace, 0):
            ints[count] += 1
            floats[time] = 0.0
            layout.put(floats, ints, {"STATE": motion.sections[ints[count]]})
            kernel["begin_drive_period"](floats, ints, trace, 0)
            kernel["on_period"](floats, ints, trace, 0)
    if "OCCURRED" in place:
        since = motion.start_time + ints[place["WINDOW_START"]] * motion.period
        layout.put(floats, ints, {"OCCURRED": [np.sum(times > since) for times in switch_times]})
    kernel["end_run"](floats, ints, trace, 0)
    return RunResults(layout, trace[None, : layout.result_size])


def _near_lift_off(motion: Any, names: tuple[str, ...]) -> np.ndarray:
    """[loads, pieces] where a true load, seen at a few points, is not farther from zero than it changes there."""
    index = np.arange(len(motion.piece_length))
    shares = np.linspace(0.0, 1.0, 5)
    loads = [motion.piece_observables(names, index, share * motion.piece_length) for share in shares]
    return np.min(loads, axis=0) <= np.ptp(loads, axis=0)


@functools.lru_cache(maxsize=16)
def _hooks(equations: Equations, order: int, integrands: Integrands | None) -> tuple[Layout, dict[str, Any]]:
    layout, text = ensemble_source(equations, order, 1, integrands)
    names = plain_kernel(text)
    names["VELOCITY_JUMPS"] = False  # the side of the contact is that of the stored pieces
    return layout, names
