"""Choice of the method for laws that can be stiff: whichever, Taylor or implicit, gets further for its cost."""

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
from vibrocap.numerics.roots import EPSILON
from vibrocap.numerics.taylor import series_value, taylor_step

LOOK = 32  # steps between two looks at the choice of method
REST = 256  # steps before the implicit method is tried again after it lost
STABLE = 0.37 * ORDER + 1.0  # about the stability interval of the Taylor method on the negative real axis
IMPLICIT_COST = 6.0  # an implicit step costs about this many Taylor steps (benchmarks)


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
        if explicit * spectral_radius(real, whole, lane) < 0.6 * STABLE:
            return explicit
        whole[STIFF + lane] = 1
        real[EXPLICIT_STEP + lane] = explicit
        real[IMPLICIT_STEP + lane] = IMPLICIT_COST * explicit
    h = implicit_step(real, whole, lane, remaining)
    if whole[PATIENCE + lane] <= 0:
        whole[PATIENCE + lane] = LOOK
        reach = real[IMPLICIT_STEP + lane] / IMPLICIT_COST
        lost = reach < real[EXPLICIT_STEP + lane]
        if lost or reach * spectral_radius(real, whole, lane) < 0.5 * STABLE:
            whole[STIFF + lane] = 0
            whole[PATIENCE + lane] = REST if lost else LOOK
    return h


def polished_step(real, whole, lane, h, longest):
    """(event, length) of an implicit step that ends where the contact velocity vanishes.

    The dense output is less exact than the step, so the step is repeated with the length at which the velocity vanishes
    at its very end (Newton's method within (0, longest]). Where there is no such length the whole step is kept.
    """
    if whole[STIFF + lane] == 0:
        return 1, h
    side = real[SIDE + lane]
    low, high = 0.0, longest
    for _ in range(60):
        implicit_stages(real, whole, lane, h)
        implicit_series(real, whole, lane, h)
        velocity_series(real, whole, lane, h)
        v = side * series_value(real, VELOCITY + lane, h)
        if v > 0.0:
            low = h
        else:
            high = h
        slope = 0.0
        for k in range(4, 0, -1):
            slope = slope * h + side * k * real[VELOCITY + k * LANES + lane]
        following = h - v / slope if slope != 0.0 else low
        if abs(following - h) <= 4.0 * EPSILON * (real[TIME + lane] + h):
            return 1, h
        if not (low < following < high):
            following = 0.5 * (low + high)
        if high - low <= 4.0 * EPSILON * (real[TIME + lane] + h):
            break
        h = following
    implicit_stages(real, whole, lane, longest)
    implicit_series(real, whole, lane, longest)
    velocity_series(real, whole, lane, longest)
    return 0, longest
