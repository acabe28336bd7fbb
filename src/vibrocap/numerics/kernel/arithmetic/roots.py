"""First root of a polynomial, isolated rigorously and polished to rounding level.

A guard is a polynomial that is positive at the start of a step. Its coefficients in the Bernstein basis of an interval
change sign at least as often as it has roots there, and an even number of times more often (Descartes' rule): none
means no root, one means one root. Halving the interval until one of the two holds finds the first root or proves that
there is none. A double root is settled at the minimum between.

A polynomial is given by the place of its first coefficient, the distance from one to the next (1 where it is not said),
and its degree.

Of a step, which is looked at in a few cells, each for one change of slope, where a polynomial turns.
"""

import math

import numpy as np

from vibrocap.numerics.kernel.generated import *

EPSILON = 2.220446049250313e-16
SLIGHT = 64.0 * EPSILON  # of the terms of a velocity or of a force; of a guard, whose natural size is one
HUGE = 1e300  # beyond all that is a number
NARROWEST = 2.0**-36  # of a step: roots closer than this count as a touch
INVERSE_BINOMIALS = np.array([[1.0 / max(math.comb(n, i), 1) for i in range(ORDER + 1)] for n in range(ORDER + 1)])


def polynomial_slope(floats, row, stride, degree, s):
    """Slope at s."""
    result = degree * floats[row + degree * stride]
    for k in range(degree - 1, 0, -1):
        result = result * s + k * floats[row + k * stride]
    return result


def value_and_rate(floats, row, stride, degree, s, of_slope):
    """(value, slope) at s; of_slope: (slope, second derivative)."""
    value, rate = 0.0, 0.0
    if of_slope:
        for k in range(degree, 0, -1):
            rate = rate * s + value
            value = value * s + k * floats[row + k * stride]
    else:
        for k in range(degree, -1, -1):
            rate = rate * s + value
            value = value * s + floats[row + k * stride]
    return value, rate


def bracketed_root(floats, series, of_slope, sign, low, high):
    """Where a polynomial passes zero, to rounding: Newton's method from the middle, kept in the bracket by halving.

    series: place of its first coefficient, distance to the next, degree; of_slope: where its slope passes zero
    sign: positive where it is positive at low, negative where it is negative
    """
    row, stride, degree = series
    s = 0.5 * (low + high)
    for _ in range(80):
        value, rate = value_and_rate(floats, row, stride, degree, s, of_slope)
        if sign * value > 0.0:
            low = s
        else:
            high = s
        following = s - value / rate if rate != 0.0 else low
        if abs(following - s) <= 2.0 * EPSILON * s:
            return min(max(following, low), high)
        if not (low < following < high):
            following = 0.5 * (low + high)
            if following in (low, high):
                return high
        s = following
    return s


def sign_changes(b, start, degree):
    """Changes from positive to not positive along b[start:start + degree + 1]."""
    changes = 0
    positive = b[start] > 0.0
    for i in range(1, degree + 1):
        now = b[start + i] > 0.0
        if now != positive:
            changes += 1
            positive = now
    return changes


def turns(b, start, degree):
    """Changes between falling and not falling along b[start:start + degree + 1]."""
    changes = 0
    falling = b[start + 1] < b[start]
    for i in range(1, degree):
        now = b[start + i + 1] < b[start + i]
        if now != falling:
            changes += 1
            falling = now
    return changes


def halve(b, start, degree, right):
    """Bernstein coefficients of the left half in place, those of the right half from `right` on (de Casteljau)."""
    for level in range(degree + 1):
        b[right + degree - level] = b[start + degree]
        for i in range(degree, level, -1):
            b[start + i] = 0.5 * (b[start + i - 1] + b[start + i])


def later_terms(floats, row, degree, start, h):
    """Sum over k >= start of |c_k| h^(k - start + 2), even and odd powers apart: half as many dependent operations."""
    square = h * h
    one = 0.0
    other = 0.0
    for i in range(degree, start, -2):
        one = one * square + abs(floats[row + i * LANES])
        other = other * square + abs(floats[row + (i - 1) * LANES])
    total = other + h * one
    if (degree - start) % 2 == 0:
        total = total * h + abs(floats[row + start * LANES])
    return total * square


def vanishing_order(floats, row, h, least):
    """How many leading coefficients, up to ORDER, change the polynomial by no more than `least` over the step h."""
    vanishing = 0
    power = 1.0
    for k in range(ORDER):
        if vanishing == k and abs(floats[row + k * LANES]) * power <= least:
            vanishing = k + 1
        power *= h
    return vanishing


def first_root(floats, row, degree, sign, vanishing, h):
    """First time in (0, h] at which sign * polynomial falls to zero; with so many leading coefficients taken as zero.

    floats[row + k * LANES]: coefficient of s^k.
    Returns (root, touch): the root, or -1 where there is none, and the first place where the polynomial touches zero to
    rounding level without falling below, or -1.
    """
    n = degree - vanishing
    first = sign * floats[row + vanishing * LANES]
    line = first + sign * floats[row + (vanishing + 1) * LANES] * h
    if min(first, line) > later_terms(floats, row, degree, vanishing + 2, h):  # a line outweighs all others: no root
        return -1.0, -1.0
    a = WORK  # coefficients over the unit interval
    total = 0.0
    power = 1.0
    for i in range(n + 1):
        term = sign * floats[row + (vanishing + i) * LANES] * power
        floats[a + i] = term
        total += abs(term)
        power *= h
    noise = 8.0 * EPSILON * total
    stride = n + 2  # Bernstein coefficients and the width of their interval
    now = a + n + 1
    for i in range(n + 1):
        floats[now + i] = floats[a + i] * INVERSE_BINOMIALS[n, i]
    for level in range(1, n + 1):
        for i in range(n, level - 1, -1):
            floats[now + i] += floats[now + i - 1]
    low, width, waiting, touch = 0.0, 1.0, 0, -1.0
    while True:
        changes = sign_changes(floats, now, n)
        if changes == 1 and floats[now] > 0.0:
            return h * bracketed_root(floats, (a, 1, n), False, 1.0, low, low + width), touch
        if changes >= 2 and (turns(floats, now, n) == 1 or width < NARROWEST):
            place = bracketed_root(floats, (a, 1, n), True, -1.0, low, low + width)
            least = value_and_rate(floats, a, 1, n, place, False)[0]
            if least < -noise:
                return h * bracketed_root(floats, (a, 1, n), False, 1.0, low, place), touch
            if least <= noise and touch < 0.0:
                touch = h * place
            changes = 0
        if changes == 0 or floats[now] <= 0.0:
            if waiting == 0:
                return -1.0, touch
            low += width
            following = now + waiting * stride
            for i in range(n + 1):
                floats[now + i] = floats[following + i]
            width = floats[following + n + 1]
            waiting -= 1
        else:
            waiting += 1
            width *= 0.5
            following = now + waiting * stride
            halve(floats, now, n, following)
            floats[following + n + 1] = width


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
