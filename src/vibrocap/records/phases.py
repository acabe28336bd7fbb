"""Slips in a noisy force record: falls of the force that stand above its noise, and the phases between them.

While a slider that is pulled through a spring sticks, the force rises at the loading rate k V; when it slips, the force
falls fast. What stands above the noise is decided by the record itself: its differences tell its noise. Where a slip
begins and ends is fitted.
"""

import dataclasses

import numpy as np

from vibrocap.quantities.declared import RecordedForce, Seconds

CORNER_SHARE = 0.35  # of the fall, which the fit of a corner takes in: there a cosine is a parabola to 4 % of the fall
NOISE_SHARE, MOST_SHARE = 3.0, 0.5  # more of the fall is taken in where noise, over the fall, hides so little of it
LEVEL_ERROR = 0.01  # of the fall: so much of the stick is fitted that the level at the corner is as good as that
SLIP_LENGTHS = 1.5  # length of the stick beside a corner that is fitted at least, in lengths of the slip
LEAST_STICK = 12.0  # samples of the stick beside a corner, where it has so many
LEAST_SAMPLES = 3  # on either side of a corner; where there are fewer, it is located by its samples only
KINK, LET_GO = 1, 2  # powers of the bend: without inertia, and of a mass that is let go
CLEARLY, TOLD = 4.0, 8.0  # -2 log likelihood, for each slip
MOST_SAMPLES = 400  # of a fit; longer stretches are averaged in blocks


@dataclasses.dataclass(frozen=True)
class Corner:
    """Where a slip begins or ends: time [s] and force (unit of the record), with their standard errors."""

    time: float
    force: float
    time_error: float
    force_error: float


@dataclasses.dataclass(frozen=True)
class _Stretch:
    """A piece of a record that runs from the stick into the slip: places [s] from the record's start, forces."""

    places: np.ndarray
    force: np.ndarray
    sign: float  # +1: the force falls into the slip as time goes on (a start), -1: read backwards (an end)
    turning: float  # place of the turning point
    noise: float  # of the averaged force
    step: float  # of the record


def fitted_corners(
    time: np.ndarray, force: np.ndarray, noise: float, tops: np.ndarray, bottoms: np.ndarray
) -> tuple[list[Corner], list[Corner]]:
    """(starts, ends) of slips whose turning points are known, fitted to the record.

    Beside a start at t1 the force is F1 + s (t - t1) - c max(t - t1, 0)^p: straight while it sticks; in the slip a mass
    that is let go falls as p = 2 (m x'' = F_s - F_k at once), one without inertia as p = 1. Least squares decide over
    t1, F1, s, c, and, for all slips of the record together, over p. An end is the same read backwards, with a p of its
    own. A slip of few samples keeps its turning points, exact to the sampling.

    time: evenly spaced [n] s;  force: without spikes [n];  noise: its standard deviation
    tops, bottoms: indices of the turning points [m]
    """
    starts: list[_Stretch] = []
    ends: list[_Stretch] = []
    step = float(time[-1] - time[0]) / (len(time) - 1)
    place = np.arange(len(time)) * step
    for index, (top, bottom) in enumerate(zip(tops, bottoms, strict=True)):
        fall = float(force[top] - force[bottom])
        stick = max(SLIP_LENGTHS * (bottom - top), (2.0 * noise / (LEVEL_ERROR * max(fall, noise))) ** 2, LEAST_STICK)
        before = bottoms[index - 1] if index else 0
        after = tops[index + 1] if index + 1 < len(tops) else len(time) - 1
        inside = force[top : bottom + 1]
        share = min(MOST_SHARE, CORNER_SHARE + NOISE_SHARE * noise / max(fall, noise))
        # Samples above a level are counted: noise makes some cross it early, and as many late.
        down = top + int(np.sum(inside > inside[0] - share * fall))
        up = bottom - int(np.sum(inside < inside[-1] + share * fall))
        first = top - int(min(stick, 0.5 * (top - before)))
        last = bottom + int(min(stick, 0.5 * (after - bottom)))
        start, end = slice(first, down + 1), slice(up, last + 1)
        starts.append(_stretch(place[start], force[start], float(place[top]), noise, step))
        ends.append(_stretch(-place[end][::-1], -force[end][::-1], -float(place[bottom]), noise, step, sign=-1.0))
    return _best(starts, float(time[0])), _best(ends, float(time[0]))


