"""The period of a force record without looking for its phases: from its spectrum and its correlation."""

import dataclasses

import numpy as np

from vibrocap.quantities.declared import Seconds

BANDS = 24  # of the spectrum in an octave
WIDTH = 4  # bands: standard deviation of the weights that smooth the spectrum; 1/6 octave
FEWEST = 3  # periods in a record
REPEATS = 0.3  # correlation at a period that is one; noise of 1000 samples, whatever its colour, seldom reaches it
BEST_TERM = 0.5  # the first peak of the correlation counts that stands out at least this share of the most outstanding
STRETCHES, LEAST_PERIODS = 8, 8  # of a record, whose periods are compared, and periods that each has at least
MATTERS = 0.05  # change of the period, over the period
OUTSTANDING = 0.1  # a peak of the correlation stands out at least so much


@dataclasses.dataclass(frozen=True)
class Recurrence:
    """How a force record repeats.

    spectral_period: where f^2 S(f) is largest, the power S weighted against slow wandering [s]; for an irregular
        record its typical period, to a tenth or two; None where there is no peak
    correlation_period: the first outstanding peak of the correlation of the force with itself [s], up to a third of the
        record; None where the force repeats too little (correlation below 0.3)
    correlation: the correlation there, 1 for a periodic record
    """

    spectral_period: Seconds | None
    correlation_period: Seconds | None
    correlation: float | None


def recurrence(force: np.ndarray, step: float, window: int = 1) -> Recurrence:
    """How a force record repeats, from its spectrum and its correlation; independent of any phases.

    force: [n], evenly spaced;  step: [s];  window: samples of a running mean that takes the noise out first
    The weighted power f^2 S(f) (per octave: f times f S) is flat for a level that wanders (S ~ 1/f^2): there a period
    stands out that the power itself would hide.
    """
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import detrend

    smooth = detrend(uniform_filter1d(force, window, mode="nearest"))
    if float(np.ptp(smooth)) == 0.0:
        return Recurrence(None, None, None)
    period, correlation = _correlation_period(smooth, step)
    return Recurrence(_spectral_period(smooth, step, window), period, correlation)


@dataclasses.dataclass(frozen=True)
class Drift:
    """How a period changes in the course of a record: its mean in the first and in the last third [s].

    error: standard error of their difference [s];  significant: whether they differ by more than twice that, and by
        more than a twentieth
    """

    first: Seconds
    last: Seconds
    error: Seconds

    @property
    def significant(self) -> bool:
        """Whether the period changes by more than chance."""
        return abs(self.last - self.first) > max(2.0 * self.error, MATTERS * self.first)


def period_drift(periods: np.ndarray) -> Drift | None:
    """The drift of periods in their order [n]; None for fewer than nine."""
    third = len(periods) // 3
    if third < 3:
        return None
    first, last = periods[:third], periods[-third:]
    error = float(np.sqrt(first.var(ddof=1) / third + last.var(ddof=1) / third))
    return Drift(float(first.mean()), float(last.mean()), error)


def stretch_periods(force: np.ndarray, step: float, window: int, period: float) -> np.ndarray:
    """Spectral periods of stretches of a record [n], where each holds enough of them."""
    count = min(STRETCHES, int(len(force) * step / (LEAST_PERIODS * period)))
    if count < 2:
        return np.array([period])
    periods = [recurrence(part, step, window).spectral_period for part in np.array_split(force, count)]
    return np.array([period for period in periods if period is not None])


def _spectral_period(force: np.ndarray, step: float, window: int) -> float | None:
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    number = len(force)
    power = np.abs(np.fft.rfft(force * np.hanning(number))[1:]) ** 2
    frequency = np.fft.rfftfreq(number, step)[1:]
    octave = np.log2(frequency)
    low, high = np.log2(FEWEST / (number * step)), np.log2(0.5 / (max(window, 2) * step))
    if high <= low:
        return None
    grid = np.arange(low, high, 1.0 / BANDS)
    edges = np.append(grid, grid[-1] + 1.0 / BANDS) - 0.5 / BANDS
    weighted = power * frequency
    smoothed = gaussian_filter1d(np.histogram(octave, edges, weights=weighted)[0], WIDTH, mode="constant")
    peaks = find_peaks(smoothed)[0]
    if not len(peaks):
        return None
    near = np.abs(octave - grid[peaks[np.argmax(smoothed[peaks])]]) < 1.5 * WIDTH / BANDS
    return float(power[near].sum() / (power[near] @ frequency[near]))


def _correlation_period(force: np.ndarray, step: float) -> tuple[float | None, float | None]:
    from scipy.signal import find_peaks

    number = len(force)
    lags = number // FEWEST
    spectrum = np.fft.rfft(force, 2 * number)
    # Divided by how many products each lag has, so that late peaks are as high as early ones.
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:lags] / (number - np.arange(lags))
    correlation /= correlation[0]
    peaks, about = find_peaks(correlation, prominence=OUTSTANDING)
    if not len(peaks):
        return None, None
    outstanding = about["prominences"]
    first = int(peaks[np.argmax(outstanding >= BEST_TERM * outstanding.max())])
    left, middle, right = correlation[first - 1 : first + 2]
    shift = 0.5 * (left - right) / (left - 2.0 * middle + right) if left - 2.0 * middle + right < 0 else 0.0
    if middle < REPEATS:
        return None, None
    return float((first + shift) * step), float(middle)
