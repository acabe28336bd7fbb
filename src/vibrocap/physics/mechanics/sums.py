"""Sums of products in one normal form, so that terms that cancel are gone: sin^2 is written 1 - cos^2.

Without it centripetal terms of opposite signs stay in the equations of motion, which then take up to three times as
long. A sum can swell where products of sums are multiplied; what is common is then better named once, by a division or
a function, which makes it an atom.
"""

import contextlib
import contextvars
from collections.abc import Iterable, Iterator
from typing import Any

from vibrocap.physics import elementary
from vibrocap.physics.mechanics.formulas import FUNCTIONS, Formula, add, div, mul, sub

_left: contextvars.ContextVar = contextvars.ContextVar("products that may still be made", default=None)
Product = tuple[tuple[Formula, int], ...]  # atoms with their powers, in order


class Sum:
    """sum of c a^n b^m ...: numbers c by products of atoms; an atom is a formula that is no sum or product."""

    __slots__ = ("terms",)

    def __init__(self, terms: dict[Product, float] | None = None):
        self.terms = terms or {}

    @classmethod
    def of(cls, x: Any) -> "Sum":
        """A number, a formula or a sum, as a sum."""
        if isinstance(x, Sum):
            return x
        if isinstance(x, Formula):
            return cls({((x, 1),): 1.0})
        return cls({(): float(x)} if x else {})

    @property
    def number(self) -> float | None:
        """The number that it is, if it is one."""
        return None if self.terms.keys() - {()} else self.terms.get((), 0.0)

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, (Sum, Formula, int, float)) and self.terms == Sum.of(other).terms

    __hash__ = None  # type: ignore[assignment]

    def __add__(self, other):
        if not isinstance(other, (Sum, Formula, int, float)):
            return NotImplemented
        terms = dict(self.terms)
        for product, c in Sum.of(other).terms.items():
            terms[product] = terms.get(product, 0.0) + c
            if terms[product] == 0.0:
                del terms[product]
        return Sum(terms)

    def __neg__(self):
        return Sum({product: -c for product, c in self.terms.items()})

    def __sub__(self, other):
        return NotImplemented if not isinstance(other, (Sum, Formula, int, float)) else self + -Sum.of(other)

    def __rsub__(self, other):
        return Sum.of(other) - self

    def __mul__(self, other):
        if not isinstance(other, (Sum, Formula, int, float)):
            return NotImplemented
        terms: dict[Product, float] = {}
        others = Sum.of(other).terms
        if not self.terms or not others:
            return Sum()
        if (left := _left.get()) is not None:
            left[0] -= len(self.terms) * len(others)
            if left[0] < 0:
                raise OverflowError("the equations are too large when expanded: write common terms as a function")
        for a, x in self.terms.items():
            for b, y in others.items():
                product = _times(a, b)
                terms[product] = terms.get(product, 0.0) + x * y
        return _reduced(terms)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other):
        if not isinstance(other, (Sum, Formula, int, float)):
            return NotImplemented
        number = Sum.of(other).number
        return self * (div(1.0, written(other)) if number is None else 1.0 / number)

    def __rtruediv__(self, other):
        return Sum.of(other) / self

    def __pow__(self, exponent: int | float):
        if exponent == 0.5:
            return elementary.sqrt(self)
        if exponent != int(exponent) or exponent < 0:
            raise TypeError(f"should be a whole number >= 0, or 0.5, got the exponent {exponent!r}")
        power = Sum.of(1.0)
        for _ in range(int(exponent)):
            power = power * self
        return power


def _function(name: str) -> Any:
    def of(self: Sum) -> Sum:
        return Sum.of(getattr(elementary, name)(written(self)))

    return of


for _name in FUNCTIONS:
    setattr(Sum, _name, _function(_name))


@contextlib.contextmanager
def bounded(products: int) -> Iterator[None]:
    """Within it OverflowError where more products of terms are made; twenty bodies in a row take a thousand."""
    token = _left.set([products])
    try:
        yield
    finally:
        _left.reset(token)


def named(x: Any) -> Sum:
    """A sum as one atom, which is not multiplied out."""
    return Sum.of(written(x))


def total(items: Iterable[Any]) -> Sum:
    """The sum of all."""
    terms: dict[Product, float] = {}
    for item in items:
        for product, c in Sum.of(item).terms.items():
            terms[product] = terms.get(product, 0.0) + c
    return Sum({product: c for product, c in terms.items() if c != 0.0})


def _times(a: Product, b: Product) -> Product:
    if not a or not b:
        return a or b
    powers = dict(a)
    for atom, n in b:
        powers[atom] = powers.get(atom, 0) + n
    return tuple(sorted(powers.items(), key=lambda item: item[0].index))


