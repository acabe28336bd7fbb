"""Truncated Taylor series of one variable, in plain Python: what `independent.py` differentiates with.

The functions of machines, laws and drives are scalar code on `+ - * /` and a few elementary functions, so that they
take a series in the place of a number. Nothing of the package's own series is used.
"""

import math


class Jet:
    """c[0] + c[1] s + ... + c[k] s^k; of two of different lengths the shorter one decides."""

    __slots__ = ("c",)

    def __init__(self, coefficients):
        self.c = [float(value) for value in coefficients]

    def __add__(self, other):
        if not isinstance(other, Jet):
            return Jet([self.c[0] + other, *self.c[1:]])
        return Jet([a + b for a, b in zip(self.c, other.c, strict=False)])

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet([a * other for a in self.c])
        size = min(len(self.c), len(other.c))
        return Jet([sum(self.c[i] * other.c[k - i] for i in range(k + 1)) for k in range(size)])

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return Jet([-a for a in self.c])

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        if not isinstance(other, Jet):
            return Jet([a / other for a in self.c])
        cs: list[float] = []
        for k in range(min(len(self.c), len(other.c))):
            rest = sum(other.c[k - i] * cs[i] for i in range(k))
            cs.append((self.c[k] - rest) / other.c[0])
        return Jet(cs)

    def __rtruediv__(self, other):
        return Jet([other, *([0.0] * (len(self.c) - 1))]) / self

    def __pow__(self, exponent: float):
        if exponent == int(exponent):
            return math.prod([self] * int(exponent), start=1.0)
        c, values = self.c, [max(0.0, self.c[0]) ** exponent]
        for k in range(1, len(c)):  # from rest |v|^alpha begins beyond the first order: nothing of it is told
            terms = ((i * (exponent + 1.0) - k) * c[i] * values[k - i] for i in range(1, k + 1))
            values.append(sum(terms) / (k * c[0]) if c[0] > 0.0 else 0.0)
        return Jet(values)

    def __lt__(self, other):
        return self.c[0] < (other.c[0] if isinstance(other, Jet) else other)

    def __gt__(self, other):
        return self.c[0] > (other.c[0] if isinstance(other, Jet) else other)

    def __floor__(self):
        return math.floor(self.c[0])

    def __abs__(self):
        return self if self.c[0] >= 0.0 else -self

    def _integrated(self, first: float, factor: "Jet") -> "Jet":
        """The series that begins with `first` and whose derivative is `factor` times that of this one."""
        values = [first]
        for k in range(1, len(self.c)):
            values.append(sum((k - i) * self.c[k - i] * factor.c[i] for i in range(k)) / k)
        return Jet(values)

    def exp(self):
        """e to it."""
        values = [math.exp(self.c[0])]
        for k in range(1, len(self.c)):
            values.append(sum(i * self.c[i] * values[k - i] for i in range(1, k + 1)) / k)
        return Jet(values)

    def log(self):
        """Natural logarithm."""
        return self._integrated(math.log(self.c[0]), 1.0 / self)

    def sqrt(self):
        """Square root."""
        values = [math.sqrt(self.c[0])]
        for k in range(1, len(self.c)):
            rest = sum(values[i] * values[k - i] for i in range(1, k))
            values.append((self.c[k] - rest) / (2.0 * values[0]))
        return Jet(values)

    def _turned(self) -> tuple[list[float], list[float]]:
        """(sine, cosine)."""
        sine, cosine = [math.sin(self.c[0])], [math.cos(self.c[0])]
        for k in range(1, len(self.c)):
            both = [sum(i * self.c[i] * other[k - i] for i in range(1, k + 1)) / k for other in (cosine, sine)]
            sine.append(both[0])
            cosine.append(-both[1])
        return sine, cosine

    def sin(self):
        """Sine."""
        return Jet(self._turned()[0])

    def cos(self):
        """Cosine."""
        return Jet(self._turned()[1])

    def tanh(self):
        """Hyperbolic tangent."""
        twice = (2.0 * self).exp()
        return (twice - 1.0) / (twice + 1.0)

    def atan(self):
        """Arc tangent."""
        return self._integrated(math.atan(self.c[0]), 1.0 / (1.0 + self * self))
