"""What a certificate rests on, gathered from a motion: its steps, its contact, its balances and a second run."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.motion.certificate import Certificate, Verdict
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.trajectory import IMPACT_WORK, Trajectory
from vibrocap.numerics.api import DEFECT_BOUND, Recorded, codes
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate
from vibrocap.physics.flow import CONTACT_CHANNELS
from vibrocap.physics.names import name_and_number, numbered

ZOOMS = 12  # of the least reaction within a piece: to 1e-8 of its length, the square of which is rounding
POINTS = 9  # per piece at which a certificate looks
FINE = 65  # points per piece among which the slowest is looked for
PIECES_AT_A_TIME = 1000
LEAST_TOLERANCE = 1e-13  # below it rounding decides
# Of the balances, over the tolerance and the natural size of energy or momentum: at most 25 in 440 plausible motions of
# all laws (tests/plausible_cases.py), and a tenth per step where a contact chatters for ten thousand steps.
BALANCE_BOUND, BALANCE_PER_STEP = 100.0, 0.1
EVENT_BOUND = 1.0  # of the velocity at an event, over the tolerance and the natural size of the velocity
EPSILON = float(np.finfo(float).eps)
ROUNDING = 64 * EPSILON  # of a velocity at rest, over the largest one or 1
STICK_SLACK = 1e-9  # of the limit; a hold is left where its force is at the limit to rounding
INCONSISTENT = 1e-9  # of the powers: more than rounding leaves of a balance that holds


def certificate(motion: Trajectory, recorded: Recorded, tighter: Recorded, ratio_of_tolerances: float) -> Certificate:
    """Evidence for a motion, from points within every piece and from a second run whose tolerance is tighter."""
    if not len(motion.piece_start):
        return Certificate(None, 0.0, True, 0.0, 0.0, 0.0, None, 0, 0, 0.0, finished=False)
    recording, parameters = equations(motion.system), parameter_values(motion.system)
    scales = np.asarray(evaluate(recording.scales, 0.0, [], 1.0, parameters), float)
    tolerance = max(motion.tolerance, LEAST_TOLERANCE)
    share = np.linspace(0.0, 1.0, POINTS)
    index = np.repeat(np.arange(len(motion.piece_start)), POINTS)
    s = np.tile(share, len(motion.piece_start)) * motion.piece_length[index]
    energy, contact_energy, momentum = motion.piece_observables(("energy", "contact_energy", "momentum"), index, s)
    # At the start of every piece and at the end.
    works, impulses = np.split(motion.piece_marks, [len(recording.channels)])
    outer = _outer_impulse(motion)
    stored = _at_marks(energy + contact_energy)
    balance = stored - stored[0] - works.sum(axis=0)
    if any(law.switched for law in motion.system.laws):
        # Energy that was stored in the contact is lost where a piece begins unloaded.
        before, after = (energy + contact_energy)[POINTS - 1 :: POINTS][:-1], stored[1:-1]
        taken = motion.piece_jumps if IMPACT_WORK in motion.integral_names else 0.0  # known to the marks
        balance[1:] -= np.cumsum(np.append(after - before - taken, 0.0))
    impulse = _at_marks(momentum) - momentum[0] + impulses.sum(axis=0) - outer
    if motion.system.machine.strikes_ground:
        impulse[1:] -= np.cumsum(np.append(motion.piece_blows, 0.0))
    seen = [_contact_evidence(motion, number, index, s) for number in range(1, 1 + motion.piece_sides.shape[1])]
    least = min(each.least for each in seen)
    slack = ROUNDING * max(1.0, *(each.fastest for each in seen))
    natural_speed = max(_natural_size(motion, recording, scales, name) for name in velocity_names(recording))
    imposed = any(derivative(each.velocity, -1).value != 0.0 for each in recording.contacts)
    if motion.system.machine.imposes_distances or imposed:
        # With an imposed part of the velocity what rests is at rest to the tolerance, not exactly.
        slack = max(slack, EVENT_BOUND * tolerance * natural_speed)
    energy_residual, momentum_residual = (float(np.max(np.abs(each), initial=0.0)) for each in (balance, impulse))
    ratio = max((each.share for each in seen if each.share is not None), default=None)
    defect = _defect(motion, scales, DEFECT_BOUND * tolerance)
    # States that only events change jump at instants that are an error apart.
    lasting = [i for i, name in enumerate(motion.state_names) if name not in motion.system.switched]
    estimate = _estimated_error(recorded, tighter, scales, lasting, ratio_of_tolerances)
    event_velocity, verdicts = recorded.contact_residual, []

    def judge(field: str, value: float, bound: float | None, text: str = "") -> None:
        verdicts.append(Verdict(field, float(value), None if bound is None else float(bound), text))

    if ratio is not None:
        text = f"the stuck contact carries {ratio:.9g} times what it can hold: a slip was missed"
        judge("stick_force_ratio", ratio, 1.0 + STICK_SLACK, text)
    shortfall = _slip_shortfall(motion, slack)
    if shortfall is not None:
        text = f"the contact slips {shortfall:.2g} of its limit below what it can hold: a slip began too early"
        judge("slip_shortfall", shortfall, STICK_SLACK, text)
    judge(
        "event_velocity",
        event_velocity,
        EVENT_BOUND * tolerance * natural_speed,
        f"the contact still moves at {event_velocity:.2g} where it is said to rest or to turn: an event was "
        f"not located to the tolerance",
    )
    if any(law.kind != "smooth" for law in motion.system.laws):
        judge("least_velocity", -least, slack, f"the velocity passes rest by {-least:.1e} without an event")
    errors = BALANCE_BOUND + BALANCE_PER_STEP * len(motion.piece_start)
    for field, value, observables, flows, check in (
        ("energy_residual", energy_residual, ("energy", "contact_energy"), works, _energy_contradiction),
        ("momentum_residual", momentum_residual, ("momentum",), (*impulses, outer), _momentum_contradiction),
    ):
        bound = errors * tolerance * _natural_size(motion, recording, scales, *observables)
        bound += EPSILON * float(sum(np.sum(np.abs(each)) for each in flows))  # half a unit in the last place of sums
        text = "" if value <= bound else _unbalanced(field, value, bound, check(motion, recording), motion.tolerance)
        judge(field, value, bound, text)
    words = f"the equations are left by {defect:.1e} within a step, where {DEFECT_BOUND * tolerance:.1e} is the bound"
    judge("defect", defect, DEFECT_BOUND * tolerance, words)
    if estimate is not None:
        judge("estimated_error", estimate, None)
    reaction, warnings = _reaction(motion, index, s)
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
        warnings=(*warnings, *_shared_rest(motion)),
    )


@dataclasses.dataclass(frozen=True)
class ContactEvidence:
    """What was seen of one contact.

    share: largest part of what it can hold that it held at rest; None: its law cannot stick
    least: least velocity along its side while it slides, 0 of a smooth law; fastest: largest size of its velocity
    """

    share: float | None
    least: float
    fastest: float


def _contact_evidence(motion: Trajectory, number: int, index: np.ndarray, s: np.ndarray) -> ContactEvidence:
    """Of a contact, at all points of the pieces; at an event of its own its velocity is that of the event."""
    law, sides = motion.system.laws[number - 1], motion.piece_sides[:, number - 1]
    names = numbered("contact_velocity", number), numbered("friction", number)
    velocity, friction = motion.piece_observables(names, index, s)
    stuck = sides[index] == 0.0
    along = (sides[index] * velocity).reshape(-1, POINTS)
    along[np.append(sides[1:] != sides[:-1], False), -1] = 0.0
    share = None
    if law.kind == "set-valued":
        held = _shares_held(motion, number, friction[stuck], index[stuck], s[stuck])
        share = float(np.max(np.abs(held), initial=0.0))
    least = 0.0 if law.kind == "smooth" else float(np.min(along, initial=0.0))
    return ContactEvidence(share, least, float(np.max(np.abs(velocity), initial=0.0)))


def _slip_shortfall(motion: Trajectory, still: float) -> float | None:
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
        at = starts, np.zeros(len(starts))
        names = numbered("contact_velocity", number), numbered("holding_force", number)
        velocity, force = motion.piece_observables(names, *at)
        shares = sides[starts] * _shares_held(motion, number, force, *at)
        missing += (1.0 - shares[np.abs(velocity) <= still]).tolist()
    return max(0.0, *missing) if missing else None


def _shares_held(motion: Trajectory, number: int, force: np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Forces at rest over what a contact can hold, from the middle of that."""
    law, load = motion.system.laws[number - 1], motion.system.law_loads[number - 1]
    limit, middle = law.holding_limit(load), law.holding_centre(load)
    if motion.system.machine.follows_load:
        names = numbered("holding_limit", number), numbered("holding_centre", number)
        limit, middle = motion.piece_observables(names, index, s)
    force = force - middle
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(force == 0.0, 0.0, force / limit)