def _stretch(
    places: np.ndarray, force: np.ndarray, turning: float, noise: float, step: float, sign: float = 1.0
) -> _Stretch:
    block = -(-len(places) // MOST_SAMPLES)
    if block > 1:
        number = len(places) // block * block
        places = places[-number:].reshape(-1, block).mean(axis=1)
        force = force[-number:].reshape(-1, block).mean(axis=1)
    return _Stretch(places, force, sign, turning, noise / block**0.5, step)


def _best(stretches: list[_Stretch], begin: float) -> list[Corner]:
    """The corner of each, with the power that suits all of them best; begin: of the record, s."""
    fits = {power: [_fit(stretch, power) for stretch in stretches] for power in (KINK, LET_GO)}
    # The likelihoods of all fits, each with a noise of its own, so that no single large slip decides.
    misfit = {power: sum(likelihood for likelihood, *_ in fits[power]) for power in fits}
    # Sliders have mass: that one falls as if it had none has to be clear.
    clear = (misfit[LET_GO] - misfit[KINK]) / max(1, len(stretches))
    power, other = (KINK, LET_GO) if clear > CLEARLY else (LET_GO, KINK)
    result = []
    for stretch, numbers, others in zip(stretches, fits[power], fits[other], strict=True):
        _, place, level, place_error, level_error = numbers
        if abs(clear) < TOLD:  # which of both forms it is adds to what is not known
            place_error = float(np.hypot(place_error, 0.5 * (place - others[1])))
            level_error = float(np.hypot(level_error, 0.5 * (level - others[2])))
        result.append(Corner(begin + stretch.sign * place, stretch.sign * level, place_error, level_error))
    return result


def _fit(stretch: _Stretch, power: int) -> tuple[float, float, float, float, float]:
    """(-2 log likelihood, less that of a straight line, place, level, error of the place, error of the level).

    What the third term explains, beside level and slope, is known in closed form for every place of the corner, so all
    places are compared.
    """
    places, force = stretch.places, stretch.force
    number = len(places)
    nearest = int(np.argmin(np.abs(places - stretch.turning)))
    if min(number - nearest, nearest) < LEAST_SAMPLES:
        return _at_samples(stretch, nearest)
    unit = (places - places.mean()) / np.ptp(places)
    line = np.stack([np.full(number, number**-0.5), unit / np.linalg.norm(unit)], axis=1)
    rest = force - line @ (line.T @ force)
    spacing = float(places[1] - places[0])
    corners = places[0] + spacing * np.arange(LEAST_SAMPLES - 1, number - LEAST_SAMPLES + 0.5, 0.5)
    bends = (np.maximum(places[:, None] - corners, 0.0) / np.ptp(places)) ** power  # [n, corners]
    bends -= line @ (line.T @ bends)
    along = rest @ bends
    gain = np.where(along < 0, along**2 / np.einsum("ij,ij->j", bends, bends), 0.0)
    at = int(np.argmax(gain))
    if gain[at] <= 0.0:
        return _at_samples(stretch, nearest)
    place = float(corners[at]) + _vertex(gain, at) * 0.5 * spacing
    bend = np.maximum(places - place, 0.0)
    shape = np.stack([np.ones(number), places - place, bend**power], axis=1)
    values = np.linalg.lstsq(shape / np.linalg.norm(shape, axis=0), force, rcond=None)[0]
    values /= np.linalg.norm(shape, axis=0)
    # With the corner the whole line moves, and the bend begins later.
    moving = -values[1] - values[2] * power * bend ** (power - 1) * (bend > 0)
    level_error, place_error = _errors(np.column_stack([shape, moving]), stretch.noise)
    if place_error > places[-1] - stretch.turning:  # the bend does not tell the corner to better than the slip
        return _at_samples(stretch, nearest)
    place_error = float(np.hypot(place_error, stretch.step / 12.0**0.5))
    misfit = number * float(np.log(max(1.0 - gain[at] / (rest @ rest), 1e-12)))
    return misfit, place, float(values[0]), place_error, level_error


def _at_samples(stretch: _Stretch, nearest: int) -> tuple[float, float, float, float, float]:
    """What `_fit` returns where no bend tells the corner: the level of the stick at the turning point."""
    force, places = stretch.force[: nearest + 1], stretch.places[: nearest + 1]
    place_error = 0.5 * max(stretch.step, float(stretch.places[-1]) - stretch.turning)
    if len(force) < 2 * LEAST_SAMPLES:
        return 0.0, stretch.turning, float(force[-1]), place_error, stretch.noise
    level = float(np.polynomial.polynomial.polyfit(places - stretch.turning, force, 1)[0])
    return 0.0, stretch.turning, level, place_error, 2.0 * stretch.noise / len(force) ** 0.5


def _vertex(gain: np.ndarray, at: int) -> float:
    """Where the parabola through three neighbours is highest, in steps from the middle one."""
    if not 0 < at < len(gain) - 1:
        return 0.0
    left, middle, right = gain[at - 1 : at + 2]
    bend = left - 2.0 * middle + right
    return float(np.clip(0.5 * (left - right) / bend, -0.5, 0.5)) if bend < 0 else 0.0


def _errors(jacobian: np.ndarray, noise: float) -> tuple[float, float]:
    """Standard errors of the first and the last unknown of a least-squares fit, for white noise."""
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv((jacobian / scale).T @ (jacobian / scale))
    errors = noise * np.sqrt(np.maximum(np.diag(inverse), 0.0)) / scale
    return float(errors[0]), float(errors[-1])


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
    mean square, does not see slips and spikes. The variance of F[i] - 3 F[i-1] + 3 F[i-2] - F[i-3] is 20 sigma^2. A
    coarsely digitised record repeats values: its noise is at least that of rounding, quantum/sqrt(12). Limit: noise
    that is slower than the window is not told from the force.
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
