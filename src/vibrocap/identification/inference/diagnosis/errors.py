"""The errors of a fit, record by record, beside the motion and the force that they belong to."""

import dataclasses
from collections.abc import Sequence

import numpy as np

REST = 1e-3  # of the typical speed


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
        """Direction of the motion: -1, 0 at rest, 1."""
        speed = np.abs(self.velocity)
        usual = float(np.quantile(speed, 0.95))
        return np.sign(np.where(speed > REST * usual, self.velocity, 0.0))


def together(records: Sequence[RecordErrors], name: str) -> np.ndarray:
    """One column of all records, the samples that count."""
    return np.concatenate([getattr(each, name)[each.counts] for each in records])


def noise_level(values: np.ndarray) -> float:
    """Robust standard deviation of what changes from sample to sample: of second differences."""
    if len(values) < 3:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 2))) / 0.6745 / np.sqrt(6.0))


@dataclasses.dataclass(frozen=True)
class Cause:
    """What errors point to. kind: a word for it; amount: its size; share: of the squared errors; words: for a text."""

    kind: str
    amount: float
    share: float
    words: tuple[str, ...] = ()
