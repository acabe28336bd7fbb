"""simulate(system, ...) -> Trajectory: the bridge from physics to numerics."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number, shown, suggestion
from vibrocap.motion.certificate import Certificate
from vibrocap.motion.equations import equations, parameter_values
from vibrocap.motion.evidence import certificate
from vibrocap.motion.trajectory import Status, Trajectory
from vibrocap.numerics.api import Recorded, memory, recorded_run
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.physics.system import BOUNDS, System
from vibrocap.physics.units import state_keys

SHORTEST = 1e-9  # drive periods of a run: shorter ones are rounding

# By the numbers of `memory_layout`.
EVENT_KINDS = np.array(["stick", "slip_forward", "slip_back", "reversal", "graze", "switch", *BOUNDS])
STATUSES = {
    memory.DONE: Status.FINISHED,
    memory.STEP_UNDERFLOW: Status.STEP_UNDERFLOW,
    memory.NOT_FINITE: Status.NOT_FINITE,
    memory.TOO_MANY_EVENTS: Status.TOO_MANY_EVENTS,
    memory.UNDECIDED: Status.UNDECIDED_CONTACT,
    memory.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
    **{memory.BEYOND_BOUND + i: Status(kind.replace("_", " ")) for i, kind in enumerate(BOUNDS)},
}
METHOD = 4  # place of the method among the numbers of a piece: 0 of a Taylor step, 1 of an implicit one
COMPANION = 10.0  # the second run of the error estimate has this many times the tolerance


def simulate(
    system: System,
    *,
    periods: float = 40,
    initial: Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
    max_events_per_period: int = 10_000,
    max_steps: int = 50_000_000,
    samples: int = 256,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """The motion of a system over so many drive periods, with the sticking contact solved exactly.

    Each step is a Taylor series (an implicit step where the law is stiff), and the roots of these polynomials are the
    events: no step crosses a change between sticking and sliding.

    periods: drive periods, a positive number, not necessarily whole
    initial: initial states by name, with a unit in it where they are in SI; what is not named starts at zero
    tolerance: error per step, relative to the natural size of each state (1e-14 to 1e-2)
    samples: points per period of the grid `motion.time`; the motion itself is known at every instant
    progress: called now and then with the share done

    Returns the motion; where it could not be completed, its status says why, and it holds what was computed.
    Raises ValueError or TypeError, naming the argument, before any work.
    """
    start = initial_state(system, initial)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    recorded = _run(system, start, periods, tolerance, max_events_per_period, max_steps, progress=progress)
    return _trajectory(system, start, periods, tolerance, max_events_per_period, max_steps, samples, recorded)


def period_marks(
    system: System,
    *,
    periods: int,
    initial: Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
    max_events_per_period: int = 10_000,
    max_steps: int = 50_000_000,
) -> tuple[Status, np.ndarray]:
    """(status, states at the start of every period and at the end [periods + 1, states]) of a long motion.

    Nothing else of it is kept, so that a hundred thousand periods cost little memory. The arguments are those of
    `simulate`; where the motion could not be completed there are fewer marks.
    """
    start = initial_state(system, initial)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    found = _run(system, start, periods, tolerance, max_events_per_period, max_steps, keep_pieces=False)
    return STATUSES[found.status], found.sections


def initial_state(system: System, initial: Mapping[str, float] | None) -> dict[str, float]:
    """All initial states by name; ArgumentError for a state that does not exist or is not a finite number.

    A name with a unit, "position_m", is a state of a system that knows its scales.
    """
    start = dict.fromkeys(system.state_names, 0.0)
    keys = {} if system.units is None else state_keys(system.si.states)
    for name, value in (initial or {}).items():
        if name not in start and name not in keys:
            near = suggestion(name, [*start, *keys], cutoff=0.0)
            raise ArgumentError(f"initial.{name}", f"no such state; {near} States: {', '.join(start)}")
        if isinstance(value, (bool, str)) or not math.isfinite(value):
            raise ArgumentError(f"initial.{name}", f"should be a finite number, got {value!r}")
        if name in start:
            start[name] = float(value)
        else:
            start[keys[name].name] = float(value) / system.si.per_key(keys[name])
    return start


def check_run(*, periods: Any, tolerance: Any, max_events_per_period: Any, max_steps: Any) -> None:
    """ArgumentError for run settings that make no sense."""
    for name, value, low, high in (
        ("periods", periods, SHORTEST, 1e9),
        ("tolerance", tolerance, 1e-14, 1e-2),
    ):
        if not is_number(value) or not (low <= value <= high):
            wanted = "a positive number" if name == "periods" else f"a number from {low:g} to {high:g}"
            wanted += f", at least {low:g}" if name == "periods" and is_number(value) and 0 < value < low else ""
            raise ArgumentError(name, f"should be {wanted}, got {shown(value)}")
    check_whole("max_events_per_period", max_events_per_period, 1, 2**62 - 1)
    check_whole("max_steps", max_steps, 1, 2**62 - 1)


def _run(system, start, periods, tolerance, max_events, max_steps, progress=None, keep_pieces=True) -> Recorded:
    return recorded_run(
        equations(system),
        parameter_values(system),
        list(start.values()),
        system.drive.period,
        periods,
        tolerance,
        max_events,
        max_steps,
        progress=progress,
        keep_pieces=keep_pieces,
    )


def _trajectory(system, start, periods, tolerance, max_events, max_steps, samples, recorded) -> Trajectory:
    recording = equations(system)
    states = len(recording.rates)
    period = system.drive.period
    parameters = parameter_values(system)
    pieces, head = recorded.pieces, memory.PIECE_HEAD
    integral_names = (*(f"{name}_work" for name in system.channels), "impulse")
    known = recording.observables | dict(zip(integral_names, recording.integrals, strict=True))

    def observe(names, t, values, side):
        local = t - period * np.floor(t / period)
        expressions = [known[name] for name in names]
        found = evaluate(expressions, local, values, side, parameters)
        return [np.broadcast_to(np.asarray(value, dtype=float), t.shape) for value in found]

    def certify(motion: Trajectory) -> Certificate:
        loose = _run(system, start, periods, min(COMPANION * tolerance, 0.05), max_events, max_steps, keep_pieces=False)
        return certificate(motion, recorded, loose, COMPANION)

    return Trajectory(
        system=system,
        initial=start,
        periods=periods,
        tolerance=tolerance,
        period=period,
        run_status=STATUSES[recorded.status],
        state_names=system.state_names,
        integral_names=integral_names,
        piece_start=pieces[:, 0] * period + pieces[:, 1],
        piece_length=pieces[:, 2],
        piece_side=pieces[:, 3],
        piece_implicit=pieces[:, METHOD] == 1.0,
        coefficients=pieces[:, head:].reshape(len(pieces), states, (pieces.shape[1] - head) // states),
        sections=recorded.sections,
        event_times=recorded.events[:, 0] * period + recorded.events[:, 1],
        event_kinds=EVENT_KINDS[recorded.events[:, 2].astype(int)],
        event_states=recorded.events[:, memory.EVENT_HEAD :],
        observe=observe,
        observable_names=tuple(recording.observables),
        certify=certify,
        samples=samples,
    )
