"""The period of a force record, from its spectrum and its correlation, and the regime of a pulled slider: what motion
the record shows, and what decides.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.quantities.declared import Seconds
from vibrocap.records.phases import Phase

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


STICK_SLIP, INERTIAL, STEADY, SLOW = "stick-slip", "inertial", "steady", "slow oscillation"
# A block on static and kinetic Coulomb friction has P/T0 = 1 + (x - atan x)/pi, x = w D/V, and sticks for the share
# x/(x + pi - atan x) of its period P: half of it where x = pi - atan x. Between its extremes its force rises for the
# share 1 - T0/(2 P), there 0.61.
HALF_STICK_X, HALF_STICK_RATIO = 2.0288, 1.29
STICKS, RISES = 0.4, 0.6  # shares of the time, less than half to allow for noise; a sine rises for half of it
STRAIGHT = 0.08  # bend of stick phases over the fall; measured: 0.03 at most where it sticks, 0.13 in coloured noise
MISSED = 1.3  # times the period of the spectrum, from which on the falls that stand above the noise are not all
BARELY = 2.0  # times the least significant fall: falls that are no larger on average may be missed
AGREE = 0.2  # relative difference of two periods that are the same
REGULAR = 0.3  # standard deviation of the intervals between tops over their mean, where there is a period


@dataclasses.dataclass(frozen=True)
class Regime:
    """What kind of motion a force record shows, and what decided it.

    name: "stick-slip": straight stick phases for at least 0.4 of the time, and a period of at least 1.29 inertial
        periods, above which a Coulomb block sticks for more than half of the time;
        "inertial": a regular oscillation whose period is near or below the inertial one, or whose force is about as
        long rising as falling where that period is not known;
        "steady": no fluctuation above the noise, or one without a period;
        "slow oscillation": a regular one, slower than inertia explains and without stick phases, driven from elsewhere
    reason: the same in a sentence, with the numbers
    typical_period: median time between tops [s], or where only some falls stand above the noise that of the spectrum
        (`from_spectrum`);  irregularity: standard deviation of these times over their mean
    inertial_period: 2 pi sqrt(m/k) [s];  period_ratio: typical_period over it; None where mass or stiffness is unknown
    stick_fraction, rise_fraction: shares of the time in stick phases, and in which the force rises
    stick_bend: how far from straight the force is in stick phases, over the mean fall
    """

    name: str
    reason: str
    typical_period: Seconds | None
    irregularity: float | None
    inertial_period: Seconds | None
    period_ratio: float | None
    stick_fraction: float | None
    rise_fraction: float | None
    stick_bend: float | None
    from_spectrum: bool = False


def regime(
    phases: Sequence[Phase],
    tops: np.ndarray,
    bottoms: np.ndarray,
    recurrence: Recurrence,
    inertial_period: float | None,
    bend: float | None,
    clearness: float = float("inf"),
) -> Regime:
    """What kind of motion phases and turning points [s] show; see `Regime` for what decides.

    clearness: mean fall over the least that is significant. Where most falls were missed, the spectrum tells the period
    """
    if len(tops) < 3:
        few = "no fall of the force stands" if not len(tops) else f"only {len(tops)} falls of the force stand"
        return Regime(STEADY, f"{few} above the noise", None, None, inertial_period, None, None, None, None)
    intervals = np.diff(tops)
    period = float(np.median(intervals))
    irregularity = float(intervals.std() / intervals.mean())
    rises = float((tops[1:] - bottoms[:-1]).sum() / (bottoms[-1] - bottoms[0]))
    resting = sum(phase.duration for phase in phases if phase.kind == "stick")
    sticks = resting / (phases[-1].end - phases[0].start)
    mean, spectral = float(intervals.mean()), recurrence.spectral_period
    missed = spectral is not None and falls_missed(mean, recurrence, clearness)
    period = spectral if spectral is not None and missed else period
    ratio = None if inertial_period is None else period / inertial_period
    if missed:
        near = ratio is None or ratio < HALF_STICK_RATIO
        name, how = (INERTIAL, "swings on its spring") if near else (SLOW, "oscillates more slowly than by its inertia")
        why = f"the spectrum has a period of {period:.4g} s, and falls stand above the noise every {mean:.4g} s only"
        compared = "" if ratio is None else f"; it is {ratio:.3g} times 2 pi sqrt(m/k) = {inertial_period:.4g} s"
        how = f"{how}: {why}{compared}"
        return Regime(name, how, period, irregularity, inertial_period, ratio, None, rises, bend, True)
    repeats = recurrence.correlation_period is not None or irregularity <= REGULAR
    far = ratio is None or ratio >= HALF_STICK_RATIO
    share = f"sticks {sticks:.0%} of the time, the force rises {rises:.0%} of it"
    compared = (
        "; mass or stiffness is not given, so the period was not compared with 2 pi sqrt(m/k)"
        if inertial_period is None
        else f"; the time between tops, {period:.4g} s, is {ratio:.3g} times 2 pi sqrt(m/k) = {inertial_period:.4g} s"
    )
    straight = bend is None or bend <= STRAIGHT
    if far and straight and sticks >= STICKS and rises >= RISES:
        name, reason = STICK_SLIP, share + compared
    elif not repeats:
        name, reason = STEADY, f"fluctuates without a period (intervals vary by {irregularity:.0%}), {share}"
    elif far and ratio is not None:
        name, reason = SLOW, f"oscillates more slowly than by its inertia, without sticking long: {share}{compared}"
    else:
        name, reason = INERTIAL, f"swings on its spring: {share}{compared}"
    return Regime(name, reason, period, irregularity, inertial_period, ratio, sticks, rises, bend)


def falls_missed(period: float, recurrence: Recurrence, clearness: float) -> bool:
    """Whether the mean period between tops is so much longer than the spectrum's that falls must have been missed."""
    spectral, repeats = recurrence.spectral_period, recurrence.correlation_period
    if spectral is None or period < MISSED * spectral:
        return False
    return clearness < BARELY or (repeats is not None and abs(repeats / spectral - 1.0) < AGREE)
