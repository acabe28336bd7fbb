"""Orbits of autonomous systems, such as a block on a belt: nothing drives them in time, and the period is unknown."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.section import section_states
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import stands_still
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution
from vibrocap.orbits.closing.returns import ARRIVED, RECURRENT, Section, recurrence, returns_of
from vibrocap.orbits.closing.shooting import closed
from vibrocap.orbits.maps.settling_runs import SETTLED
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, named_states, state_vector
from vibrocap.physics.events import STICK
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System

SIMULATED = 1e-10  # tolerance of the run that looks for a cycle
MOST_RETURNS = 64  # of a cycle, unless told otherwise
QUIET = 3.0  # longest times between returns without one, after which a section is no longer met
LOOKS = 64  # instants at which a motion at rest is looked at
STEADY = 1e-3  # of its own value, by which a velocity may change that is constant
BESIDE = 1e-6  # of a cycle: an event so soon after a return belongs to it
STOPS = 4  # the last ones, that have to go on alike
NEARER = 0.95  # share of the rates at a stop that is left at the next one, at most
ALIKE = 1e-3  # by which this share may change from stop to stop
EXCESS = 1e-12  # of what a contact can hold, that it may hold more than it rubs in the slowest slide


def autonomous_orbit(
    system: System,
    start: np.ndarray,
    settle_periods: int,
    tolerance: float = 1e-12,
    section: Section | None = None,
    returns: int = MOST_RETURNS,
) -> PeriodicSolution:
    """The cycle that a start leads to, of a system whose equations do not contain the time.

    It is closed from a guess (`closed`), modulo travel and whole turns. The guess comes from a simulation: the motion
    returns to a section, and the cycle is as many returns as bring its last passage back. Without a section several are
    tried (a place of what turns, sticks, slips, reversals of each contact, the middle of each state), and that is taken
    at which the motion comes back best. The multiplier 1 of the direction along the motion is left out. Where the
    motion ends at an equilibrium instead of cycling, the status is SLIDES_STEADILY, CARRIED or COMES_TO_REST, the last
    also in the limit by ever smaller stops.

    settle_periods: length of that simulation in `drive.period`; returns: most of them in a cycle
    """
    map_ = StroboscopicMap(system, tolerance)
    motion = simulate(system, periods=settle_periods, initial=named_states(system, start), tolerance=SIMULATED)
    guess = _turn(motion, section, returns)
    if isinstance(guess, OrbitStatus):
        unknown, none = np.full((map_.states,) * 2, np.nan), np.empty(0, dtype=complex)
        ended = named_states(system, state_vector(system, motion.state))
        return PeriodicSolution(system, ended, 0.0, 0, None, none, np.inf, None, unknown, guess, 0, tolerance)
    state, side, period, passed = guess
    cycle = closed(map_, state, period=period, side=side)
    return dataclasses.replace(cycle, returns=passed) if cycle.closes else cycle


def near_cycle(system: System, state: np.ndarray, period: float, tolerance: float = 1e-12) -> PeriodicSolution:
    """The cycle near a state [states] and a period, stable or not, by Newton's method as in `autonomous_orbit`."""
    map_ = StroboscopicMap(system, tolerance)
    return closed(map_, state, period=period, side=map_.contact_side(state, map_.parameters()))


def _turn(motion: Trajectory, section: Section | None, most: int) -> tuple[np.ndarray, Any, float, int] | OrbitStatus:
    """(state, sides, time, returns) of the last turn of a simulation, amid the phase that begins at a return.

    A section that was met before, but no longer is, belongs to what the motion has left: a rotor that has stopped.
    """
    if not motion.run_status.ok:
        return OrbitStatus.RUN_FAILED
    if (equilibrium := _equilibrium(motion)) is not None:
        return equilibrium
    points = []
    for times in returns_of(motion, section):
        if len(times) > 1 and motion.end - times[-1] <= QUIET * np.max(np.diff(times)):
            count, away = recurrence(motion, times, most)
            points.append((away, count, times))
        if points and points[-1][0] <= ARRIVED:
            break
    if not points:
        return OrbitStatus.NOT_SETTLED if section is None else OrbitStatus.SECTION_NOT_MET
    away, count, times = min(points, key=lambda pair: pair[0])
    if away > RECURRENT:
        return OrbitStatus.COMES_TO_REST if comes_to_rest(motion) else OrbitStatus.MORE_RETURNS
    return *_within(motion, times[-1 - count], times[-1]), count


