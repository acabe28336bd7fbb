"""Writes enclosures: interval arithmetic on the nodes of a graph, as straight code of one lane or of all at once.

From the least and the largest value of the leaves follow those of every node (Moore 1966). Rounding is not directed: an
enclosure is a matter of factors here, not of last digits.
"""

from collections.abc import Callable

from vibrocap.numerics.codegen.straight_line import POLYNOMIALS
from vibrocap.numerics.expressions.graph import Graph

MOST_EXPONENT = 700.0  # exp of more is as good as infinite here, and no overflow

Interval = tuple[str, str]  # names or literals of the least and the largest value; the same one where they are equal


class Lines:
    """Lines of straight code of `lane`, one or all, each formula once."""

    def __init__(self, polynomials: bool):
        self.polynomials = polynomials
        self.lines: list[str] = []
        self._names: dict[str, str] = {}

    def name(self, formula: str) -> str:
        """The name under which a formula is kept; a number stays one."""
        formula = formula.replace("--", "")
        if _is_number(formula):
            return formula
        if formula not in self._names:
            self._names[formula] = f"e{len(self._names)}"
            self.lines.append(f"{self._names[formula]} = {formula}")
        return self._names[formula]

    def entry(self, place: str) -> str:
        """What stands at a place of the memory."""
        return f"floats[{place} + lane]"

    def excursion(self, row: str) -> str:
        """How far the series in a row goes over a step of length h."""
        return f"excursion(floats, {row} + lane, h)"

    def conditional(self, condition: str, one: str, other: str) -> str:
        """One value where a condition holds, else the other."""
        return f"where({condition}, {one}, {other})"

    def larger(self, a: str, b: str) -> str:
        """The larger of two numbers."""
        if _is_number(a) and _is_number(b):
            return repr(max(float(a), float(b)))
        return self.name(f"max({a}, {b})")

    def smaller(self, a: str, b: str) -> str:
        """The smaller of two numbers."""
        if _is_number(a) and _is_number(b):
            return repr(min(float(a), float(b)))
        return self.name(f"min({a}, {b})")

    def size(self, interval: Interval) -> str:
        """Largest absolute value within an interval."""
        low, high = interval
        if low == high:
            return repr(abs(float(low))) if _is_number(low) else self.name(f"abs({low})")
        return self.larger(high, self.name(f"-{low}"))

    def function(self, op: str, x: str) -> str:
        """Value of an elementary function."""
        if op == "exp":
            x = self.smaller(x, repr(MOST_EXPONENT))
        if op in ("sin", "cos") and self.polynomials:
            return self.name(f"{self.name(f'sine_cosine({x})')}[{0 if op == 'sin' else 1}]")
        return self.name(f"{POLYNOMIALS[op]}({x})" if self.polynomials else f"math.{op}({x})")


def same(value: str) -> Interval:
    """The interval of a single value."""
    return value, value


def _is_number(text: str) -> bool:
    """Whether a text is a literal."""
    try:
        float(text)
    except ValueError:
        return False
    return True


class Enclosures:
    """Enclosures of the nodes of a graph by interval arithmetic, from those of its leaves."""

    def __init__(self, graph: Graph, text: Lines, leaf: Callable[[int], Interval | None], inverses: dict | None = None):
        """inverses: of divisors that are watched elsewhere, what one over them is where their own enclosure fails."""
        self.graph, self.text, self.leaf, self.inverses = graph, text, leaf, inverses or {}
        self._known: dict[int, Interval] = {}

    def of(self, index: int) -> Interval:
        """Least and largest value of a node."""
        if index not in self._known:
            self._known[index] = self._enclosure(index)
        return self._known[index]

    def _enclosure(self, index: int) -> Interval:
        known = self.leaf(index)
        if known is not None:
            return known
        text = self.text
        op, *operands = self.graph.nodes[index]
        if op == "constant":
            return same(repr(operands[0]))
        if op == "side":
            return same(text.name(text.entry(f"SIDE + {operands[0]} * LANES")))
        if op == "parameter":
            return same(text.name(text.entry(f"PARAMETER + {operands[0]} * LANES")))
        if op in ("sin", "cos"):
            return self._wave(op, self.of(operands[0]))
        a = self.of(operands[0])
        if op == "neg":
            return self._pair(a, lambda x: f"-{x}", turned=True)
        if op == "add":
            b = self.of(operands[1])
            return text.name(f"{a[0]} + {b[0]}"), text.name(f"{a[1]} + {b[1]}")
        if op == "sub":
            b = self.of(operands[1])
            return text.name(f"{a[0]} - {b[1]}"), text.name(f"{a[1]} - {b[0]}")
        if op == "mul":
            return self._square(a) if operands[0] == operands[1] else self._product(a, self.of(operands[1]))
        if op == "div":
            return self._product(a, self.inverse(operands[1]))
        if op == "power":
            rate = self._product(self._monotone("log", a), self.of(operands[1]))
            return self._monotone("exp", rate)
        return self._monotone(op, a)

    def inverse(self, index: int) -> Interval:
        """Enclosure of one over a node: everything where the node may vanish."""
        text = self.text
        low, high = self.of(index)
        if low == high:
            return same(text.name(f"1.0 / {low}"))
        passes = text.name(f"({low} <= 0.0) & ({high} >= 0.0)")
        least, most = self.inverses.get(index, ("-1e+300", "1e+300"))
        # Both sides of a choice are computed.
        low, high = (text.name(text.conditional(passes, "1.0", end)) for end in (low, high))
        ends = [text.name(text.conditional(passes, far, f"1.0 / {end}")) for far, end in ((least, high), (most, low))]
        return ends[0], ends[1]

    def _wave(self, op: str, a: Interval) -> Interval:
        """Sine or cosine, whose slope is at most 1: over a short step the determinant of moving bodies stays apart."""
        text, (low, high) = self.text, a
        if low == high:
            return same(text.function(op, low))
        middle = text.name(f"0.5 * ({low} + {high})")
        value, far = text.function(op, middle), text.name(f"{high} - {middle}")
        return text.larger(text.name(f"{value} - {far}"), "-1.0"), text.smaller(text.name(f"{value} + {far}"), "1.0")

    def _pair(self, a: Interval, formula: Callable[[str], str], turned: bool = False) -> Interval:
        ends = tuple(self.text.name(formula(x)) for x in (a[::-1] if turned else a))
        return ends[0], ends[1]

    def _monotone(self, op: str, a: Interval) -> Interval:
        text = self.text
        if op in ("log", "sqrt"):
            least = "1e-300"
            a = text.larger(a[0], least), text.larger(a[1], least)
        if a[0] == a[1]:
            return same(text.function(op, a[0]))
        return text.function(op, a[0]), text.function(op, a[1])

    def _times(self, x: str, y: str) -> str:
        """Product of two numbers."""
        if "1.0" in (x, y):
            return y if x == "1.0" else x
        return self.text.name(f"{x} * {y}")

    def _square(self, a: Interval) -> Interval:
        text, (low, high) = self.text, a
        if low == high:
            return same(self._times(low, low))
        far = text.size(a)
        near = text.larger(text.larger(low, text.name(f"-{high}")), "0.0")
        return self._times(near, near), self._times(far, far)

    def _product(self, a: Interval, b: Interval) -> Interval:
        text = self.text
        products = list(dict.fromkeys(self._times(x, y) for x in dict.fromkeys(a) for y in dict.fromkeys(b)))
        low = high = products[0]
        for other in products[1:]:
            low, high = text.smaller(low, other), text.larger(high, other)
        return low, high
