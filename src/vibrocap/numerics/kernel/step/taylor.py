"""The Taylor step: how far the series of this step may be trusted, and the state at its end.

`lane` is the number of a lane; functions without `ints` are of all lanes, too, where it stands for the places of all
(`plain_vectors.all_lanes`). To the last bit alike, but for what LLVM fuses: the lengths of stiff steps hang on the last
coefficients, which hang on what is left of disturbances that have decayed, and a cycle is one whether its steps were
taken together or alone.
"""

import math

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.plain_vectors import (
    exponent,
    mantissa,
    max,
    min,
    power_of_two,
    square_root,
    where,
)
from vibrocap.numerics.kernel.arithmetic.roots import HUGE
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at

NEAREST = 1.5 * 2.0**52  # to which a number is added to be rounded to a whole one: the last binary digits of the sum
SAFETY = math.log2(0.9)  # of a step length, as the logarithm of its factor
STABLE = 0.37 * ORDER + 1.0  # about the stability interval of the Taylor method on the negative real axis
NON_STIFF = 0.6 * STABLE  # step times largest |eigenvalue| below which stability is far from bounding the step
NO_SPEED = 1e-15  # of the natural speed: rounding
LEAVING = 5.0  # times tolerance sqrt(v), see `leaving`: the ends of 40 oscillators then are within 0.3 tolerances
DECIDED = 2e-8  # of a guard of the law: at a looser tolerance, what creeps along a border would pass it again and again
OMITTED = 10.0  # times its last two terms: what the series of a bound may leave out, where it is not cut for them


def taylor_step(floats, ints, lane):
    """Largest step whose last two terms stay below the tolerance (Jorba and Zou 2005, with a fixed order).

    h = 0.9 min over the last two k of (tolerance/|c_k|)^(1/k), with c_k over the natural size of its state. The terms
    left out are smaller than the last one by about the ratio of step and radius of convergence. Enormous for a motion
    at rest; not a number if a coefficient is not.
    """
    if not finite_series(floats, lane):
        return math.nan
    last, before = last_terms(floats, lane)
    last, before = holding_terms(floats, lane, last, before)
    h, _ = series_length(floats, lane, last, before)
    tolerance = lane.tolerance
    wanted = rough_logarithm(tolerance)
    vanishing = 0
    for c in range(CONTACTS):
        vanishing = max(vanishing, lane.transition[c])
    if LACUNARY and vanishing == 2:
        # v = c t^2 there, and a law in v^2 makes of it a series in t^4, whose last two terms may both vanish.
        for k in range(ORDER - 3, ORDER - 1):
            h = min(h, rough_power((wanted - rough_logarithm(largest_term(floats, lane, k))) * (1.0 / k) + SAFETY))
    for c in range(CONTACTS):
        if KINKS[c] == 1:
            # Close to rest even the sign of the velocity counts, which may be smaller than the tolerance.
            row, scale = lane.velocity_row[c], 1.0
            if SEVERAL:
                scale = lane.scale[STATE_OF[c]]
            speed, slope = abs(floats[row]), abs(floats[row + LANES])
            while 0.1 * (speed + slope * h) < tolerance * scale and sign_in_doubt(floats, c, lane, h):
                h *= 0.5
    for i in range(BRANCHES, SWITCHES):  # a bound that is far away need not be known as well as the states
        row = lane.guard_row[i]
        if LOCATED[i] == 1 and not stays_positive(floats, row, min(h, lane.period)):
            h = min(h, reach(wanted, abs(floats[row + (ORDER - 1) * LANES]), ORDER - 1))
            h = min(h, reach(wanted, abs(floats[row + (ORDER - 2) * LANES]), ORDER - 2))
    return h


def finite_series(floats, lane):
    """Whether the last coefficients of all states are numbers, and not too large."""
    total = 0.0
    for i in range(STATES):
        total += abs(lane.series[i * (ORDER + 1) + ORDER])
    return total <= HUGE


def series_length(floats, lane, last, before):
    """(length of the step over which the series keep to the tolerance, largest last coefficient).

    last, before: those of the states and of the forces that hold contacts, see `holding_terms`
    """
    earlier = 0.0 * last
    for i in range(LAW_BRANCHES, BRANCHES):  # the guards of the branches decide too
        row = lane.guard_row[i]
        last = max(last, abs(floats[row + ORDER * LANES]))
        before = max(before, abs(floats[row + (ORDER - 1) * LANES]))
    closer = max(1.0, lane.tolerance * (1.0 / DECIDED))
    for i in range(LAW_BRANCHES):  # of the law, to one order less, where every other term vanishes after a reversal
        row = lane.guard_row[i]
        before = max(before, closer * abs(floats[row + (ORDER - 1) * LANES]))
        earlier = max(earlier, closer * abs(floats[row + (ORDER - 2) * LANES]))
    wanted = rough_logarithm(lane.tolerance)
    one = (wanted * (1.0 / ORDER) + SAFETY) - rough_logarithm(last) * (1.0 / ORDER)
    other = (wanted * (1.0 / (ORDER - 1)) + SAFETY) - rough_logarithm(before) * (1.0 / (ORDER - 1))
    h = rough_power(min(one, other))
    if LAW_BRANCHES:
        h = min(h, reach(wanted, earlier, ORDER - 2))
    return h, last


