"""Stabilised Taylor steps: series whose last terms are damped carry a step on where stability ends a plain one.

To a fast decay y' = -rate y, a step of length h multiplies a disturbance by R(-rate h), the series' polynomial of
degree ORDER. That of a plain series is small up to rate h = 5 or so and enormous beyond, which is what bounds the steps
of bristles. Here the last three coefficients are damped,

    y(s) = sum over k < ORDER - 2 of c_k s^k  +  sum over the last three k of DAMPING_k c_k s^k,

with the factors for which |R| <= 0.9 holds furthest, to rate h = STABILITY (optimal stability polynomials, Ketcheson
and Ahmadia 2012; tests/stability_polynomials.py finds them). What is no fast decay loses accuracy: its error is

    D(h) = sum over the last three k of FILTER_k c_k h^k,

whose first factor is exactly that of the error, 1 - DAMPING. The others are chosen for D to be smallest on fast decays:
at most 12 times their size, where the last terms themselves are up to 10^5 times as large and cancel.
"""

import numpy as np

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, max, min, where
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at
from vibrocap.numerics.kernel.step.taylor import NON_STIFF, STABLE, clear_of_bounds, last_terms, taylor_step, unlike

# STABILITY, then DAMPING and FILTER of the last three terms; of the orders that motions and ensembles use.
POLYNOMIALS = {
    10: (12.88, (0.82381365, 0.42858625, 0.10008173), (0.17618635, 0.2701079, 0.11440277)),
    12: (13.03, (0.86064511, 0.48848495, 0.12688469), (0.13935489, 0.25365453, 0.12546171)),
    16: (13.91, (0.90046413, 0.56664443, 0.16836287), (0.09953587, 0.22671543, 0.1374365)),
}
PLAIN = (STABLE, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))  # of all others: nothing is damped
STABILITY = POLYNOMIALS.get(ORDER, PLAIN)[0]
DAMPING = np.array(POLYNOMIALS.get(ORDER, PLAIN)[1])
FILTER = np.array(POLYNOMIALS.get(ORDER, PLAIN)[2])
FIRST_DAMPED = ORDER - 2
# Rate times length: of the longest stabilised step (bristles decay faster as the contact gets faster), of a plain one.
DAMPED_REACH = 0.85 * STABILITY
PLAIN_REACH = 0.9 * STABLE
LONGEST = STABILITY / STABLE  # stabilised step over a plain one
# With this share, errors of ten capsules over 30 periods were those of plain steps at the same tolerance.
SHARE = 0.03
LENGTHS, SHORTER = 4, 0.7  # that are tried


def series_step(floats, ints, lane, remaining):
    """(step length, non_stiff): that of the series, damped where stability would end a plain step early.

    non_stiff: whether stability is far from bounding the step, by the rate of decay and by the last terms, which grow
    like those of exp(-rate s), or of a fast oscillation, where they bound it: their ratio is rate/ORDER then. A start
    from rest is a plain step: |v| = 0 is never stiff.
    """
    if not MAYBE_STIFF:
        return taylor_step(floats, ints, lane), True
    if lane.damped_step > 0.0:
        return lane.damped_step, True  # the series in memory is one for this step, see `simd_step.py`
    longest = taylor_step(floats, ints, lane)
    if not (longest < remaining) or starts_from_rest(ints, lane):
        return longest, True
    stretch = lane.decay_rate * longest
    last, before = last_terms(floats, lane)
    if not (stretch > NON_STIFF) and ORDER * last * longest < NON_STIFF * before:
        return longest, True
    allowed = lane.tolerance
    if not (stretch > PLAIN_REACH):
        return longest, False
    if KINKS[0] == 1 and not SEVERAL:  # close to rest the sign of the velocity counts, see `taylor_step`
        speed, slope = abs(lane.velocity[0]), abs(floats[at.velocity_row[0] + LANES + lane])
        allowed = min(allowed, 0.1 * (speed + slope * longest))
    if SEVERAL and (near_turning(floats, lane, longest) or one_rests(floats, lane)):
        return PLAIN_REACH / lane.decay_rate, False  # the forces that hold one are known to one term less
    longest, _ = stabilised_step(floats, lane, True, longest, allowed)
    return longest, False


