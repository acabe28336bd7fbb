"""A quantity along a motion, with the derivatives that mechanics takes of it.

Of a function v of coordinates q, which move at generalised speeds u, and of time:

    value v,   slopes v_i = dv/du_i of its rate,   rate w = v',   curvature c: what is left of v'' where all u_i' = 0

    product   v = a b     v_i = a b_i + b a_i     w = a w_b + b w_a     c = a c_b + b c_a + 2 w_a w_b
    f(a)      v = f       v_i = f' a_i            w = f' w_a            c = f'' w_a^2 + f' c_a

so that v'' = sum of v_i u_i' + c. Directions besides the speeds are "time", which runs at the rate 1, and virtual ones
that stay 0: those that lift a body off the ground or stretch what a drive imposes, for the force along them.
"""

from collections.abc import Hashable, Mapping
from typing import Any

from vibrocap.physics import elementary
from vibrocap.physics.mechanics.formulas import Formula
from vibrocap.physics.mechanics.sums import Sum

Direction = Hashable
SCALARS = (Sum, Formula, int, float)


class Quantity:
    """A quantity along a motion; slopes that are zero are left out."""

    __slots__ = ("curvature", "rate", "slopes", "value")

    def __init__(
        self, value: Any, slopes: Mapping[Direction, Sum] | None = None, rate: Any = 0.0, curvature: Any = 0.0
    ):
        self.value, self.rate, self.curvature = Sum.of(value), Sum.of(rate), Sum.of(curvature)
        self.slopes = {} if slopes is None else {along: slope for along, slope in slopes.items() if slope}

    @classmethod
    def of(cls, x: Any) -> "Quantity":
        """A number, a parameter or a quantity, as a quantity."""
        return x if isinstance(x, Quantity) else cls(x)

    def slope(self, along: Direction) -> Sum:
        return self.slopes.get(along, NOTHING)

    @property
    def moves(self) -> bool:
        """Whether it changes with a coordinate or in time."""
        return bool(self.slopes)

    def __add__(self, other):
        if not isinstance(other, (Quantity, *SCALARS)):
            return NotImplemented
        o = Quantity.of(other)
        slopes = {along: self.slope(along) + o.slope(along) for along in {**self.slopes, **o.slopes}}
        return Quantity(self.value + o.value, slopes, self.rate + o.rate, self.curvature + o.curvature)

    def __neg__(self):
        return self * -1.0

    def __sub__(self, other):
        return NotImplemented if not isinstance(other, (Quantity, *SCALARS)) else self + -Quantity.of(other)

    def __rsub__(self, other):
        return Quantity.of(other) - self

    def __mul__(self, other):
        if not isinstance(other, (Quantity, *SCALARS)):
            return NotImplemented
        o = Quantity.of(other)
        a, b = self.value, o.value
        slopes = {along: a * o.slope(along) + b * self.slope(along) for along in {**self.slopes, **o.slopes}}
        bend = a * o.curvature + b * self.curvature + 2.0 * (self.rate * o.rate)
        return Quantity(a * b, slopes, a * o.rate + b * self.rate, bend)

    __radd__, __rmul__ = __add__, __mul__

    def _of(self, f: Any, slope: Any, bend: Any) -> "Quantity":
        """A function of it, with its value and its first two derivatives."""
        slopes = {along: slope * own for along, own in self.slopes.items()}
        return Quantity(f, slopes, slope * self.rate, bend * (self.rate * self.rate) + slope * self.curvature)

    def __rtruediv__(self, other):
        i = 1.0 / self.value
        return Quantity.of(other) * self._of(i, -(i * i), 2.0 * (i * i * i))

    def __truediv__(self, other):
        if isinstance(other, Quantity):
            return self * (1.0 / other)
        return self * (1.0 / Sum.of(other))

    def __pow__(self, exponent: int | float):
        if exponent == 0.5:
            return self.sqrt()
        if exponent != int(exponent) or exponent < 1:
            raise TypeError(f"should be a whole number >= 1, or 0.5, got the exponent {exponent!r}")
        return self if exponent == 1 else self * self ** (int(exponent) - 1)

    def __float__(self):
        raise TypeError(
            "a function of numbers is given a coordinate; take sin, cos, sqrt, exp, tanh and atan from "
            "vibrocap.mechanics, not from math"
        )

    def sin(self):
        return self._of(elementary.sin(self.value), elementary.cos(self.value), -elementary.sin(self.value))

    def cos(self):
        return self._of(elementary.cos(self.value), -elementary.sin(self.value), -elementary.cos(self.value))

    def exp(self):
        e = elementary.exp(self.value)
        return self._of(e, e, e)

    def log(self):
        i = 1.0 / self.value
        return self._of(elementary.log(self.value), i, -(i * i))

    def sqrt(self):
        r = elementary.sqrt(self.value)
        i = 1.0 / r
        return self._of(r, 0.5 * i, -0.25 * (i * i * i))

    def tanh(self):
        h = elementary.tanh(self.value)
        slope = 1.0 - h * h
        return self._of(h, slope, -2.0 * (h * slope))

    def atan(self):
        d = 1.0 / (1.0 + self.value * self.value)
        return self._of(elementary.atan(self.value), d, -2.0 * (self.value * (d * d)))


NOTHING = Sum()
