"""The errors of a fit, record by record, and the faults of a measurement that its columns show by themselves.

Saturation, quantisation and outliers do not need the law to be right: a force that never exceeds a limit and lies on it
again and again, a motion whose values are whole multiples of one step, single samples that stand alone.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.identification.problem.samples import noise_of, turns

REST = 1e-3  # of the typical speed
WINDOW = 9  # samples over which what is smooth is a cubic
LARGEST = 25_000  # samples in which patterns are looked for, beside all those about a reversal

# Thresholds. `benchmarks/faulty_records.py` counts with them 100 records of each fault and of none: 95 of 100 are to be
# named, and none else. `tests/test_identification_thresholds.py` has witnesses of each on both sides.
# A limit is named from n_0 >= FEWEST samples on it and RATIO n_1 on, with n_1 samples just below it and beyond. Where a
# density falls towards its end, n_0 is binomial with a probability of at most one half of n_0 + n_1: by chance below
# 2^-6 at each end, and in noise there are not 6 samples so near to the largest one.
FEWEST, RATIO = 6, 5.0
WIDTH, BEYOND = 0.05, 4.0  # noises: of the band; below the limit, up to which a predicted force counts as cut by it
REMAINING = 0.2  # share of the samples that a saturated force must leave for other faults to be told
LEVELS, WHOLE = 6, 0.01  # so many differences are multiples of the least, within 1 %, with a probability below 10^-8
EFFECT = 0.02  # share of the squared errors that steps make, from which on they matter, as of a pattern
FAR = 7.0  # deviations of an outlier: of a million normal errors of one size none is so far away
NUMBER = 2  # of outliers, from which on they are told, or one that is twice as far
BESIDE = 3  # samples on either side of an outlier among which no difference of the force is as large
AROUND = 20  # samples about a reversal, where a direction is uncertain


@dataclasses.dataclass(frozen=True, eq=False)
class RecordErrors:
    """One record: columns [n] in SI.

    force, predicted N: measured and of the fit; place m: displacement as it was measured, or the velocity's integral;
    unit N: error that counts as 1; counts: samples that take part; velocity_made: from the place.
    """

    time: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    place: np.ndarray
    force: np.ndarray
    predicted: np.ndarray
    unit: float
    counts: np.ndarray
    velocity_made: bool = False
    rotary: bool = False

    @property
    def error(self) -> np.ndarray:
        """Measured less predicted force, over the unit."""
        return (self.force - self.predicted) / self.unit

    @property
    def side(self) -> np.ndarray:
        """Direction of the motion, at rest that of the last one, as friction has it: -1 or 1."""
        speed = np.abs(self.velocity)
        moving = speed > REST * float(np.quantile(speed, 0.95))
        last = np.maximum.accumulate(np.where(moving, np.arange(len(speed)), np.argmax(moving)))
        return np.sign(self.velocity[last])

    @property
    def turned(self) -> np.ndarray:
        """Samples [n] at which the motion has turned."""
        turned = np.zeros(len(self.time), bool)
        turned[turns(self.side)] = True
        return turned


def roughness(values: np.ndarray) -> np.ndarray:
    """What cubics over WINDOW samples leave of values [n] (Savitzky and Golay 1964)."""
    powers, half = np.vander(np.linspace(-1.0, 1.0, WINDOW), 4), WINDOW // 2
    left = np.eye(WINDOW) - powers @ np.linalg.pinv(powers)  # of each sample of a window
    middle = np.convolve(values, left[half], "valid")
    return np.concatenate((left[:half] @ values[:WINDOW], middle, left[half + 1 :] @ values[-WINDOW:]))


def sampled(records: Sequence[RecordErrors]) -> list[RecordErrors]:
    """The records of which about LARGEST samples count: each so-manieth one, and all beside the motion's turns.

    A pattern that explains 2 % of the squares shows in these as surely as in a million.
    """
    from scipy.ndimage import maximum_filter1d

    every = -(-sum(int(record.counts.sum()) for record in records) // LARGEST)
    if every <= 1:
        return list(records)
    sampled_errors = []
    for record in records:
        some = maximum_filter1d(record.turned.astype(np.uint8), 2 * AROUND + 1) > 0
        some[::every] = True
        sampled_errors.append(dataclasses.replace(record, counts=record.counts & some))
    return sampled_errors


def together(records: Sequence[RecordErrors], name: str) -> np.ndarray:
    """One column of all records, the samples that count."""
    return np.concatenate([getattr(record, name)[record.counts] for record in records])


def of(columns: Sequence[np.ndarray], counts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The samples that count of a column [n] of each record."""
    return [column[count] for column, count in zip(columns, counts, strict=True)]


