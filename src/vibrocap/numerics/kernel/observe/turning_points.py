"""Turning points of polynomials on an interval: where a state, or friction, is largest or least within a step.

A polynomial is given by the place of its first coefficient, the distance from one to the next, and its degree.
"""

CELLS = 8  # parts of a step that are looked at one by one for a change of slope
CLOSE = 1e-9  # of a cell: an extreme is missed by the square of that


def polynomial_value(floats, row, stride, degree, s):
    """Value at s."""
    result = floats[row + degree * stride]
    for k in range(degree - 1, -1, -1):
        result = result * s + floats[row + k * stride]
    return result


def polynomial_slope(floats, row, stride, degree, s):
    """Slope at s."""
    result = degree * floats[row + degree * stride]
    for k in range(degree - 1, 0, -1):
        result = result * s + k * floats[row + k * stride]
    return result


def polynomial_bend(floats, row, stride, degree, s):
    """Second derivative at s."""
    result = degree * (degree - 1) * floats[row + degree * stride]
    for k in range(degree - 1, 1, -1):
        result = result * s + k * (k - 1) * floats[row + k * stride]
    return result


def may_turn(floats, row, stride, degree, h):
    """Whether the slope may change its sign on (0, h): not if its first coefficient outweighs all others."""
    others = 0.0
    for k in range(degree, 1, -1):
        others = others * h + k * abs(floats[row + k * stride])
    return abs(floats[row + stride]) <= others * h


def turning_point(floats, row, stride, degree, low, high):
    """Where the slope changes its sign between two points; -1.0 where it does not.

    Newton's method from the secant, by halving where it leaves the bracket.
    """
    before = polynomial_slope(floats, row, stride, degree, low)
    after = polynomial_slope(floats, row, stride, degree, high)
    if after == 0.0:
        return high
    if not (before * after < 0.0):
        return -1.0
    close = CLOSE * (high - low)
    s = low + (high - low) * (before / (before - after))
    for _ in range(60):
        slope = polynomial_slope(floats, row, stride, degree, s)
        if slope * before > 0.0:
            low = s
        else:
            high = s
        bend = polynomial_bend(floats, row, stride, degree, s)
        following = s - slope / bend if bend != 0.0 else low
        if not (low <= following <= high):
            following = 0.5 * (low + high)
        if abs(following - s) <= close:
            return following
        s = following
    return s


def sign_change(floats, row, stride, degree, low, high):
    """Where a polynomial that is monotone between two points changes its sign; -1.0 where it does not."""
    before = polynomial_value(floats, row, stride, degree, low)
    after = polynomial_value(floats, row, stride, degree, high)
    if not (before * after < 0.0):
        return -1.0
    close = CLOSE * (high - low)
    s = low + (high - low) * (before / (before - after))
    for _ in range(60):
        value = polynomial_value(floats, row, stride, degree, s)
        if value * before > 0.0:
            low = s
        else:
            high = s
        slope = polynomial_slope(floats, row, stride, degree, s)
        following = s - value / slope if slope != 0.0 else low
        if not (low <= following <= high):
            following = 0.5 * (low + high)
        if abs(following - s) <= close:
            return following
        s = following
    return s
