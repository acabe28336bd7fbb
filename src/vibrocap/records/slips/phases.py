"""Slips in a noisy force record: falls of the force that stand above its noise, and the phases between them.

While a slider that is pulled through a spring sticks, the force rises at the loading rate k V; when it slips, the force
falls fast. What stands above the noise is decided by the record itself: its second differences tell its noise.
"""

import dataclasses

import numpy as np

from vibrocap.quantities.declared import RecordedForce, Seconds
from vibrocap.records.slips.corners import Corner, fitted_corners

SIGNIFICANT = 8.0  # a reversal is one if it is so many standard deviations of the smoothed noise: none of 1e6 by chance
CLEAR = 10.0  # smoothing goes on until the mean fall is so many times the least significant one
LEAST_SLIPS = 3  # two periods
SPIKE = 5.0  # standard deviations off the running median
SPIKE_WIDTH = 7  # samples of the running median: spikes of up to three samples go, steps stay


@dataclasses.dataclass(frozen=True)
class Phase:
    """A stretch of a record in which the slider sticks or slips.

    kind: "stick" or "slip"
    start, end: times [s];  start_error, end_error: their standard errors [s], from noise and sampling
    start_force, end_force: fitted levels at both ends, unit of the record: of a slip, the static level and the level at
        its end;  force_error: the larger of their standard errors
    minor: True for a slip whose fall is less than a share (half, unless asked otherwise) of the mean fall
    """

    kind: str
    start: Seconds
    end: Seconds
    start_force: RecordedForce
    end_force: RecordedForce
    start_error: Seconds
    end_error: Seconds
    force_error: RecordedForce
    minor: bool = False

    @property
    def duration(self) -> float:
        return self.end - self.start

    @property
    def fall(self) -> float:
        """Force at the start less force at the end."""
        return self.start_force - self.end_force


@dataclasses.dataclass(frozen=True)
class Falls:
    """Falls of the force that stand above the noise.

    force: the record without spikes [n];  spikes: how many samples were replaced
    noise: standard deviation of the noise of one sample
    window: samples of the running mean that shows the falls;  least: the least fall that is significant there
    tops, bottoms: turning points [m], indices: each fall goes from a top to the next bottom
    """

    force: np.ndarray
    spikes: int
    noise: float
    window: int
    least: float
    tops: np.ndarray
    bottoms: np.ndarray


