"""Writes scalar code of one law under an imposed motion: its step, force, guards and jumps (see `driven_generated.py`).

The implicit step is Rodas5P, without loops; method and coefficients are those of `implicit.py`. Written out for one
law, what vanishes in its Jacobian costs nothing, and states that only jump take no part. Of Rodas3, Rodas4P and Rodas5P
this one takes the least time per sample at any error below 1e-5 of the scale, since a law is cheap: its eight stages
cost a fifth more than six.
"""

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.codegen.resolution import SharpArgument
from vibrocap.numerics.codegen.straight_line import LEAVES, ScalarWriter, branch_source, function_source
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative
from vibrocap.numerics.kernel.driven_generated import Numbers, Wholes
from vibrocap.numerics.kernel.step.implicit import COUPLING, GAMMA, NODES, STAGE_WEIGHTS, STAGES, TIME_WEIGHTS

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


def _moved(equations: DrivenEquations, frozen: dict[int, str], states: Sequence[Expression]) -> list[str]:
    """Lines that put other states to `at`."""
    writer = DrivenWriter(equations, frozen)
    lines = writer.stores(states, "at")
    return [*_loaded(writer, equations.states), *lines]


Entries = set[tuple[int, int]]


def driven_source(equations: DrivenEquations) -> tuple[DrivenLayout, str]:
    """(layout, source) of everything that `driven_generated.py` promises."""
    frozen: dict[int, str] = {}
    functions = [*step_source(equations, frozen), force_source(equations, frozen), guard_source(equations, frozen)]
    switched = [_moved(equations, frozen, states) for states in equations.after_switch]
    functions.append(branch_source("switch(floats, at, which, v, w, side)", "which", switched))
    turned = _moved(equations, frozen, equations.after_reversal)
    functions.append(function_source("reverse(floats, at, w, side)", turned))
    writer = ScalarWriter(equations.graph, OF_LAW | {"parameter": "floats[PARAMETER + {}]"})
    values = [Expression(equations.graph, index) for index in frozen]  # of all functions above
    functions.append(function_source("freeze(floats, side)", writer.stores(values, "FROZEN")))
    layout = DrivenLayout(equations.states, len(equations.parameter_names), len(frozen))
    constants = {
        "STATES": equations.states,
        "GUARDS": len(equations.guards),
        "SET_VALUED": equations.set_valued,
        "MOVING": equations.moving,
        "SHARP_INTERNAL": equations.sharp_internal,
        **layout.places,
    }
    return layout, "\n".join([*(f"{name} = {value!r}" for name, value in constants.items()), "", *functions])


def step_source(equations: DrivenEquations, frozen: dict[int, str]) -> list[str]:
    """`rates`, `slopes` (rates, Jacobian, derivative in time) and `attempt`, a step of the method."""
    moving, states = equations.moving, equations.states
    rates, slopes = DrivenWriter(equations, frozen), DrivenWriter(equations, frozen)
    point, slots = [f"z{i}" for i in range(states)], range(moving)
    values = [rates.name(rate) for rate in equations.rates]
    outputs, names, jacobian = _slopes(equations, slopes)
    used = [*rates.used, *(name for name in slopes.used if name not in rates.used)]
    call_of_slopes = f"slopes({', '.join([*point, 'v', 'w', 'a', 'b', 'side', *slopes.used])})"
    lines = [
        *(f"z{i} = floats[STATE + {i}]" for i in range(states)),
        "v, w, a, b = floats[VELOCITY], floats[LOAD], floats[VELOCITY_RATE], floats[LOAD_RATE]",
        *frozen_lines(used),
        *([f"{_tuple(names)} = {call_of_slopes}"] if names else []),
        f"inverse, over, dv, dw = {1.0 / GAMMA!r} / h, 1.0 / h, h * a, h * b",
    ]
    elimination, filled = decomposition(jacobian, moving)
    lines += elimination
    for stage, node in enumerate(NODES.tolist()):
        weights, coupling, time_weight = STAGE_WEIGHTS[stage], COUPLING[stage], float(TIME_WEIGHTS[stage])
        if stage > 0 and moving:
            lines += [f"u{i} = {_sum(f'z{i}', weights, f'_{i}')}" for i in slots]
            at = [f"v + {node!r} * dv" if node else "v", f"w + {node!r} * dw" if node else "w"]
            arguments = [*(f"u{i}" for i in slots), *point[moving:], *at, "side", *rates.used]
            lines += [f"{_tuple([f'f{i}' for i in slots])} = rates({', '.join(arguments)})"]
        for i in slots:
            right = f"f{i}"
            if time_weight:
                right += f" + {time_weight!r} * (h * t{i})"
            if coupling.any():
                right += f" + over * ({_sum('', coupling, f'_{i}')})"
            lines += [f"r{i} = {right}"]
        lines += solution(filled, moving, stage)
    last = STAGES - 1
    lines += [f"floats[NEW + {i}] = u{i} + k{last}_{i}" for i in slots]
    lines += [f"floats[NEW + {i}] = z{i}" for i in range(moving, states)]
    lines += ["error = 0.0"]
    for i in slots:
        lines += [f"estimate = abs(k{last}_{i}) * floats[INVERSE_SCALE + {i}]"]
        lines += ["if not (estimate <= error):", "    error = estimate if estimate <= 1e300 else math.inf"]
    return [
        function_source(f"rates({', '.join([*point, 'v', 'w', 'side', *rates.used])})", _returned(rates, values)),
        function_source(call_of_slopes, _returned(slopes, outputs)),
        function_source("attempt(floats, side, h)", [*lines, "return error"]),
    ]


