"""What is gathered from the pieces of a motion: integrals, peaks and extremes, all of the motion as computed.

Functions of the instant (powers, friction, functions of one's own) are known at six points of a piece, both ends among
them. The Lobatto sum over these is exact for polynomials of degree 9. A series of order p is followed over a share
tolerance^(1/p) of its radius of convergence; the integrands share its singularities, so that the sum is off by about
(share/4)^10 = 1e-6 tolerance^(10/p), and a polynomial through the six points by (share/4)^6: enough to locate a turning
point, at which the function itself is then asked.
"""

import math

import numpy as np

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import (
    CELLS,
    may_turn,
    polynomial_slope,
    sign_change,
    turn_in_cell,
    value_and_rate,
)
from vibrocap.numerics.kernel.codes import ASK_INTEGRALS, ASK_MAGNITUDE, ASK_PEAK, FUNCTIONS_PER_CONTACT
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import shared
from vibrocap.numerics.kernel.step.taylor import series_state, series_value

# Lobatto points and weights on [0, 1] (Abramowitz and Stegun, table 25.6, n = 6).
POINTS = 6
INNER, OUTER = math.sqrt((7.0 - 2.0 * math.sqrt(7.0)) / 21.0), math.sqrt((7.0 + 2.0 * math.sqrt(7.0)) / 21.0)
SHARES = 0.5 + 0.5 * np.array([-1.0, -OUTER, -INNER, INNER, OUTER, 1.0])
HEAVY, LIGHT = (14.0 + math.sqrt(7.0)) / 60.0, (14.0 - math.sqrt(7.0)) / 60.0
SHARE_WEIGHTS = np.array([1.0 / 30.0, LIGHT, HEAVY, HEAVY, LIGHT, 1.0 / 30.0])
# Places in the work space: a state, the functions at the points of a piece and at one point more, a polynomial.
INSTANT = WORK
VALUES = INSTANT + STATES
ONCE = VALUES + POINTS * INTEGRANDS
FITTED = ONCE + INTEGRANDS
FIT = (FITTED, 1, POINTS - 1)  # as a series


def gather_functions(floats, ints, lane, h):
    """Add a piece to the integrals and peaks that are asked for."""
    asked = shared.asked
    lane.step = h
    for j in range(POINTS):
        look(floats, ints, lane, SHARES[j] * h, VALUES + j * INTEGRANDS)
    if asked & ASK_INTEGRALS != 0:
        for i in range(SUMMED):
            lane.integral[i] += h * lobatto_sum(floats, i)
    if asked & ASK_MAGNITUDE != 0:
        for c in range(CONTACTS):
            lane.magnitude[c] += magnitude(floats, ints, lane, h, FRICTION + c * FUNCTIONS_PER_CONTACT)
    if asked & ASK_PEAK != 0:
        for c in range(CONTACTS):
            peak = peak_on_piece(floats, ints, lane, h, FRICTION + c * FUNCTIONS_PER_CONTACT, lane.peak[c])
            lane.peak[c] = peak
        for i in range(INTEGRANDS - SUMMED):
            peak = peak_on_piece(floats, ints, lane, h, SUMMED + i, lane.peak[CONTACTS + i])
            lane.peak[CONTACTS + i] = peak


def look(floats, ints, lane, s, out):
    """Values of the functions at time s of the piece, written to floats[out:out + INTEGRANDS].

    On an implicit step they are asked at the state consistent with its slopes, see `linear_system.py`.

    The acceleration of a contact is the slope of its state as computed, so that R dv has no area where R depends on v
    alone; and of what its velocity is ahead of that state, where that is imposed.
    """
    series_state(floats, lane, s, INSTANT)
    hook.consistent_state(floats, ints, lane, s, INSTANT)
    integrands(floats, lane.time + s, INSTANT, lane, out)
    for c in range(CONTACTS):
        slope = polynomial_slope(floats, lane.row[STATE_OF[c]], LANES, ORDER, s)
        friction = out + FRICTION + c * FUNCTIONS_PER_CONTACT
        floats[friction + 2] = floats[friction] * (slope + floats[friction + 2])


