"""The steady motion that a start leads to: simulated until it settles, then closed by shooting."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import depends_on_time
from vibrocap.numerics.kernel import memory_layout as memory
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.orbits.free_orbit import free_orbit
from vibrocap.orbits.orbit import Orbit, OrbitStatus
from vibrocap.orbits.shooting import SAME, closing, named_states, shoot
from vibrocap.orbits.stroboscopic_map import MOST_EVENTS, StroboscopicMap
from vibrocap.simulate import initial_state
from vibrocap.system import System

SETTLED = 1e-6  # distance to the steady motion, over natural sizes, from which Newton's method starts
ROUGH = 1e-9  # tolerance of the run there


def orbit(
    system: System,
    *,
    initial: Mapping[str, float] | None = None,
    response_period: int | None = None,
    half: bool = False,
    settle_periods: int = 2000,
    tolerance: float = 1e-12,
) -> Orbit:
    """The steady motion that a start leads to, closed to rounding.

    What a capsule does in the long run is periodic modulo a shift of its position: a relative periodic orbit, whose
    shift per period is the drift. The motion is simulated until its stroboscopic state has settled, which gives the
    response period, then closed by Newton's method (`shoot`), which also gives the Floquet multipliers. If the orbit
    is unstable the motion has not arrived: it is pushed off and followed to the orbit that it keeps; `Orbit.passed` is
    the one that it left, and `passed.pushed_off()` are the orbits to both sides. The orbit of a system without a drive
    that changes in time (a block on a belt) has a period of its own, which is found too.

    initial: the start of the simulation, by state name (those not named are zero)
    response_period, half: look for an orbit of so many drive periods (half: for a symmetric one) straight from
        `initial`, and only if none closes from where a simulation leads; finds unstable orbits too
    settle_periods: most drive periods simulated before it counts as not settled
    tolerance: of the runs, error per step over the natural size of each state
    Returns an `Orbit`; its `status` says whether it closed, and `status.advice` what to try if not.
    """
    start = list(initial_state(system, initial).values())
    if not depends_on_time(StroboscopicMap(system).equations.rates):
        return free_orbit(system, start, settle_periods, tolerance)
    start = np.array(start)
    if response_period is not None or half:
        return _asked_for(system, start, response_period or 1, half, settle_periods, tolerance)
    state, periods = settled_state(system, start, settle_periods)
    if periods == 0:
        return _not_settled(system, state, tolerance)
    found = shortest(shoot(system, named_states(system, state), periods, tolerance=tolerance))
    return _kept(found, state, periods, settle_periods) if found.status is OrbitStatus.CONVERGED else found


def _asked_for(
    system: System, start: np.ndarray, response_period: int, half: bool, settle_periods: int, tolerance: float
) -> Orbit:
    """The orbit of a period, or the symmetric one, near a start or else near where a simulation leads."""
    options = {"half": half, "tolerance": tolerance}
    found = shoot(system, named_states(system, start), response_period, **options)
    if found.status is OrbitStatus.CONVERGED:
        return found
    state, _ = settled_state(system, start, settle_periods)
    if not np.all(np.isfinite(state)):
        return found
    later = shoot(system, named_states(system, state), response_period, **options)
    return later if later.status is OrbitStatus.CONVERGED else found


def _kept(found: Orbit, state: np.ndarray, periods: int, settle_periods: int) -> Orbit:
    """The orbit that a simulation keeps, where it seemed to have settled: on from one that is unstable.

    A motion that passes close to an unstable orbit stands still for a while. Only Newton's method tells, which also
    may lead from a slow motion to an orbit that is elsewhere; then nothing is claimed.
    """
    from vibrocap.orbits.unstable import far_apart, pushed_off

    if far_apart(found, state) > np.sqrt(SETTLED):
        return closing(StroboscopicMap(found.system, found.tolerance), state, periods, OrbitStatus.NOT_CONVERGED)
    if not found.unstable:
        return found
    reached = pushed_off(found, towards=named_states(found.system, state), settle_periods=settle_periods)
    return dataclasses.replace(reached[0] if reached else _unsettled(found), passed=found)


def _unsettled(passed: Orbit) -> Orbit:
    """The record of a motion that leaves an unstable orbit and then does not settle: as of that orbit, not closed."""
    return dataclasses.replace(passed, status=OrbitStatus.NOT_SETTLED)


def shortest(found: Orbit) -> Orbit:
    """The same orbit over its shortest period: a motion that settles by turns may look longer than it is."""
    map_ = StroboscopicMap(found.system, found.tolerance)
    state = np.array(list(found.state.values()))
    for periods in range(1, found.response_period):
        divides = found.response_period % periods == 0 and found.status is OrbitStatus.CONVERGED
        if divides and closing(map_, state, periods, found.status).residual <= SAME:
            return shoot(found.system, found.state, periods, tolerance=found.tolerance)
    return found


def settled_state(system: System, start: Any, settle_periods: int) -> tuple[np.ndarray, int]:
    """(state at the end, response period) of a simulation that ends as soon as it has settled; period 0: it did not."""
    map_ = StroboscopicMap(system)
    budget = Budget(settle_periods, 1, SETTLED, ROUGH, MOST_EVENTS, 10**9)
    layout, results = ensemble_run(map_.equations, map_.parameters()[None], np.array([start], dtype=float), budget)
    first = len(memory.RESULT_HEAD) + layout.states
    settled = results[0, 0] == memory.DONE
    periods = int(results[0, memory.RESULT_HEAD.index("response_period")]) if settled else 0
    return results[0, first : first + layout.states].copy(), periods


def _not_settled(system: System, state: np.ndarray, tolerance: float) -> Orbit:
    """What is known of a motion that did not settle: how far it is from closing after one period."""
    return closing(StroboscopicMap(system, tolerance), state, 1, OrbitStatus.NOT_SETTLED)