def _slopes(equations: DrivenEquations, writer: DrivenWriter) -> tuple[list[str], list[str], Entries]:
    """(values, names, entries of the Jacobian that do not vanish) of what `slopes` returns."""
    graph, moving, states = equations.graph, equations.moving, equations.states
    jacobian: Entries = set()
    velocity_rate, load_rate = graph.node("state", states + 2), graph.node("state", states + 3)
    values = [writer.name(rate) for rate in equations.rates]
    names = [f"f{i}" for i in range(moving)]
    for i, rate in enumerate(equations.rates):
        for j in range(moving):
            slope = derivative(rate, j)
            if slope.value != 0.0:
                jacobian.add((i, j))
                values.append(writer.name(slope))
                names.append(f"j{i}_{j}")
        by_velocity, by_load = (derivative(rate, states + i) for i in range(2))
        values.append(writer.name(by_velocity * velocity_rate + by_load * load_rate))
        names.append(f"t{i}")
    return values, names, jacobian


def _returned(writer: DrivenWriter, values: list[str]) -> list[str]:
    return [*writer.lines, f"return {_tuple(values)}"] if values else ["return 0.0"]


def _tuple(names: Sequence[str]) -> str:
    return f"({', '.join(names)},)"


def _sum(first: str, weights: np.ndarray, suffix: str) -> str:
    """first + the sum of weights times stages."""
    terms = [f"k{j}{suffix}" if a == 1.0 else f"{a!r} * k{j}{suffix}" for j, a in enumerate(weights.tolist()) if a]
    return " + ".join([first] * bool(first) + terms)


def decomposition(jacobian: Entries, size: int) -> tuple[list[str], Entries]:
    """(lines, entries) of inverse 1 - J = L M: l below a diagonal of ones, m with the reciprocal pivots p.

    Without pivoting: 1/(gamma h) dominates the diagonal for the steps that the error control takes.
    """
    filled = jacobian | {(i, i) for i in range(size)}
    lines = []
    for i, j in sorted(filled):
        entry = f"j{i}_{j}" if (i, j) in jacobian else "0.0"
        lines.append(f"m{i}_{j} = inverse - {entry}" if i == j else f"m{i}_{j} = -{entry}")
    for j in range(size):
        lines.append(f"p{j} = 1.0 / m{j}_{j}")
        for i in range(j + 1, size):
            if (i, j) in filled:
                lines.append(f"l{i}_{j} = m{i}_{j} * p{j}")
                for k in range(j + 1, size):
                    if (j, k) in filled:
                        before = f"m{i}_{k} " if (i, k) in filled else ""
                        lines.append(f"m{i}_{k} = {before}- l{i}_{j} * m{j}_{k}")
                        filled.add((i, k))
    return lines, filled


def solution(filled: Entries, size: int, stage: int) -> list[str]:
    """Lines that solve for the right-hand sides r and leave the stage in k."""
    lines = []
    for i in range(size):
        below = [f" - l{i}_{j} * r{j}" for j in range(i) if (i, j) in filled]
        if below:
            lines.append(f"r{i} = r{i}{''.join(below)}")
    for i in range(size - 1, -1, -1):
        above = "".join(f" - m{i}_{j} * k{stage}_{j}" for j in range(i + 1, size) if (i, j) in filled)
        lines.append(f"k{stage}_{i} = (r{i}{above}) * p{i}" if above else f"k{stage}_{i} = r{i} * p{i}")
    return lines
