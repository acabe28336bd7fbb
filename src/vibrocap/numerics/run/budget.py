"""What every run is given: where it starts, what it may cost, in which form its kernel is; and its first memory."""

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.numerics.kernel.memory_layout import Layout

if TYPE_CHECKING:
    from vibrocap.numerics.codegen.source import Integrands

NO_TABLES = np.empty((0, 0, 0))  # of a drive without corners


@dataclasses.dataclass(frozen=True, eq=False)
class MotionStart:
    """Where one motion begins: its parameters, states and the phase of the drive, a share of its period from 0 to 1.

    Times count from where that period began.
    """

    equations: Equations
    parameters: Sequence[float]
    initial: Sequence[float]
    period: float
    phase: float = 0.0

    @property
    def entries(self) -> dict[str, Any]:
        """What a lane holds of it."""
        sizes = evaluate(self.equations.scales, 0.0, self.initial, 1.0, self.parameters)
        own = {"STATE": self.initial, "PARAMETER": self.parameters, "SCALE": sizes}
        return own | {"PERIOD": self.period, "TIME": self.phase * self.period}


@dataclasses.dataclass(frozen=True, eq=False)
class EnsembleStart:
    """Where many motions begin.

    parameters: [runs, parameters]; initial: [runs, states]
    time: [runs] since the drive began its period; mark_distance: [runs] time between two marks, at each of which the
        drive begins anew, if not the period of the drive
    delay: [runs] by which the start itself moves along the tangent of a run
    """

    equations: Equations
    parameters: np.ndarray
    initial: np.ndarray
    time: np.ndarray | float = 0.0
    mark_distance: np.ndarray | None = None
    delay: np.ndarray | float = 0.0

    @property
    def tables(self) -> np.ndarray:
        """[tables, segments, numbers] of the drive, one for each run or one for all; none where it has no corners."""
        return NO_TABLES if self.equations.corners is None else self.equations.corners.tables(self.parameters)

    def write(self, rows: np.ndarray) -> None:
        """Fill the rows of runs that `run_queue.begin_run` reads."""
        parameters = self.equations.filled(self.parameters, self.time)
        expressions = [*self.equations.scales, self.equations.period]
        *sizes, period = evaluate(expressions, 0.0, self.initial.T, 1.0, parameters.T)
        last = (self.time, period if self.mark_distance is None else self.mark_distance, self.delay)
        numbers = [*self.initial.T, *parameters.T, *sizes, *last]
        for column, number in enumerate(numbers):
            rows[:, column] = number


@dataclasses.dataclass(frozen=True)
class Form:
    """In which form the kernel of a run is.

    order: of the series; 0: the cheapest for the tolerance; lanes: of an ensemble; 0: as many as registers hold
    integrands: what an ensemble gathers, with functions of one's own; None: the standard ones
    plain: whether it is plain Python; literal: computes as a browser does, and as plain Python with its polynomials
    """

    order: int = 0
    lanes: int = 0
    integrands: "Integrands | None" = None
    plain: bool = False
    literal: bool = False


COMPILED = Form()


@dataclasses.dataclass(frozen=True)
class Budget:
    """What a run may cost and when it is measured.

    periods: drive periods at most, whole ones of a run that is measured
    tolerance: error per step over the natural size of a state
    window: the last so many periods are measured where nothing settles; 0: all of them
    threshold: of settling, over the natural size of each state; 0: every run goes on to its end
    asked: groups of measures, a sum of powers of two
    evidence: last periods, of the window, of which evidence is taken where nothing settles (else of the response), see
        `kernel/observe/evidence.py`; 0: of no run
    returns: whether runs settle by their returns, as motions do that nothing drives in time, see `observe/returns.py`
    extrapolate: whether runs go on from the limit of their marks where it holds, see
        `kernel/observe/extrapolation.py`; never those of a rotor or with a tangent
    """

    periods: float
    tolerance: float
    max_events_per_period: int
    max_steps: int
    _: dataclasses.KW_ONLY
    window: int = 0
    threshold: float = 0.0
    asked: int = 0
    evidence: int = 0
    returns: bool = False
    extrapolate: bool = False


def prepared_memory(layout: Layout, budget: Budget, **entries: Any) -> tuple[np.ndarray, np.ndarray]:
    """(floats, ints) of lanes that are about to run: what the budget says, and these entries by name.

    A number goes to every lane, several numbers to the one lane that there is. All that follows from states,
    parameters, natural sizes, time and period the kernel itself begins (`loop/one_step.py`).
    """
    floats, ints = layout.allocated()
    entries["TOLERANCE"] = budget.tolerance
    entries["EVENT_LIMIT"], entries["STEP_LIMIT"] = budget.max_events_per_period, budget.max_steps
    if layout.gathered:  # the run is measured
        whole = int(budget.periods)
        entries |= {
            "PERIOD_BUDGET": whole,
            "WINDOW": budget.window or whole,
            "WINDOW_START": -1,
            "THRESHOLD": budget.threshold,
            "ASKED": budget.asked,
            "EVIDENCE_PERIODS": budget.evidence,
            "EXTRAPOLATE": budget.extrapolate,
        }
    layout.put(floats, ints, entries)
    return floats, ints
