"""Writes the values of recorded expressions as scalar code, and functions of it."""

from collections.abc import Mapping, Sequence
from typing import Any

from vibrocap.numerics.expressions.graph import Expression

OPERATORS = {"add": "{} + {}", "sub": "{} - {}", "mul": "{} * {}", "div": "{} / {}", "neg": "-{}"}
LEAVES = {  # what a kernel of motions calls them
    "time": "t",
    "side": "side",
    "delay": "floats[DELAY + lane]",
    "state": "floats[point + {}]",
    "parameter": "floats[PARAMETER + {} * LANES + lane]",
}


class ScalarWriter:
    """Writes the values of expressions as straight-line scalar code, each node once."""

    def __init__(self, graph: Any, leaves: Mapping[str, str] = LEAVES):
        """leaves: how what is given is written, by its operator."""
        self.graph, self.leaves = graph, leaves
        self.lines: list[str] = []
        self._names: dict[int, str] = {}

    def name(self, expression: Expression) -> str:
        """Name (or literal) of the value of an expression."""
        return self._name(expression.index)

    def stores(self, values: Sequence[Expression], place: str = "out") -> list[str]:
        """Lines that write the values of expressions to memory from a place on, after those that make them."""
        stores = [f"floats[{place} + {i}] = {self.name(value)}" for i, value in enumerate(values)]
        return [*self.lines, *stores]

    def _name(self, index: int) -> str:
        if index not in self._names:
            op, *operands = self.graph.nodes[index]
            if op == "constant":
                found = repr(operands[0])
            elif op == "side" and operands:
                found = f"floats[SIDE + {operands[0]} * LANES + lane]"
            elif op in ("time", "side", "delay"):
                found = self.leaves[op]
            else:
                formula = self._formula(op, operands)
                # Numbered as they are written: the text must not depend on what else was recorded in the graph.
                found = f"n{len(self.lines)}"
                self.lines.append(f"{found} = {formula}")
            self._names[index] = found
        return self._names[index]

    def _formula(self, op: str, operands: list) -> str:
        if op in self.leaves:
            return self.leaves[op].format(*operands)
        return OPERATORS.get(op, f"math.{op}({{}})").format(*(self._name(i) for i in operands))


def function_source(head: str, lines: Sequence[str]) -> str:
    """A function from its head and the lines of its body, if there are any."""
    return "\n".join([f"def {head}:", *indented(lines or ['"""There is none."""']), ""])


def chosen_source(head: str, chosen: str, bodies: Sequence[Sequence[str]], before: Sequence[str] = ()) -> str:
    """A function whose body is one of several, by the value of one of its arguments, behind the lines of all."""
    lines = [line for i, body in enumerate(bodies) for line in (f"if {chosen} == {i}:", *indented(body))]
    return function_source(head, [*before, *lines])


def stored_source(name: str, graph: Any, values: Sequence[Expression], arguments: str = "point, side, lane") -> str:
    """A function that writes the values of expressions of one lane at a point to memory from `out` on."""
    return function_source(f"{name}(floats, t, {arguments}, out)", ScalarWriter(graph).stores(values))


def returned_source(head: str, graph: Any, value: Expression) -> str:
    """A function that returns the value of an expression."""
    writer = ScalarWriter(graph)
    result = writer.name(value)
    return function_source(head, [*writer.lines, f"return {result}"])


def indented(lines: Sequence[str], spaces: int = 4) -> list[str]:
    """Lines further to the right."""
    return [" " * spaces + line for line in lines]
