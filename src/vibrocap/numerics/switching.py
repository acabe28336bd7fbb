"""Choice of the method for laws that can be stiff: whichever, Taylor or implicit, gets further for its cost."""

import math

from vibrocap.numerics.generated import (
    EXPLICIT_STEP,
    IMPLICIT_STEP,
    LANES,
    ORDER,
    PATIENCE,
    SIDE,
    STIFF,
    TIME,
    VELOCITY,
    ZEROS,
)
from vibrocap.numerics.implicit import (
    implicit_series,
    implicit_stages,
    implicit_step,
    spectral_radius,
    velocity_series,
)
from vibrocap.numerics.roots import EPSILON, first_root
from vibrocap.numerics.taylor import series_value, taylor_step

LOOK = 32  # steps between two looks at the choice of method
REST = 256  # steps before the implicit method is tried again after it lost
REACH = 2.0  # times the time to rest: the longest implicit step towards a reversal
STABLE = 0.37 * ORDER + 1.0  # about the stability interval of the Taylor method on the negative real axis
IMPLICIT_COST = 5.0  # in Taylor steps: 1.4 us against 0.34 us where it was measured, and some are refused


def chosen_step(real, whole, lane, remaining):
    """Step length by the method that is cheaper here; an implicit step replaces the series in memory.

    The implicit method is tried where stability, not accuracy, bounds the Taylor step, and kept while its steps are
    longer by more than it costs. A start from rest is a Taylor step: |v| = 0 is never stiff.
    """
    if whole[ZEROS + lane] > 0:
        whole[STIFF + lane] = 0
    whole[PATIENCE + lane] -= 1
    if whole[STIFF + lane] == 0:
        explicit = taylor_step(real, whole, lane)
        if whole[ZEROS + lane] > 0 or whole[PATIENCE + lane] > 0 or not (explicit < remaining):
            return explicit
        whole[PATIENCE + lane] = LOOK
        stretch = explicit * spectral_radius(real, whole, lane)
        if stretch < 0.6 * STABLE:
            if stretch < 0.3 * STABLE:
                whole[PATIENCE + lane] = REST
            return explicit
        whole[STIFF + lane] = 1
        real[EXPLICIT_STEP + lane] = explicit
        real[IMPLICIT_STEP + lane] = IMPLICIT_COST * explicit
        whole[PATIENCE + lane] = 0  # one step tells whether it pays
    h = implicit_step(real, whole, lane, min(remaining, REACH * time_to_rest(real, lane)))
    if whole[PATIENCE + lane] <= 0:
        whole[PATIENCE + lane] = LOOK
        reach = real[IMPLICIT_STEP + lane] / IMPLICIT_COST
        lost = reach < real[EXPLICIT_STEP + lane]
        if lost or reach * spectral_radius(real, whole, lane) < STABLE:
            whole[STIFF + lane] = 0
            whole[PATIENCE + lane] = REST if lost else LOOK
    return h


def time_to_rest(real, lane):
    """Time in which the contact velocity would vanish at its present rate; infinite if it grows.

    Beyond rest the equations of this side mean nothing (bristles of a LuGre contact would grow without bound), so an
    implicit step should not go far beyond. The series in memory need not be that of the present state: only its first
    two coefficients are used, which the Taylor series of every step provides.
    """
    v, slope = real[VELOCITY + lane], real[VELOCITY + LANES + lane]
    return -v / slope if v * slope < 0.0 else math.inf


def polished_step(real, whole, lane, h, longest):
    """(event, length) of an implicit step that ends where the contact velocity vanishes.

    The dense output is less exact than the step, so the step is repeated with the length at which the velocity vanishes
    at its very end. Where that step would not be exact enough, or where only the dense output saw an event, a shorter
    step without an event is made instead.
    """
    if whole[STIFF + lane] == 0:
        return 1, h
    rest = length_to_rest(real, whole, lane, h, longest)
    h = rest if rest > 0.0 else longest
    error = implicit_stages(real, whole, lane, h)
    if rest > 0.0 and error <= 1.0:
        return 1, h
    for _ in range(60):
        h *= max(0.2, min(0.8, 0.9 * error ** (-0.2)))
        v = real[SIDE + lane] * end_velocity(real, whole, lane, h)
        error = implicit_stages(real, whole, lane, h)
        root, _touch = first_root(real, VELOCITY + lane, ORDER, real[SIDE + lane], 0, h)
        if error <= 1.0 and v > 0.0 and root < 0.0:
            break
    real[IMPLICIT_STEP + lane] = h
    return 0, h


def repeat_to(real, whole, lane, h):
    """Repeat an implicit step up to an event within it: its dense output is less exact than its end."""
    if whole[STIFF + lane] == 1:
        implicit_stages(real, whole, lane, h)
        implicit_series(real, whole, lane, h)


def length_to_rest(real, whole, lane, h, longest):
    """Length within (0, longest] of the implicit step that ends at rest, whose series is written, or 0 without one.

    Newton's method from a guess h, by halving where that is slow.
    """
    side = real[SIDE + lane]
    low, high = 0.0, longest
    before = math.inf
    for _ in range(200):
        v = side * end_velocity(real, whole, lane, h)
        if v > 0.0:
            low = h
        else:
            high = h
        slope = 0.0
        for k in range(4, 0, -1):
            slope = slope * h + side * k * real[VELOCITY + k * LANES + lane]
        newton = slope != 0.0 and abs(v) < 0.5 * before
        following = h - v / slope if newton else low
        if newton and abs(following - h) <= EPSILON * (real[TIME + lane] + h):
            return h
        if not (low < following < high):
            following = 0.5 * (low + high)
            if following in (low, high):
                break
        before = abs(v)
        h = following
    return high if side * end_velocity(real, whole, lane, high) <= 0.0 else 0.0


def end_velocity(real, whole, lane, h):
    """Contact velocity at the end of an implicit step of length h, whose series is written."""
    implicit_stages(real, whole, lane, h)
    implicit_series(real, whole, lane, h)
    velocity_series(real, whole, lane, h)
    return series_value(real, VELOCITY + lane, h)
