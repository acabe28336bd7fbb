"""What was gathered of many runs over their windows, by name: from this the standard measures are read."""

import dataclasses

import numpy as np

from vibrocap.measures.travel import travelling
from vibrocap.numerics.api import LETTERS_PER_PLACE, RESULT_HEAD, Layout
from vibrocap.physics.machines.machine import IMPACT
from vibrocap.physics.system import System

CODES = {1: "F", 2: "S", 3: "B"}  # two bits of a letter of a word, see `numerics.kernel.observe.stick_statistics`


@dataclasses.dataclass(frozen=True, eq=False)
class Gathered:
    """Results of runs of systems of one form; every quantity is an array [runs].

    system: one of them, for names and kinds; results: [runs, layout.result_size], see `memory_layout.RESULT_HEAD`
    period: drive period of each run; mirrored: whether it has the half-period symmetry
    threshold: of settling; 0 where it was not looked for
    """

    system: System
    layout: Layout
    results: np.ndarray
    period: np.ndarray
    mirrored: np.ndarray
    threshold: float

    def head(self, name: str) -> np.ndarray:
        """A number of the head of a result, by its name in `RESULT_HEAD`."""
        return self.results[:, RESULT_HEAD.index(name)]

    @property
    def settled(self) -> np.ndarray:
        """Whether the run was measured over one response period of its settled motion."""
        return self.head("response_period") > 0

    @property
    def periods(self) -> np.ndarray:
        """Drive periods in the window."""
        return self.head("periods") - self.head("window_start")

    @property
    def time(self) -> np.ndarray:
        """Length of the window."""
        return self.periods * self.period

    @property
    def displacement(self) -> np.ndarray:
        """Change of the cyclic coordinate over the window."""
        first = len(RESULT_HEAD) + self.system.state_names.index(travelling(self.system.machine))
        return self.results[:, first + self.layout.states] - self.results[:, first]

    def entry(self, name: str, i: int = 0) -> np.ndarray:
        """Number i of an entry of what is gathered, see `memory_layout.gathered_entries`."""
        place = self.layout.gathered_slice(name)
        if not 0 <= i < place.stop - place.start:
            raise IndexError(f"{name} has no number {i}")
        return self.results[:, place.start + i]

    def state_entry(self, name: str, state: str) -> np.ndarray:
        """The number of a state of such an entry; NaN where the system has no such state."""
        names = self.system.state_names
        return self.entry(name, names.index(state)) if state in names else self.nowhere

    @property
    def impacts(self) -> np.ndarray:
        """Number of impacts on stops in the window: infinite where they accumulate, NaN for a machine without stops.

        Of a mass that comes to rest at a rigid stop in ever smaller rebounds only the first are counted as events: it
        strikes the stop more often than it leaves it.
        """
        names = self.system.placed.switch_events
        if "impact" not in names:
            return self.nowhere
        counts = self.results[:, self.layout.gathered_slice("OCCURRED")]
        names = names[: counts.shape[1]]  # a machine may have fewer guards than it has names for
        struck = counts[:, [name == "impact" for name in names]].sum(axis=1)
        opened = counts[:, [name == "stop_opened" for name in names]].sum(axis=1)
        rigid = IMPACT in self.system.placed.channels
        return np.where((opened > 0.0) & (struck > opened), np.inf, struck) if rigid else struck

    @property
    def nowhere(self) -> np.ndarray:
        """NaN for every run: of a measure that the system does not have."""
        return np.full(len(self.results), np.nan)

    @property
    def words(self) -> np.ndarray:
        """The word of the last period of each window, an array of text; see `measures.sticking.word`."""
        place = self.layout.gathered_slice("LETTERS")
        keys = np.column_stack((self.results[:, place], self.entry("LETTER_COUNT")))
        different, which = np.unique(keys, axis=0, return_inverse=True)
        return np.array([_word(key) for key in different], dtype=str)[which.ravel()]


def _word(key: np.ndarray) -> str:
    """The word in the numbers of the entry LETTERS followed by the count of its letters."""
    *places, count = (int(number) for number in key)
    room = LETTERS_PER_PLACE * len(places)
    letters: list[str] = []
    for place, packed in enumerate(places):
        size = min(max(count - place * LETTERS_PER_PLACE, 0), LETTERS_PER_PLACE)
        letters += [CODES[(packed >> (2 * (size - 1 - i))) & 3] for i in range(size)]
    if count > room:
        return "".join(letters) + "..."  # there is no telling how the period ends
    while len(letters) > 1 and letters[-1] == letters[0]:
        letters.pop()
    return "".join(letters)
