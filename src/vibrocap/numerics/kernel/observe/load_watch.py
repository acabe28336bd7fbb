"""The true loads of contacts whose friction takes them as constant: whether one falls below zero in the window.

The series of a load (`LoadSeries`) is a bound that clears nearly every step. On the others the load is
asked as the measure of its least value asks it: at the points of the piece, and where a polynomial through them turns.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import CELLS, later_terms, may_turn, turn_in_cell
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.observe.accumulators import FIT, INSTANT, POINTS, SHARES, VALUES, fit, largest_change
from vibrocap.numerics.kernel.step.taylor import series_state


def watch_load(floats, ints, lane, h):
    """After a step of length h: the series of each load tells, or it is looked at."""
    if lane.window_start < 0:
        return
    for w in range(WATCHED):
        if lane.lifted[w] == 0.0 and not (lane.stiff == 0 and line_outweighs(floats, lane.load_row[w], h)):
            look_at_load(floats, ints, lane, w, h)


def line_outweighs(floats, row, h):
    """Whether the first two terms of a load outweigh all others, and stay positive."""
    end = floats[row] + floats[row + LANES] * h
    return min(floats[row], end) > later_terms(floats, row, ORDER - 2, 2, h)


def look_at_load(floats, ints, lane, w, h):
    """Whether a load falls below zero on a piece of length h."""
    lane.step = h
    least = reaction_at(floats, ints, lane, w, 0.0)
    floats[VALUES] = least
    for j in range(1, POINTS):
        value = reaction_at(floats, ints, lane, w, SHARES[j] * h)
        floats[VALUES + j * INTEGRANDS] = value
        least = min(least, value)
    if 0.0 <= least <= largest_change(floats, 0):
        fit(floats, 0)
        if may_turn(floats, FIT, 1.0):
            for cell in range(CELLS):
                turn = turn_in_cell(floats, FIT, cell, 1.0)
                if turn >= 0.0:
                    least = min(least, reaction_at(floats, ints, lane, w, turn * h))
    if least < 0.0:
        lane.lifted[w] = 1.0


def reaction_at(floats, ints, lane, w, s):
    """A true load at time s of the piece."""
    series_state(floats, lane, s, INSTANT)
    hook.consistent_state(floats, ints, lane, s, INSTANT)
    return reaction(floats, lane.time + s, INSTANT, w, lane)
