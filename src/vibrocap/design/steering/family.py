"""The family of schedules among which is searched: bursts of the drive, each followed by a pause, then a hold."""

import dataclasses

import numpy as np

from vibrocap.physics.drives.drive import Drive, Piecewise

PAUSES = (1, 2, 4, 8, 16, 32)  # periods, of which the shortest that leaves the machine at rest is taken
STILL = 2 * PAUSES[-1]  # periods after which a machine that rests at all is at rest
SHORT = 8  # periods: bursts of any factor
FINE = 4  # periods: second bursts
STEP = 0.25  # periods: between the lengths of short bursts, of a drive without corners of its own
WINDOW = np.arange(-6.0, 4.0)  # periods about the length by which a long burst would arrive
FASTEST = 6  # factors whose settled motions travel fastest, of which long bursts are tried
FINER = 8  # times as fine is each of the two refinements of the last factor, where none arrives
REFINEMENTS = 2


@dataclasses.dataclass(frozen=True)
class Family:
    """The bursts that there are.

    factors: of the drive, [factors], both signs; step: between lengths in periods
    """

    factors: np.ndarray
    step: float

    @classmethod
    def of(cls, drive: Drive, levels: int) -> "Family":
        """The family of a drive, with so many factors from 0 to 1 and their negatives."""
        sizes = np.arange(1, levels + 1) / levels
        return cls(np.concatenate([sizes, -sizes]), 1.0 if isinstance(drive, Piecewise) else STEP)

    def bursts(self, longest: float) -> np.ndarray:
        """All bursts up to a length, as rows (periods, factor)."""
        lengths = np.arange(self.step, longest + 0.5 * self.step, self.step)
        return np.stack(np.meshgrid(lengths, self.factors, indexing="ij"), axis=-1).reshape(-1, 2)


def schedules_of(bursts: np.ndarray, pause: float) -> np.ndarray:
    """Schedules [n, 2 bursts, 2] of bursts [n, bursts, 2], each followed by a pause."""
    found = np.zeros((len(bursts), 2 * bursts.shape[1], 2))
    found[:, ::2] = bursts
    found[:, 1::2, 0] = np.where(bursts[:, :, 0] > 0.0, pause, 0.0)
    return found


def periods_of(bursts: np.ndarray, pause: float) -> np.ndarray:
    """Periods of the drive [n] from the start to the end of the last pause."""
    return np.sum(schedules_of(bursts, pause)[:, :, 0], axis=1)