def _reduced(terms: dict[Product, float]) -> Sum:
    """With 1 - cos^2 in place of every sin^2."""
    merged: dict[Product, float] = {}
    again = False
    for product, c in terms.items():
        square = next((atom for atom, n in product if n >= 2 and atom.op == "sin"), None)
        if square is None:
            merged[product] = merged.get(product, 0.0) + c
            continue
        again, powers = True, dict(product)
        powers[square] -= 2
        rest = tuple((atom, n) for atom, n in powers.items() if n)
        cosine = square.tape.formula("cos", *square.operands)
        for more, sign in (((), 1.0), (((cosine, 2),), -1.0)):
            product = _times(rest, more)
            merged[product] = merged.get(product, 0.0) + sign * c
    merged = {product: c for product, c in merged.items() if c != 0.0}
    return _reduced(merged) if again else Sum(merged)


def _divided(terms: dict[Product, float], atom: Formula) -> tuple[dict[Product, float], dict[Product, float]]:
    """(the terms that contain an atom, over it; those that do not)."""
    inside: dict[Product, float] = {}
    rest: dict[Product, float] = {}
    for product, c in terms.items():
        powers = dict(product)
        if atom in powers:
            powers[atom] -= 1
            inside[tuple((atom, n) for atom, n in powers.items() if n)] = c
        else:
            rest[product] = c
    return inside, rest


def written(x: Any) -> Any:
    """A number or a formula: a number that all terms share is factored out, then the atom that most products share,
    with those whose products with the rest are proportional, again and again."""
    whole = Sum.of(x)
    terms = whole.terms
    if whole.number is not None:
        return whole.number
    sizes = {abs(c) for c in terms.values()}
    if len(terms) > 1 and len(sizes) == 1 and (max(terms.values()) < 0.0 or sizes != {1.0}):
        size = max(terms.values(), key=lambda c: (abs(c), c))
        return mul(size, written(Sum({product: c / size for product, c in terms.items()})))
    shared: dict[Formula, int] = {}
    for product in terms:
        for atom, _ in product:
            shared[atom] = shared.get(atom, 0) + 1
    if len(terms) > 1 and (most := max(shared.values())) > 1:
        first = max((atom for atom in shared if shared[atom] == most), key=lambda atom: atom.index)
        inside, rest = _divided(terms, first)
        factors = {((first, 1),): 1.0}
        for other in shared:
            own, left = _divided(rest, other)
            if own.keys() == inside.keys() and len({own[product] / inside[product] for product in inside}) == 1:
                factors[((other, 1),)] = own[next(iter(inside))] / next(iter(inside.values()))
                rest = left
        return add(written(Sum(rest)), mul(written(Sum(inside)), written(Sum(factors))))
    expression: Any = None
    for product, c in sorted(terms.items(), key=lambda item: (item[1] < 0, [(a.index, n) for a, n in item[0]])):
        factor: Any = None
        for atom, n in product:
            for _ in range(n):
                factor = atom if factor is None else mul(factor, atom)
        size = abs(c) if factor is None else mul(abs(c), factor)
        if expression is None:
            expression = -size if c < 0 else size
        else:
            expression = expression - size if c < 0 else add(expression, size)
    return expression


# --- linear equations ------------------------------------------------------------------------------------------------


def eliminate(rows: list[list], pivots: int) -> None:
    """The first so many unknowns of rows [M | b], taken out of the rows below. Over numbers what is left is one sum."""
    for p in range(pivots):
        pivot = Sum.of(rows[p][p])
        for below in rows[p + 1 :]:
            if not below[p]:
                continue
            if pivot.number is not None:
                factor = below[p] * (1.0 / pivot.number)
                below[p + 1 :] = [a - factor * b for a, b in zip(below[p + 1 :], rows[p][p + 1 :], strict=True)]
                continue
            quotient = div(written(below[p]), written(pivot))
            below[p + 1 :] = [
                Sum.of(sub(written(a), mul(quotient, written(b))))
                for a, b in zip(below[p + 1 :], rows[p][p + 1 :], strict=True)
            ]


def back_substituted(rows: list[list], n: int, eliminated: int) -> list[list]:
    """Solutions, written, of rows [M | b_1, b_2, ...] whose first pivots are eliminated; the others are, here."""
    last = [list(row[eliminated:]) for row in rows[eliminated:]]
    eliminate(last, n - eliminated)
    rows = [*rows[:eliminated], *([None] * eliminated + row for row in last)]
    lists: list[list] = [[]] * n
    for i in reversed(range(n)):
        right = [written(row) for row in rows[i][n:]]
        for j in range(i + 1, n):
            right = [sub(r, mul(written(rows[i][j]), x)) for r, x in zip(right, lists[j], strict=True)]
        lists[i] = [div(r, written(rows[i][i])) for r in right]
    return lists


def solved(rows: list[list], n: int) -> list[list]:
    """Rows [M | b_1, b_2, ...] of n unknowns: their solutions, written."""
    return back_substituted(rows, n, 0)
