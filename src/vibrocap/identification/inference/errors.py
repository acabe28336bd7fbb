"""The errors of a fit, record by record, beside the motion and the force that they belong to."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.identification.problem.samples import noise_of, turns

REST = 1e-3  # of the typical speed
WINDOW = 9  # samples over which what is smooth is a cubic
LARGEST, BESIDE = 25_000, 20  # samples in which patterns are looked for, and on either side of a turn


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
        some = maximum_filter1d(record.turned.astype(np.uint8), 2 * BESIDE + 1) > 0
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
