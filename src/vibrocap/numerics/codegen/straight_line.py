"""Straight-line code: formulas that know when their value is there, the lines that give them names, and scalar code.

Sums are computed in the order in which they are written. Half of a step passes in chains of operations that wait for
one another, and a term that is added too early makes all later ones wait for it. So every sum is written with its
latest term last. The values of recorded expressions in one lane, and functions of them, are written as they stand
(`ScalarWriter`).
"""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vibrocap.numerics.compiler.subset import LIBRARY
from vibrocap.numerics.expressions.graph import LEAST_BASE, Expression

SUM, PRODUCT, ATOM = range(3)  # the outermost operation of a formula; an atom needs no brackets anywhere
ADDING, MULTIPLYING, DIVIDING, CALLING = 4, 4, 14, 40  # cycles, about those of an x86-64 processor
POLYNOMIALS = {**LIBRARY, "sqrt": "square_root"}  # of `elementary_polynomials.py`


@dataclasses.dataclass(slots=True, eq=False)
class Formula:
    """A value of straight-line code, with the operators of a number.

    known: cycles after which it is there, if nothing but its operands delays it
    factors: of a product, when both factors are known; a product in a sum is free, the left one of two
    number: of a literal
    """

    text: str
    known: int = 0
    level: int = ATOM
    factors: int | None = None
    number: float | None = None

    def __add__(self, other: "Formula") -> "Formula":
        if other is ZERO or self is ZERO:
            return self if other is ZERO else other
        if self.number is not None and other.number is not None:
            return literal(self.number + other.number)
        return self._sum("+", other)

    def __sub__(self, other: "Formula") -> "Formula":
        if other is ZERO or self is ZERO:
            return self if other is ZERO else -other
        if self.number is not None and other.number is not None:
            return literal(self.number - other.number)
        return self._sum("-", other)

    def __mul__(self, other: "Formula") -> "Formula":
        if self is ZERO or other is ZERO:
            return ZERO
        if self.number is not None and other.number is not None:
            return literal(self.number * other.number)
        both = max(self.known, other.known)
        return Formula(self._joined("*", other, PRODUCT), both + MULTIPLYING, PRODUCT, both)

    def __truediv__(self, other: "Formula") -> "Formula":
        if self is ZERO:
            return ZERO
        return Formula(self._joined("/", other, PRODUCT), max(self.known, other.known) + DIVIDING, PRODUCT)

    def __neg__(self) -> "Formula":
        if self is ZERO:
            return ZERO
        if self.number is not None:
            return literal(-self.number)
        if self.level == SUM:
            return Formula(f"-({self.text})", self.known)
        text = self.text[1:] if self.text[0] == "-" else f"-{self.text}"
        return Formula(text, self.known, self.level, self.factors)

    def _sum(self, sign: str, other: "Formula") -> "Formula":
        if self.factors is not None:
            operands = self.factors, other.known
        else:
            operands = self.known, other.known if other.factors is None else other.factors
        return Formula(self._joined(sign, other, SUM), max(operands) + ADDING, SUM)

    def _joined(self, operator: str, other: "Formula", level: int) -> str:
        left = self.text if self.level >= level else f"({self.text})"
        return f"{left} {operator} {other.text if other.level > level else f'({other.text})'}"

    @property
    def is_name(self) -> bool:
        """Whether it is a name, neither a number nor a formula."""
        return self.text.isidentifier()


def literal(number: float) -> Formula:
    """A number."""
    return Formula(repr(number), number=number)


ZERO = Formula("0.0", number=0.0)  # what vanishes for every value of the operands: it leaves no trace in a formula
ONE = literal(1.0)
Term = tuple[int, Formula]  # of a sum: sign and size


def total(terms: Iterable[Term]) -> Formula:
    """The sum of terms, the latest last; ZERO of none."""
    ordered = sorted((term for term in terms if term[1] is not ZERO), key=lambda term: term[1].known)
    first = next((i for i, (sign, _) in enumerate(ordered) if sign > 0), None)
    if first is None:
        return -total((1, size) for _, size in ordered) if ordered else ZERO
    ordered.insert(0, ordered.pop(first))
    if len(ordered) > 1 and ordered[1][0] > 0 and all(size.factors is not None for _, size in ordered[:2]):
        ordered[:2] = ordered[1::-1]  # of two products that are added the left one is free
    whole = ordered[0][1]
    for sign, size in ordered[1:]:
        whole = whole + size if sign > 0 else whole - size
    return whole


