"""Recorded expressions: call a scalar function once with these, and its formula is known as a graph.

Common subexpressions are merged as they are recorded and constants folded, so that whoever reads the graph (series,
Jacobians, NumPy) meets every operation once.
"""

import math
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.refusals import Recordable

LARGEST_PRODUCT = 8  # exponent up to which a whole power is a product, as in `vibrocap.physics.elementary.power`
LEAST_BASE = 1e-300  # of a power, whose value at zero is zero by that
LEAVES = ("constant", "time", "side", "delay", "state", "parameter")
FUNCTIONS = {
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "tanh": math.tanh,
    "atan": math.atan,
}


class Graph:
    """The nodes of recorded expressions, in an order in which each comes after its operands.

    A node is (op, operands): ("constant", value), ("time",), ("side", i) of contact i (of a law alone ("side",)),
    ("delay",), ("state", i), ("parameter", i), ("add" | "sub" | "mul" | "div", a, b), ("neg", a), ("power", a, b) for
    a^b with a >= 0 and a constant b, ("rate", a) for a', known by its series alone, or (function, a) with a function of
    FUNCTIONS.
    """

    def __init__(self):
        self.nodes: list[tuple] = []
        self._known: dict[tuple, int] = {}
        self._constant: dict[int, bool] = {}
        self._reached: dict[tuple[int, ...], list[int]] = {}  # what `reached_from` has found
        self._slopes: dict[tuple[int, int], int] = {}  # what `sensitivity` has found, by expression and node

    def __deepcopy__(self, memory: dict) -> "Graph":
        """A graph that begins with the nodes of this one."""
        copied = Graph()
        copied.nodes, copied._known = list(self.nodes), dict(self._known)
        copied._constant, copied._slopes = dict(self._constant), dict(self._slopes)
        memory[id(self)] = copied
        return copied

    def node(self, op: str, *operands) -> "Expression":
        """The expression of this node, recorded now if it is new."""
        key = (op, *operands)
        index = self._known.get(key)
        if index is None:
            index = len(self.nodes)
            self.nodes.append(key)
            self._known[key] = index
        return Expression(self, index)

    def known(self, op: str, a: int, b: int) -> int | None:
        """Index of the sum or product of two nodes, if it has been recorded."""
        return self._known.get((op, min(a, b), max(a, b)))

    def constant(self, value: float) -> "Expression":
        """A number."""
        return self.node("constant", float(value))

    def expression(self, value: Any) -> "Expression":
        """A number or an expression, as an expression."""
        return value if isinstance(value, Expression) else self.constant(value)

    def reached_from(self, roots: tuple[int, ...]) -> list[int]:
        """Indices of all nodes that the roots need, operands first: kept, as a node never changes."""
        if roots not in self._reached:
            self._reached[roots] = reachable(self, roots)
        return self._reached[roots]

    def is_constant_in_time(self, index: int) -> bool:
        """Whether a node depends on neither time nor state."""
        if index not in self._constant:
            op, *operands = self.nodes[index]
            leaf = op in LEAVES
            constant = op not in ("time", "state") if leaf else all(map(self.is_constant_in_time, operands))
            self._constant[index] = constant
        return self._constant[index]