def _shared_rest(motion: Trajectory) -> tuple[str, ...]:
    """What is to be said of contacts at imposed distances that rest together: their forces are open, the motion not."""
    system = motion.system
    if not system.machine.imposes_distances:
        return ()
    can_rest = [each.kind == "set-valued" for each in system.laws]
    together = np.sum(motion.piece_sides[:, can_rest] == 0.0, axis=1) > 1
    if not np.any(together):
        return ()
    return (
        f"contacts rest together, first from time {motion.piece_start[np.argmax(together)]:.4g}: how they share the "
        "force that is held is open at imposed distances (the motion is not); shown are equal shares of their limits",
    )


def _reaction(motion: Trajectory, index: np.ndarray, s: np.ndarray) -> tuple[float | None, tuple[str, ...]]:
    """(least normal reaction of the ground, what is to be said of it): a constant load does not notice a lift-off."""
    contacts = range(1, 1 + motion.piece_sides.shape[1])
    names = {name: i for i in contacts if (name := numbered("reaction", i)) in motion.observable_names}
    if not names:
        return None, ()
    found, warnings = [], []
    for (name, number), reaction in zip(names.items(), motion.piece_observables(tuple(names), index, s), strict=True):
        where = f" on contact {number}" if len(contacts) > 1 else ""
        if not np.all(np.isfinite(reaction)):
            warnings.append(f"the normal load{where} is beyond all numbers: nothing is known of it")
            continue
        pieces, least = _least_of_pieces(motion, name, reaction.reshape(-1, POINTS))
        found.append(float(np.min(least)))
        if found[-1] < 0.0 and not motion.system.machine.follows_load:
            time = motion.piece_start[pieces[np.argmax(least < 0.0)]]
            warnings.append(
                f"the true normal load{where} would be negative, first about time {time:.4g}, down to {found[-1]:.4g}: "
                f'the machine would lift off, which a constant load hides; use normal_load = "dynamic"'
            )
    return min(found, default=None), tuple(warnings)


