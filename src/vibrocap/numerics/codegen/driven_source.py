"""Writes scalar code of one law under an imposed motion: its force, guards and jumps (see `driven_generated.py`)."""

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.codegen.resolution import SharpArgument
from vibrocap.numerics.codegen.straight_line import LEAVES, ScalarWriter, branch_source, function_source
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.numerics.kernel.driven_generated import Numbers, Wholes

SMALLEST_EXPONENT = -700.0  # exp of it is 1e-304
INT_ENTRIES = tuple(name.upper() for name in Wholes.__annotations__)


@dataclasses.dataclass(frozen=True, eq=False)
class DrivenEquations:
    """A law under an imposed motion, recorded; laws of one form share it, their numbers are parameters.

    The states of the graph are the internal states, those that move first, then velocity, load and their rates in time.
    """

    graph: Graph
    parameter_names: tuple[str, ...]
    order: tuple[int, ...]  # state of the graph for each internal state of the law
    moving: int  # how many states move; the others have the rate zero and change in jumps only
    rates: tuple[Expression, ...]  # of the states that move
    force: Expression
    guards: tuple[Expression, ...]
    after_switch: tuple[tuple[Expression, ...], ...]  # states after each guard has fallen
    after_reversal: tuple[Expression, ...]
    scales: tuple[Expression, ...]  # natural size of each state
    sharp: tuple[SharpArgument, ...]  # of the contact velocity, in the rates
    sharp_internal: bool  # whether a sharp function depends on an internal state
    set_valued: bool

    @property
    def states(self) -> int:
        """Number of internal states."""
        return len(self.order)


@dataclasses.dataclass(frozen=True)
class DrivenLayout:
    """Where everything stands in the memory of a driven kernel."""

    states: int
    parameters: int
    frozen: int

    @property
    def sizes(self) -> dict[str, int]:
        """Numbers per entry of `floats`."""
        own = {"parameter": self.parameters, "frozen": self.frozen}
        own |= dict.fromkeys(("state", "new", "inverse_scale"), self.states)
        return {name.upper(): own.get(name, 1) for name in Numbers.__annotations__}

    @property
    def places(self) -> dict[str, int]:
        """Offset of each entry of `ints` and of `floats`."""
        starts = itertools.accumulate(self.sizes.values(), initial=0)
        return {name: i for i, name in enumerate(INT_ENTRIES)} | dict(zip(self.sizes, starts, strict=False))

    def allocated(self) -> tuple[np.ndarray, np.ndarray]:
        """(floats, ints) with everything zero."""
        return np.zeros(sum(self.sizes.values())), np.zeros(len(INT_ENTRIES), dtype=np.int64)


OF_LAW = LEAVES | {"side": "side"}  # of the one contact


class DrivenWriter(ScalarWriter):
    """Scalar code in which states, velocity and load are local names, and what does not change on a side is frozen."""

    def __init__(self, equations: DrivenEquations, frozen: dict[int, str]):
        super().__init__(equations.graph, OF_LAW)
        self.frozen = frozen
        self.used: list[str] = []  # names of what is frozen, in the order of their use
        k = equations.states
        self.symbols = {i: f"z{i}" for i in range(k)} | {k: "v", k + 1: "w", k + 2: "a", k + 3: "b"}

    def _name(self, index: int) -> str:
        op, *operands = self.graph.nodes[index]
        if op == "state":
            return self.symbols[operands[0]]
        if op not in ("constant", "side") and is_frozen(self.graph, index):
            name = self.frozen.setdefault(index, f"c{len(self.frozen)}")
            if name not in self.used:
                self.used.append(name)
            return name
        return super()._name(index)

    def _formula(self, op: str, operands: list) -> str:
        if op == "exp":  # an exponential that underflows takes twice the time
            return f"math.exp(max({self._name(operands[0])}, {SMALLEST_EXPONENT!r}))"
        return super()._formula(op, operands)


def is_frozen(graph: Graph, index: int) -> bool:
    """Whether a node depends on nothing but parameters and the side."""
    waiting, visited = [index], set()
    while waiting:
        node = waiting.pop()
        if node in visited:
            continue
        visited.add(node)
        op, *operands = graph.nodes[node]
        if op in ("state", "time"):
            return False
        if op not in ("constant", "parameter", "side"):
            waiting.extend(operands)
    return True


def _loaded(writer: DrivenWriter, states: int) -> list[str]:
    """Lines that read the states at `at` and what is frozen."""
    return [f"z{i} = floats[at + {i}]" for i in range(states)] + frozen_lines(writer.used)


def frozen_lines(names: Sequence[str]) -> list[str]:
    """Lines that read what is frozen under these names."""
    return [f"{name} = floats[FROZEN + {name[1:]}]" for name in names]


def frozen_source(equations: DrivenEquations, frozen: dict[int, str]) -> str:
    """`freeze`: what depends on parameters and side only, once from turn to turn."""
    writer = ScalarWriter(equations.graph, OF_LAW | {"parameter": "floats[PARAMETER + {}]"})
    values = [Expression(equations.graph, index) for index in frozen]
    return function_source("freeze(floats, side)", writer.stores(values, "FROZEN"))


def force_source(equations: DrivenEquations, frozen: dict[int, str]) -> str:
    """`force`: of the states at a place of the memory."""
    writer = DrivenWriter(equations, frozen)
    value = writer.name(equations.force)
    lines = [*_loaded(writer, equations.states), *writer.lines, f"return {value}"]
    return function_source("force(floats, at, v, w, side)", lines)


def guard_source(equations: DrivenEquations, frozen: dict[int, str]) -> str:
    """`least_guard`: value and number of the guard that is least."""
    writer = DrivenWriter(equations, frozen)
    values = [writer.name(guard) for guard in equations.guards]
    lines = [*_loaded(writer, equations.states), *writer.lines]
    lines += [f"least, which = {values[0] if values else '1.0'}, 0"]
    for i, value in enumerate(values[1:], start=1):
        lines += [f"if {value} < least:", f"    least, which = {value}, {i}"]
    return function_source("least_guard(floats, at, v, w, side)", [*lines, "return least, which"])


def switch_source(equations: DrivenEquations, frozen: dict[int, str]) -> str:
    """`switch`: the states at a place of the memory become those after a guard has fallen."""
    bodies = [_moved(equations, frozen, states) for states in equations.after_switch]
    return branch_source("switch(floats, at, which, v, w, side)", "which", bodies)


def reversal_source(equations: DrivenEquations, frozen: dict[int, str]) -> str:
    """`reverse`: the states at a place of the memory become those after the contact has turned to `side`."""
    return function_source("reverse(floats, at, w, side)", _moved(equations, frozen, equations.after_reversal))


def _moved(equations: DrivenEquations, frozen: dict[int, str], states: Sequence[Expression]) -> list[str]:
    """Lines that put other states to `at`."""
    writer = DrivenWriter(equations, frozen)
    lines = writer.stores(states, "at")
    return [*_loaded(writer, equations.states), *lines]
