"""Orbits of autonomous systems, such as a block on a belt: nothing drives them in time, and the period is unknown."""

import numpy as np

from vibrocap.motion.section import brought_back, section_states, winding
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import LONGEST_PERIOD
from vibrocap.orbits.closing.periodic_solution import (
    OrbitStatus,
    PeriodicSolution,
    floquet_multipliers,
    named_states,
)
from vibrocap.orbits.closing.shooting import CLOSED, MOST_STEPS, ROUNDING
from vibrocap.orbits.maps.differences import contradicted
from vibrocap.orbits.maps.stroboscopic_map import Images, StroboscopicMap
from vibrocap.physics.system import System

SIMULATED = 1e-10  # tolerance of the run that looks for a cycle
ARRIVED = 1e-6  # natural sizes within which a state is that of the turn before
CYCLES = 3  # turns of the contact that a run must show before the last is taken as a guess


def autonomous_orbit(
    system: System, start: np.ndarray, settle_periods: int, tolerance: float = 1e-12
) -> PeriodicSolution:
    """The cycle that a start leads to, of a system whose equations do not contain the time.

        P_T(y) = y  for y and T,  y moving across the flow only:  f(y_0) . (y - y_0) = 0  (over natural sizes)

    modulo travel and whole turns. The guess is one turn of a simulation, from one stick (or, without any, one reversal
    of the same direction) to the next; of a machine whose own turns go on, from one angle to where it and all other
    states are again. The multiplier 1 of the direction along the motion is left out. Where the motion comes to rest
    instead of cycling, the status is NOT_SETTLED.

    settle_periods: length of that simulation in `drive.period`
    """
    map_ = StroboscopicMap(system, tolerance)
    guess = _turn(system, start, settle_periods)
    if guess is None:
        ended = start
        unknown = np.full((map_.states,) * 2, np.nan)
        return _record(map_, ended, ended, 0.0, unknown, np.inf, OrbitStatus.NOT_SETTLED, 0)
    return _closed(map_, *guess)


def near_cycle(system: System, state: np.ndarray, period: float, tolerance: float = 1e-12) -> PeriodicSolution:
    """The cycle near a state [states] and a period, stable or not, by Newton's method as in `autonomous_orbit`."""
    map_ = StroboscopicMap(system, tolerance)
    return _closed(map_, state, map_.contact_side(state, map_.parameters()), period)


def _closed(map_: StroboscopicMap, state: np.ndarray, side: float, period: float) -> PeriodicSolution:
    """Newton's method from a guess."""
    parameters, scales = map_.parameters(), map_.scales(map_.parameters())
    state = brought_back(map_.system, state)
    free = map_.section_states[map_.free(state[None], parameters[None])[0][map_.section_states]]
    flow = map_.rates(state, side, parameters)[free] / scales[free]
    best, steps = _image(map_, state, period, parameters, scales), 0
    while best[0] > 1e-3 * CLOSED and steps < MOST_STEPS:
        steps += 1
        residual, image, jacobian = best
        along = map_.rates(image, side, parameters)[free] / scales[free]
        size = scales[free]
        slope = jacobian[np.ix_(free, free)] * size / size[:, None] - np.eye(len(free))
        bordered = np.block([[slope, along[:, None]], [flow[None, :], np.zeros((1, 1))]])
        mismatch = (map_.away(image, state) / scales)[free]
        step = np.linalg.lstsq(bordered, -np.append(mismatch, 0.0), rcond=1e-13)[0]
        following = state.copy()
        following[free] += step[:-1] * size
        found = _image(map_, following, period + step[-1], parameters, scales)
        if not found[0] < residual:
            break
        state, period, best = following, period + float(step[-1]), found
    status = OrbitStatus.CONVERGED if best[0] <= ROUNDING else OrbitStatus.NOT_CONVERGED
    if not np.isfinite(best[0]):
        status = OrbitStatus.RUN_FAILED
    elif status is OrbitStatus.CONVERGED:
        images = Images(best[1][None], best[2][None], np.array([True]), np.array([True]))
        if contradicted(map_, state, images, parameters, mark_distance=np.array([period])):
            status = OrbitStatus.CONTRADICTED
    return _record(map_, state, best[1], period, best[2], best[0], status, steps)


