"""Whether a step sees all that the law holds, see `resolution.py`; what has been proved once is not asked again.

For a law whose sharp functions depend on the contact velocity alone, the proof is made once for whole ranges of speed:
up to some SAFE_SPEED each of them is visible from any start, and from some FAR_SPEED on none can be noticed. A step
whose speed stays within one of these needs no look at the law.
"""

import math

from vibrocap.numerics.kernel.arithmetic.plain_vectors import max, min, square_root
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, later_terms
from vibrocap.numerics.kernel.generated.equations import unresolved
from vibrocap.numerics.kernel.generated.facts import (
    CONTACT_STATE,
    GAPS,
    KINKED,
    LACUNARY,
    ROUGH,
    SET_VALUED,
    SHARP,
    SHARP_INTERNAL,
    SIDES_ALIKE,
)
from vibrocap.numerics.kernel.generated.lane import (
    FAR_SPEED,
    NEAR_SPEED,
    PERIOD,
    REFUTED_SPEED,
    SAFE_SPEED,
    SCALE,
    SIDE,
    TOLERANCE,
)
from vibrocap.numerics.kernel.generated.rows import VELOCITY
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER
from vibrocap.numerics.kernel.step.taylor import series_tail

LEAST_SHARE = 0.003  # of a period: a shorter step says little of how long those to come are
WIDE = 2.0  # natural sizes: what is known of the speeds holds for all states that a motion visits
FAINT = 0.01  # share of the velocity that the last terms of its series may have
LEAVING = 5.0  # times tolerance sqrt(v), see `faint`: the ends of 40 oscillators then are within 0.3 tolerances
FAR_RANGE = 4.0  # far is from FAR_SPEED to so many times as much


def excursion(floats, row, h):
    """Bound of |y(s) - y(0)| over a step of length h, of the series y: the sum of |c_k| h^k."""
    return later_terms(floats, row, ORDER, 2, h) + abs(floats[row + LANES]) * h


def resolved(floats, lane, h):
    """Whether the series in memory sees all that the law holds over a step of length h."""
    if not SHARP or (floats[SIDE + lane] == 0.0 and not SHARP_INTERNAL):
        return True  # nothing to see; or at rest for the whole step
    start = floats[VELOCITY + lane]
    change = excursion(floats, VELOCITY + lane, h)
    # An error within the tolerance may be larger than the velocity of a contact near rest, and make it turn.
    resting = (GAPS or ROUGH) and abs(start) <= FAINT * change
    if LACUNARY and floats[SIDE + lane] != 0.0:  # of a contact at rest the series is rounding
        tail = series_tail(floats, VELOCITY + lane, h)
        if ROUGH and resting:  # the series of a power that is rounded off at rest has, as v = c t^2, one term in four
            tail += series_tail(floats, VELOCITY - 2 * LANES + lane, h) / (h * h)
        if tail > faint(floats, lane, abs(start) + change):
            return h <= 8.0 * EPSILON * floats[PERIOD + lane]
    if not SHARP_INTERNAL and not (GAPS and resting):
        if known(floats, lane, abs(start) - change, abs(start) + change):
            return True
        learn(floats, lane, h, abs(start) - change, abs(start) + change)
        if known(floats, lane, abs(start) - change, abs(start) + change):
            return True
    return seen(floats, lane, h, change)


def seen(floats, lane, h, change):
    """The same by the proof for this very step, over which the contact velocity changes by so much at most."""
    start = floats[VELOCITY + lane]
    low, high = start - change, start + change
    if KINKED or SET_VALUED:  # the side lasts the step
        if floats[SIDE + lane] > 0.0:
            low = max(low, 0.0)
        else:
            high = min(high, 0.0)
    return (
        unresolved(floats, lane, h, h, start, start, low, high, 0.0) == 0.0
        or h <= 8.0 * EPSILON * floats[PERIOD + lane]
    )


def faint(floats, lane, speed):
    """Largest last terms of the velocity's series in a step that reaches this speed.

    An error d of the velocity of a contact that leaves rest as v = c t^2 makes all that follows late by d/v', which is
    d/sqrt(4 c v). Where friction falls sharply its velocity grows to that of the fall, and the error with it. So with a
    power of the speed, whose steps begin at speeds below the tolerance, the error is held to tolerance sqrt(v).
    """
    least = FAINT * speed
    if ROUGH:
        scale = floats[SCALE + CONTACT_STATE * LANES + lane]
        least = min(least, LEAVING * floats[TOLERANCE + lane] * square_root(speed * scale))
    return least


def known(floats, lane, least, most):
    """Whether nothing can hide within a step whose speed stays between these two."""
    far = floats[FAR_SPEED + lane]
    return (most <= floats[SAFE_SPEED + lane]) | ((least >= far) & (most <= FAR_RANGE * far))


def learn(floats, lane, h, least, most):
    """Widen the ranges of speed about which something is known to a step whose speed stays between these two."""
    lasting = max(h, LEAST_SHARE * floats[PERIOD + lane])
    tried = 8.0 * most
    if tried >= floats[REFUTED_SPEED + lane]:
        tried = 0.5 * (most + floats[REFUTED_SPEED + lane])
    while most <= tried < floats[REFUTED_SPEED + lane]:
        if hidden(floats, lane, h, lasting, 0.0, tried) == 0.0:
            floats[SAFE_SPEED + lane] = tried
            return
        floats[REFUTED_SPEED + lane] = tried
        tried = max(most, 0.5 * tried)
    tried = least
    for _ in range(4):
        if not (floats[NEAR_SPEED + lane] < tried < floats[FAR_SPEED + lane]):
            return
        if hidden(floats, lane, h, lasting, tried, FAR_RANGE * tried) > 0.0:
            floats[NEAR_SPEED + lane] = tried
            return
        floats[FAR_SPEED + lane] = tried
        tried *= 0.6


def hidden(floats, lane, h, lasting, least, most):
    """How many functions might hide within some step whose speed stays between these two, to either side."""
    if not (KINKED or SET_VALUED) and least == 0.0:
        return unresolved(floats, lane, h, lasting, -most, most, -most, most, WIDE)
    side = floats[SIDE + lane]
    floats[SIDE + lane] = 1.0
    count = unresolved(floats, lane, h, lasting, least, most, least, most, WIDE)
    if not SIDES_ALIKE:
        floats[SIDE + lane] = -1.0
        count += unresolved(floats, lane, h, lasting, -most, -least, -most, -least, WIDE)
    floats[SIDE + lane] = side
    return count


def forget(floats, lane):
    """Nothing is known of the law yet."""
    floats[SAFE_SPEED + lane] = 0.0
    floats[REFUTED_SPEED + lane] = math.inf
    floats[FAR_SPEED + lane] = math.inf
    floats[NEAR_SPEED + lane] = 0.0
