"""What was gathered of many runs over their windows, by name: from this the standard measures are read."""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.measures.travel import travelling
from vibrocap.numerics.api import RunResults
from vibrocap.physics import events
from vibrocap.physics.machines.machine import IMPACT
from vibrocap.physics.system import System

LETTERS = {1: "F", 2: "S", 3: "B"}
# Of every run, asked for or not; how they are stored: `studies/store/zarr_form.py`.
ALWAYS = ("status", "settled", "response_period", "window_start", "window_periods")


@dataclasses.dataclass(frozen=True, eq=False)
class Gathered:
    """Results of runs of systems of one form; every quantity is an array [runs].

    system: one of them, for names and kinds; results: of the kernel
    period: drive period of each run; mirrored: says whether it has the half-period symmetry, where that is asked for
    threshold: of settling; 0 where it was not looked for
    """

    system: System
    results: RunResults
    period: np.ndarray
    mirrored: Callable[[], np.ndarray]
    threshold: float

    @property
    def settled(self) -> np.ndarray:
        """Whether the run was measured over one response period of its settled motion."""
        return self.results.head("response_period") > 0

    @property
    def periods(self) -> np.ndarray:
        """Drive periods in the window."""
        return self.results.head("periods") - self.results.head("window_start")

    @property
    def time(self) -> np.ndarray:
        """Length of the window."""
        return self.periods * self.period

    @property
    def displacement(self) -> np.ndarray:
        """Change of the cyclic coordinate over the window."""
        place = self.system.state_names.index(travelling(self.system))
        return self.results.state[:, place] - self.results.start[:, place]

    def turned(self, state: str) -> np.ndarray:
        """Turns of a coordinate over the window; NaN where the system has none that turns by this name."""
        if state not in self.system.turns:
            return self.nowhere
        place = self.system.state_names.index(state)
        return (self.results.state[:, place] - self.results.start[:, place]) / self.system.turns[state]

    def state_entry(self, name: str, state: str) -> np.ndarray:
        """The number of a state of an entry of the results; NaN where the system has no such state."""
        names = self.system.state_names
        return self.results.entry(name, names.index(state)) if state in names else self.nowhere

    @property
    def impacts(self) -> np.ndarray:
        """Number of impacts on stops in the window: infinite where they accumulate, NaN for a machine without stops.

        Of a mass that comes to rest at a rigid stop in ever smaller rebounds only the first are counted as events: it
        strikes the stop more often than it leaves it.
        """
        names = self.system.placed.switch_events
        if events.IMPACT not in names or "OCCURRED" not in dict(self.results.layout.gathered):
            return self.nowhere  # a run may also end where it would strike
        counts = self.results.entries("OCCURRED")
        names = names[: counts.shape[1]]  # a machine may have fewer guards than it has names for
        struck = counts[:, [name == events.IMPACT for name in names]].sum(axis=1)
        opened = counts[:, [name == events.STOP_OPENED for name in names]].sum(axis=1)
        rigid = IMPACT in self.system.placed.channels
        return np.where((opened > 0.0) & (struck > opened), np.inf, struck) if rigid else struck

    @property
    def nowhere(self) -> np.ndarray:
        """NaN for every run: of a measure that the system does not have."""
        return np.full(len(self.results), np.nan)

    @property
    def mode_sequences(self) -> np.ndarray:
        """Mode sequences of the last period of each window, an array of text; see `sticking.mode_sequence`."""
        sequences, which = self.results.letters()
        return np.array([_letters(*sequence) for sequence in sequences], dtype=str)[which]


def _letters(sides: tuple[int, ...], complete: bool) -> str:
    """The mode sequence, in letters, of a sequence of sides."""
    letters = [LETTERS[side] for side in sides]
    if not complete:
        return "".join(letters) + "..."  # there is no telling how the period ends
    while len(letters) > 1 and letters[-1] == letters[0]:
        letters.pop()
    return "".join(letters)
