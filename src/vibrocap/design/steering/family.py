"""The family of schedules among which is searched: bursts of the drive, each followed by a pause, then a hold."""

import dataclasses

import numpy as np

from vibrocap.physics.drives.drive import Drive, Piecewise

PAUSES = (1, 2, 4, 8, 16, 32)  # periods, of which the shortest that leaves the machine at rest is taken
STILL = 2 * PAUSES[-1]  # periods after which a machine that rests at all is at rest
SHORT = 8  # periods: first bursts of any factor
FINE = 4  # periods: second bursts
STEP = 0.25  # periods: between the lengths of short bursts, of a drive without corners of its own
WINDOW = np.arange(-6.0, 4.0)  # periods about the length by which a long burst would arrive
FASTEST = 6  # factors whose settled motions travel fastest, of which long bursts are tried


@dataclasses.dataclass(frozen=True)
class Family:
    """The bursts that there are.

    factors: of the drive, [factors] in order, both signs, without 0; step: between lengths in periods
    """

    factors: np.ndarray
    step: float

    @classmethod
    def of(cls, drive: Drive, levels: int) -> "Family":
        """The family of a drive, with so many factors from 0 to 1 and their negatives."""
        sizes = np.arange(1, levels + 1) / levels
        return cls(np.concatenate([-sizes[::-1], sizes]), 1.0 if isinstance(drive, Piecewise) else STEP)

    def bursts(self, longest: float) -> np.ndarray:
        """All bursts up to a length, as rows (periods, factor): [lengths, factors, 2]."""
        lengths = np.arange(self.step, longest + 0.5 * self.step, self.step)
        return np.stack(np.meshgrid(lengths, self.factors, indexing="ij"), axis=-1)


def schedules_of(bursts: np.ndarray, pause: float) -> np.ndarray:
    """Schedules [n, 2 bursts, 2] of bursts [n, bursts, 2], each followed by a pause.

    A burst of no length has no pause, unless there is no other.
    """
    found = np.zeros((len(bursts), 2 * bursts.shape[1], 2))
    found[:, ::2] = bursts
    found[:, 1::2, 0] = np.where(bursts[:, :, 0] > 0.0, pause, 0.0)
    found[np.all(bursts[:, :, 0] == 0.0, axis=1), -1, 0] = pause
    return found


def periods_of(bursts: np.ndarray, pause: float) -> np.ndarray:
    """Periods of the drive [...] from the start to the end of the last pause, of bursts [..., bursts, 2]."""
    lengths = bursts[..., 0]
    return np.sum(lengths + pause * (lengths > 0.0), axis=-1)


def spread(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(middle, half) of the range of errors [..., samples]; NaN where one of them failed. The worst is their sum."""
    high, low = np.max(errors, axis=-1), np.min(errors, axis=-1)
    return 0.5 * (high + low), 0.5 * (high - low)
