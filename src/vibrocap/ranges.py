"""The values of a range of a user: the intended decimals, without rounding errors."""

from fractions import Fraction
from math import lcm

import numpy as np


def values_between(low: float, high: float, count: int, logarithmic: bool = False) -> np.ndarray:
    """Values [count >= 2] from low to high, both included, at equal distances, or ratios where logarithmic.

    Each is the floating-point number next to the exact value, between the decimals as which low and high are written:
    from -0.1 to 0.2 in steps of 0.1 there is 0, where `numpy.linspace` has 1.4e-17, a velocity that is none. A value of
    a logarithmic range is rounded to 15 digits.
    """
    if logarithmic:
        inner = np.geomspace(low, high, count)[1:-1].tolist()
        return np.array([low, *(float(f"{value:.15g}") for value in inner), high])
    first, last = Fraction(repr(float(low))), Fraction(repr(float(high)))
    common = lcm(first.denominator, last.denominator)
    begin, end, steps = int(first * common), int(last * common), count - 1
    return np.array([(begin * (steps - i) + end * i) / (common * steps) for i in range(count)])


def cell_middles(low: float, high: float, count: int) -> np.ndarray:
    """Middles [count] of equal cells from low to high."""
    return values_between(low, high, 2 * count + 1)[1::2]
