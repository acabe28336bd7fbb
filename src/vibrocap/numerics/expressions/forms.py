"""What is known of recorded expressions as functions of time, before any number is: degrees and constant factors."""

from collections.abc import Sequence

from vibrocap.numerics.expressions.graph import Expression, Graph

FREE = 10**9  # degree of a node that is no polynomial in time


class Forms:
    """Degrees and factors of the nodes of one graph, along motions with these rates."""

    def __init__(self, graph: Graph, rates: Sequence[Expression]):
        self.graph = graph
        self.rates = rates
        self._degrees: dict[int, int] = {}
        self._multiples: dict[int, tuple[Expression, int]] = {}
        self._linear: dict[int, tuple[Expression, int]] = {}

    def degree(self, index: int) -> int:
        """Degree in time of a node if it is a polynomial for every motion, else FREE. Higher coefficients vanish."""
        if index not in self._degrees:
            op, *operands = self.graph.nodes[index]
            if op == "time":
                degree = 1
            elif self.graph.is_constant_in_time(index) or self._is_switched(op, operands):
                degree = 0
            elif op in ("add", "sub", "neg"):
                degree = max(self.degree(i) for i in operands)
            elif op == "mul":
                degree = min(FREE, self.degree(operands[0]) + self.degree(operands[1]))
            elif op == "div" and self.degree(operands[1]) == 0:
                degree = self.degree(operands[0])
            else:
                degree = FREE
            self._degrees[index] = degree
        return self._degrees[index]

    def _is_switched(self, op: str, operands: list) -> bool:
        """Whether a node is a state that changes at events only."""
        return op == "state" and self.rates[operands[0]].value == 0.0

    def multiple(self, index: int) -> tuple[Expression, int]:
        """(factor, base): the node is factor * base with a constant factor, drawn out of products too."""
        if index not in self._multiples:
            self._multiples[index] = self._multiple(index)
        return self._multiples[index]

    def _multiple(self, index: int) -> tuple[Expression, int]:
        op, *operands = self.graph.nodes[index]
        one = self.graph.constant(1.0)
        if self.degree(index) == 0 or op not in ("neg", "mul", "div"):
            return one, index
        if op == "neg":
            factor, base = self.multiple(operands[0])
            return -factor, base
        a, b = operands
        if op == "div":
            if self.degree(b) > 0:
                return one, index
            factor, base = self.multiple(a)
            return factor / Expression(self.graph, b), base
        if self.degree(a) == 0 or self.degree(b) == 0:
            constant, varying = (a, b) if self.degree(a) == 0 else (b, a)
            factor, base = self.multiple(varying)
            return Expression(self.graph, constant) * factor, base
        (left, x), (right, y) = self.multiple(a), self.multiple(b)
        if (x, y) == (a, b):
            return one, index
        return left * right, (Expression(self.graph, x) * Expression(self.graph, y)).index

    def linear(self, index: int) -> tuple[Expression, int]:
        """(factor, base): but for constants the node is factor * base; its coefficients k >= 1 are factor * base_k."""
        if index not in self._linear:
            self._linear[index] = self._linear_form(index)
        return self._linear[index]

    def _linear_form(self, index: int) -> tuple[Expression, int]:
        op, *operands = self.graph.nodes[index]
        varying = [i for i in operands if self.degree(i) > 0] if op in ("add", "sub", "mul", "neg", "div") else []
        if len(varying) != 1 or (op == "div" and varying[0] == operands[1]):
            return self.multiple(index)
        factor, base = self.linear(varying[0])
        if op == "neg" or (op == "sub" and operands[1] == varying[0]):
            factor = -factor
        if op == "mul":
            other = operands[0] if operands[1] == varying[0] else operands[1]
            factor = Expression(self.graph, other) * factor
        if op == "div":
            factor = factor / Expression(self.graph, operands[1])
        return factor, base