def _image(
    map_: StroboscopicMap, state: np.ndarray, period: float, parameters: np.ndarray, scales: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """(mismatch over natural sizes, image, derivative) after a time."""
    found = map_.images(state[None], parameters[None], 1, mark_distance=np.array([period]))
    assert found.jacobian is not None
    residual = float(np.max(np.abs(map_.away(found.state[0], state) / scales)[map_.section_states]))
    return residual if found.finished[0] and np.isfinite(residual) else np.inf, found.state[0], found.jacobian[0]


def _turn(system: System, start: np.ndarray, periods: int) -> tuple[np.ndarray, float, float] | None:
    """(state, side, time) of the last turn of a simulation, from the middle of a phase to that of the next like it."""
    motion = simulate(system, periods=periods, initial=named_states(system, start), tolerance=SIMULATED)
    for name, turn in system.machine.turns.items():
        if len(motion.piece_start) and (found := _around(motion, name, turn)) is not None:
            return found
    for kind in ("stick", "slip_back", "slip_forward", "reversal"):
        times = [event.time for event in motion.events if event.kind == kind]
        every = 2 if kind == "reversal" else 1
        if len(times) >= CYCLES * every + 1:
            return _within(motion, times[-1 - every], times[-1])
    return None


def _around(motion: Trajectory, name: str, turn: float) -> tuple[np.ndarray, float, float] | None:
    """As `_turn`, from the last passages of a coordinate that turns through one place; None where it does not go on.

    Of several turns as many are taken as bring all other states back best.
    """
    from scipy.optimize import brentq  # only here: most orbits are found without, and it takes long to load

    marks = [event.time for event in motion.events][-2:]
    end = 0.5 * sum(marks) if len(marks) == 2 else motion.end
    times = np.concatenate([np.asarray(motion.piece_start)[np.asarray(motion.piece_start) < end], [end]])
    here = float(motion.at(end, name)[0])
    way = np.sign(here - float(motion.at(0.0, name)[0]))
    ahead = way * (here - motion.at(times, name))  # how far it still has to go
    passages = []
    for k in range(1, LONGEST_PERIOD + 1):
        before = np.flatnonzero(ahead >= k * turn)
        if not len(before):
            break
        low, high = times[before[-1]], times[before[-1] + 1]
        passages.append(brentq(lambda t, k=k: way * (here - motion.at(t, name)[0]) - k * turn, low, high, xtol=1e-12))
    if len(passages) < CYCLES:
        return None
    sizes = np.array(motion.system.scales(), dtype=float)
    where = section_states(motion.system, motion.states([end, *passages]).T, sizes)
    away = np.max(np.abs(where[1:] - where[0]), axis=1)
    best = int(np.flatnonzero(away <= max(2.0 * np.min(away), ARRIVED))[0])
    state, side = motion.states([end])[:, 0], float(motion.at(end, "side")[0])
    if side == 0.0:
        state[motion.state_names.index(motion.system.machine.contact_state)] = 0.0
    return state, side, end - passages[best]


def _within(motion: Trajectory, begin: float, end: float) -> tuple[np.ndarray, float, float]:
    """A state soon after an event, amid the phase that begins there, its side, and the time between two such events."""
    marks = [event.time for event in motion.events if begin < event.time <= end]
    middle = 0.5 * (begin + marks[0])
    state = np.array([float(motion.at(middle, name)[0]) for name in motion.state_names])
    side = float(motion.at(middle, "side")[0])
    if side == 0.0:
        state[motion.state_names.index(motion.system.machine.contact_state)] = 0.0
    return state, side, end - begin


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
