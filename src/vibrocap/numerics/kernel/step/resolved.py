"""Whether a step sees all that the law holds, see `resolution.py`; what has been proved once is not asked again.

For a law whose sharp functions depend on the contact velocity alone, the proof is made once for whole ranges of speed:
up to some SAFE_SPEED each of them is visible from any start, and from some FAR_SPEED on none can be noticed. A step
whose speed stays within one of these needs no look at the law.
"""

import math

from vibrocap.numerics.kernel.arithmetic.plain_vectors import max, min
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, later_terms
from vibrocap.numerics.kernel.generated import *

LEAST_SHARE = 0.003  # of a period: a shorter step says little of how long those to come are
WIDE = 2.0  # natural sizes: what is known of the speeds holds for all states that a motion visits
FAINT = 0.01  # share of the velocity that the last terms of its series may have
FAR_RANGE = 4.0  # far is from FAR_SPEED to so many times as much


def excursion(floats, row, h):
    """Bound of |y(s) - y(0)| over a step of length h, of the series y: the sum of |c_k| h^k."""
    return later_terms(floats, row, ORDER, 2, h) + abs(floats[row + LANES]) * h


def resolved(floats, lane, h):
    """Whether the series in memory sees all that the law holds over a step of length h."""
    if not SHARP or (lane.side[SHARP_CONTACT] == 0.0 and not SHARP_INTERNAL):
        return True  # nothing to see; or at rest for the whole step
    start = lane.velocity[SHARP_CONTACT]
    change = excursion(floats, lane.velocity_row[SHARP_CONTACT], h)
    if not SHARP_INTERNAL and not (GAPS and abs(start) <= FAINT * change):
        if known(floats, lane, abs(start) - change, abs(start) + change):
            return True
        learn(floats, lane, h, abs(start) - change, abs(start) + change)
        if known(floats, lane, abs(start) - change, abs(start) + change):
            return True
    return seen(floats, lane, h, change)


def seen(floats, lane, h, change):
    """The same by the proof for this very step, over which the contact velocity changes by so much at most."""
    start = lane.velocity[SHARP_CONTACT]
    low, high = start - change, start + change
    if STICKS[SHARP_CONTACT] + KINKS[SHARP_CONTACT] > 0:  # the side lasts the step
        if lane.side[SHARP_CONTACT] > 0.0:
            low = max(low, 0.0)
        else:
            high = min(high, 0.0)
    return unresolved(floats, lane, h, h, start, start, low, high, 0.0) == 0.0 or h <= 8.0 * EPSILON * lane.period


def known(floats, lane, least, most):
    """Whether nothing can hide within a step whose speed stays between these two."""
    far = lane.far_speed
    return (most <= lane.safe_speed) | ((least >= far) & (most <= FAR_RANGE * far))


def learn(floats, lane, h, least, most):
    """Widen the ranges of speed about which something is known to a step whose speed stays between these two."""
    lasting = max(h, LEAST_SHARE * lane.period)
    tried = 8.0 * most
    if tried >= lane.refuted_speed:
        tried = 0.5 * (most + lane.refuted_speed)
    while most <= tried < lane.refuted_speed:
        if hidden(floats, lane, h, lasting, 0.0, tried) == 0.0:
            lane.safe_speed = tried
            return
        lane.refuted_speed = tried
        tried = max(most, 0.5 * tried)
    tried = least
    for _ in range(4):
        if not (lane.near_speed < tried < lane.far_speed):
            return
        if hidden(floats, lane, h, lasting, tried, FAR_RANGE * tried) > 0.0:
            lane.near_speed = tried
            return
        lane.far_speed = tried
        tried *= 0.6


def hidden(floats, lane, h, lasting, least, most):
    """How many functions might hide within some step whose speed stays between these two, to either side."""
    if STICKS[SHARP_CONTACT] + KINKS[SHARP_CONTACT] == 0 and least == 0.0:
        return unresolved(floats, lane, h, lasting, -most, most, -most, most, WIDE)
    side = lane.side[SHARP_CONTACT]
    lane.side[SHARP_CONTACT] = 1.0
    count = unresolved(floats, lane, h, lasting, least, most, least, most, WIDE)
    lane.side[SHARP_CONTACT] = -1.0
    count += unresolved(floats, lane, h, lasting, -most, -least, -most, -least, WIDE)
    lane.side[SHARP_CONTACT] = side
    return count


def forget(floats, lane):
    """Nothing is known of the law yet."""
    lane.safe_speed = 0.0
    lane.refuted_speed = math.inf
    lane.far_speed = math.inf
    lane.near_speed = 0.0