def noise_level(force: np.ndarray, window: int = 1) -> float:
    """Standard deviation of the noise that a running mean over `window` samples leaves, unit of the record.

    Third differences of the means of neighbouring blocks take out level, slope and bend; their median, unlike their
    mean square, does not see slips and spikes. The variance of F[i] - 3 F[i-1] + 3 F[i-2] - F[i-3] is 20 sigma^2. The
    block means tell directly what noise with correlated neighbours (a filtered record) leaves. A coarsely digitised
    record repeats values: its noise is at least that of rounding, quantum/sqrt(12). Limit: noise that is slower than
    the window is not told from the force.
    """
    blocks = force[: len(force) // window * window].reshape(-1, window).mean(axis=1)
    spread = float(np.median(np.abs(np.diff(blocks, 3)))) / (0.674490 * 20.0**0.5) if len(blocks) > 3 else 0.0
    steps = np.abs(np.diff(force))
    steps = steps[steps > 1e-9 * float(np.ptp(force))]
    # Only a digitised record has many steps of the same least size.
    digitised = len(steps) > 0 and float(np.mean(steps < 1.5 * steps.min())) > 0.05
    rounding = float(steps.min()) / 12.0**0.5 if digitised else 0.0
    return max(spread, rounding / window**0.5)


def falls(force: np.ndarray) -> Falls:
    """The falls of a force record that stand above its noise, at the least smoothing that shows them clearly.

    Turning points are found with hysteresis: a top counts once the force has come down from it by SIGNIFICANT standard
    deviations of what noise the running mean leaves. The mean is symmetric, so it shifts nothing. Its window doubles
    from one sample on until the mean fall is CLEAR times as large as that. A window that reaches the period flattens
    the falls: if none shows them clearly, the one that shows them best is taken. Falls that do not last were peaks.
    """
    from scipy.ndimage import uniform_filter1d

    noise = noise_level(force)
    clean, spikes = _without_spikes(force, noise)
    none = np.zeros(0, dtype=int)
    best, clearest = (1, SIGNIFICANT * noise, none, none), 0.0
    window = 1
    while window <= len(force) // 8:
        smooth = uniform_filter1d(clean, window, mode="nearest")
        left = max(noise_level(clean, window), noise / window**0.5)
        least = max(SIGNIFICANT * left, 1e-6 * float(np.ptp(clean)))
        tops, bottoms = _turning_points(smooth, least, max(1, window // 8))
        if len(tops) >= LEAST_SLIPS:
            clearness = float(np.mean(smooth[tops] - smooth[bottoms])) / least
            if clearness > clearest:
                best, clearest = (window, least, tops, bottoms), clearness
            if clearness >= CLEAR:
                break
        elif clearest > 0:
            break
        window = 2 * window + 1
    window, least, tops, bottoms = best
    lasting = _lasting(clean, tops, bottoms, window, least)
    return Falls(clean, spikes, noise, window, least, tops[lasting], bottoms[lasting])


def phases(time: np.ndarray, record: Falls) -> tuple[Phase, ...]:
    """Slips, and the stick phases between them, in order of time.

    time: evenly spaced [n] s
    What lies before the first and after the last slip is no whole phase and left out; so is a stick phase of no length,
    as in a motion that never sticks.
    """
    starts, ends = fitted_corners(time, record.force, record.noise, record.tops, record.bottoms)
    result: list[Phase] = []
    for index, (start, end) in enumerate(zip(starts, ends, strict=True)):
        if index and start.time > ends[index - 1].time:
            result.append(_phase("stick", ends[index - 1], start))
        result.append(_phase("slip", start, end))
    return tuple(result)


def with_minor(every: tuple[Phase, ...], share: float) -> tuple[Phase, ...]:
    """The same phases, the slips whose fall is less than a share of the mean fall marked as minor; none for 0."""
    slips = [phase.fall for phase in every if phase.kind == "slip"]
    least = share * float(np.mean(slips)) if slips and share > 0 else -np.inf
    return tuple(dataclasses.replace(phase, minor=phase.kind == "slip" and phase.fall < least) for phase in every)


def stick_bend(time: np.ndarray, record: Falls, every: tuple[Phase, ...]) -> float | None:
    """How far from straight the force is while the slider sticks, over the mean fall; None without stick phases.

    The median over the stick phases of the standard deviation about a line, the noise taken off. It is a few hundredths
    where a slider sticks, and 0.1 or more in a force that only wanders.
    """
    slips = [phase.fall for phase in every if phase.kind == "slip"]
    bends = []
    for phase in every:
        first, last = np.searchsorted(time, (phase.start, phase.end))
        if phase.kind == "stick" and last - first > 2 * LEAST_SLIPS:
            place, force = time[first:last] - phase.start, record.force[first:last]
            rest = force - np.polynomial.Polynomial.fit(place, force, 1)(place)
            bends.append(max(0.0, float(rest @ rest) / (len(rest) - 2) - record.noise**2) ** 0.5)
    return float(np.median(bends)) / abs(float(np.mean(slips))) if bends and np.mean(slips) else None


def _phase(kind: str, start: Corner, end: Corner) -> Phase:
    times, errors = (start.time, end.time), (start.time_error, end.time_error)
    return Phase(kind, *times, start.force, end.force, *errors, max(start.force_error, end.force_error))


def _without_spikes(force: np.ndarray, noise: float) -> tuple[np.ndarray, int]:
    """The record with its spikes set to the running median, and their number.

    A spike stands off the median by more than noise does, and by more than its neighbours range over, the highest and
    the lowest of them left out: so corners and steps are none.
    """
    from scipy.ndimage import median_filter, rank_filter

    middle = median_filter(force, SPIKE_WIDTH, mode="nearest")
    spread = rank_filter(force, -2, SPIKE_WIDTH, mode="nearest") - rank_filter(force, 1, SPIKE_WIDTH, mode="nearest")
    spike = np.abs(force - middle) > np.maximum(SPIKE * noise, spread)
    return np.where(spike, middle, force), int(spike.sum())


def _turning_points(force: np.ndarray, least: float, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices of tops and of the bottoms after them [m], where every rise and fall is larger than `least`."""
    tops: list[int] = []
    bottoms: list[int] = []
    high = low = float(force[0])
    at_high = at_low = 0
    direction = 0  # +1 rising, a top is looked for; -1 falling; 0 at the start: either
    for index, value in enumerate(force[::stride].tolist()):
        if direction >= 0 and value > high:
            high, at_high = value, index
        if direction <= 0 and value < low:
            low, at_low = value, index
        if direction >= 0 and value < high - least:
            tops.append(at_high)
            direction, low, at_low = -1, value, index
        elif direction <= 0 and value > low + least:
            if tops:
                bottoms.append(at_low)
            direction, high, at_high = 1, value, index
    if tops and tops[0] == 0:  # a fall that had begun before the record
        tops, bottoms = tops[1:], bottoms[1:]
    number = min(len(tops), len(bottoms))  # a fall that the record does not show to its end is left out
    return np.array(tops[:number], dtype=int) * stride, np.array(bottoms[:number], dtype=int) * stride


def _lasting(force: np.ndarray, tops: np.ndarray, bottoms: np.ndarray, window: int, least: float) -> np.ndarray:
    """Which falls last: [m] bool.

    After a fall the force stays down, which after a peak of the noise it does not: the mean force before the top is
    compared with that after the bottom, each over twice the length of the fall, but at most a quarter of the rise.
    """
    lasting = np.zeros(len(tops), dtype=bool)
    for index, (top, bottom) in enumerate(zip(tops, bottoms, strict=True)):
        before = top - (bottoms[index - 1] if index else 0)
        after = (tops[index + 1] if index + 1 < len(tops) else len(force) - 1) - bottom
        longest = 2 * (bottom - top) + window
        left, right = max(1, min(longest, before // 4)), max(1, min(longest, after // 4))
        level = float(force[top - left + 1 : top + 1].mean() - force[bottom : bottom + right].mean())
        lasting[index] = level > least
    return lasting