class Expression(Recordable):
    """A node of a graph that behaves like a number."""

    __slots__ = ("graph", "index")

    def __init__(self, graph: Graph, index: int):
        self.graph = graph
        self.index = index

    @property
    def value(self) -> float | None:
        """The number that this expression is, if it is one."""
        op, *operands = self.graph.nodes[self.index]
        return operands[0] if op == "constant" else None

    @property
    def state(self) -> int:
        """Number of the state that this expression is, -1 if it is none."""
        op, *operands = self.graph.nodes[self.index]
        return operands[0] if op == "state" else -1

    def _binary(self, op: str, left: Any, right: Any) -> "Expression":
        graph = self.graph
        try:
            a, b = graph.expression(left), graph.expression(right)
        except TypeError:  # no number, which may know what to do with an expression
            return NotImplemented
        x, y = a.value, b.value
        if x is not None and y is not None:
            return graph.constant({"add": x + y, "sub": x - y, "mul": x * y}[op] if op != "div" else x / y)
        if (op in ("add", "sub") and y == 0.0) or (op in ("mul", "div") and y == 1.0):
            return a
        if (op == "add" and x == 0.0) or (op == "mul" and x == 1.0):
            return b
        if (
            (op == "mul" and (x == 0.0 or y == 0.0))
            or (op == "div" and x == 0.0)
            or (op == "sub" and a.index == b.index)
        ):
            return graph.constant(0.0)
        if op == "sub" and x == 0.0:
            return -b
        if op == "sub" and graph.nodes[b.index][0] == "add" and a.index in graph.nodes[b.index][1:]:
            _, i, j = graph.nodes[b.index]  # a - (a + rest) = -rest
            return -Expression(graph, j if i == a.index else i)
        i, j = (b.index, a.index) if op in ("add", "mul") and b.index < a.index else (a.index, b.index)
        return graph.node(op, i, j)

    def __add__(self, other):
        return self._binary("add", self, other)

    def __radd__(self, other):
        return self._binary("add", other, self)

    def __sub__(self, other):
        return self._binary("sub", self, other)

    def __rsub__(self, other):
        return self._binary("sub", other, self)

    def __mul__(self, other):
        return self._binary("mul", self, other)

    def __rmul__(self, other):
        return self._binary("mul", other, self)

    def __truediv__(self, other):
        return self._binary("div", self, other)

    def __rtruediv__(self, other):
        return self._binary("div", other, self)

    def __neg__(self):
        if self.value is not None:
            return self.graph.constant(-self.value)
        op, *operands = self.graph.nodes[self.index]
        if op == "sub":
            return self._binary("sub", Expression(self.graph, operands[1]), Expression(self.graph, operands[0]))
        if op == "mul":  # move the sign to the factor that can absorb it
            for i, j in (operands, operands[::-1]):
                if self.graph.nodes[j][0] in ("sub", "constant", "neg"):
                    return self._binary("mul", Expression(self.graph, i), -Expression(self.graph, j))
        if op == "neg":
            return Expression(self.graph, operands[0])
        return self.graph.node("neg", self.index)

    def __pow__(self, exponent):
        """A product for whole numbers; any other power is a node of its own, of a base that is never negative."""
        graph = self.graph
        number = exponent.value if isinstance(exponent, Expression) else float(exponent)
        if self.value is not None and number is not None:
            return graph.constant(self.value**number)
        if number is None or number != int(number) or abs(number) > LARGEST_PRODUCT:
            power = graph.expression(exponent)
            if not graph.is_constant_in_time(power.index):
                return (power * self.log()).exp()
            return graph.node("power", self.index, power.index)
        product = self if number else graph.constant(1.0)
        for _ in range(abs(int(number)) - 1):
            product = product * self
        return 1.0 / product if number < 0 else product

    def __rpow__(self, base):
        return (math.log(base) * self).exp()

    def _function(self, name: str) -> "Expression":
        if self.value is not None:
            return self.graph.constant(FUNCTIONS[name](self.value))
        return self.graph.node(name, self.index)

    def rate(self):
        """The derivative in time, by its series."""
        still = self.graph.is_constant_in_time(self.index)
        return self.graph.constant(0.0) if still else self.graph.node("rate", self.index)

    def sin(self):
        return self._function("sin")

    def cos(self):
        return self._function("cos")

    def exp(self):
        return self._function("exp")

    def log(self):
        return self._function("log")

    def sqrt(self):
        return self._function("sqrt")

    def tanh(self):
        return self._function("tanh")

    def atan(self):
        return self._function("atan")


def derivative(expression: Expression, state: int) -> Expression:
    """Partial derivative with respect to a state (state = -1: with respect to time), as an expression."""
    graph = expression.graph
    variable = graph.node("time") if state == -1 else graph.node("state", state)
    return sensitivity(expression, variable.index)


