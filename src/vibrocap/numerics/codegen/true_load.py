"""Writes what the watch of the true load needs, where friction takes it as constant: its series, as a bound."""

from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.codegen.straight_line import Formula, literal
from vibrocap.numerics.expressions.graph import Expression

TAIL = 4.0  # times the last term: with those that follow it, if each is at most three quarters of the one before


class LoadSeries:
    """The series of the true load: where it may go within a step.

    Where the load is a constant and the second derivative of a height h, its coefficient k is (k + 1) (k + 2) h_(k+2),
    which is there. Elsewhere it is written from the load itself.
    """

    def __init__(self, load: Expression, height: tuple[Expression, float] | None, writer: JetWriter, order: int):
        self.load, self.height, self.writer, self.last = load, height, writer, order - 2

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
        return self.writer.coefficient(height.index, k + 2) * literal(sign * factor * (k + 1) * (k + 2))
