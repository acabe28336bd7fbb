"""Orbits of autonomous systems, such as a block on a belt: nothing drives them in time, and the period is unknown."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.section import brought_back, section_states, winding
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import stands_still
from vibrocap.orbits.closing.coming_to_rest import comes_to_rest
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution, floquet_multipliers
from vibrocap.orbits.closing.returns import ARRIVED, RECURRENT, Section, recurrence, returns_of
from vibrocap.orbits.closing.shooting import CLOSED, Closure
from vibrocap.orbits.maps.differences import contradicted
from vibrocap.orbits.maps.settling_runs import SETTLED
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, named_states, state_vector
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System

SIMULATED = 1e-10  # tolerance of the run that looks for a cycle
MOST_RETURNS = 64  # of a cycle, unless told otherwise
QUIET = 3.0  # longest times between returns without one, after which a section is no longer met
LOOKS = 64  # instants at which a motion at rest is looked at
STEADY = 1e-3  # of its own value, by which a velocity may change that is constant
BESIDE = 1e-6  # of a cycle: an event so soon after a return belongs to it


def autonomous_orbit(
    system: System,
    start: np.ndarray,
    settle_periods: int,
    tolerance: float = 1e-12,
    section: Section | None = None,
    returns: int = MOST_RETURNS,
) -> PeriodicSolution:
    """The cycle that a start leads to, of a system whose equations do not contain the time.

        P_T(y) = y  for y and T,  y moving across the flow only:  f(y_0) . (y - y_0) = 0  (over natural sizes)

    modulo travel and whole turns. The guess comes from a simulation: the motion returns to a section, and the cycle is
    as many returns as bring its last passage back. Without a section several are tried (a place of what turns, sticks,
    slips, reversals of each contact, the middle of each state), and that is taken at which the motion comes back best.
    The multiplier 1 of the direction along the motion is left out. Where the motion ends at an equilibrium instead of
    cycling, the status is SLIDES_STEADILY, CARRIED or COMES_TO_REST, the last also in the limit by ever smaller stops.

    settle_periods: length of that simulation in `drive.period`; returns: most of them in a cycle
    """
    map_ = StroboscopicMap(system, tolerance)
    motion = simulate(system, periods=settle_periods, initial=named_states(system, start), tolerance=SIMULATED)
    guess = _turn(motion, section, returns)
    if isinstance(guess, OrbitStatus):
        unknown, ended = np.full((map_.states,) * 2, np.nan), state_vector(system, motion.state)
        return _record(map_, ended, ended, 0.0, unknown, np.inf, guess, 0)
    state, sides, period, passed = guess
    closed_orbit = _closed(map_, state, sides, period)
    return dataclasses.replace(closed_orbit, returns=passed) if closed_orbit.closes else closed_orbit


def near_cycle(system: System, state: np.ndarray, period: float, tolerance: float = 1e-12) -> PeriodicSolution:
    """The cycle near a state [states] and a period, stable or not, by Newton's method as in `autonomous_orbit`."""
    map_ = StroboscopicMap(system, tolerance)
    return _closed(map_, state, map_.contact_side(state, map_.parameters()), period)


def _closed(map_: StroboscopicMap, state: np.ndarray, side: Any, period: float) -> PeriodicSolution:
    """The cycle near a guess, by shooting with the period as an unknown."""
    closure = Closure(map_, brought_back(map_.system, state), side=side)
    best, steps = closure.closed(np.append(closure.start, period))
    status, period = OrbitStatus.CONVERGED, float(best.x[-1])
    if best.residual > CLOSED.rounding:
        status = OrbitStatus.NOT_CONVERGED if best.finished else OrbitStatus.RUN_FAILED
    else:
        if contradicted(map_, best.state, best.images, closure.parameters, mark_distance=np.array([period])):
            status = OrbitStatus.CONTRADICTED
    return _record(map_, best.state, best.image, period, best.jacobian, best.residual, status, steps)


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


def _record(
    map_: StroboscopicMap,
    state: np.ndarray,
    image: np.ndarray,
    period: float,
    jacobian: np.ndarray,
    residual: float,
    status: OrbitStatus,
    steps: int,
) -> PeriodicSolution:
    """The record of the cycle from a state to its image."""
    system = map_.system
    multipliers = np.empty(0, dtype=complex)
    if np.all(np.isfinite(jacobian)):
        multipliers = floquet_multipliers(map_, jacobian)
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
    return PeriodicSolution(
        system=system,
        state=named_states(system, state),
        period=period,
        response_period=0,
        drift=float(image[map_.cyclic] - state[map_.cyclic]) if map_.cyclic >= 0 else None,
        multipliers=multipliers,
        residual=residual,
        symmetric=None,
        derivative=jacobian,
        status=status,
        iterations=steps,
        tolerance=map_.tolerance,
        winding=winding(system, image - state),
    )
