"""Writes the generated part of a kernel: series, rates and Jacobian of one system's equations, as Python source."""

import math
from collections.abc import Sequence
from typing import Any

from vibrocap.numerics.graph import Expression, derivative
from vibrocap.numerics.jets import JetWriter
from vibrocap.numerics.lanes import Layout

OPERATORS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def generated_source(equations: Any, layout: Layout, abreast: bool = False) -> str:
    """Source of everything that `generated.py` promises, for these equations.

    The integrals are carried along where the layout has rows for them. abreast: the series of all lanes at once.
    """
    series = layout.places["SERIES"]
    row_size = (layout.order + 1) * layout.lanes
    constants = {
        **layout.constants(),
        "SET_VALUED": equations.hold is not None,
        "KINKED": equations.kinked,
        "CONTACT_STATE": equations.contact_state,
        "CYCLIC": equations.cyclic_state,
    }
    for i, name in enumerate(("VELOCITY", "HOLD", "LIMIT", "GUARD"), start=layout.rows):
        constants[name] = series + i * row_size
    lines = [f"{name} = {value!r}" for name, value in constants.items()]
    integrals = equations.integrals[: layout.rows - layout.states]
    functions = [
        jet_source(equations, integrals, layout, abreast),
        rates_source(equations, integrals),
        jacobian_source(equations, integrals),
    ]
    return "\n".join([*lines, "", *functions, ""])


def jet_source(equations: Any, integrals: Sequence[Expression], layout: Layout, abreast: bool) -> str:
    """`jet`: Taylor coefficients of states, integrals, contact velocity and guards for all lanes."""
    graph, order = equations.graph, layout.order
    writer = JetWriter(graph, list(equations.rates), abreast)
    states, rows = layout.states, layout.rows
    stored: list[tuple[int, int, str]] = []
    for k in range(order + 1):
        for i in range(states):
            stored.append((i, k, writer.coefficient(graph.node("state", i).index, k)))
        for i, rate in enumerate(integrals, start=states):
            if k == 0:
                stored.append((i, 0, writer.entry(f"STATE + {i} * LANES")))
            else:
                stored.append((i, k, f"{writer.coefficient(rate.index, k - 1)} * {1.0 / k!r}"))
        stored.append((rows, k, writer.coefficient(equations.contact_velocity.index, k)))
        if equations.hold is not None and k < order:
            stored.append((rows + 1, k, writer.coefficient(equations.hold.index, k)))
            stored.append((rows + 2, k, writer.coefficient(equations.limit.index, k)))
    body = [f"time = {writer.entry('TIME')}", f"sliding = {writer.entry('SIDE')}", *writer.lines]
    places = [(f"SERIES + {row * (order + 1) + k} * LANES", value) for row, k, value in stored]
    if abreast:
        body += [f"store(real, {place}, {value})" for place, value in places]
        return "\n".join(["def jet(real):", *_indented(body, 4), "", guard_source(order)])
    body += [f"real[{place} + lane] = {value}" for place, value in places]
    return "\n".join(["def jet(real):", "    for lane in range(LANES):", *_indented(body, 8), ""])


def guard_source(order: int) -> str:
    """`speed_guard`: of all lanes abreast, the speed as a polynomial over the step and its signs (see `roots.py`)."""
    body = [f"v{k} = load(real, VELOCITY + {k} * LANES)" for k in range(order + 1)]
    for k in range(order + 1):
        one, two = (f"v{k + i}" if k + i <= order else "0.0" for i in (1, 2))
        power = "" if k == 0 else " * p"
        body.append(f"a{k} = side * where(two, {two}, where(one, {one}, v{k})){power}")
        body.append(f"store(real, WORK + {k} * LANES, a{k})")
        body.append("p = h" if k == 0 else "p = p * h")
    body += [f"b{k} = a{k} * {1.0 / math.comb(order, k)!r}" for k in range(order + 1)]
    body += [f"b{i} = b{i} + b{i - 1}" for level in range(1, order + 1) for i in range(order, level - 1, -1)]
    body.append("changes = where((b0 > 0.0) ^ (b1 > 0.0), 1.0, 0.0)")
    for k in range(2, order + 1):
        body.append(f"changes = changes + where((b{k - 1} > 0.0) ^ (b{k} > 0.0), 1.0, 0.0)")
    body.append(f"return a0, b{order}, changes")
    return "\n".join(["def speed_guard(real, side, one, two, h):", *_indented(body, 4), ""])


def rates_source(equations: Any, integrals: Sequence[Expression]) -> str:
    """`rates` and `contact_velocity` of one lane."""
    writer = ScalarWriter(equations.graph)
    body = [f"real[out + {i}] = {writer.name(e)}" for i, e in enumerate((*equations.rates, *integrals))]
    rates = ["def rates(real, t, point, side, lane, out):", *_indented([*writer.lines, *body], 4), ""]
    writer = ScalarWriter(equations.graph)
    velocity = writer.name(equations.contact_velocity)
    head = "def contact_velocity(real, t, point, lane):"
    return "\n".join([*rates, head, *_indented([*writer.lines, f"return {velocity}"], 4), ""])


def jacobian_source(equations: Any, integrals: Sequence[Expression]) -> str:
    """`jacobian` of one lane, exact."""
    states, memory = len(equations.rates), {}
    writer = ScalarWriter(equations.graph)
    body = []
    for i, rate in enumerate((*equations.rates, *integrals)):
        for j in range(states + 1):
            slope = derivative(rate, j if j < states else -1, memory)
            body.append(f"real[out + {i * (states + 1) + j}] = {writer.name(slope)}")
    head = "def jacobian(real, t, point, side, lane, out):"
    return "\n".join([head, *_indented([*writer.lines, *body], 4), ""])


class ScalarWriter:
    """Writes the values of expressions as straight-line scalar code, each node once."""

    def __init__(self, graph: Any):
        self.graph = graph
        self.lines: list[str] = []
        self._names: dict[int, str] = {}

    def name(self, expression: Expression) -> str:
        """Name (or literal) of the value of an expression."""
        return self._name(expression.index)

    def _name(self, index: int) -> str:
        if index not in self._names:
            op, *operands = self.graph.nodes[index]
            leaf = {"time": "t", "side": "side"}.get(op)
            if op == "constant":
                leaf = repr(operands[0])
            if leaf is None:
                leaf = f"n{index}"
                self.lines.append(f"{leaf} = {self._formula(op, operands)}")
            self._names[index] = leaf
        return self._names[index]

    def _formula(self, op: str, operands: list) -> str:
        if op == "state":
            return f"real[point + {operands[0]}]"
        if op == "parameter":
            return f"real[PARAMETER + {operands[0]} * LANES + lane]"
        names = [self._name(i) for i in operands]
        if op in OPERATORS:
            return f"{names[0]} {OPERATORS[op]} {names[1]}"
        return f"-{names[0]}" if op == "neg" else f"math.{op}({names[0]})"


def _indented(lines: list[str], spaces: int) -> list[str]:
    return [" " * spaces + line for line in lines]
