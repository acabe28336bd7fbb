"""The stepper of one motion: its layout, its memory at the start, and its entries, compiled or as C."""

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.codegen.source import generated_source, instants_source
from vibrocap.numerics.compiler.c_text import c_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression
from vibrocap.numerics.expressions.structure import traits
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import Linked, compiled_kernel, linked_source, plain_kernel, stepper_recipe
from vibrocap.numerics.run.budget import Budget, prepared_memory
from vibrocap.numerics.run.motion import series_order

ENTRIES = ("begin_motion", "take_step", "look_at")
ENDLESS = 2**62  # periods
CONTACT_KINDS = codes.SWITCHED  # kinds of event that are counted for each contact; then those of none
WAITING_PER_CONTACT = 14  # events at one instant: each of `one_step.MOST_ZERO_PROGRESS` and what it leads to

Entry = Callable[[int], Any]


@dataclasses.dataclass(frozen=True)
class StepperMemory:
    """What one motion carries: flat arrays, of which a copy is another motion."""

    floats: np.ndarray
    ints: np.ndarray
    trace: np.ndarray

    def take(self, other: "StepperMemory") -> None:
        """Become the same as another."""
        self.floats[:], self.ints[:], self.trace[:] = other.floats, other.ints, other.trace


@dataclasses.dataclass(frozen=True)
class StepperKernel:
    """A stepper's text, and what it is given.

    observed: names of the observables that it shows, in order; held_input: whether the drive is an input
    segments: how many its drive has
    """

    layout: Layout
    text: Linked
    observed: tuple[str, ...]
    held_input: bool
    segments: int

    @property
    def counted_kinds(self) -> int:
        """How many kinds of event are told apart: those of contacts, of a law's branches, and each of the machine's."""
        return CONTACT_KINDS + self.layout.counts - CONTACT_KINDS * self.layout.contacts

    @functools.cached_property
    def places(self) -> dict[str, int]:
        """Of the memory, by name."""
        return self.layout.constants()

    def memory(self, parameters: Sequence[float], initial: Sequence[float], budget: Budget) -> StepperMemory:
        """The memory that `begin_motion` is given; the budget is one per length, of an input its events too."""
        floats, ints = prepared_memory(
            self.layout,
            budget,
            STATE=initial,
            PARAMETER=parameters,
            REFUTED_SPEED=np.inf,
            FAR_SPEED=np.inf,
            WHOLE_PERIODS=0 if self.held_input else ENDLESS,
            STEPS_PER_CALL=budget.max_steps,
            TABLE_START=self.layout.shown,
            SEGMENT_COUNT=self.segments,
            NEW_INPUT=self.held_input,
        )
        return StepperMemory(floats, ints, np.zeros(self.layout.stepper_trace_size))

    def entry(self, name: str, memory: StepperMemory, plain: bool = False) -> Entry:
        """One of ENTRIES on a memory: compiled, with every sum and product rounded as in C, or as plain Python."""
        arrays = memory.floats, memory.ints, memory.trace
        if plain:
            return functools.partial(plain_kernel(self.text)[name], *arrays)
        if name not in self._compiled:
            self._compiled[name] = compiled_kernel(self.text, literal=True, entry=name)
        return self._compiled[name].bound_to(*arrays)

    @functools.cached_property
    def _compiled(self) -> dict[str, Any]:
        return {}

    def c_text(self, prefix: str) -> str:
        """The entries in C; all names begin with `prefix`."""
        self.text.check()
        return c_source(self.text, ENTRIES, prefix)


def stepper_kernel(
    equations: Equations,
    observed: Mapping[str, Expression],
    tolerance: float,
    held_input: bool,
    parameters: Sequence[float],
) -> StepperKernel:
    """The stepper of these equations.

    parameters: their values, which decide how many segments its drive has
    observed: what it shows besides the states; tolerance: that of the order of its series, others run with that too
    held_input: whether the equations are recorded with an input for a drive (`motion/held_input.py`)
    """
    corners = None if held_input else equations.corners
    parts = 0 if corners is None else corners.count(np.array(parameters))
    return _stepper_kernel(equations, tuple(observed.items()), series_order(tolerance), held_input, parts)


@functools.lru_cache(maxsize=64)
def _stepper_kernel(equations: Equations, observed: tuple, order: int, held_input: bool, parts: int) -> StepperKernel:
    contacts, own = len(equations.contacts), None if held_input else equations.corners
    part, rows = (0, 0) if own is None else (len(own.numbers), len(own.lengths))
    layout = Layout(
        **vars(traits(equations)),
        order=order,
        counts=CONTACT_KINDS * contacts + 1 + len(equations.switches) - equations.law_switches,
        waiting=0 if held_input else WAITING_PER_CONTACT * contacts + 2,
        observed=len(observed),
        part=part,
        table=parts * part,
    )
    values = [value for _, value in observed]
    generated = [generated_source(equations, layout), instants_source(equations, values, with_table=not held_input)]
    text = linked_source("\n\n".join(generated), stepper_recipe(layout, held_input))
    names = tuple(name for name, _ in observed)
    return StepperKernel(layout, text, names, held_input, parts * rows)
