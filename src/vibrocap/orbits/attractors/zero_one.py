"""The 0-1 test for chaos: one number of one series, without derivatives and without a reconstructed phase space."""

import dataclasses
import math
from typing import Any

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.measures.recorded.settling import stroboscopic_states
from vibrocap.motion.trajectory import Trajectory

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
    displacement = np.stack([_displacement(phi, each, len(lags)) for each in c])
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
        raise ValueError(f"series should be numbers, one per period, or a motion, got {series!r}") from None
    if phi.ndim != 1 or len(phi) < FEWEST:
        raise ValueError(f"series should be at least {FEWEST} numbers in a row, got an array of shape {phi.shape}")
    if not np.all(np.isfinite(phi)):
        raise ValueError(f"series should be finite, got {phi[~np.isfinite(phi)][0]} at {np.argmin(np.isfinite(phi))}")
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
    """Correlation of each row with the lags; 0 for a row that does not vary."""
    rows = rows - rows.mean(axis=1, keepdims=True)
    ramp = lags - lags.mean()
    spread = np.sqrt(np.sum(rows**2, axis=1) * np.sum(ramp**2))
    return np.divide(rows @ ramp, spread, out=np.zeros(len(rows)), where=spread > 0.0)
