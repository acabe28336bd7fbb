"""What a certificate rests on: evidence from a motion, its steps, its contact, its balances and a second run.

And whether the runs of an ensemble are motions of the equations, by the evidence that was taken while they ran.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.motion.certificate import Certificate, Verdict
from vibrocap.motion.contradictions import at_starts, energy_contradiction, momentum_contradiction, unbalanced
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.trajectory import IMPACT_WORK, MANY, PIECES_AT_A_TIME, Trajectory, along
from vibrocap.numerics.api import DEFECT_BOUND, Recorded, RunResults, codes
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import derivative, evaluate, evaluated
from vibrocap.physics.names import numbered
from vibrocap.quantities.dimensional import said

POINTS = 9  # per piece at which a certificate looks
FINER = 8  # times closer to the slowest of these points, a still slower one is looked for
# Of the least reaction within a piece, each sixteen times closer than the one before: to 1e-8 of the length of the
# piece, the square of which is rounding.
ZOOMS, CLOSER = 6, np.linspace(-1.0, 1.0, 33)
LEAST_TOLERANCE = 1e-13  # below it rounding decides
# Of the balances, over the tolerance and the natural size of energy or momentum: at most 25 in 440 plausible motions of
# all laws (tests/plausible_cases.py), and a tenth per step where a contact chatters for ten thousand steps.
BALANCE_BOUND, BALANCE_PER_STEP = 100.0, 0.1
EVENT_BOUND = 1.0  # of the velocity at an event, over the tolerance and the natural size of the velocity
EPSILON = float(np.finfo(float).eps)
ROUNDING = 64 * EPSILON  # of a velocity at rest, over the largest one or 1
KNOWN = 1e-3  # of what a state moves by: an error beyond it leaves less than three digits
STICK_SLACK = 1e-9  # of the limit; a hold is left where its force is at the limit to rounding


def certificate(
    motion: Trajectory, recorded: Recorded, tighter: Recorded | None, ratio_of_tolerances: float
) -> Certificate:
    """Evidence for a motion, from points within every piece and from a second run whose tolerance is tighter.

    tighter: None: without what is held to no bound, the estimated error, the least reaction and the warnings
    """
    if not len(motion.piece_start):
        return Certificate(None, 0.0, True, 0.0, 0.0, 0.0, None, 0, 0, 0.0, finished=False)
    recording, parameters = equations(motion.system), parameter_values(motion.system)
    scales = np.asarray(evaluate(recording.scales, 0.0, [], 1.0, parameters), float)
    tolerance = max(motion.tolerance, LEAST_TOLERANCE)
    observed = _seen(motion)
    # At the start of every piece and at the end.
    works, impulses = np.split(motion.piece_marks, [len(recording.channels)])
    outer: Any = 0.0  # impulse from outside
    if "outer_force" in motion.observable_names:
        whole = motion.piece_integrals(np.arange(len(motion.piece_start)), motion.piece_length, ("outer_force",))
        outer = np.append(0.0, np.cumsum(whole[0]))
    energy, momentum = observed["energy"] + observed["contact_energy"], _at_marks(observed["momentum"])
    stored = _at_marks(energy)
    balance = stored - stored[0] - works.sum(axis=0)
    if any(law.switched for law in motion.system.laws):
        # Energy that was stored in the contact is lost where a piece begins unloaded.
        before, after = energy[:-1, -1], stored[1:-1]
        taken = motion.piece_jumps if IMPACT_WORK in motion.integral_names else 0.0  # known to the marks
        balance[1:] -= np.cumsum(np.append(after - before - taken, 0.0))
    impulse = momentum - momentum[0] + impulses.sum(axis=0) - outer
    if motion.system.machine.strikes_ground:
        impulse[1:] -= np.cumsum(np.append(motion.piece_blows, 0.0))
    numbers = range(1, 1 + motion.piece_sides.shape[1])
    shares, lows, speeds = zip(*(_contact_evidence(motion, number, observed) for number in numbers), strict=True)
    least, slack = min(lows), ROUNDING * max(1.0, *speeds)
    starts = at_starts(motion)
    natural_speed = max(_natural_size(recording, scales, starts, name) for name in velocity_names(recording))
    imposed = any(derivative(contact.velocity, -1).value != 0.0 for contact in recording.contacts)
    if motion.system.machine.imposes_distances or imposed:
        # With an imposed part of the velocity what rests is at rest to the tolerance, not exactly.
        slack = max(slack, EVENT_BOUND * tolerance * natural_speed)
    energy_residual, momentum_residual = (float(np.max(np.abs(verdict), initial=0.0)) for verdict in (balance, impulse))
    ratio = max((share for share in shares if share is not None), default=None)
    defect = _defect(motion, observed, scales, DEFECT_BOUND * tolerance)
    of_states = tighter and _estimated_errors(motion, recorded, tighter, 1.0 / (1.0 - ratio_of_tolerances))
    estimate = None if of_states is None else float(np.max(of_states / scales))
    event_velocity, verdicts = recorded.contact_residual, []

    def judge(field: str, value: float, bound: float | None, text: str = "") -> None:
        verdicts.append(Verdict(field, float(value), None if bound is None else float(bound), text))

    if ratio is not None:
        text = f"the stuck contact carries {ratio:.9g} times what it can hold: a slip was missed"
        judge("stick_force_ratio", ratio, 1.0 + STICK_SLACK, text)
    shortfall = _slip_shortfall(motion, observed, slack)
    if shortfall is not None:
        text = f"the contact slips {shortfall:.2g} of its limit below what it can hold: a slip began too early"
        judge("slip_shortfall", shortfall, STICK_SLACK, text)
    judge(
        "event_velocity",
        event_velocity,
        EVENT_BOUND * tolerance * natural_speed,
        f"the contact still moves at {event_velocity:.2g} at a located rest or reversal: an event was "
        f"not located to the tolerance",
    )
    if any(law.kind != "smooth" for law in motion.system.laws):
        judge("least_velocity", -least, slack, f"the velocity passes rest by {-least:.1e} without an event")
    errors = BALANCE_BOUND + BALANCE_PER_STEP * len(motion.piece_start)
    for field, value, observables, flows, check in (
        ("energy_residual", energy_residual, ("energy", "contact_energy"), works, energy_contradiction),
        ("momentum_residual", momentum_residual, ("momentum",), (*impulses, outer), momentum_contradiction),
    ):
        bound = errors * tolerance * _natural_size(recording, scales, starts, *observables)
        bound += EPSILON * float(sum(np.sum(np.abs(flow)) for flow in flows))  # half a unit in the last place of sums
        text = "" if value <= bound else unbalanced(field, value, bound, check(motion, recording), motion.tolerance)
        judge(field, value, bound, text)
    words = f"the equations are left by {defect:.1e} within a step, where {DEFECT_BOUND * tolerance:.1e} is the bound"
    judge("defect", defect, DEFECT_BOUND * tolerance, words)
    if estimate is not None:
        judge("estimated_error", estimate, None)
    reaction, warnings = (None, ()) if tighter is None else _reaction(motion, observed)
    return Certificate(
        stick_force_ratio=ratio,
        slip_shortfall=shortfall,
        finished=motion.run_status.ok,
        event_velocity=event_velocity,
        sign_kept=bool(least >= -slack),
        least_velocity=least,
        energy_residual=energy_residual,
        momentum_residual=momentum_residual,
        estimated_error=estimate,
        taylor_steps=recorded.taylor_steps,
        implicit_steps=recorded.implicit_steps,
        defect=defect,
        verdicts=tuple(verdicts),
        least_reaction=reaction,
        warnings=(*warnings, *_shared_rest(motion), *_barely_known(motion, starts[0], of_states, scales)),
    )


def _seen(motion: Trajectory) -> dict[str, np.ndarray]:
    """Observables by name at POINTS points of every piece, both ends among them: arrays [pieces, POINTS]."""
    names = ["energy", "contact_energy", "momentum"]
    for number, law in enumerate(motion.system.laws, 1):
        own = ["contact_velocity", "friction"]
        own += ["reaction"] if numbered("reaction", number) in motion.observable_names else []
        if law.kind == "set-valued":
            limits = ("holding_limit", "holding_centre") if motion.system.machine.follows_load else ()
            own += ["holding_force", *limits]
        names += [numbered(name, number) for name in own]
    s = motion.piece_length[:, None] * np.linspace(0.0, 1.0, POINTS)
    return dict(zip(names, motion.piece_observables(tuple(names), np.arange(len(s)), s), strict=True))


def _contact_evidence(
    motion: Trajectory, number: int, observed: Mapping[str, np.ndarray]
) -> tuple[float | None, float, float]:
    """Of a contact: largest part of what it can hold that it held at rest (None: its law cannot stick), least velocity
    along its side while it slides (0 of a smooth law), largest size of its velocity; at an event that of the event."""
    law, sides = motion.system.laws[number - 1], motion.piece_sides[:, number - 1]
    velocity = observed[numbered("contact_velocity", number)]
    forward = sides[:, None] * velocity
    forward[np.append(sides[1:] != sides[:-1], False), -1] = 0.0
    share = None
    if law.kind == "set-valued":
        held = _shares_held(motion, number, observed, "friction", sides == 0.0)
        share = float(np.max(np.abs(held), initial=0.0))
    least = 0.0 if law.kind == "smooth" else float(np.min(forward, initial=0.0))
    return share, least, float(np.max(np.abs(velocity), initial=0.0))


def _slip_shortfall(motion: Trajectory, observed: Mapping[str, np.ndarray], still: float) -> float | None:
    """Largest part of what a contact can hold that was missing where it left rest; None: none did.

    Not asked of slips that begin faster than `still`, as after an impact, nor of contacts that act on one another.
    """
    if equations(motion.system).coupled:
        return None
    missing: list[float] = []
    for number, law in enumerate(motion.system.laws, 1):
        sides = motion.piece_sides[:, number - 1]
        starts = 1 + np.flatnonzero((sides[:-1] == 0.0) & (sides[1:] != 0.0))
        if law.kind != "set-valued" or not len(starts):
            continue
        at = starts, 0
        shares = sides[starts] * _shares_held(motion, number, observed, "holding_force", at)
        velocity = observed[numbered("contact_velocity", number)][at]
        missing += (1.0 - shares[np.abs(velocity) <= still]).tolist()
    return max(0.0, *missing) if missing else None


def _shares_held(
    motion: Trajectory, number: int, observed: Mapping[str, np.ndarray], name: str, at: np.ndarray | tuple
) -> np.ndarray:
    """A force at rest over what a contact can hold, from the middle of that; at: those of the points that were seen."""
    law, load = motion.system.laws[number - 1], motion.system.law_loads[number - 1]
    limit, middle = law.holding_limit(load), law.holding_centre(load)
    if motion.system.machine.follows_load:
        limit, middle = (observed[numbered(name, number)][at] for name in ("holding_limit", "holding_centre"))
    force = observed[numbered(name, number)][at] - middle
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(force == 0.0, 0.0, force / limit)


def _shared_rest(motion: Trajectory) -> tuple[str, ...]:
    """What is to be said of contacts at imposed distances that rest together: their forces are open, the motion not."""
    system = motion.system
    if not system.machine.imposes_distances:
        return ()
    can_rest = [law.kind == "set-valued" for law in system.laws]
    together = np.sum(motion.piece_sides[:, can_rest] == 0.0, axis=1) > 1
    if not np.any(together):
        return ()
    first = _in_units(motion, "time", motion.piece_start[np.argmax(together)])
    return (
        f"contacts rest together, first from time {first}: how they share the "
        "force that is held is open at imposed distances (the motion is not); shown are equal shares of their limits",
    )


def _reaction(motion: Trajectory, observed: Mapping[str, np.ndarray]) -> tuple[float | None, tuple[str, ...]]:
    """(least normal reaction of the ground, what is to be said of it): a constant load does not notice a lift-off."""
    contacts = range(1, 1 + motion.piece_sides.shape[1])
    names = {name: i for i in contacts if (name := numbered("reaction", i)) in observed}
    if not names:
        return None, ()
    reactions, warnings = [], []
    for name, number in names.items():
        where = f" on contact {number}" if len(contacts) > 1 else ""
        if not np.all(np.isfinite(observed[name])):
            warnings.append(f"the normal load{where} is beyond all numbers: nothing is known of it")
            continue
        lows = _least_of_pieces(motion, name, observed[name])
        reactions.append(float(np.min(lows)))
        if reactions[-1] < 0.0 and not motion.system.machine.follows_load:
            time = motion.piece_start[np.argmax(lows < 0.0)]
            warnings.append(
                f"the true normal load{where} would be negative, first about time {_in_units(motion, 'time', time)}, "
                f"down to {_in_units(motion, name, reactions[-1])}: "
                f'the machine would lift off, which a constant load hides; use normal_load = "dynamic"'
            )
    return min(reactions, default=None), tuple(warnings)


def _in_units(motion: Trajectory, name: str, value: float) -> str:
    """A value of a quantity in words, in SI where the scales are known."""
    units = motion.system.result_units
    return said(value * units.factor(name), units.unit(name), 4)


def _least_of_pieces(motion: Trajectory, name: str, values_at: np.ndarray) -> np.ndarray:
    """Least reaction in each piece: to rounding where it is the least of all, below zero where it falls below.

    seen: at the points of every piece; where it may fall lower between them, by as much as it differs among those next
    to the lowest, it is looked at ever closer
    """
    least, spread = values_at.min(axis=1), np.ptp(values_at, axis=1)
    middle, reach = values_at.argmin(axis=1) / (POINTS - 1.0), 1.0 / (POINTS - 1.0)
    for _ in range(ZOOMS):
        lowest = least.min() - EPSILON * abs(least.min())
        near = np.flatnonzero((least - spread < lowest) | ((least >= 0.0) & (least < spread)))
        if not len(near):
            break
        around = np.clip(middle[near, None] + reach * CLOSER, 0.0, 1.0)
        (values,) = motion.piece_observables((name,), near, around * motion.piece_length[near, None])
        least[near], spread[near] = np.minimum(least[near], values.min(axis=1)), np.ptp(values, axis=1)
        middle[near] = around[np.arange(len(near)), values.argmin(axis=1)]
        reach *= 2.0 / (len(CLOSER) - 1.0)
    return least


def _natural_size(recording: Equations, scales: np.ndarray, starts: tuple, *names: str) -> float:
    """How much observables change, at most, where every state changes by its natural size: to the second order.

    The first vanishes of the energy of a machine that stays at rest, as the common centre of a worm between mirror
    images does. starts: states and drive there
    """
    states, (local, parameters) = starts
    return float(np.sum(np.max(changes(recording, names, scales, local, states, parameters), axis=1)))


def changes(
    recording: Equations, names: Sequence[str], scales: np.ndarray, t: Any, states: np.ndarray, parameters: Any
) -> np.ndarray:
    """How much a sum of observables changes where one state changes by its natural size: array [states, n].

    To the second order. scales: [states] or [states, n]; states: [states, n]
    """
    slopes = [(i, derivative(recording.observables[name], i)) for name in names for i in range(len(scales))]
    asked = [*(slope for _, slope in slopes), *(derivative(slope, i) for i, slope in slopes)]
    values = evaluated(asked, t, states, 1.0, parameters, states.shape[1:])
    slope, bend = values.reshape(2, len(names), *states.shape).sum(axis=1)
    scale = scales.reshape(len(scales), -1)
    return scale * np.maximum(np.abs(slope), np.abs(0.5 * scale * bend))


def velocity_names(recording: Equations) -> tuple[str, ...]:
    """Names of the velocities of all contacts."""
    return tuple(numbered("contact_velocity", number) for number in range(1, 1 + len(recording.contacts)))


def _defect(motion: Trajectory, observed: Mapping[str, np.ndarray], scales: np.ndarray, bound: float) -> float:
    """Largest h |y' - f(t, y)| over the natural size of a state; of implicit steps along their stiff directions.

    Nine points of every step, and of Taylor steps five more about where each contact is slowest: friction changes
    most near rest. A law that may be stiff multiplies what a stabilised step leaves of a decay, too: what is beyond the
    bound is asked again as of an implicit step.
    """
    worst, even, last = 0.0, np.linspace(0.0, 1.0, POINTS), POINTS - 1.0
    near, about = np.arange(1 - FINER, FINER) / (FINER * last), np.arange(-2, 3) / (FINER * last)
    names = velocity_names(equations(motion.system))
    for method in (motion.piece_implicit, ~motion.piece_implicit):
        every = np.flatnonzero(method)
        for first in range(0, len(every), PIECES_AT_A_TIME):
            pieces = every[first : first + PIECES_AT_A_TIME]
            h = motion.piece_length[pieces, None]
            shares = [np.broadcast_to(even, (len(pieces), POINTS))]
            for i, name in enumerate(() if method is motion.piece_implicit else names):
                slowest = np.argmin(np.abs(observed[name][pieces]), axis=1)[:, None] / last
                around = np.clip(slowest + near, 0.0, 1.0)
                speed = np.abs(motion.piece_observables(names[i : i + 1], pieces, h * around)[0])
                slowest = np.take_along_axis(around, np.argmin(speed, axis=1)[:, None], axis=1)
                shares.append(np.clip(slowest + about, 0.0, 1.0))
            worst = max(worst, float(np.max(_left(motion, scales, pieces, h * np.hstack(shares), bound))))
    return worst


def _left(motion: Trajectory, scales: np.ndarray, index: np.ndarray, s: np.ndarray, bound: float) -> np.ndarray:
    """h |y' - f(t, y)| over the natural size of a state; of implicit steps, and beyond the bound, along stiff
    directions."""
    recording, implicit = equations(motion.system), motion.piece_implicit[index]
    if s.size >= MANY or np.any(implicit):
        return motion.observe.left_at_many(motion, bound, index, s)
    local, parameters = motion.drive_at(index, s)
    sides = tuple(along(side, s) for side in motion.sides(index))
    rates = evaluate(recording.rates, local, motion.piece_states(index, s), sides, parameters)
    left = np.zeros(s.shape)
    for slope, rate, scale in zip(motion.piece_slopes(index, s), rates, scales, strict=True):
        left = np.maximum(left, np.abs(rate - slope) * along(motion.piece_length[index], s) / scale)
    beyond = np.nonzero(~(left <= bound))
    if recording.maybe_stiff and len(beyond[0]):
        left[beyond] = motion.observe.left_at_many(motion, bound, index[beyond[0]], s[beyond])
    return left


def _estimated_errors(motion: Trajectory, recorded: Recorded, tighter: Recorded, share: float) -> np.ndarray | None:
    """Error of each state from a tighter run, at the period marks that both reached, and at the end if both did.

    Of states that only events change, nothing: they jump at instants that are an error apart.
    share: the error over the difference, as the tighter run has an error too
    """
    count = min(len(recorded.sections), len(tighter.sections))
    differences = list(recorded.sections[1:count] - tighter.sections[1:count])
    if recorded.status == tighter.status == codes.DONE:
        differences.append(recorded.final - tighter.final)
    if not differences:
        return None
    smooth = [name not in motion.system.switched for name in motion.state_names]
    return share * np.where(smooth, np.max(np.abs(differences), axis=0), 0.0)


def _barely_known(
    motion: Trajectory, states: np.ndarray, errors: np.ndarray | None, scales: np.ndarray
) -> tuple[str, ...]:
    """What is to be said of states whose error is not small against all that they move by."""
    moved = np.ptp(states, axis=1)
    if errors is None:
        return ()
    return tuple(
        f"the error of {name.replace('_', ' ')} is {error / move:.1g} of all that it moves by, "
        f"{_in_units(motion, name, move)}: a tighter tolerance or a shorter run tells more"
        for name, move, error, scale in zip(motion.state_names, moved, errors, scales, strict=True)
        if move > LEAST_TOLERANCE * scale and error > KNOWN * move
    )


def _at_marks(values: np.ndarray) -> np.ndarray:
    """Of values at POINTS points per piece: those at the start of every piece, and at the end."""
    return np.append(values[:, 0], values[-1, -1])


def certified(recording: Equations, results: RunResults, parameters: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether what was seen of each run is within the bounds of a certificate: array [runs] of bool.

    The velocity at located events is that of the whole run. The share of its limit that a hold takes, the sign of the
    velocity and the defect are those at some points of its last response (`kernel/observe/evidence.py`), so that a
    certificate, which asks everywhere, may refuse a motion that passes here. Works: `measures/gathered.py`.

    parameters: [runs, parameters]
    """
    count = len(results)
    tolerance = max(tolerance, LEAST_TOLERANCE)
    states = results.start[:, : recording.base].T
    values = recording.filled(parameters).T
    with np.errstate(all="ignore"):  # of runs that failed
        scales, speeds = evaluated(recording.scales, 0.0, states, 1.0, values, (count,)), np.zeros(count)
        for name in velocity_names(recording):
            speeds = np.maximum(speeds, changes(recording, (name,), scales, 0.0, states, values).sum(axis=0))
    slowest = EVENT_BOUND * tolerance * speeds
    good = results.head("contact_residual") <= slowest
    rounding = ROUNDING * np.maximum(1.0, speeds)
    imposed = recording.several or any(derivative(contact.velocity, -1).value != 0.0 for contact in recording.contacts)
    good &= -results.entry("LEAST_VELOCITY") <= (np.maximum(slowest, rounding) if imposed else rounding)
    good &= results.entry("STICKING_SHARE") <= 1.0 + STICK_SLACK
    return good & (results.entry("DEFECT") <= DEFECT_BOUND * tolerance)