def squares(errors: Sequence[np.ndarray], counts: Sequence[np.ndarray]) -> float:
    """Sum of the squared errors that count."""
    return sum(float(np.sum(error**2)) for error in of(errors, counts))


def noise_level(values: np.ndarray) -> float:
    """Robust standard deviation of what changes from sample to sample: of second differences."""
    return noise_of(np.diff(values, 2)) if len(values) >= 3 else 0.0


@dataclasses.dataclass(frozen=True)
class Cause:
    """What errors point to. kind: a word for it; amount: its size; share: of the squared errors; words: for a text."""

    kind: str
    amount: float
    share: float
    words: tuple[str, ...] = ()


def saturation(records: Sequence[RecordErrors]) -> tuple[Cause | None, list[np.ndarray]]:
    """Whether forces lie on their extreme, and which samples [n] of each record that touches.

    A limit is looked for among all values: samples within a band of a twentieth of the noise, n_0, against those in
    the next one below and all beyond, n_1, so that single glitches do not hide it. None is named
    where the prediction lies there too, as that of a constant sliding friction would.
    """
    touched = [np.zeros(len(record.time), bool) for record in records]
    cut, where = 0, []
    for record, mine in zip(records, touched, strict=True):
        for side in (1.0, -1.0):
            force = side * record.force
            rms = float(np.sqrt(np.mean((record.force - record.predicted) ** 2)))
            noise, ordered = max(noise_level(record.force), 1e-3 * rms), np.sort(force)
            width = max(WIDTH * noise, 1e-9 * float(np.abs(ordered[[0, -1]]).max()))
            below, begin, end = (np.searchsorted(ordered, ordered + far * width) for far in (-1.5, -0.5, 0.5))
            numbers = end - begin - 1
            piled = (numbers >= FEWEST) & (numbers >= RATIO * (len(force) - below - numbers - 1))
            if not piled.any():
                continue
            most = int(np.argmax(np.where(piled, numbers, 0)))
            limit, number = float(np.median(ordered[begin[most] : end[most]])), int(numbers[most])
            on = np.abs(force - ordered[most]) <= 0.5 * width
            error = (side * record.predicted - limit)[on]
            if float(np.sqrt(np.mean(error**2))) < 3 * width:
                continue
            cut += number + 1
            where.append(f"{side * limit:.4g}")
            mine |= on | (side * record.predicted > limit - BEYOND * noise)
    if not cut:
        return None, touched
    share = cut / sum(len(record.time) for record in records)
    return Cause("saturation", share, share, (f"{share:.2g}", " and ".join(dict.fromkeys(where)))), touched


def quantisation(records: Sequence[RecordErrors]) -> Cause | None:
    """A resolution of the motion that is coarse for the force: its effect is 2 % of the squared errors or more.

    Looked at is what drives the law: the velocity, or the place where the velocity was made from it. The effect on the
    force is reckoned as the sum of q^2/12 times the mean square of the local slope of the predicted force, of what the
    steps make of the prediction itself (its differences from cubics over nine samples, away from reversals), and of a
    quarter of the force's squared jump where the sign of the velocity is uncertain.
    """
    from scipy.ndimage import maximum_filter1d

    worst: Cause | None = None
    for record in records:
        errors = float(np.mean((record.force - record.predicted) ** 2))
        name = "place" if record.velocity_made else "velocity"
        column = getattr(record, name)
        step = resolution(column) if errors > 0 else 0.0
        if not step:
            continue
        slope = step**2 / 12 * _squared_slope(column, record.predicted, step)
        uncertain = 0.5 * step / (1.0 if name == "velocity" else float(np.median(np.diff(record.time))))
        rough, away = 0.0, maximum_filter1d(record.turned.astype(np.uint8), 2 * AROUND + 1) == 0
        if len(record.predicted) >= 2 * WINDOW and away.any():  # what is not smooth in the prediction
            rough = float(np.mean(roughness(record.predicted)[away] ** 2))
        effect = (slope + rough + _turning(record, uncertain)) / errors
        if effect > EFFECT and (worst is None or effect > worst.share):
            what = "position" if name == "place" else "velocity"
            unit = ("rad" if record.rotary else "m") + ("" if name == "place" else "/s")
            worst = Cause("quantisation", step, min(effect, 1.0), (what, f"{step:.3g} {unit}"))
    return worst


