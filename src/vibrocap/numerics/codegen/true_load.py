"""Writes what the watch of the true load needs, where friction takes it as constant: its series, as a bound."""

from typing import Any

from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.codegen.straight_line import Formula, literal
from vibrocap.numerics.expressions.graph import Expression

TAIL = 4.0  # times the last term: with those that follow it, if each is at most three quarters of the one before


class LoadSeries:
    """The series of the true load: where it may go within a step.

    The load is a constant and the rate of a momentum q normal to the ground, so that its coefficient k is
    (k + 1) q_(k+1). Of a bob at the height cos(a), q = -sin(a) a', and the coefficient is (k + 1) (k + 2) that of
    cos(a), which is there. Of any other machine it is written from the load itself.
    """

    def __init__(self, equations: Any, writer: JetWriter, order: int):
        self.load, self.rates, self.writer, self.last = equations.true_load, equations.rates, writer, order - 2
        momentum = equations.normal_momentum
        self.height = None if momentum is None else self._height(momentum, -1.0)

    def _height(self, momentum: Expression, sign: float) -> tuple[int, float] | None:
        """(cos(a), sign) of a momentum sign cos(a)', written as a product; None where it is written otherwise."""
        nodes = momentum.graph.nodes
        op, *operands = nodes[momentum.index]
        if op == "neg":
            return self._height(Expression(momentum.graph, operands[0]), -sign)
        for function, rate in (operands, operands[::-1]) if op == "mul" else ():
            name, *inner = nodes[function]
            if name == "sin" and nodes[inner[0]][0] == "state" and self.rates[nodes[inner[0]][1]].index == rate:
                return self.writer.graph.node("cos", inner[0]).index, sign
        return None

    def at_order(self, k: int) -> list[tuple[int, Formula]]:
        """(number, value) of the coefficients that are known with the coefficients k of the states."""
        numbers = {0: [], 1: [], 2: [0]}.get(k, [k - 2])
        return [(number, self._term(number)) for number in numbers]

    def _term(self, k: int) -> Formula:
        """The coefficient k; of the last one a bound of itself and of all that follow."""
        factor = TAIL if k == self.last else 1.0
        if k == 0:
            return self.writer.coefficient(self.load.index, 0)
        if self.height is None:
            return self.writer.coefficient(self.load.index, k) * literal(factor)
        height, sign = self.height
        return self.writer.coefficient(height, k + 2) * literal(sign * factor * (k + 1) * (k + 2))
