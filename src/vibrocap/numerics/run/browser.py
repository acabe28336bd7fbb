"""Kernels for a browser: JavaScript with the bits of plain Python, in statements that several kernels may share."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from vibrocap.numerics.codegen.source import generated_source, instants_source
from vibrocap.numerics.compiler import FLOAT, FLOATS, INT, INTS, javascript_statements
from vibrocap.numerics.expressions.graph import Expression
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker.link import linked_source
from vibrocap.numerics.linker.recipes import shown_motion_recipe
from vibrocap.numerics.run.ensemble import ensemble_order, ensemble_source
from vibrocap.numerics.run.motion import series_order

MEMORY = (FLOATS, INTS, FLOATS)
MOTION_ENTRIES = {
    "advance": (*MEMORY, INT),
    "begin": (*MEMORY, INT),
    "take_piece": (*MEMORY, INT),
    "look_at": (*MEMORY, FLOAT, INT),
}
ENSEMBLE_ENTRIES = {"advance_ensemble": (*MEMORY, INT)}


@dataclasses.dataclass(frozen=True)
class BrowserKernel:
    """A kernel of a page.

    statements: of its module, the exports last; text: the plain kernel that they were translated from
    """

    layout: Layout
    statements: tuple[str, ...]
    text: str

    @property
    def module(self) -> str:
        """The module as one text."""
        return "\n".join([*self.statements, ""])


def browser_motion(equations: Any, observed: Sequence[Expression], tolerance: float) -> BrowserKernel:
    """The kernel of recorded motions at this and nearby tolerances: that of `recorded_run`, and what looks at them.

    observed: what can be seen besides the states, at least one; see `instants_source`
    """
    states, guards = len(equations.rates), len(equations.guards)
    order = series_order(tolerance)
    layout = Layout(1, states, states, order, len(equations.parameter_paths), switches=guards)
    generated = [generated_source(equations, layout), instants_source(equations, observed)]
    text = linked_source("\n\n".join(generated), shown_motion_recipe(equations.hold is None, guards > 0))
    return BrowserKernel(layout, javascript_statements(text, MOTION_ENTRIES), text)


def browser_ensemble(equations: Any, tolerance: float) -> BrowserKernel:
    """The kernel of many motions of which only measures are kept, one by one: the bits of `ensemble_run`."""
    layout, text = ensemble_source(equations, ensemble_order(tolerance), 1, loop="browser")
    return BrowserKernel(layout, javascript_statements(text, ENSEMBLE_ENTRIES), text)