def combined(op: str, operands: Iterable[Iterable[Term]]) -> list[Term]:
    """The terms of a sum, a difference or a negative ("add", "sub", "neg") of operands that are given as terms."""
    signs = (-1,) if op == "neg" else (1, -1 if op == "sub" else 1)
    return [(sign * own, size) for sign, terms in zip(signs, operands, strict=True) for own, size in terms]


class Code:
    """Lines of straight-line code of `lane`, one or all: each name stands for a number, or for one of each.

    reading: cycles until an entry of the memory is there
    polynomials: with the elementary functions of `elementary_polynomials.py`, not of the library
    lanes: name of the choice of those lanes of which values are written, if not of all
    """

    def __init__(self, reading: int = 0, polynomials: bool = False, lanes: str = ""):
        self.reading, self.polynomials, self.lanes = reading, polynomials, lanes
        self.lines: list[str] = []
        self._kept: dict[str, Formula] = {}

    @property
    def operations(self) -> int:
        """Of all lines, and the values that they name."""
        operators = " + ", " - ", " * ", " / "
        return len(self.lines) + sum(line.count(operator) for line in self.lines for operator in operators)

    def name(self, name: str, formula: Formula) -> Formula:
        """What a formula is kept under; its line is written if the name is new. What vanishes needs no name."""
        if formula is ZERO:
            return ZERO
        if name not in self._kept:
            self._kept[name] = Formula(name, formula.known)
            self.lines.append(f"{name} = {formula.text}")
        return self._kept[name]

    def entry(self, place: str) -> Formula:
        """What stands at a place of the memory."""
        return Formula(f"floats[{place} + lane]", self.reading)

    def larger(self, name: str, one: Formula, other: Formula) -> Formula:
        """The larger of two values that have names, under a name."""
        return self.name(name, Formula(f"max({one.text}, {other.text})", max(one.known, other.known)))

    def store(self, place: str, value: Formula) -> None:
        """Write a value to memory."""
        entry = f"floats[{place} + lane]"
        written = f"where({self.lanes}, {value.text}, {entry})" if self.lanes else value.text
        self.lines.append(f"{entry} = {written}")

    def function(self, op: str, x: Formula) -> Formula:
        """Value of an elementary function."""
        if not self.polynomials:
            return Formula(f"math.{op}({x.text})", x.known + CALLING)
        if op not in ("sin", "cos"):
            return Formula(f"{POLYNOMIALS[op]}({x.text})", x.known + CALLING)
        pair = self.name(f"pair_{x.text}", Formula(f"sine_cosine({x.text})", x.known + CALLING))
        return Formula(f"{pair.text}[{0 if op == 'sin' else 1}]", pair.known)


OPERATORS = {"add": "{} + {}", "sub": "{} - {}", "mul": "{} * {}", "div": "{} / {}", "neg": "-{}"}
OPERATORS["power"] = f"math.exp({{1}} * math.log(max(abs({{0}}), {LEAST_BASE!r})))"
LEAVES = {  # what a kernel of motions calls them
    "time": "t",
    "side": "floats[SIDE + {} * LANES + lane]",
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
                text = repr(operands[0])
            elif op in ("time", "side", "delay"):
                text = self.leaves[op].format(*operands)
            else:
                formula = self._formula(op, operands)
                # Numbered as they are written: the text must not depend on what else was recorded in the graph.
                text = f"n{len(self.lines)}"
                self.lines.append(f"{text} = {formula}")
            self._names[index] = text
        return self._names[index]

    def _formula(self, op: str, operands: list) -> str:
        if op in self.leaves:
            return self.leaves[op].format(*operands)
        return OPERATORS.get(op, f"math.{op}({{}})").format(*(self._name(i) for i in operands))


def function_source(head: str, lines: Sequence[str]) -> str:
    """A function from its head and the lines of its body, if there are any."""
    return "\n".join([f"def {head}:", *indented(lines or ['"""There is none."""']), ""])


def branch_source(head: str, number: str, bodies: Sequence[Sequence[str]]) -> str:
    """A function whose body is one of several, by the value of one of its arguments."""
    lines = [line for i, body in enumerate(bodies) for line in (f"if {number} == {i}:", *indented(body))]
    return function_source(head, lines)


def stored_source(name: str, graph: Any, values: Sequence[Expression], arguments: str = "point, lane") -> str:
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
