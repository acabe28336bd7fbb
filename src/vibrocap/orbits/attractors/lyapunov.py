"""Lyapunov exponents: how fast neighbouring motions part, correct through sticking, slipping and reversal."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.numerics.api import Budget
from vibrocap.orbits.closing.periodic_solution import FORGOTTEN
from vibrocap.orbits.maps.settling_runs import iterates
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap, driven_map
from vibrocap.physics.system import System

ALIGNING = 0.1  # share of the periods in which directions turn towards those that grow most; not averaged
BATCHES = 16  # of the periods, from whose means the error is estimated
BLOCK = 4096  # periods of which derivatives are computed at a time


@dataclasses.dataclass(frozen=True)
class LyapunovExponents:
    """Mean rates of growth of small changes along a motion, per time.

    value: the largest exponent: > 0 chaos, 0 quasi-periodic, < 0 what comes back. -inf where sticking forgets all
    error: estimate of how far `value` is from its limit, see `lyapunov_exponent`
    spectrum: all of them [moving states], largest first, without that of the cyclic coordinate (which is 0); -inf for
        each direction that sticking forgets; errors: theirs (0 for those)
    periods: drive periods averaged over; finished: False where the motion could not be completed: of what there was
    certified: whether the evidence of all these periods is within the bounds of a certificate (`motion.run_evidence`);
        False: the motion is not one of the equations, or not to the tolerance
    """

    value: float
    error: float
    spectrum: np.ndarray
    errors: np.ndarray
    periods: int
    finished: bool
    certified: bool = True


def lyapunov_exponent(
    system: System,
    initial: Mapping[str, float] | None = None,
    *,
    periods: int = 1000,
    transient: int = 200,
    tolerance: float = 1e-12,
    threads: int | None = None,
) -> LyapunovExponents:
    """The largest Lyapunov exponent of the motion from a start, with the others.

        lambda_i = lim 1/(N T) sum over periods of log |R_ii|,     J_k Q_(k-1) = Q_k R_k

    (Benettin et al. 1980; Shimada and Nagashima 1979), where J_k is the derivative of the stroboscopic map over period
    k, from the variational equations with saltation at every event, and the QR factors turn the directions anew in each
    period. A contact that sticks forgets a direction: R_ii is zero there and the exponent is -inf. For a periodic
    orbit lambda_1 = log|largest multiplier|/period.

    initial: the start (states that are not named are zero); periods: averaged over, after `transient` others
    tolerance: of the runs, error per step over the natural size of each state
    The error is the larger of the standard error of 16 batch means and half the difference of the two halves' means: a
    motion that visits its attractor evenly gives an error that falls as 1/sqrt(N), a periodic one as 1/N. Exponents
    below log(tolerance)/period are lost in rounding.
    Returns `LyapunovExponents`. Raises ValueError naming the argument; so it does for a system that nothing drives in
    time.
    """
    start = np.array(list(initial_state(system, initial).values()))
    check_whole("periods", periods, 20, 10**7)
    check_whole("transient", transient, 0, 10**9)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    map_ = driven_map(system, tolerance, threads)
    parameters = map_.parameters()
    state = advanced(map_, start, parameters, transient)
    if state is None:
        return exponents(map_, np.empty((0, map_.states)), parameters, False)
    found = iterates(map_, state[None], parameters[None], periods)[:, 0]
    whole = np.all(np.isfinite(found), axis=1)
    return exponents(map_, found[whole][: periods if whole.all() else -1], parameters, bool(whole.all()))


def advanced(map_: StroboscopicMap, state: np.ndarray, parameters: np.ndarray, periods: int) -> np.ndarray | None:
    """The state so many periods later; None where the run could not be completed."""
    if periods == 0:
        return state
    budget = Budget(periods, 1, 0.0, map_.tolerance, MOST_EVENTS, MOST_STEPS * periods)
    ends = map_.run(budget, state[None], parameters[None])
    return ends.state[0] if ends.finished[0] else None


def exponents(map_: StroboscopicMap, states: np.ndarray, parameters: np.ndarray, finished: bool) -> LyapunovExponents:
    """Exponents along successive states at the section [periods, states], whose periods are computed side by side."""
    moving = map_.smooth_states
    if len(states) < BATCHES:
        nothing = np.full(len(moving), math.nan)
        return LyapunovExponents(math.nan, math.inf, nothing, np.full(len(moving), math.inf), len(states), False)
    size = map_.scales(parameters)[moving]
    growth = np.empty((len(states), len(moving)))
    certified = True
    directions = np.linalg.qr(np.random.default_rng(0).normal(size=(len(moving), len(moving))))[0]
    for first in range(0, len(states), BLOCK):
        part = states[first : first + BLOCK]
        found = map_.images(part, np.tile(parameters, (len(part), 1)))
        assert found.jacobian is not None
        certified = certified and bool(found.certified.all())
        slopes = found.jacobian[:, moving][:, :, moving] * size / size[:, None]
        for k, slope in enumerate(slopes):
            directions, upper = np.linalg.qr(slope @ directions)
            growth[first + k] = np.abs(np.diag(upper))
    return dataclasses.replace(_averaged(map_, growth, map_.period(parameters), finished), certified=certified)


def _averaged(map_: StroboscopicMap, growth: np.ndarray, period: float, finished: bool) -> LyapunovExponents:
    """Means of the logarithms of growth [periods, directions] per time, and their errors."""
    least = FORGOTTEN if map_.equations.hold is not None else 0.0
    used = growth[round(ALIGNING * len(growth)) :]
    lost = np.any(used <= least, axis=0)
    rates = np.log(np.where(used <= least, 1.0, used)) / period
    mean = rates.mean(axis=0)
    batches = np.array([batch.mean(axis=0) for batch in np.array_split(rates, BATCHES)])
    halves = np.array([half.mean(axis=0) for half in np.array_split(rates, 2)])
    error = np.maximum(batches.std(axis=0, ddof=1) / math.sqrt(BATCHES), 0.5 * np.abs(halves[0] - halves[1]))
    mean, error = np.where(lost, -np.inf, mean), np.where(lost, 0.0, error)
    order = np.argsort(-mean, kind="stable")
    mean, error = mean[order], error[order]
    return LyapunovExponents(float(mean[0]), float(error[0]), mean, error, len(used), finished)