def _turning(record: RecordErrors, uncertain: float) -> float:
    """Mean over all samples of a quarter of the force's squared range about those of an uncertain direction."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    slow = np.abs(record.velocity) < uncertain * (1 + 1e-9)
    begins = np.flatnonzero(np.diff(np.concatenate(([0], slow.astype(int)))) > 0)
    ends = np.flatnonzero(np.diff(np.concatenate((slow.astype(int), [0]))) < 0)
    longest = int(np.max(ends - begins)) + 1 if len(begins) else 0
    wide = 2 * min(longest, AROUND) + 3
    ranges = maximum_filter1d(record.predicted, wide) - minimum_filter1d(record.predicted, wide)
    return float(np.sum(ranges[slow] ** 2)) / 4 / len(slow)


def resolution(column: np.ndarray) -> float:
    """The step q of which all differences of a column are whole multiples; 0 where there is none."""
    values = np.unique(column)
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-10 * max(np.ptp(column), 1e-300)]
    if len(gaps) < LEVELS:
        return 0.0
    step = float(gaps.min())
    for _ in range(2):  # the least gap is off by rounding: the mean over small multiples is less so
        times = np.round(gaps / step)
        if np.any(np.abs(gaps / step - times) > np.maximum(WHOLE, 1e-9 * times)):
            return 0.0
        small = times <= 100
        step = float(np.sum(gaps[small]) / np.sum(times[small]))
    return step


def _squared_slope(column: np.ndarray, force: np.ndarray, step: float) -> float:
    """Mean square of the slope of the force over a column that moves by five steps or more; 0 elsewhere."""
    slopes = np.zeros(len(column))
    for wide in (2, 8, 32, 128, 512, 2048):
        if 2 * wide >= len(column):
            break
        change, answer = column[2 * wide :] - column[: -2 * wide], force[2 * wide :] - force[: -2 * wide]
        steep = (np.abs(change) >= 5 * step) & (slopes[wide:-wide] == 0)
        slopes[wide:-wide][steep] = np.abs(answer[steep] / change[steep])
    return float(np.mean(slopes**2))


def outliers(records: Sequence[RecordErrors], errors: Sequence[np.ndarray]) -> tuple[Cause | None, list[np.ndarray]]:
    """Samples that stand alone, and the errors [n] of each record without them; errors: what patterns leave of them.

    How far an error is outside of what lies between the medians of the three before and the three after it is compared
    with the robust deviation of second differences at like speeds. An outlier is `FAR` past the largest second
    difference of the predicted force among seven samples, of which none is at a reversal (so that no jump of the law
    counts, a little early or late).
    """
    from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d

    cleaned, number_before, number, looked = [], 0, 0, 0
    for record, error in zip(records, errors, strict=True):
        medians = median_filter(error, 3, mode="nearest")
        padded = np.concatenate((medians[:1], medians[:1], medians, medians[-1:], medians[-1:]))
        before, after = padded[:-4], padded[4:]
        alone = error - np.clip(error, np.minimum(before, after), np.maximum(before, after))
        beyond = {"prepend": record.predicted[0], "append": record.predicted[-1]}
        jump = maximum_filter1d(np.abs(np.diff(record.predicted, 2, **beyond)) / record.unit, 2 * BESIDE + 1)
        looked_at = record.counts & ~record.turned
        inside = minimum_filter1d(looked_at.astype(np.uint8), 2 * BESIDE + 1) > 0
        times = (np.abs(alone) - jump) / np.maximum(_deviation(error, np.abs(record.velocity), inside), 1e-300)
        far = inside & (times > FAR)
        number_before += NUMBER if np.any(times[inside] > 2 * FAR) else int(np.sum(far))
        number, looked = number + int(np.sum(far)), looked + int(np.sum(inside))
        cleaned.append(np.where(far, error - alone, error))
    if number_before < NUMBER:
        return None, list(errors)
    counts, share = [record.counts for record in records], number / looked
    before, after = squares(errors, counts), squares(cleaned, counts)
    return Cause("outliers", share, max(1 - after / max(before, 1e-300), 0.0), (f"{share:.2g}",)), cleaned


def _deviation(errors: np.ndarray, speed: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Robust standard deviation of errors of like speed, from second differences of those inside."""
    second = np.abs(errors[1:-1] - 0.5 * (errors[2:] + errors[:-2]))
    second = np.concatenate((second[:1], second, second[-1:])) / (0.6745 * np.sqrt(1.5))
    if not inside.any():
        return second
    number = int(np.clip(inside.sum() // 100, 1, 40))
    edges = np.quantile(speed[inside], np.linspace(0, 1, number + 1)[1:-1])
    bins = np.searchsorted(edges, speed)
    order = np.argsort(bins[inside], kind="stable")
    parts = np.split(second[inside][order], np.cumsum(np.bincount(bins[inside], minlength=number))[:-1])
    sizes = np.array([float(np.median(part)) if len(part) else 0.0 for part in parts])
    return np.maximum(sizes, 0.1 * float(np.median(second[inside])))[bins]