def _least_of_pieces(motion: Trajectory, name: str, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(pieces in which a reaction may be least or below zero, its least value in each).

    seen: at the points of every piece; between them it is looked at again and again, four times closer each time
    """
    lows, spread = seen.min(axis=1), np.ptp(seen, axis=1)
    pieces = np.flatnonzero(lows - spread <= max(lows.min(), 0.0))
    least, middle = lows[pieces], seen[pieces].argmin(axis=1) / (POINTS - 1.0)
    for zoom in range(1, ZOOMS + 1):
        width = 4.0**-zoom
        around = np.clip(middle[:, None] + np.linspace(-0.5, 0.5, POINTS) * width, 0.0, 1.0)
        s = around * motion.piece_length[pieces][:, None]
        (values,) = motion.piece_observables((name,), np.repeat(pieces, POINTS), s.ravel())
        values = values.reshape(-1, POINTS)
        least, middle = np.minimum(least, values.min(axis=1)), around[np.arange(len(pieces)), values.argmin(axis=1)]
    return pieces, least


def _natural_size(motion: Trajectory, recording: Equations, scales: np.ndarray, *names: str) -> float:
    """How much observables change, at most, where every state changes by its natural size: to the second order.

    The first vanishes of the energy of a machine that stays at rest, as the common centre of a worm between mirror
    images does.
    """
    start, zero = np.arange(len(motion.piece_start)), 0.0 * motion.piece_length
    states, (local, parameters) = motion.piece_states(start, zero), motion.drive_at(start, zero)
    return float(np.sum(np.max(changes(recording, names, scales, local, states, parameters), axis=1)))


def changes(
    recording: Equations, names: Sequence[str], scales: np.ndarray, t: Any, states: np.ndarray, parameters: Any
) -> np.ndarray:
    """How much a sum of observables changes where one state changes by its natural size: array [states, n].

    To the second order. scales: [states] or [states, n]; states: [states, n]
    """
    found = np.zeros(states.shape)
    for i, scale in enumerate(scales):
        slopes = [derivative(recording.observables[name], i) for name in names]
        bends = [derivative(slope, i) for slope in slopes]
        slope, bend = (sum(evaluate(each, t, states, 1.0, parameters)) for each in (slopes, bends))
        found[i] = scale * np.maximum(np.abs(slope), np.abs(0.5 * scale * bend))
    return found


def velocity_names(recording: Equations) -> tuple[str, ...]:
    """Names of the velocities of all contacts."""
    return tuple(numbered("contact_velocity", number) for number in range(1, 1 + len(recording.contacts)))


def _unbalanced(field: str, value: float, bound: float, contradiction: str, tolerance: float) -> str:
    """A balance that does not close, and what that probably means."""
    what = field.removesuffix("_residual")
    said = f"the balance of {what} is off by {value:.2g}, where {bound:.2g} is the bound: "
    if contradiction:
        return said + contradiction
    return said + (
        f"the equations are in balance, the motion is not, so that its works and impulse are not to be trusted; the "
        f"tolerance {tolerance:.1e} is too loose for a law as stiff as this"
    )


def _energy_contradiction(motion: Trajectory, recording: Equations) -> str:
    """What of a system's energies and powers contradicts its rates, in words; empty where nothing does."""
    known, machine, contact = recording.observables, [], []
    for name, power in zip(recording.channels, recording.powers, strict=True):
        (contact if name_and_number(name)[0] in CONTACT_CHANNELS else machine).append(power)
    taken = [each.friction * each.velocity for each in recording.contacts]
    found = _contradiction(motion, recording, known["energy"], [*machine, *(-each for each in taken)])
    if found:
        return f"`energy` and `powers` of the machine contradict its `rates`: {found}"
    found = _contradiction(motion, recording, known["contact_energy"], [*contact, *taken])
    if found:
        return f"`losses` and `stored_energy` of the law contradict its `force`: {found}"
    return ""


def _momentum_contradiction(motion: Trajectory, recording: Equations) -> str:
    """What of a machine's momentum contradicts its rates, in words; empty where nothing does."""
    known = recording.observables
    outer = [known["outer_force"]] if "outer_force" in known else []
    taken = [-each.friction for each in recording.contacts]
    found = _contradiction(motion, recording, known["momentum"], [*outer, *taken])
    return f"`momentum` of the machine contradicts its `rates`: {found}" if found else ""


def _contradiction(motion: Trajectory, recording: Equations, stored: Expression, inflows: Sequence[Expression]) -> str:
    """Where the rate of what is stored is not the sum of what flows in, at the starts of the pieces; empty: nowhere."""
    terms = [derivative(stored, i) * rate for i, rate in enumerate(recording.rates)]
    terms += [derivative(stored, -1), *(-each for each in inflows)]
    start = np.arange(len(motion.piece_start))
    zero = 0.0 * motion.piece_length
    states, (local, parameters) = motion.piece_states(start, zero), motion.drive_at(start, zero)
    values = [
        np.broadcast_to(each, local.shape) for each in evaluate(terms, local, states, motion.sides(start), parameters)
    ]
    gap, size = np.abs(np.sum(values, axis=0)), np.sum(np.abs(values), axis=0)
    worst = int(np.argmax(gap - INCONSISTENT * size))
    if not gap[worst] > INCONSISTENT * size[worst]:
        return ""
    change = float(np.sum(values[: -len(inflows)], axis=0)[worst])
    inflow = -float(np.sum(values[-len(inflows) :], axis=0)[worst])
    return f"at time {motion.piece_start[worst]:.6g} it changes at the rate {change:.6g}, while {inflow:.6g} flows in"


def _defect(motion: Trajectory, scales: np.ndarray, bound: float) -> float:
    """Largest h |y' - f(t, y)| over the natural size of a state; of implicit steps along their stiff directions.

    Nine points of every step, and of Taylor steps five more about where each contact is slowest: friction changes
    most near rest. A law that may be stiff multiplies what a stabilised step leaves of a decay, too: what is beyond the
    bound is asked again as of an implicit step.
    """
    recording = equations(motion.system)
    implicit = np.flatnonzero(motion.piece_implicit)
    even = np.linspace(0.0, 1.0, POINTS)
    index, s = np.repeat(implicit, POINTS), (even * motion.piece_length[implicit, None]).ravel()
    worst = float(np.max(_left(motion, scales, index, s, 0.0), initial=0.0))
    taylor = np.flatnonzero(~motion.piece_implicit)
    fine = np.linspace(0.0, 1.0, FINE)
    for first in range(0, len(taylor), PIECES_AT_A_TIME):
        pieces = taylor[first : first + PIECES_AT_A_TIME]
        h = motion.piece_length[pieces]
        grid = (fine * h[:, None]).ravel()
        shares = [np.broadcast_to(even, (len(pieces), POINTS))]
        for speed in np.abs(motion.piece_observables(velocity_names(recording), np.repeat(pieces, FINE), grid)):
            slowest = fine[np.argmin(speed.reshape(-1, FINE), axis=1)]
            shares.append(np.clip(slowest[:, None] + np.linspace(-1.0, 1.0, 5) / (FINE - 1.0), 0.0, 1.0))
        share = np.hstack(shares)
        index, s = np.repeat(pieces, share.shape[1]), (share * h[:, None]).ravel()
        worst = max(worst, float(np.max(_left(motion, scales, index, s, bound if recording.maybe_stiff else math.inf))))
    return worst


def _left(motion: Trajectory, scales: np.ndarray, index: np.ndarray, s: np.ndarray, stiff_from: float) -> np.ndarray:
    """h |y' - f(t, y)| over the natural size of a state; what is above `stiff_from`, along stiff directions."""
    recording, (local, parameters) = equations(motion.system), motion.drive_at(index, s)
    with np.errstate(all="ignore"):  # of an implicit step the dense output may pass rest
        rates = evaluate(recording.rates, local, motion.piece_states(index, s), motion.sides(index), parameters)
    left = np.zeros(len(index))
    for slope, rate, scale in zip(motion.piece_slopes(index, s), rates, scales, strict=True):
        left = np.maximum(left, np.abs(rate - slope) * motion.piece_length[index] / scale)
    beyond = np.flatnonzero(~(left <= stiff_from))
    if len(beyond):
        change = np.max(np.abs(motion.piece_correction(index[beyond], s[beyond])) / scales[:, None], axis=0)
        left[beyond] = np.where(change > 0.0, change, left[beyond])  # zero: nothing is stiff
    return left


def _outer_impulse(motion: Trajectory) -> Any:
    """Integral of the force from outside, at the start of every piece and at the end; 0.0 where there is none."""
    if "outer_force" not in motion.observable_names:
        return 0.0
    whole = motion.piece_integrals(np.arange(len(motion.piece_start)), motion.piece_length, ("outer_force",))
    return np.append(0.0, np.cumsum(whole[0]))


def _estimated_error(
    recorded: Recorded, tighter: Recorded, scales: np.ndarray, kept: Sequence[int], ratio_of_tolerances: float
) -> float | None:
    """Error of a run from a tighter one, at the period marks that both reached, and at the end if both did.

    kept: the states that are compared; ratio_of_tolerances: the share of the error that the tighter run has, too
    """
    count = min(len(recorded.sections), len(tighter.sections))
    differences = list(recorded.sections[1:count] - tighter.sections[1:count])
    if recorded.status == tighter.status == codes.DONE:
        differences.append(recorded.final - tighter.final)
    if not differences:
        return None
    return float(np.max((np.abs(differences) / scales)[:, kept])) / (1.0 - ratio_of_tolerances)


def _at_marks(values: np.ndarray) -> np.ndarray:
    """Of values at POINTS points per piece: those at the start of every piece, and at the end."""
    return np.append(values[::POINTS], values[-1])
