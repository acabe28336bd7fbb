"""Kernels for a browser: one WebAssembly module for all of them, with the bits of plain Python."""

import dataclasses
from collections.abc import Mapping, Sequence

from vibrocap.numerics.codegen.source import Integrands, generated_source, instants_source
from vibrocap.numerics.compiler import FLOAT, FLOATS, INT, INTS, Kind
from vibrocap.numerics.compiler.webassembly import webassembly_module
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD, Layout
from vibrocap.numerics.linker import linked_source, shown_motion_recipe
from vibrocap.numerics.run.ensemble import ensemble_order, ensemble_source
from vibrocap.numerics.run.motion import series_order

MEMORY = (FLOATS, INTS, FLOATS)
MOTION_ENTRIES = {
    "advance": (*MEMORY, INT),
    "begin": (*MEMORY, INT),
    "write_table": (*MEMORY, FLOAT, INT),
    "take_piece": (*MEMORY, INT),
    "look_at": (*MEMORY, FLOAT, INT),
}
ENSEMBLE_ENTRIES = {"advance_ensemble": (*MEMORY, INT)}


@dataclasses.dataclass(frozen=True)
class BrowserKernel:
    """A kernel of a page: its text, and the functions of it that a page calls, with the kinds of their arguments."""

    layout: Layout
    text: str
    entries: Mapping[str, tuple[Kind, ...]]

    @property
    def result_head(self) -> dict[str, int]:
        """Where the first numbers of a result stand, by name."""
        return {name: i for i, name in enumerate(RESULT_HEAD)}


def browser_module(pairs: Sequence[Sequence[BrowserKernel]]) -> bytes:
    """The WebAssembly module of several such pairs, of which the first exports `advance0`, the second `advance1`."""
    numbered = (
        (kernel.text, {f"{name}{number}": (name, kinds) for name, kinds in kernel.entries.items()})
        for number, kernels in enumerate(pairs)
        for kernel in kernels
    )
    return webassembly_module(numbered)


def browser_kernels(
    equations: Equations,
    observed: Sequence[Expression],
    tolerance: float,
    ensemble_tolerance: float,
    room: Sequence[Expression] = (),
    integrands: Integrands | None = None,
) -> tuple[BrowserKernel, BrowserKernel]:
    """(kernel of recorded motions, of many of which only measures are kept), at these and nearby tolerances.

    The first is that of `recorded_run`, with what looks at a motion; the second that of `ensemble_run`, one by one.
    Both have one layout but for the order, so that of equal order they share most of their statements.
    observed: what can be seen besides the states, at least one; room: where they may begin; see `instants_source`
    integrands: what the second one can gather, see `ensemble_source`
    """
    layout, text = ensemble_source(equations, ensemble_order(ensemble_tolerance), 1, integrands, "browser")
    text.check()
    ensemble = BrowserKernel(layout, text, ENSEMBLE_ENTRIES)
    part = 0 if equations.corners is None else len(equations.corners.numbers)
    layout = dataclasses.replace(layout, order=series_order(tolerance), observed=len(observed), part=part)
    generated = [generated_source(equations, layout), instants_source(equations, observed, room)]
    text = linked_source("\n\n".join(generated), shown_motion_recipe(layout))
    text.check()
    return BrowserKernel(layout, text, MOTION_ENTRIES), ensemble