def lobatto_sum(floats, i):
    """Mean of function i over the piece."""
    total = 0.0
    for j in range(POINTS):
        total += SHARE_WEIGHTS[j] * floats[VALUES + j * INTEGRANDS + i]
    return total


def largest_change(floats, i):
    """Largest change of function i from point to point: it is nowhere farther from the values at the points."""
    change = 0.0
    for j in range(1, POINTS):
        change = max(change, abs(floats[VALUES + j * INTEGRANDS + i] - floats[VALUES + (j - 1) * INTEGRANDS + i]))
    return change


def fit(floats, i):
    """The polynomial in the share of the piece through the points of function i, by divided differences."""
    for j in range(POINTS):
        floats[FITTED + j] = floats[VALUES + j * INTEGRANDS + i]
    for level in range(1, POINTS):
        for j in range(POINTS - 1, level - 1, -1):
            floats[FITTED + j] = (floats[FITTED + j] - floats[FITTED + j - 1]) / (SHARES[j] - SHARES[j - level])
    for level in range(POINTS - 2, -1, -1):  # from Newton's form to powers
        for j in range(level, POINTS - 1):
            floats[FITTED + j] -= SHARES[level] * floats[FITTED + j + 1]


def magnitude(floats, ints, lane, h, i):
    """Integral of |R|, R function i, over the piece, cut where R changes its sign."""
    closest = math.inf
    for j in range(POINTS):
        closest = min(closest, abs(floats[VALUES + j * INTEGRANDS + i]))
    if closest > largest_change(floats, i):
        return h * abs(lobatto_sum(floats, i))
    fit(floats, i)
    total = 0.0
    start, monotone_from = 0.0, 0.0
    for cell in range(CELLS):
        end = (cell + 1.0) / CELLS
        turn = turn_in_cell(floats, FIT, cell, 1.0)
        for part in range(2):
            monotone_to = turn if part == 0 else end
            if monotone_to < 0.0:
                continue
            cut = sign_change(floats, FIT, False, monotone_from, monotone_to)
            if cut >= 0.0:
                total += abs(friction_impulse(floats, ints, lane, i, start * h, cut * h))
                start = cut
            monotone_from = monotone_to
    return total + abs(friction_impulse(floats, ints, lane, i, start * h, h))


def friction_impulse(floats, ints, lane, i, start, end):
    """Integral of R over a part of the piece."""
    total = 0.0
    for j in range(POINTS):
        look(floats, ints, lane, start + SHARES[j] * (end - start), ONCE)
        total += SHARE_WEIGHTS[j] * floats[ONCE + i]
    return total * (end - start)


def peak_on_piece(floats, ints, lane, h, i, best):
    """The largest of `best` and all values of function i on the piece; of friction of their magnitudes."""
    here = -math.inf
    for j in range(POINTS):
        value = floats[VALUES + j * INTEGRANDS + i]
        here = max(here, abs(value) if i < SUMMED else value)
    best = max(best, here)
    if here + largest_change(floats, i) > best:
        fit(floats, i)
        if may_turn(floats, FIT, 1.0):
            for cell in range(CELLS):
                turn = turn_in_cell(floats, FIT, cell, 1.0)
                if turn >= 0.0:
                    look(floats, ints, lane, turn * h, ONCE)
                    value = floats[ONCE + i]
                    best = max(best, abs(value) if i < SUMMED else value)
    return best


def gather_extremes(floats, lane, h):
    """Widen the ranges of the states by a piece."""
    for i in range(STATES):
        row = lane.row[i]
        largest, least = lane.largest[i], lane.least[i]
        away = 0.0  # how far the state may get from where it is
        for k in range(ORDER, 0, -1):
            away = (away + abs(floats[row + k * LANES])) * h
        if floats[row] + away <= largest and floats[row] - away >= least:
            continue
        end = series_value(floats, row, h)
        largest, least = max(largest, end), min(least, end)
        if may_turn(floats, (row, LANES, ORDER), h):
            for cell in range(CELLS):
                turn = turn_in_cell(floats, (row, LANES, ORDER), cell, h)
                if turn >= 0.0:
                    value = value_and_rate(floats, row, LANES, ORDER, turn, False)[0]
                    largest, least = max(largest, value), min(least, value)
        lane.largest[i] = largest
        lane.least[i] = least