def reach(wanted, term, k):
    """Length over which term k of a series stays below the tolerance, whose rough logarithm is `wanted`."""
    return rough_power((wanted * (1.0 / k) + SAFETY) - rough_logarithm(term) * (1.0 / k))


def clear_of_bounds(floats, lane, h):
    """Whether every bound of the equations holds over a step of length h beyond doubt."""
    clear = h == h
    for i in range(BRANCHES, SWITCHES):
        row = lane.guard_row[i]
        if LOCATED[i] == 1:
            clear = clear & stays_positive(floats, row, min(h, lane.period))
        else:
            clear = clear & (floats[row] > 0.0)
    return clear


def stays_positive(floats, row, h):
    """Whether a bound of the equations is positive over a step of length h, whatever its series leaves out.

    As `simd_step.within_piece`, with OMITTED times the last two terms. Such a bound decides nothing within the step and
    does not cut it: the load of a contact that does not lift off has a series of larger terms than the states, one
    order shorter, which would ask for half as many steps again.
    """
    others = OMITTED * abs(floats[row + (ORDER - 1) * LANES]) * h + OMITTED * abs(floats[row + (ORDER - 2) * LANES])
    for k in range(ORDER - 3, 3, -1):
        others = others * h + abs(floats[row + k * LANES])
    return least_of_cubic(floats, row, others, h) > 0.0


def least_of_cubic(floats, row, others, h):
    """A bound from below of a series over a step: the Bernstein coefficients of its first four terms.

    others: of all others, over h^4, which are largest at the end of the step
    """
    fourth = (floats[row + 3 * LANES] - others * h) * h * h * h
    return least_of_four(floats[row], floats[row + LANES] * h, floats[row + 2 * LANES] * h * h, fourth)


def least_of_four(first, second, third, fourth):
    """The least Bernstein coefficient over the unit interval of a polynomial of these coefficients.

    Not a number where any of these is none: it shows in the sum, which `min` keeps as the first.
    """
    early = first + second * (1.0 / 3.0)
    late = early + (second + third) * (1.0 / 3.0)
    return min(first + second + third + fourth, late, early, first)


def sticking_rate(period, order):
    """A tenth of the ratio of terms `order` and `order` - 2 of a force with this period: the states go before."""
    rate = 2.0 * math.pi / period
    return 0.1 * rate * rate / (order * (order - 1))


def last_terms(floats, lane):
    """(largest last coefficient, largest last but one) of a state or contact velocity, over its natural size."""
    last = 0.0
    before = 0.0
    for i in range(STATES):
        inverse = hook.inverse_scale(floats, i, lane)
        row = lane.row[i]
        last = max(last, abs(floats[row + ORDER * LANES]) * inverse)
        before = max(before, abs(floats[row + (ORDER - 1) * LANES]) * inverse)
    for c in range(CONTACTS):
        row, inverse = lane.velocity_row[c], hook.inverse_scale(floats, STATE_OF[c], lane)
        if ROUGH[c] == 1:
            speed = where(lane.side[c] != 0.0, abs(floats[row]), 0.0)
            inverse = inverse / leaving(where(speed > 0.0, speed * inverse, 1.0))
        if ROUGH[c] == 1 or at.velocity_row[c] != at.row[STATE_OF[c]]:
            # With an imposed part of a contact velocity, that is another series; its zeros are what ends a mode.
            last = max(last, abs(floats[row + ORDER * LANES]) * inverse)
            before = max(before, abs(floats[row + (ORDER - 1) * LANES]) * inverse)
    return last, before


def leaving(speed):
    """Tolerances by which a contact velocity may be off, that has left rest and is this share of its natural size.

    An error d of the velocity of a contact that leaves rest as v = c t^2 makes all that follows late by d/v', which is
    d/sqrt(4 c v). Where friction falls sharply its velocity grows to that of the fall, and the error with it. So with a
    power of the speed, whose steps begin at speeds below the tolerance, the error is held to tolerance sqrt(v).
    """
    return min(LEAVING * square_root(speed), 1.0)


