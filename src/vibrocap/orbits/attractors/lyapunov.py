"""Whether a motion is chaotic: Lyapunov exponents, correct through sticking, slip and reversal, and the 0-1 test."""

import dataclasses
import math
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.measures.recorded.settling import stroboscopic_states
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import stands_still
from vibrocap.numerics.api import Budget
from vibrocap.orbits.closing.periodic_solution import FORGOTTEN
from vibrocap.orbits.closing.settling_runs import SETTLED, iterates
from vibrocap.orbits.closing.shooting import differ
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap, is_driven
from vibrocap.orbits.maps.variations import LEEWAY
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Rate, Rates
from vibrocap.quantities.dimensional import Dimensional

ALIGNING = 0.1  # share of the periods in which directions turn towards those that grow most; not averaged
BATCHES = 16  # of the periods, from whose means the error is estimated
BLOCK = 4096  # periods of which derivatives are computed at a time
ASKED = 8  # periods whose derivative is compared with differences


@dataclasses.dataclass(frozen=True)
class LyapunovExponents(Dimensional):
    """Mean rates of growth of small changes along a motion, per time.

    value: the largest exponent: > 0 chaos, 0 quasi-periodic, < 0 what comes back. -inf where sticking forgets all
    error: estimate of how far `value` is from its limit, see `lyapunov_exponent`
    spectrum: all of them [moving states], largest first, without that of the cyclic coordinate (which is 0) and, where
        nothing drives the system in time, without that along the motion (which is 0 too); -inf for each direction that
        sticking forgets; errors: theirs (0 for those)
    periods: drive periods averaged over; finished: False where the motion could not be completed: of what there was
    certified: whether it was, and the evidence of all these periods is within the bounds of a certificate
        (`motion.evidence`); False: the motion is not one of the equations, or not to the tolerance
    """

    value: Rate
    error: Rate
    spectrum: Rates
    errors: Rates
    periods: int
    finished: bool
    certified: bool = True


