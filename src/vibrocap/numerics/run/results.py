"""What runs leave, by name: results of an ensemble, pieces of one motion. Nobody outside has to know the places."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD, Layout


@dataclasses.dataclass(frozen=True, eq=False)
class RunResults:
    """Results of runs that are measured as they run; every quantity is an array [runs].

    layout: of the kernel; numbers: [runs, layout.result_size], as the kernel wrote them
    """

    layout: Layout
    numbers: np.ndarray

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, which: slice | np.ndarray | list[int]) -> "RunResults":
        """Those of some runs."""
        return RunResults(self.layout, self.numbers[which])

    def head(self, name: str) -> np.ndarray:
        """A number of the head of a result, by its name in `memory_layout.RESULT_HEAD`."""
        return self.numbers[:, RESULT_HEAD.index(name)]

    @property
    def status(self) -> np.ndarray:
        """Why each run ended, a number of `codes`."""
        return self.head("status").astype(int)

    @property
    def finished(self) -> np.ndarray:
        """Whether the run came to its end."""
        return self.status == codes.DONE

    @property
    def response_period(self) -> np.ndarray:
        """Drive periods after which the motion repeats; 0 where the run did not settle."""
        periods = self.head("response_period")
        return np.where(self.finished & (periods > 0), periods, 0).astype(int)

    @property
    def start(self) -> np.ndarray:
        """[runs, states] at the start of the window; of a run that has settled, one response before its end."""
        return self._states(0)

    @property
    def state(self) -> np.ndarray:
        """[runs, states] at the end."""
        return self._states(1)

    def _states(self, place: int) -> np.ndarray:
        first = self.layout.start_place + place * self.layout.states
        return self.numbers[:, first : first + self.layout.states].copy()

    @property
    def lifted(self) -> np.ndarray:
        """1 where a true load falls below zero in the window, 0 where none does; NaN where none is looked at."""
        return self.entries("LIFTED").max(axis=1) if self.layout.watched else np.full(len(self), np.nan)

    def entries(self, name: str) -> np.ndarray:
        """[runs, numbers] of an entry of what was gathered over the window, see `memory_layout.gathered_entries`."""
        return self.numbers[:, self.layout.gathered_slice(name)]

    def entry(self, name: str, i: int = 0) -> np.ndarray:
        """Number i of such an entry."""
        column = self.entries(name)
        if not 0 <= i < column.shape[1]:
            raise IndexError(f"{name} has no number {i}")
        return column[:, i]

    def letters(self, contact: int) -> tuple[list[tuple[tuple[int, ...], bool]], np.ndarray]:
        """The different sequences of sides of a contact in the last period, and which of them is that of each run.

        A sequence is its letters (1 forward, 2 at rest, 3 back), and whether there was room for all of them.
        """
        own = slice(contact * codes.MODE_PLACES, (contact + 1) * codes.MODE_PLACES)
        keys = np.column_stack((self.entries("LETTERS")[:, own], self.entry("LETTER_COUNT", contact))).tolist()
        different = {key: number for number, key in enumerate(dict.fromkeys(map(tuple, keys)))}
        return [_unpacked(key) for key in different], np.array([different[tuple(key)] for key in keys], dtype=int)


@dataclasses.dataclass(frozen=True, eq=False)
class PieceSeries:
    """Taylor coefficients of the pieces of a motion; of a state whose rate is another state, the first alone is kept.

    The others are those of its rate, c_k = r_(k-1)/k, to the last bit: the series of a step is made so. It is not where
    its last terms are damped, nor of implicit steps; of motions that may have such steps all coefficients are kept.

    numbers: [pieces, numbers], the states at the start, then row by row the other coefficients that are kept
    rates: of each state the state that is its rate, -1 where all coefficients are kept
    """

    numbers: np.ndarray
    rates: tuple[int, ...]
    order: int

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, pieces: Any) -> np.ndarray:
        """Coefficients of some pieces, in powers of the time since their start: array [pieces, states, order + 1]."""
        kept, states = self.numbers[pieces], len(self.rates)
        coefficients = np.empty((len(kept), states, self.order + 1))
        coefficients[:, :, 0] = kept[:, :states]
        whole = [state for state in range(states) if self.rates[state] < 0]
        coefficients[:, whole, 1:] = kept[:, states:].reshape(len(kept), len(whole), self.order)
        shares = 1.0 / np.arange(1, self.order + 1)
        for state, rate in enumerate(self.rates):
            if rate >= 0:
                np.multiply(coefficients[:, rate, :-1], shares, out=coefficients[:, state, 1:])
        return coefficients


def _unpacked(key: tuple[float, ...]) -> tuple[tuple[int, ...], bool]:
    """The letters in the numbers of the entry LETTERS followed by their count, two bits each."""
    *places, count = (int(number) for number in key)
    room = codes.LETTERS_PER_PLACE
    sequence: list[int] = []
    for place, packed in enumerate(places):
        size = min(max(count - place * room, 0), room)
        sequence += [(packed >> (2 * (size - 1 - i))) & 3 for i in range(size)]
    return tuple(sequence), count <= room * len(places)
