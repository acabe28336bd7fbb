"""What a run may cost, and the memory with which it begins."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.numerics.kernel.memory_layout import Layout


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
    parameters, natural sizes, time and period the kernel itself begins (`loop/start.py`).
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