def lyapunov_exponent(
    system: System,
    initial: ByName | None = None,
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
    orbit lambda_1 = log|largest multiplier|/period. Where nothing drives the system in time, the map is that over
    `drive.period`, of whatever length, and the first column of every Q is the direction of the motion: the others give
    the separation of neighbouring paths.

    initial: the start (states that are not named are zero); periods: averaged over, after `transient` others
    tolerance: of the runs, error per step over the natural size of each state
    The error is the largest of the standard error of 16 batch means, half the difference of the two halves' means, and
    the effect of the tolerance on the derivatives: a motion that visits its attractor evenly gives an error that falls
    as 1/sqrt(N), a periodic one as 1/N. Differences over eight of the periods have to agree with the derivatives; where
    they do not, they give the error. Exponents below log(tolerance)/period are lost in rounding.
    Returns `LyapunovExponents`. Raises ValueError naming the argument.
    """
    start = np.array(list(initial_state(system, initial).values()))
    check_whole("periods", periods, 20, 10**7)
    check_whole("transient", transient, 0, 10**9)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    map_ = StroboscopicMap(system, tolerance, threads)
    budget = Budget(max(transient, 1), tolerance, MOST_EVENTS, MOST_STEPS * max(transient, 1), window=1)
    begun = map_.run(budget, start[None], map_.parameters()) if transient else None
    if begun is not None and not begun.finished[0]:
        return exponents(map_, np.empty((0, map_.states)), False)
    states = iterates(map_, start[None] if begun is None else begun.state, periods)[:, 0]
    whole = np.all(np.isfinite(states), axis=1)
    return exponents(map_, states[whole][: periods if whole.all() else -1], bool(whole.all()))


def exponents(map_: StroboscopicMap, states: np.ndarray, finished: bool) -> LyapunovExponents:
    """Exponents along successive states at the section [periods, states], whose periods are computed side by side."""
    moving, parameters = map_.smooth_states, map_.parameters()
    if len(states) < BATCHES:
        nothing = np.full(len(moving), math.nan)
        return LyapunovExponents(math.nan, math.inf, nothing, np.full(len(moving), math.inf), len(states), False, False)
    size = map_.scales(parameters)[moving]
    growth = np.empty((len(states), len(moving)))
    certified = True
    directions = np.random.default_rng(0).normal(size=(len(moving), len(moving)))
    flow = None
    if not is_driven(map_.system):  # rates, which the derivative of the map carries into one another
        flow = map_.rates(states.T, map_.contact_side(states.T, parameters), parameters).T[:, moving] / size
    if flow is not None and stands_still(flow[-1] * map_.period(parameters), SETTLED):
        flow = None  # an equilibrium: every direction counts
    if flow is not None:
        directions[:, 0] = flow[0]
    along = 0 if flow is None else 1  # the first direction that is not that of the motion
    directions = np.linalg.qr(directions)[0]
    asked = dict.fromkeys(np.linspace(ALIGNING * len(states), len(states) - 1, ASKED).astype(int).tolist())
    for first in range(0, len(states), BLOCK):
        part = states[first : first + BLOCK]
        images = map_.images(part, parameters)
        assert images.jacobian is not None
        certified = certified and bool(images.certified.all())
        slopes = images.jacobian[:, moving][:, :, moving] * size / size[:, None]
        for k, slope in enumerate(slopes):
            if first + k in asked:
                asked[first + k] = directions[:, along], slope @ directions[:, along], images.state[k]
            grown = slope @ directions
            if flow is not None and first + k + 1 < len(flow):
                grown[:, 0] = flow[first + k + 1]
            directions, upper = np.linalg.qr(grown)
            growth[first + k] = np.abs(np.diag(upper))
    growth = growth[:, along:]
    doubt = _doubt(map_, states, asked, parameters)
    averaged = _averaged(map_, growth, map_.period(parameters), finished, doubt)
    return dataclasses.replace(averaged, certified=certified and finished)


def _doubt(map_: StroboscopicMap, states: np.ndarray, asked: dict, parameters: np.ndarray) -> float:
    """By how much the logarithm of the growth over a period is wrong, as far as differences tell; 0 where they agree.

    asked: by number of a state, (direction, its image by the derivative, image of the state)
    """
    moving, places, size = map_.smooth_states, list(asked), map_.scales(parameters)
    along, grown, images = (np.stack(column) for column in zip(*asked.values(), strict=True))
    directions = np.zeros((len(places), map_.states))
    directions[:, moving] = along * size[moving]
    directions *= map_.free(states[places], parameters[None])
    rows = np.tile(parameters, (len(places), 1))
    slopes, sure = map_.slopes_along(states[places], directions, images, rows)
    slopes = slopes[:, moving]
    wrong = [
        abs(math.log(max(float(np.linalg.norm(one)), FORGOTTEN) / max(float(np.linalg.norm(other)), FORGOTTEN)))
        for one, other, certain in zip(grown, slopes, sure, strict=True)
        if certain and differ(one, other)
    ]
    return sum(wrong) / max(1, int(np.sum(sure)))


def _averaged(
    map_: StroboscopicMap, growth: np.ndarray, period: float, finished: bool, doubt: float
) -> LyapunovExponents:
    """Means of the logarithms of growth [periods, directions] per time, and their errors, at least `doubt`."""
    least = FORGOTTEN if map_.resting else 0.0
    used = growth[round(ALIGNING * len(growth)) :]
    lost = np.any(used <= least, axis=0)
    rates = np.log(np.where(used <= least, 1.0, used)) / period
    mean = rates.mean(axis=0)
    batches = np.array([batch.mean(axis=0) for batch in np.array_split(rates, BATCHES)])
    halves = np.array([half.mean(axis=0) for half in np.array_split(rates, 2)])
    open_ = LEEWAY * map_.tolerance * np.mean(1.0 / np.where(used <= least, 1.0, used), axis=0)
    error = np.maximum(batches.std(axis=0, ddof=1) / math.sqrt(BATCHES), 0.5 * np.abs(halves[0] - halves[1]))
    error = np.maximum(error, (open_ + doubt) / period)
    mean, error = np.where(lost, -np.inf, mean), np.where(lost, 0.0, error)
    order = np.argsort(-mean, kind="stable")
    mean, error = mean[order], error[order]
    return LyapunovExponents(float(mean[0]), float(error[0]), mean, error, len(used), finished)


FREQUENCIES = 100
LOWEST, HIGHEST = math.pi / 5, 4 * math.pi / 5  # of c: farther out resonances are frequent
SHARE = 0.1  # of the series, the longest lag
FEWEST = 200  # values; Gottwald and Melbourne advise a thousand or more
CONSTANT = 1e-9  # extent over the largest value, below which a series stands still


@dataclasses.dataclass(frozen=True)
class ZeroOneTest:
    """Result of the 0-1 test: `value` near 1 is chaos, near 0 a periodic or quasi-periodic motion.

    value: median of `correlations`, one per frequency c in `frequencies` (radians per sample); samples: values used
    """

    value: float
    correlations: np.ndarray
    frequencies: np.ndarray
    samples: int


def zero_one_test(series: Any, *, frequencies: int = FREQUENCIES, seed: int = 0) -> ZeroOneTest:
    """The 0-1 test of Gottwald and Melbourne (SIAM J. Appl. Dyn. Syst. 8, 129-145, 2009), by correlation.

    The series phi drives a point in the plane, which wanders off as by chance if the series is chaotic and stays within
    bounds if it is regular:

        p(n) + i q(n) = sum_{j<=n} phi(j) exp(i j c)
        M(n) = mean_j |(p, q)(j + n) - (p, q)(j)|^2,   n <= N/10
        D(n) = M(n) - <phi>^2 (1 - cos n c)/(1 - cos c)           the modified mean-square displacement
        K(c) = correlation of D(n) with n;   the result is the median of K over c from (pi/5, 4 pi/5)

    series: [N] values, one per period (a finely sampled signal looks regular), or a `Trajectory`, of which the state at
        the section that varies most is taken, over its natural size, in the last half of the motion
    A series that stands still has K = 0. Weak chaos and slow transients need many values; noise counts as chaos.
    Returns `ZeroOneTest`. Raises ValueError for fewer than 200 values or what is no series of finite numbers.
    """
    phi = _values(series)
    check_whole("frequencies", frequencies, 1)
    count = len(phi)
    c = np.sort(np.random.default_rng(seed).uniform(LOWEST, HIGHEST, frequencies))
    if np.ptp(phi) <= CONSTANT * np.max(np.abs(phi)):
        return ZeroOneTest(0.0, np.zeros(frequencies), c, count)
    lags = np.arange(1, int(SHARE * count) + 1)
    displacement = np.stack([_displacement(phi, frequency, len(lags)) for frequency in c])
    swinging = np.mean(phi) ** 2 * (1.0 - np.cos(lags * c[:, None])) / (1.0 - np.cos(c[:, None]))
    correlations = _correlations(displacement - swinging, lags)
    return ZeroOneTest(float(np.median(correlations)), correlations, c, count)


def _values(series: Any) -> np.ndarray:
    if isinstance(series, Trajectory):
        states = stroboscopic_states(series)
        states = states[len(states) // 2 :]
        series = states[:, np.argmax(np.ptp(states, axis=0))] if len(states) else states.ravel()
    try:
        phi = np.asarray(series, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError("series", f"should be numbers, one per period, or a motion, got {series!r}") from None
    if phi.ndim != 1 or len(phi) < FEWEST:
        why = f"should be at least {FEWEST} numbers in a row, got an array of shape {phi.shape}"
        raise ArgumentError("series", why)
    if not np.all(np.isfinite(phi)):
        why = f"should be finite, got {phi[~np.isfinite(phi)][0]} at {np.argmin(np.isfinite(phi))}"
        raise ArgumentError("series", why)
    return phi


def _displacement(phi: np.ndarray, c: float, longest: int) -> np.ndarray:
    """M(n) for n = 1 ... longest, each a mean over the same number of j."""
    count = len(phi)
    z = np.cumsum(phi * np.exp(1j * c * np.arange(1, count + 1)))
    used = count - longest
    size = 1 << (2 * count - 1).bit_length()
    first = np.where(np.arange(count) < used, z, 0.0)
    products = np.fft.ifft(np.conj(np.fft.fft(first, size)) * np.fft.fft(z, size))[1 : longest + 1]
    squares = np.concatenate(([0.0], np.cumsum(np.abs(z) ** 2)))
    later = squares[used + 1 : used + longest + 1] - squares[1 : longest + 1]
    return (later + squares[used] - 2.0 * products.real) / used


def _correlations(rows: np.ndarray, lags: np.ndarray) -> np.ndarray:
    rows = rows - rows.mean(axis=1, keepdims=True)
    ramp = lags - lags.mean()
    spread = np.sqrt(np.sum(rows**2, axis=1) * np.sum(ramp**2))
    return np.divide(rows @ ramp, spread, out=np.zeros(len(rows)), where=spread > 0.0)
