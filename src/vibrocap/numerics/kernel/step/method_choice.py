"""Choice of the method for laws that can be stiff: whichever, Taylor or implicit, gets further for its cost."""

import math

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, first_root, polynomial_slope
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at
from vibrocap.numerics.kernel.step.implicit import (
    attempted_step,
    dense_output,
    implicit_series,
    implicit_stages,
    implicit_step,
    spectral_radius,
    velocity_series,
)
from vibrocap.numerics.kernel.step.stabilised import PLAIN_REACH, STABILITY, series_step, starts_from_rest
from vibrocap.numerics.kernel.step.taylor import NO_SPEED, NON_STIFF, series_value

LOOK = 32  # steps between two looks at the choice of method
REST, MOST_REST = 256, 4096  # steps before the implicit method is tried again after it lost, at first and at most
TIMES_TO_REST = 2.0  # times the time to rest: the longest implicit step towards a reversal
NEAR_EVENT = 4.0  # explicit steps to an event below which they are taken
APPROACH = 0.75  # share of the way to an event that an implicit step may go
EXPLICIT_STEPS = 8  # that are taken then, at least
# In Taylor steps: 1.4 us against 0.34 us where it was measured, and some are refused. One lane makes it while the rest
# waits, and its linear system grows with every contact.
IMPLICIT_COST = 5.0 * (LANES * CONTACTS if SEVERAL and LANES > 1 else 1)


def step_length(floats, ints, lane, remaining):
    """Step length by the method that is cheaper here; an implicit step replaces the series in memory.

    The implicit method is tried where stability, not accuracy, bounds the Taylor step, and kept while its steps are
    longer by more than it costs. A start from rest is a Taylor step: |v| = 0 is never stiff. The eigenvalues of the
    Jacobian are looked at now and then, and only where its trace or the last terms say so, see `series_step`.
    """
    if starts_from_rest(ints, lane):
        lane.stiff = 0
    lane.patience -= 1
    if lane.stiff == 0:
        explicit, non_stiff = series_step(floats, ints, lane, remaining)
        beyond = explicit != explicit  # so stiff that coefficients are no numbers
        if beyond:
            explicit = 1.0 / lane.decay_rate
        elif non_stiff or lane.patience > 0:
            return explicit
        lane.patience = LOOK
        stretch = explicit * spectral_radius(floats, ints, lane)
        # Next to rest a step of several goes as far as their summed rates of decay let it, see `series_step`.
        bounded = beyond or lane.decay_rate * explicit > 0.999 * PLAIN_REACH
        if stretch < NON_STIFF and not bounded:
            if stretch < 0.5 * NON_STIFF:
                lane.patience = rest_steps(ints, lane)
            return explicit
        lane.explicit_step = explicit
        lane.implicit_step = IMPLICIT_COST * explicit
        lane.patience = 0  # one step tells whether it pays
        tries = 60 if beyond else 1
        h = attempted_step(floats, ints, lane, min(remaining, TIMES_TO_REST * time_to_rest(floats, lane)), tries)
        if h == 0.0 and beyond:
            return math.nan
        if h == 0.0:
            lane.patience = LOOK if SEVERAL else rest_steps(ints, lane)
            return -1.0 if SEVERAL else explicit
        lane.stiff = 1
    else:
        longest = min(remaining, TIMES_TO_REST * time_to_rest(floats, lane))
        h = implicit_step(floats, ints, lane, longest)
        if SEVERAL and (h == 0.0 or (h < lane.explicit_step and h < remaining)):
            leave_implicit(ints, lane)
            return -1.0
    if lane.patience <= 0:
        lane.patience = LOOK
        reach = lane.implicit_step / IMPLICIT_COST
        lost = reach < lane.explicit_step
        if lost or reach * spectral_radius(floats, ints, lane) < STABILITY:
            lane.stiff = 0
            lane.patience = rest_steps(ints, lane) if lost else LOOK
            if SEVERAL:
                return -1.0  # made anew: an explicit step may end with an event
    return h


