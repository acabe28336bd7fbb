"""simulate(system, ...) -> Trajectory: the bridge from physics to numerics."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number, shown, suggestion
from vibrocap.motion.equations import Equations, equations, parameter_values
from vibrocap.motion.trajectory import Certificate, Status, Trajectory
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
POINTS = 9  # per piece at which a certificate looks
METHOD = 4  # place of the method among the numbers of a piece: 0 of a Taylor step, 1 of an implicit one
FINE = 65  # points per piece among which the slowest is looked for
PIECES_AT_A_TIME = 1000
# What a step leaves of the equations, over the tolerance: at most 500 in motions of all laws at tolerances from 1e-4 to
# 1e-14, from 1e3 to 1e5 where a law was stepped over. Below LEAST_DEFECT rounding decides.
DEFECT_BOUND, LEAST_DEFECT = 1e3, 1e-13
STICK_SLACK = 1e-9  # of the limit; a hold is left where its force is at the limit to rounding
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
        scales = np.asarray(evaluate(recording.scales, 0.0, [], 1.0, parameters), float)
        return _certificate(motion, recorded, loose, scales, _defect(motion, recorded, recording, parameters, scales))

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


def _certificate(
    motion: Trajectory, recorded: Recorded, loose: Recorded, scales: np.ndarray, defect: float
) -> Certificate:
    """Evidence for a motion, from points within every piece and from a second, looser run."""
    if not len(motion.piece_start):
        return Certificate(None, 0.0, True, 0.0, 0.0, 0.0, None, 0, 0, 0.0)
    share = np.linspace(0.0, 1.0, POINTS)
    index = np.repeat(np.arange(len(motion.piece_start)), POINTS)
    s = np.tile(share, len(motion.piece_start)) * motion.piece_length[index]
    side = motion.piece_side[index]
    names = ("contact_velocity", "friction", "energy", "contact_energy", "momentum")
    velocity, friction, energy, contact_energy, momentum = motion.piece_observables(names, index, s)
    marks = motion.piece_marks  # integrals at the start of every piece and at the end
    stored = _at_marks(energy + contact_energy)
    balance = stored - stored[0] - marks[:-1].sum(axis=0)
    if motion.system.friction.switched:  # energy that was stored in the contact is lost where a piece begins unloaded
        before, after = (energy + contact_energy)[POINTS - 1 :: POINTS][:-1], stored[1:-1]
        balance[1:] -= np.cumsum(np.append(after - before, 0.0))
    impulse = _at_marks(momentum) - momentum[0] + marks[-1] - _outer_impulse(motion)
    stuck = side == 0
    ratio = None
    if motion.system.friction.kind == "set-valued":
        if motion.system.machine.follows_load:
            limit, middle = motion.piece_observables(("holding_limit", "holding_middle"), index[stuck], s[stuck])
        else:
            load = motion.system.machine.load()
            limit, middle = motion.system.friction.holding_limit(load), motion.system.friction.holding_middle(load)
        force, limit = np.abs(friction[stuck] - middle), np.broadcast_to(limit, friction[stuck].shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = float(np.max(np.where(force == 0.0, 0.0, force / limit), initial=0.0))
    least = float(np.min((side * velocity)[~stuck], initial=0.0))
    slack = 64 * np.finfo(float).eps * max(1.0, float(np.max(np.abs(velocity), initial=0.0)))
    failures = []
    bound = DEFECT_BOUND * max(motion.tolerance, LEAST_DEFECT)
    if not defect <= bound:
        failures.append(f"the equations are left by {defect:.1e} within a step, where {bound:.1e} is the bound")
    if ratio is not None and not ratio <= 1.0 + STICK_SLACK:
        failures.append(f"the stuck contact carries {ratio:.9g} times what it can hold")
    if motion.system.friction.kind != "smooth" and not least >= -slack:
        failures.append(f"the velocity passes rest by {-least:.1e} without an event")
    return Certificate(
        stick_force_ratio=ratio,
        event_velocity=recorded.contact_residual,
        sign_kept=least >= -slack,
        least_velocity=least,
        energy_residual=float(np.max(np.abs(balance), initial=0.0)),
        momentum_residual=float(np.max(np.abs(impulse), initial=0.0)),
        estimated_error=_estimated_error(recorded, loose, scales),
        taylor_steps=recorded.taylor_steps,
        implicit_steps=recorded.implicit_steps,
        defect=defect,
        failures=tuple(failures),
    )


def _defect(
    motion: Trajectory, recorded: Recorded, recording: Equations, parameters: Sequence[float], scales: np.ndarray
) -> float:
    """Largest h |y' - f(t, y)| over the natural size of a state, of all Taylor steps.

    Nine points of every step, and five more about the slowest of a finer grid: friction changes most near rest.
    """
    worst = 0.0
    taylor = np.flatnonzero(recorded.pieces[:, METHOD] == 0.0)
    fine = np.linspace(0.0, 1.0, FINE)
    for first in range(0, len(taylor), PIECES_AT_A_TIME):
        pieces = taylor[first : first + PIECES_AT_A_TIME]
        h = motion.piece_length[pieces]
        grid = (fine * h[:, None]).ravel()
        speed = np.abs(motion.piece_observables(("contact_velocity",), np.repeat(pieces, FINE), grid)[0])
        slowest = fine[np.argmin(speed.reshape(-1, FINE), axis=1)]
        near = slowest[:, None] + np.linspace(-1.0, 1.0, 5) / (FINE - 1.0)
        share = np.hstack(
            [np.broadcast_to(np.linspace(0.0, 1.0, POINTS), (len(pieces), POINTS)), np.clip(near, 0.0, 1.0)]
        )
        index, s = np.repeat(pieces, share.shape[1]), (share * h[:, None]).ravel()
        local = motion.piece_start[index] + s
        local = local - motion.period * np.floor(local / motion.period)
        rates = evaluate(recording.rates, local, motion.piece_states(index, s), motion.piece_side[index], parameters)
        slopes = motion.piece_slopes(index, s)
        for i, rate in enumerate(rates):
            worst = max(worst, float(np.max(np.abs(rate - slopes[i]) * motion.piece_length[index])) / scales[i])
    return worst


def _outer_impulse(motion: Trajectory) -> Any:
    """Integral of the force from outside, at the start of every piece and at the end; 0.0 where there is none."""
    if "outer_force" not in motion.observable_names:
        return 0.0
    whole = motion.piece_integrals(np.arange(len(motion.piece_start)), motion.piece_length, ("outer_force",))
    return np.append(0.0, np.cumsum(whole[0]))


def _estimated_error(recorded: Recorded, loose: Recorded, scales: np.ndarray) -> float | None:
    """Error of a run from a looser one, at the period marks that both reached, and at the end if both did."""
    count = min(len(recorded.sections), len(loose.sections))
    differences = list(recorded.sections[1:count] - loose.sections[1:count])
    if recorded.status == loose.status == memory.DONE:
        differences.append(recorded.final - loose.final)
    if not differences:
        return None
    return float(np.max(np.abs(differences) / scales)) / (COMPANION - 1.0)


def _at_marks(values: np.ndarray) -> np.ndarray:
    """Of values at POINTS points per piece: those at the start of every piece, and at the end."""
    return np.append(values[::POINTS], values[-1])