def sensitivity(expression: Expression, node: int) -> Expression:
    """Partial derivative with respect to a node, as if that were a variable of its own."""
    graph, key = expression.graph, (expression.index, node)
    if expression.index == node:
        return graph.constant(1.0)
    if expression.index < node:  # a node comes after its operands
        return graph.constant(0.0)
    known = graph._slopes.get(key)
    if known is not None:
        return Expression(graph, known)
    op, *operands = graph.nodes[expression.index]
    if op in LEAVES:
        result = graph.constant(0.0)
    else:
        args = [Expression(graph, i) for i in operands]
        slopes = [sensitivity(a, node) for a in args]
        nothing = op in LINEAR_IN_SLOPES and all(slope.value == 0.0 for slope in slopes)
        result = slopes[0] if nothing else _chain_rule(op, expression, args, slopes)
    graph._slopes[key] = result.index
    return result


# What the chain rule makes of slopes that are zero is zero then, and no other node is recorded on the way.
LINEAR_IN_SLOPES = ("neg", "add", "sub", "mul", "div", "power", "exp", "log")


def _chain_rule(op: str, f: Expression, args: Sequence[Expression], slopes: Sequence[Expression]) -> Expression:
    a, da = args[0], slopes[0]
    if op == "neg":
        return -da
    if op == "sin":
        return a.cos() * da
    if op == "cos":
        return -(a.sin() * da)
    if op == "exp":
        return f * da
    if op == "log":
        return da / a
    if op == "sqrt":
        return 0.5 * da / f
    if op == "tanh":
        return (1.0 - f * f) * da
    if op == "atan":
        return da / (1.0 + a * a)
    b, db = args[1], slopes[1]
    if op == "add":
        return da + db
    if op == "sub":
        return da - db
    if op == "mul":
        return da * b + a * db
    if op == "power":
        slope = b * a ** (b - 1.0) * da
        # a^b log(a), written so that it has a series where the power has one, and is zero where that is
        return slope if db.value == 0.0 else slope + f * (f + LEAST_BASE).log() * db / b
    return (da - f * db) / b


BINARY = {"add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": np.divide}


@np.errstate(over="ignore", invalid="ignore")  # what is beyond all numbers shows in the values
def evaluate(expressions: Sequence[Expression], t, states, side, parameters) -> list:
    """Values of expressions on NumPy arrays: `states[i]`, `side` and `t` are numbers or arrays of one shape.

    side: of several contacts a tuple, one for each, or one for all
    """
    sides = side if isinstance(side, tuple) else None
    if not expressions:
        return []
    graph = expressions[0].graph
    values: dict[int, Any] = {}
    for index in graph.reached_from(tuple(e.index for e in expressions)):
        op, *operands = graph.nodes[index]
        if op in BINARY:
            values[index] = BINARY[op](values[operands[0]], values[operands[1]])
        elif op == "constant":
            values[index] = operands[0]
        elif op == "time":
            values[index] = t
        elif op == "side":
            values[index] = side if sides is None else sides[operands[0]]
        elif op == "state":
            values[index] = states[operands[0]]
        elif op == "parameter":
            values[index] = parameters[operands[0]]
        elif op == "neg":
            values[index] = -values[operands[0]]
        elif op == "power":
            values[index] = np.maximum(np.abs(values[operands[0]]), LEAST_BASE) ** values[operands[1]]
        else:
            values[index] = getattr(np, op)(values[operands[0]])
    return [values[e.index] for e in expressions]


def evaluated(expressions: Sequence[Expression], t, states, side, parameters, shape: tuple[int, ...]) -> np.ndarray:
    """The same as one array [expressions, *shape]."""
    values = np.empty((len(expressions), *shape))
    for i, value in enumerate(evaluate(expressions, t, states, side, parameters)):
        values[i] = value
    return values


def reachable(graph: Graph, roots: Sequence[int]) -> list[int]:
    """Indices of all nodes that the roots need, operands first."""
    visited: set[int] = set()
    waiting = list(roots)
    while waiting:
        index = waiting.pop()
        if index in visited:
            continue
        visited.add(index)
        waiting.extend(operands_of(graph, index))
    return sorted(visited)


def operands_of(graph: Graph, index: int) -> list[int]:
    """Indices of the nodes on which a node depends at once."""
    op, *operands = graph.nodes[index]
    return [] if op in LEAVES else operands


def depends_on_time(expressions: Sequence[Expression]) -> bool:
    """Whether any of the expressions of a graph contains the time itself."""
    graph = expressions[0].graph
    return any(graph.nodes[i][0] == "time" for i in graph.reached_from(tuple(e.index for e in expressions)))
