"""The true load of a contact whose friction takes it as constant: whether it falls below zero in the window.

The series of the load (`LoadSeries`) is a bound that clears nearly every step. On the others the load is
asked as the measure of its least value asks it: at the points of the piece, and where a polynomial through them turns.
"""

from vibrocap.numerics.kernel.arithmetic.roots import later_terms
from vibrocap.numerics.kernel.generated.equations import reaction
from vibrocap.numerics.kernel.generated.places import SERIES
from vibrocap.numerics.kernel.generated.rows import REACTION
from vibrocap.numerics.kernel.generated.sizes import INTEGRANDS, LANES, ORDER, STATES
from vibrocap.numerics.kernel.interface import consistent_state
from vibrocap.numerics.kernel.observe.accumulators import FITTED, INSTANT, POINTS, SHARES, VALUES, fit, largest_change
from vibrocap.numerics.kernel.observe.turning_points import CELLS, may_turn, turning_point
from vibrocap.numerics.kernel.step.taylor import series_value


def watch_load(floats, ints, lane, h):
    """After a step of length h: the series of the load tells, or it is looked at."""
    if lane.window_start < 0 or lane.lifted != 0.0:
        return
    if lane.stiff == 0:  # a line outweighs all other terms
        end = floats[REACTION + lane] + floats[REACTION + LANES + lane] * h
        if min(floats[REACTION + lane], end) > later_terms(floats, REACTION + lane, ORDER - 2, 2, h):
            return
    look_at_load(floats, ints, lane, h)


def look_at_load(floats, ints, lane, h):
    """Whether the load falls below zero on a piece of length h."""
    lane.step = h
    least = reaction_at(floats, ints, lane, 0.0)
    floats[VALUES] = least
    for j in range(1, POINTS):
        value = reaction_at(floats, ints, lane, SHARES[j] * h)
        floats[VALUES + j * INTEGRANDS] = value
        least = min(least, value)
    if 0.0 <= least <= largest_change(floats, 0):
        fit(floats, 0)
        if may_turn(floats, FITTED, 1, POINTS - 1, 1.0):
            for cell in range(CELLS):
                turn = turning_point(floats, FITTED, 1, POINTS - 1, float(cell) / CELLS, (cell + 1.0) / CELLS)
                if turn >= 0.0:
                    least = min(least, reaction_at(floats, ints, lane, turn * h))
    if least < 0.0:
        lane.lifted = 1.0


def reaction_at(floats, ints, lane, s):
    """The true load at time s of the piece."""
    for i in range(STATES):
        floats[INSTANT + i] = series_value(floats, SERIES + i * (ORDER + 1) * LANES + lane, s)
    consistent_state(floats, ints, lane, s, INSTANT)
    return reaction(floats, lane.time + s, INSTANT, lane.side, lane)
