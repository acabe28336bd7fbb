"""Whether contacts turn within a step of all lanes, or are too near rest to tell."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import all_lanes, bits, floor, load, where
from vibrocap.numerics.kernel.events.contact import NO_MOTION
from vibrocap.numerics.kernel.generated.facts import (
    MANIFOLDS,
    PLACE,
    PLACE_TURN,
    SHARP,
    SHARP_CONTACT,
    SLOW_CONTACT,
    SLOW_STATE,
    STATE_OF,
)
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER
from vibrocap.numerics.kernel.lane import at, lanes
from vibrocap.numerics.kernel.step.resolved import excursion
from vibrocap.numerics.kernel.step.side_by_side import resolved_simd
from vibrocap.numerics.kernel.step.slow_manifold import CUT
from vibrocap.numerics.kernel.step.taylor import least_of_four, series_value, sign_in_doubt

CUTS = 6  # of steps on a slow manifold


def still_simd(floats, ints, c, h):
    """Where one of several contacts is at rest to rounding over the step, as the middle one of three that are alike.

    As `one_step.first_rest`: it does not turn.
    """
    every = all_lanes()
    row = at.velocity_row[c]
    reach = abs(load(floats, row)) + excursion(floats, row + every, h)
    return (reach <= NO_MOTION * lanes.scale[STATE_OF[c]]) & (lanes.transition[c] == 0)


def out_of_doubt(floats, c, slow, h):
    """Step lengths within which the sign of a velocity is not in doubt, of lanes on a slow manifold; cut a few times.

    The long steps of the others make much of the rounding of one that is at rest to rounding.
    """
    for _ in range(CUTS):
        doubtful = slow & sign_in_doubt(floats, c, all_lanes(), h)
        if bits(doubtful) == 0:
            break
        h = where(doubtful, CUT * h, h)
    return h


def before_turning(floats, slow, h):
    """Step lengths within which contacts on a slow manifold do not turn and laws are resolved; cut a few times."""
    for _ in range(CUTS):
        fine = slow | ~slow
        for m in range(MANIFOLDS):
            if SLOW_STATE[m] >= 0:
                c = SLOW_CONTACT[m]
                off = ~(lanes.slow[m] > 0.0)
                none = off & ~off
                side = lanes.side[c]
                ahead, change = ahead_simd(floats, c, side, none, none, none, h)
                fine = fine & (off | ahead)
                if SHARP and c == SHARP_CONTACT:
                    fine = fine & resolved_simd(floats, side, lanes.velocity[c], change, h, slow)
        fine = fine | ~slow
        if bits(~fine) == 0:
            break
        h = where(fine, h, CUT * h)
    return h


def ahead_simd(floats, c, side, stuck, one, two, h):
    """Of contact c (where a slide lasts the step beyond doubt, bound of how far its velocity goes).

    It lasts where the velocity's first four terms stay above the sum of all others.
    """
    velocity = at.velocity_row[c]
    others = abs(load(floats, velocity + ORDER * LANES))
    for k in range(ORDER - 1, 5, -1):
        others = others * h + abs(load(floats, velocity + k * LANES))
    v1, v2, v3 = load(floats, velocity + LANES), load(floats, velocity + 2 * LANES), load(floats, velocity + 3 * LANES)
    v4, v5 = load(floats, velocity + 4 * LANES), load(floats, velocity + 5 * LANES)
    after_five = others * h + abs(v5)
    after_four = after_five * h + abs(v4)
    change = (((after_four * h + abs(v3)) * h + abs(v2)) * h + abs(v1)) * h
    others = where(two, others, where(one, after_five, after_four))
    first = side * where(two, v2, where(one, v1, load(floats, velocity)))
    second = side * where(two, v3, where(one, v2, v1)) * h
    third = side * where(two, v4, where(one, v3, v2)) * h * h
    fourth = (side * where(two, v5, where(one, v4, v3)) - others * h) * h * h * h
    return (least_of_four(first, second, third, fourth) > 0.0) & ~stuck, change


def passing_simd(floats, h):
    """Where the place of returns may be passed within the step, see `observe/returns.py`."""
    every = all_lanes()
    row = at.row[PLACE]
    if PLACE_TURN > 0.0:
        return floor(load(floats, row) / PLACE_TURN) != floor(series_value(floats, row + every, h) / PLACE_TURN)
    rate = 0.0 * h
    for k in range(ORDER, 0, -1):
        rate = rate * h + k * load(floats, row + k * LANES)
    return (load(floats, row + LANES) > 0.0) & ~(rate > 0.0)