def holding_terms(floats, lane, last, before):
    """These terms, and those of the forces that hold stuck contacts.

    Such a force is an acceleration: less exact than the states, and it decides. Near the crests of the drive every
    other term of it vanishes; where the states do not move, no other term tells of it.
    """
    for c in range(CONTACTS):
        if STICKS[c] == 1:
            limit = lane.limit[c]
            holding = (lane.side[c] == 0.0) & (limit > 0.0)
            inverse = 1.0 / where(holding, limit, 1.0)
            row = lane.sticking_force_row[c]
            share = abs(floats[row + (ORDER - 1) * LANES]) * inverse
            before = where(holding, max(before, share), before)
            share = abs(floats[row + (ORDER - 2) * LANES]) * inverse * lane.sticking_rate
            last = where(holding, max(last, share), last)
    return last, before


def largest_term(floats, lane, k):
    """Largest coefficient k of a state, over its natural size."""
    largest = 0.0
    for i in range(STATES):
        row = lane.row[i]
        largest = max(largest, abs(floats[row + k * LANES]) / lane.scale[i])
    return largest


def sign_in_doubt(floats, c, lane, h):
    """Whether the last terms of a contact velocity are not small against its first ones at time h."""
    row = lane.velocity_row[c]
    first = abs(floats[row]) + abs(floats[row + LANES]) * h + abs(floats[row + 2 * LANES]) * h * h
    none = NO_SPEED * lane.scale[STATE_OF[c]] if SEVERAL else 0.0
    return series_tail(floats, row, h) > 0.01 * first + none


def series_tail(floats, row, h):
    """Sum of the sizes of the last two terms at time h of the series whose first coefficient stands at floats[row]."""
    power = h
    for _ in range(ORDER - 2):
        power = power * h
    return (abs(floats[row + ORDER * LANES]) * h + abs(floats[row + (ORDER - 1) * LANES])) * power


def unlike(choices):
    """Where a choice is not made."""
    return where(choices, 0.0, 1.0) > 0.0


def rough_logarithm(x):
    """log2(x) for x >= 0, from the bits of x, with a line between powers of two: too small by 0.086 at most.

    A step length, of which this is the root of a high order, needs no more, and all of the next step waits for it.
    """
    return exponent(x) + (mantissa(x) - 1.0)


def rough_power(y):
    """2**y to 0.2 %, with a parabola around whole y, for |y| < 1022."""
    whole = (y + NEAREST) - NEAREST
    g = y - whole
    return (1.00044 + g * (0.70345 + 0.23843 * g)) * power_of_two(whole)


def series_value(floats, row, s):
    """Value at time s of the series whose first coefficient stands at floats[row].

    Even and odd powers are summed apart, chains of half as many dependent operations: each step waits for its start.
    """
    square = s * s
    one = floats[row + ORDER * LANES]
    other = floats[row + (ORDER - 1) * LANES]
    for k in range(ORDER - 2, 0, -2):
        one = one * square + floats[row + k * LANES]
        other = other * square + floats[row + (k - 1) * LANES]
    if ORDER % 2:
        return other + s * one
    return floats[row] + s * (other + s * one)


def series_state(floats, lane, s, out):
    """Write the state at time s of the present series to floats[out:out + STATES]."""
    for i in range(STATES):
        floats[out + i] = series_value(floats, lane.row[i], s)


def through_points(floats, row, first, stride, h):
    """Write the series of degree 4 through five values at even distances along a step, from floats[first] on."""
    v0, v1, v2 = floats[first], floats[first + stride], floats[first + 2 * stride]
    v3, v4 = floats[first + 3 * stride], floats[first + 4 * stride]
    for k in range(5, ORDER + 1):
        floats[row + k * LANES] = 0.0
    floats[row] = v0
    floats[row + LANES] = (-25.0 * v0 + 48.0 * v1 - 36.0 * v2 + 16.0 * v3 - 3.0 * v4) / (3.0 * h)
    floats[row + 2 * LANES] = (70.0 * v0 - 208.0 * v1 + 228.0 * v2 - 112.0 * v3 + 22.0 * v4) / (3.0 * h**2)
    floats[row + 3 * LANES] = (-80.0 * v0 + 288.0 * v1 - 384.0 * v2 + 224.0 * v3 - 48.0 * v4) / (3.0 * h**3)
    floats[row + 4 * LANES] = 32.0 * (v0 - 4.0 * v1 + 6.0 * v2 - 4.0 * v3 + v4) / (3.0 * h**4)


def write_state(floats, lane, out):
    """Write the present state of a lane to floats[out:out + STATES]."""
    for i in range(STATES):
        floats[out + i] = lane.state[i]


def move_to(floats, ints, lane, s):
    """Put the lane at time s of its present series."""
    for i in range(STATES):
        lane.state[i] = series_value(floats, lane.row[i], s)
    lane.time += s
