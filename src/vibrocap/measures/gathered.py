"""What was gathered of many runs over their windows, by name, and whether the works of each add up."""

import dataclasses
import functools
from collections.abc import Callable

import numpy as np

from vibrocap.measures.recorded.sticking import as_cycle, first_turned
from vibrocap.measures.recorded.travel import travelling
from vibrocap.motion.evidence import BALANCE_BOUND, BALANCE_PER_STEP, LEAST_TOLERANCE
from vibrocap.motion.trust import RESIDUE, ZERO, stands_still
from vibrocap.numerics.api import RunResults
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluated
from vibrocap.physics.mechanics.stops import sides
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System

FEW_RETURNS = 2  # fewer are none to speak of
LETTERS = {1: "F", 2: "S", 3: "B"}
# Of every run, asked for or not; how they are stored: `studies/store/zarr_form.py`.
ALWAYS = ("status", "settled", "response_period", "window_start", "window_periods")


@dataclasses.dataclass(frozen=True, eq=False)
class Gathered:
    """Results of runs of systems of one form; every quantity is an array [runs].

    system: one of them, for names and kinds; results: of the kernel
    period: drive period of each run; mirrored: says whether it has the half-period symmetry, where that is asked for
    threshold: of settling; 0 where it was not looked for
    scales: [runs, states] natural sizes; None where no residue is asked for
    """

    system: System
    results: RunResults
    period: np.ndarray
    mirrored: Callable[[], np.ndarray]
    threshold: float
    scales: np.ndarray | None = None

    def some(self, runs: np.ndarray) -> "Gathered":
        assert self.scales is not None
        arrays = {name: getattr(self, name)[runs] for name in ("results", "period", "scales")}
        return dataclasses.replace(self, mirrored=lambda: self.mirrored()[runs], **arrays)

    @property
    def settled(self) -> np.ndarray:
        """Whether the run was measured over one response period, or one turn of the cycle, of its settled motion.

        What makes no returns has to stand still: marks at equal distances also stand still where that is its period.
        """
        periods = self.results.head("response_period") > 0
        return periods & ((self.cycle_time > 0.0) | self.still) if self.results.layout.returns else periods

    @property
    def response_period(self) -> np.ndarray:
        """Drive periods, or returns of a cycle, after which the settled motion repeats; 0 where it has not settled."""
        periods = self.results.head("response_period")
        return np.where(self.settled, periods, 0) if self.results.layout.returns else periods

    @property
    def cycle_time(self) -> np.ndarray:
        """Length of a window that is a turn of a cycle, from one return to another; 0 of any other window."""
        returns = self.results.layout.returns
        return self.results.entry("CYCLE_TIME") if returns else np.zeros(len(self.results))

    @property
    def still(self) -> np.ndarray:
        """Whether nothing moves in the window but the cyclic coordinate: rest or steady sliding."""
        system, results = self.system, self.results
        assert self.scales is not None
        moving = [name not in (system.cyclic, *system.switched) for name in system.state_names]
        extents = results.entries("LARGEST") - results.entries("LEAST")
        return stands_still(extents[:, moving] / self.scales[:, moving], self.threshold)

    @property
    def outcome(self) -> np.ndarray:
        unsettled = np.full(len(self.results), "not settled", dtype="U32")
        if not self.results.layout.returns:
            return np.where(self.settled, "periodic", unsettled)
        few = self.results.entry("RETURNS") < FEW_RETURNS
        unsettled = np.where(few, "not settled: no returns", "not settled: no repetition")
        return np.where(self.settled, np.where(self.still, "equilibrium", "cycle"), unsettled)

    @property
    def periods(self) -> np.ndarray:
        """Drive periods in the window; 1 where it is a turn of a cycle."""
        periods = self.results.head("periods") - self.results.head("window_start")
        return np.where(self.cycle_time > 0.0, 1, periods) if self.results.layout.returns else periods

    @property
    def time(self) -> np.ndarray:
        time = self.periods * self.period
        return np.where(self.cycle_time > 0.0, self.cycle_time, time) if self.results.layout.returns else time

    @property
    def time_to_settle(self) -> np.ndarray:
        """Time after which the motion stays within the threshold of where it goes, where it has settled."""
        time = self.results.head("since") * self.period
        if not self.results.layout.returns:
            return time
        return np.where(self.cycle_time > 0.0, self.results.entry("SETTLED_TIME"), time)

    @property
    def displacement(self) -> np.ndarray:
        """Change of the cyclic coordinate over the window."""
        place = self.system.state_names.index(travelling(self.system))
        return self.results.state[:, place] - self.results.start[:, place]

    @property
    def drift(self) -> np.ndarray:
        return self.displacement / self.periods

    @property
    def travels(self) -> np.ndarray:
        """Whether the machine travels, by more than its residue (`motion.trust`) where it has settled or was not to."""
        if self.scales is None:
            return self.drift != 0.0
        place = self.system.state_names.index(travelling(self.system))
        rests = stands_still((self.drift / self.scales[:, place])[:, None], self.threshold or ZERO / RESIDUE)
        return (self.drift != 0.0) & ~(rests & (self.settled if self.threshold else True))

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
        strikes the stop more often than it comes to rest there, which it does as often as it leaves it, or rests there
        at the end of the window and not at its start.
        """
        stops = [stop for stop in self.system.machine.derived.stops if stop.switches]
        if not stops or "OCCURRED" not in dict(self.results.layout.gathered):
            return self.nowhere  # a run may also end where it would strike
        counts, impacts, first = self.results.entries("OCCURRED"), np.zeros(len(self.results)), 0
        for number, stop in enumerate(stops, start=1):
            place = self.system.state_names.index(numbered("touching", number))
            before, after = self.results.start[:, place], self.results.state[:, place]
            own = counts[:, first : first + len(sides(stop))]
            opened, first = own[:, sides(stop).index(0.0)], first + len(sides(stop))
            struck = own.sum(axis=1) - opened
            rested = opened + after * after - before * before
            impacts += np.where(stop.rigid & (rested > 0.0) & (struck > rested), np.inf, struck)
        return impacts

    @property
    def nowhere(self) -> np.ndarray:
        """NaN for every run: of a measure that the system does not have."""
        return np.full(len(self.results), np.nan)

    def mode_sequences(self, contact: int) -> np.ndarray:
        """Mode sequences of a contact in the last period of each window, an array of text, see `mode_sequence`.

        That of a cycle begins where it comes first in the alphabet, at whichever return the window began.
        """
        sequences, which = self.results.letters(contact)
        texts = [_letters(*sequence) for sequence in sequences]
        modes = np.array(texts, dtype=str)[which]
        if not self.results.layout.returns:
            return modes
        turned = np.array([text if text.endswith("...") else first_turned(text) for text in texts], dtype=str)[which]
        return np.where(self.cycle_time > 0.0, turned, modes)


def _letters(sides: tuple[int, ...], complete: bool) -> str:
    letters = [LETTERS[side] for side in sides]  # "...": there is no telling how the period ends
    return as_cycle(letters) if complete else "".join(letters) + "..."


def balanced(recording: Equations, gathered: Gathered, parameters: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether the energy stored over the window of each run is the work of all channels: array [runs] of bool.

    The bound is that of a certificate: 100 tolerances, and a tenth for each step, of the natural size of the energy,
    here with all works added. Both states stand at the start of a drive period. True for laws that lose stored energy
    where a branch begins (`loses_at_switches`): there the works need not add up.

    parameters: [runs, parameters]
    """
    count = len(gathered.results)
    if not count or loses_at_switches(recording):
        return np.ones(count, dtype=bool)
    before, after = gathered.results.start.T, gathered.results.state.T
    energy, slopes = _energy(recording)
    values = parameters.T

    def at(expressions: tuple[Expression, ...], states: np.ndarray) -> np.ndarray:
        return evaluated(expressions, 0.0, states, 1.0, values, (count,))

    scales = at(recording.scales, before)
    reach = np.zeros(count)
    for states in (before, after, scales):
        reach = np.maximum(reach, np.sum(np.abs(at(slopes, states)) * scales, axis=0))
    works = np.array([gathered.results.entry("INTEGRAL", i) for i in range(len(recording.powers))])
    residual = at((energy,), after)[0] - at((energy,), before)[0] - works.sum(axis=0)
    steps = gathered.results.head("taylor_steps") + gathered.results.head("implicit_steps")
    errors = max(tolerance, LEAST_TOLERANCE) * (BALANCE_BOUND + BALANCE_PER_STEP * steps)
    return np.abs(residual) <= errors * (reach + np.abs(works).sum(axis=0))


@functools.lru_cache(maxsize=64)
def loses_at_switches(recording: Equations) -> bool:
    """Whether a change of branch may change what the contact stores, as where one begins unloaded."""
    stored = recording.observables["contact_energy"]
    outcomes = (*recording.after_switch, *(contact.after_reversal for contact in recording.contacts))
    return any(
        value.index != recording.graph.node("state", i).index and derivative(stored, i).value != 0.0
        for outcome in outcomes
        for i, value in enumerate(outcome)
    )


@functools.lru_cache(maxsize=64)
def _energy(recording: Equations) -> tuple[Expression, tuple[Expression, ...]]:
    """The stored energy, and its slope with every state."""
    energy = recording.observables["energy"] + recording.observables["contact_energy"]
    return energy, tuple(derivative(energy, i) for i in range(len(recording.rates)))