def _equilibrium(motion: Trajectory) -> OrbitStatus | None:
    """What a motion has become of which nothing but the cyclic coordinate moves in the last tenth; None of another.

    A velocity that tends to zero, as of a contact that creeps, changes by a share of itself.
    """
    times = np.linspace(0.9 * motion.end, motion.end, LOOKS)
    late = section_states(motion.system, motion.states(times).T, np.array(motion.system.scales(), dtype=float))
    if not stands_still(np.ptp(late, axis=0), SETTLED):
        return None
    names = [numbered("contact_velocity", k + 1) for k in range(motion.piece_sides.shape[1])]
    slides = [_even(motion.at(times, name)) for name in names]
    if any(slides):
        return OrbitStatus.SLIDES_STEADILY
    places = () if motion.system.cyclic is None else motion.at(times, motion.system.cyclic)
    return OrbitStatus.CARRIED if _even(np.diff(places)) else OrbitStatus.COMES_TO_REST


def _even(gains: np.ndarray) -> bool:
    """Whether each is the same way, and of the same size to a share."""
    return bool(len(gains)) and float(np.ptp(gains)) < STEADY * abs(float(gains[-1]))


def _within(motion: Trajectory, begin: float, end: float) -> tuple[np.ndarray, Any, float]:
    """A state soon after a return, amid the phase that begins there, its sides, and the time between two returns."""
    marks = [event.time for event in motion.events if begin + BESIDE * (end - begin) < event.time <= end]
    middle = 0.5 * (begin + (marks[0] if marks else end))
    state = motion.states([middle])[:, 0]
    sides = tuple(float(side) for side in motion.piece_sides[motion.piece_at(np.array([middle]))[0]])
    for contact, side in zip(equations(motion.system).contacts, sides, strict=True):
        if side == 0.0 and contact.is_state:
            state[contact.state] = 0.0
    return state, sides[0] if len(sides) == 1 else sides, end - begin


def comes_to_rest(motion: Trajectory) -> bool:
    """Whether a motion continues to rest by smaller and smaller stops, of which none is the last.

    So ends a linear loop with integral action around a contact that holds no more than it rubs: each slide is the one
    before on a smaller scale, turned round, so that stops shrink by one share, while the time that the integral needs
    to push the contact loose again grows by as much. Asked are the last stops of all contacts: their rates fall by one
    share below 1, and they grow longer. A contact that holds more than it rubs has a smallest slide: there is a cycle.
    """
    system = motion.system
    if not _rubs_as_it_holds(system):
        return False
    kinds = {f"{STICK}{number}" for number in ("", *(f"_{i}" for i in range(2, 1 + len(system.laws))))}
    stops = [event for event in motion.events if event.kind in kinds]
    at_rest = [not motion.piece_sides[motion.piece_at(np.array([stop.time]))[0]].any() for stop in stops]
    stops = [stop for stop, rests in zip(stops, at_rest, strict=True) if rests][-1 - STOPS :]
    if len(stops) <= STOPS:
        return False
    sizes = np.array(system.scales(), dtype=float)
    kept = [i for i, name in enumerate(system.state_names) if name != system.cyclic]
    rates = [system.rates(stop.time, tuple(stop.state.values()), (0,) * len(system.laws)) for stop in stops]
    speeds = np.max(np.abs(np.array(rates, dtype=float) / sizes)[:, kept], axis=1)
    lengths = np.diff([stop.time for stop in stops])
    if not np.all(speeds > 0.0):
        return False
    shares = speeds[1:] / speeds[:-1]
    return bool(np.all(shares <= NEARER) and np.ptp(shares) <= ALIKE * shares[-1] and np.all(np.diff(lengths) > 0.0))


def _rubs_as_it_holds(system: System) -> bool:
    """Whether contacts hold no more at rest than they rub in the slowest slide, which alone is set-valued then."""
    for law, load in zip(system.laws, system.law_loads, strict=True):
        if law.kind != "set-valued":
            return False
        limit, middle = law.holding_limit(load), law.holding_centre(load)
        slowest = [law.force(0.0, (0.0,) * len(law.internal), side, load)[0] for side in (1, -1)]
        if max(middle + limit - slowest[0], slowest[1] - (middle - limit)) > EXCESS * limit:
            return False
    return True
