"""Turning points of polynomials on an interval: where a state, or friction, is largest or least within a step.

A series is given as in `roots.bracketed_root`. A step is looked at in a few cells, each for one change of slope.
"""

from vibrocap.numerics.kernel.arithmetic.roots import bracketed_root, value_and_rate

CELLS = 8


def may_turn(floats, series, h):
    """Whether the slope may change its sign on (0, h): not if its first coefficient outweighs all others."""
    row, stride, degree = series
    others = 0.0
    for k in range(degree, 1, -1):
        others = others * h + k * abs(floats[row + k * stride])
    return abs(floats[row + stride]) <= others * h


def turn_in_cell(floats, series, cell, h):
    """Where the slope changes its sign within a cell of a step of length h; -1.0 where it does not."""
    return sign_change(floats, series, True, cell * h / CELLS, (cell + 1.0) * h / CELLS)


def sign_change(floats, series, of_slope, low, high):
    """Where a polynomial, or its slope, monotone between two points, changes its sign; -1.0 where it does not."""
    row, stride, degree = series
    before, _ = value_and_rate(floats, row, stride, degree, low, of_slope)
    after, _ = value_and_rate(floats, row, stride, degree, high, of_slope)
    if of_slope and after == 0.0:
        return high
    return bracketed_root(floats, series, of_slope, before, low, high) if before * after < 0.0 else -1.0