def starts_from_rest(ints, lane):
    """Whether a contact leaves rest, or turns, where the step starts."""
    starts = 0
    for c in range(CONTACTS):
        vanishing = lane.transition[c]
        if vanishing > 0 and (not SEVERAL or vanishing < ORDER):
            starts += 1  # of several, one that rests for good leaves nothing
    return starts > 0


def near_turning(floats, lane, h):
    """Whether within a step of length h a contact is so close to rest that the sign of its velocity counts."""
    for c in range(CONTACTS):
        row = lane.velocity_row[c]
        reach = abs(floats[row]) + abs(floats[row + LANES]) * h
        if KINKS[c] == 1 and 0.1 * reach < lane.tolerance * lane.scale[STATE_OF[c]]:
            return True
    return False


def one_rests(floats, lane):
    """Whether a contact sticks, of several."""
    rests = lane.decay_rate < 0.0
    for c in range(CONTACTS):
        if STICKS[c] == 1:
            rests = rests | (lane.side[c] == 0.0)
    return rests


def stabilised_step(floats, lane, wanted, longest, allowed):
    """(step length, whether the series has been damped for it), of a lane or of all lanes of which the step is wanted.

    longest: that of the plain series; where it is beyond stability the series is damped for the step if it can
    allowed: of which the error that damping makes may be a SHARE

    The rate is that of the equations. The last terms of the series tell it too, but where disturbances have decayed to
    rounding they tell rounding, and steps that depend on rounding differ from one machine to the next.
    """
    rate = lane.decay_rate
    damped = wanted & unlike(wanted)
    untried = wanted & (rate * longest > PLAIN_REACH)
    h = min(DAMPED_REACH / rate, LONGEST * longest)
    longest = where(untried, PLAIN_REACH / rate, longest)
    for _ in range(LENGTHS):
        if bits(untried) == 0:
            break
        accurate = untried & (damping_error(floats, lane, h) <= SHARE * allowed)
        if BRANCHES < SWITCHES:
            accurate = accurate & clear_of_bounds(floats, lane, h)
        longest = where(accurate, h, longest)
        damped = damped | accurate
        untried = untried & unlike(accurate)
        h = SHORTER * h
    if bits(damped) != 0:
        damp_series(floats, lane, damped)
    return longest, damped


def damping_error(floats, lane, h):
    """Largest |D(h)| over the states, each over its natural size."""
    worst = 0.0 * h
    for i in range(STATES):
        row = SERIES + (i * (ORDER + 1) + FIRST_DAMPED) * LANES + lane
        last = FILTER[1] * floats[row + LANES] + h * (FILTER[2] * floats[row + 2 * LANES])
        total = FILTER[0] * floats[row] + h * last
        worst = max(worst, abs(total) * hook.inverse_scale(floats, i, lane))
    power = h * h
    for _ in range(FIRST_DAMPED - 2):
        power = power * h
    return worst * power


def damp_series(floats, lane, damped):
    """Damp the last terms of all that the step moves: states, contact velocity and guards of pieces."""
    for i in range(STATES):
        damp_row(floats, lane.row[i], damped)
    for c in range(CONTACTS):
        if at.velocity_row[c] != at.row[STATE_OF[c]]:
            damp_row(floats, lane.velocity_row[c], damped)
    for i in range(SWITCHES):
        damp_row(floats, lane.guard_row[i], damped)


def damp_row(floats, row, damped):
    """Damp the last terms of the series whose first coefficient stands at floats[row]."""
    for k in range(3):
        floats[row + (FIRST_DAMPED + k) * LANES] *= where(damped, DAMPING[k], 1.0)