def rest_steps(ints, lane):
    """Steps until the implicit method is tried again: the more, the longer a run has done without it."""
    if lane.implicit_steps > 0:
        return REST
    return max(REST, min(lane.taylor_steps // 2, MOST_REST))


def time_to_rest(floats, lane):
    """Time in which the contact velocity would vanish at its present rate; infinite if it grows.

    Beyond rest the equations of this side mean nothing (bristles of a LuGre contact would grow without bound), so an
    implicit step should not go far beyond. The series in memory need not be that of the present state: only its first
    two coefficients are used, which the Taylor series of every step provides.
    """
    time = math.inf
    for c in range(CONTACTS):
        if KINKS[c] == 1 or not SEVERAL:
            v, slope = lane.velocity[c], floats[at.velocity_row[c] + LANES + lane]
            none = NO_SPEED * lane.scale[STATE_OF[c]] if SEVERAL else 0.0
            if abs(v) > none and v * slope < 0.0:
                time = min(time, -v / slope)
    return time


def shorter_step(floats, ints, lane, h):
    """Make the present implicit step anew: part of the way to an event at h; 0 where explicit steps come next.

    What an event is decided by, a velocity or a force near its limit, the dense output knows less well than the states.
    So no implicit step ends with an event of several contacts. Ever shorter ones lead towards it, each more exact than
    the one before, and where it is within reach of explicit steps their series find it.
    """
    if h * spectral_radius(floats, ints, lane) < NEAR_EVENT * STABILITY:
        leave_implicit(ints, lane)
        return 0.0
    h *= APPROACH
    for _ in range(4):
        if implicit_stages(floats, ints, lane, h) <= 1.0:
            dense_output(floats, ints, lane, h)
            return h
        h *= 0.5
    leave_implicit(ints, lane)
    return 0.0


def leave_implicit(ints, lane):
    lane.stiff = 0
    lane.patience = EXPLICIT_STEPS


def polished_step(floats, ints, lane, h, longest):
    """(event, length) of an implicit step that ends where the velocity of a contact alone vanishes.

    The dense output is less exact than the step, so the step is repeated with the length at which the velocity vanishes
    at its very end. Where that step would not be exact enough, or where only the dense output saw an event, a shorter
    step without an event is made instead.
    """
    if lane.stiff == 0:
        return 1, h
    rest = length_to_rest(floats, ints, lane, h, longest)
    h = rest if rest > 0.0 else longest
    error = implicit_stages(floats, ints, lane, h)
    if rest > 0.0 and error <= 1.0:
        return 1, h
    for _ in range(60):
        h *= max(0.2, min(0.8, 0.9 * error ** (-0.2)))
        v = lane.side * end_velocity(floats, ints, lane, h)
        error = implicit_stages(floats, ints, lane, h)
        root, _touch = first_root(floats, lane.velocity_row[0], ORDER, lane.side, 0, h)
        if error <= 1.0 and v > 0.0 and root < 0.0:
            break
    lane.implicit_step = h
    return 0, h


def made_again(floats, ints, lane, h):
    if lane.stiff == 0:
        return False
    implicit_stages(floats, ints, lane, h)
    implicit_series(floats, ints, lane, h)
    return True


def length_to_rest(floats, ints, lane, h, longest):
    """Length within (0, longest] of the implicit step that ends at rest, whose series is written, or 0 without one.

    Newton's method from a guess h, by halving where that is slow.
    """
    side = lane.side
    low, high = 0.0, longest
    before = math.inf
    for _ in range(200):
        v = side * end_velocity(floats, ints, lane, h)
        if v > 0.0:
            low = h
        else:
            high = h
        slope = side * polynomial_slope(floats, lane.velocity_row[0], LANES, ORDER, h)
        newton = slope != 0.0 and abs(v) < 0.5 * before
        following = h - v / slope if newton else low
        if newton and abs(following - h) <= EPSILON * (lane.time + h):
            return h
        if not (low < following < high):
            following = 0.5 * (low + high)
            if following in (low, high):
                break
        before = abs(v)
        h = following
    return high if side * end_velocity(floats, ints, lane, high) <= 0.0 else 0.0


def end_velocity(floats, ints, lane, h):
    """Contact velocity at the end of an implicit step of length h, whose series is written."""
    implicit_stages(floats, ints, lane, h)
    implicit_series(floats, ints, lane, h)
    velocity_series(floats, ints, lane, h)
    return series_value(floats, lane.velocity_row[0], h)
