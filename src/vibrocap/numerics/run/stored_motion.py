"""Looks at a stored motion at many instants, in a compiled loop."""

import functools
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.numerics.codegen.source import stored_motion_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import compiled_kernel, linked_source, stored_motion_recipe
from vibrocap.numerics.run.motion import motion_layout


@functools.lru_cache(maxsize=64)
def _kernel(equations: Equations, order: int) -> tuple[Layout, Callable]:
    """(layout, entry) of the kernel that looks at motions of these equations."""
    layout, recipe = motion_layout(equations, order), stored_motion_recipe(equations.maybe_stiff)
    return layout, compiled_kernel(linked_source(stored_motion_source(equations, layout), recipe), entry=recipe.entry)


class StoredMotion:
    """A motion that is looked at; its pieces are given anew each time.

    rows: what can be seen, states, then `observables` of the equations, then the rates of their integrals
    """

    def __init__(self, equations: Equations, order: int, parameters: Sequence[float], scales: np.ndarray):
        self.layout, self._look_along = _kernel(equations, order)
        self._memory = self.layout.allocated()
        self.layout.put(*self._memory, {"PARAMETER": parameters, "SCALE": scales})

    def rows(
        self, rows: Sequence[int], of_law: Sequence[bool], pieces: np.ndarray, ends: np.ndarray, times: np.ndarray
    ) -> np.ndarray:
        """Rows by number at times [n]: array [rows, n].

        of_law: whether a row depends on the law's forces
        pieces: [pieces, numbers] as a run records them, with the numbers of the drive's segment, if any, behind
        ends: [pieces] number of the instants up to the end of each piece; times: since the start of the piece
        """
        observed = max(rows) >= self.layout.states
        head = [len(rows), len(times), observed, 0.0, *np.column_stack((rows, of_law)).ravel()]
        return self._seen(head, len(rows), pieces, ends, times)

    def left(self, bound: float, pieces: np.ndarray, ends: np.ndarray, times: np.ndarray) -> np.ndarray:
        """h |y' - f(t, y)| over the natural size of a state [n]; what is beyond the bound, along stiff directions."""
        return self._seen([0, len(times), 0.0, bound], 1, pieces, ends, times)[0]

    def _seen(self, head: list, rows: int, pieces: np.ndarray, ends: np.ndarray, times: np.ndarray) -> np.ndarray:
        written = np.concatenate((head, pieces.ravel(), ends, times))
        trace = np.empty(len(written) + rows * len(times))
        trace[: len(written)] = written
        self._look_along(*self._memory, trace, len(pieces))
        return trace[len(written) :].reshape(rows, -1)
