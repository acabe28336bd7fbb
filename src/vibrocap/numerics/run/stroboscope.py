"""The marks of a stored motion, asked by the very functions that decide during a run whether it has settled."""

import functools
import math
from types import CodeType
from typing import Any

import numpy as np

from vibrocap.numerics.kernel.codes import LONGEST_PERIOD
from vibrocap.numerics.linker import kernel_source


class Stroboscope:
    """Stroboscopic states [marks, kept] over their natural sizes, as `motion.section.section_states` gives them.

    See `settle.py` for what its methods answer, all for the last mark.
    """

    def __init__(self, states: np.ndarray):
        self.last = len(states) - 1
        size = states.shape[1]
        room = [0.0] * (9 * size + 32)  # in which limits of marks are sought
        self._states = [*states.ravel().tolist(), *room]  # numbers of Python's own are faster to get at one by one
        places = {"LANES": 1, "MARK_SIZE": size, "STATES": size, "MARK_COUNT": len(states), "WORK": states.size}
        places |= {"THRESHOLD": len(self._states) - 2, "TOLERANCE": len(self._states) - 1}
        self.functions: dict[str, Any] = {"math": math, "LONGEST_PERIOD": LONGEST_PERIOD, **places}
        exec(_decision(), self.functions)

    def _asked(self, question: str, *arguments: Any, threshold: float = 0.0, tolerance: float = 0.0) -> Any:
        self._states[-2:] = threshold, tolerance
        return self.functions[question](self._states, 0, 0, self.last, *arguments)

    def difference(self, n: int) -> float:
        """Largest difference over the states to the mark n periods earlier."""
        return self._asked("difference", self.last - n)

    def settled_response(self, threshold: float, tolerance: float) -> tuple[int, int, float]:
        """What a run decides at this mark: (response period, since, remaining), or (0, 0, 0.0)."""
        return self._asked("settled_response", LONGEST_PERIOD, threshold=threshold, tolerance=tolerance)

    def distance_to_go(self, n: int, tolerance: float) -> tuple[float | None, float | None]:
        """(contraction over n periods, bound of the distance still to go); None where differences do not shrink."""
        ratio, remaining = self._asked("distance_to_go", n, tolerance=tolerance)
        return (ratio, remaining) if ratio >= 0.0 else (None, None)

    def shortest_period(self, n: int, ratio: float, threshold: float) -> int:
        """The smallest divisor of n that the settled motion has as its period to within the threshold."""
        return self._asked("shortest_period", n, ratio, threshold=threshold)

    def settled_since(self, n: int, distance: float) -> int:
        """First mark from which on every state is within a distance of the final one of the same phase."""
        return self._asked("settled_since", n, distance)


@functools.cache
def _decision() -> CodeType:
    return compile(kernel_source("observe.settle"), "<settle>", "exec")
