"""Turning points of polynomials on an interval: where a state, or friction, is largest or least within a step.

A polynomial is given as in `roots.py`.
"""

from vibrocap.numerics.kernel.arithmetic.roots import bracketed_root, value_and_rate

CELLS = 8  # parts of a step that are looked at one by one for a change of slope
CLOSE = 1e-9  # of a cell: an extreme is missed by the square of that


def may_turn(floats, row, stride, degree, h):
    """Whether the slope may change its sign on (0, h): not if its first coefficient outweighs all others."""
    others = 0.0
    for k in range(degree, 1, -1):
        others = others * h + k * abs(floats[row + k * stride])
    return abs(floats[row + stride]) <= others * h


def turning_point(floats, row, stride, degree, low, high):
    """Where the slope changes its sign between two points; -1.0 where it does not."""
    return sign_change(floats, row, stride, degree, low, high, True)


def sign_change(floats, row, stride, degree, low, high, of_slope):
    """Where a polynomial, or its slope, monotone between two points, changes its sign; -1.0 where it does not."""
    before, _ = value_and_rate(floats, row, stride, degree, low, of_slope)
    after, _ = value_and_rate(floats, row, stride, degree, high, of_slope)
    if of_slope and after == 0.0:
        return high
    if not (before * after < 0.0):
        return -1.0
    secant = low + (high - low) * (before / (before - after))
    return bracketed_root(floats, row, stride, degree, of_slope, 0.0, before, low, high, secant, CLOSE * (high - low))
