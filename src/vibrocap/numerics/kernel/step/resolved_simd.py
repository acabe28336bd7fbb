"""Whether a step of all lanes sees all that the law holds, see `resolved.py`."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, load, square_root, store, where
from vibrocap.numerics.kernel.generated.ensemble import STEP
from vibrocap.numerics.kernel.generated.equations import unresolved_simd
from vibrocap.numerics.kernel.generated.facts import (
    CONTACT_STATE,
    GAPS,
    KINKED,
    LACUNARY,
    ROUGH,
    SET_VALUED,
    SHARP_INTERNAL,
)
from vibrocap.numerics.kernel.generated.lane import FAR_SPEED, SAFE_SPEED, SCALE, TOLERANCE
from vibrocap.numerics.kernel.generated.rows import VELOCITY
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER
from vibrocap.numerics.kernel.step.resolved import FAINT, FAR_RANGE, LEAVING, excursion, learn
from vibrocap.numerics.kernel.step.taylor_simd import greater, lesser


def excursion_simd(floats, row, h):
    """`resolved.excursion` of all lanes."""
    total = abs(load(floats, row + ORDER * LANES))
    for k in range(ORDER - 1, 0, -1):
        total = total * h + abs(load(floats, row + k * LANES))
    return total * h


def resolved_simd(floats, side, start, change, h, moving):
    """Lanes whose step of length h sees all that the law holds; `change`: bound of how far the velocity goes.

    moving: the lanes that are asked about
    """
    fine = ~moving
    if not SHARP_INTERNAL:
        fine = fine | (side == 0.0)
    speed = abs(start)
    least, most = speed - change, speed + change
    resting = speed <= FAINT * change
    if not SHARP_INTERNAL:
        fine = fine | asked_before(floats, resting, least, most)
        open_still = bits(~fine)
        if open_still != 0:
            store(floats, STEP, h)
            for lane in range(LANES):
                if (open_still >> lane) & 1:
                    length = floats[STEP + lane]
                    reach = excursion(floats, VELOCITY + lane, length)
                    learn(
                        floats, lane, length, abs(floats[VELOCITY + lane]) - reach, abs(floats[VELOCITY + lane]) + reach
                    )
            fine = fine | asked_before(floats, resting, least, most)
    telling = moving | ~moving
    if LACUNARY:
        least, tail = FAINT * most, velocity_tail_simd(floats, VELOCITY, h)
        if ROUGH:  # as `resolved.faint`
            tail = tail + where(resting, velocity_tail_simd(floats, VELOCITY - 2 * LANES, h) / (h * h), 0.0)
            scale = load(floats, SCALE + CONTACT_STATE * LANES)
            least = lesser(least, LEAVING * load(floats, TOLERANCE) * square_root(most * scale))
        telling = ~moving | (side == 0.0) | ~(tail > least)
    if bits(~fine) == 0:
        return fine & telling
    low, high = start - change, start + change
    if KINKED or SET_VALUED:
        low = where(side > 0.0, greater(low, 0.0 * low), low)
        high = where(side < 0.0, lesser(high, 0.0 * high), high)
    return (fine | (unresolved_simd(floats, h, h, start, start, low, high) == 0.0)) & telling


def velocity_tail_simd(floats, row, h):
    """`resolved.velocity_tail` of all lanes."""
    power = h
    for _ in range(ORDER - 2):
        power = power * h
    last, before = load(floats, row + ORDER * LANES), load(floats, row + (ORDER - 1) * LANES)
    return (abs(last) * h + abs(before)) * power


def asked_before(floats, resting, least, most):
    """`known_simd`, but for starts from rest of a law whose series has gaps there."""
    known = known_simd(floats, least, most)
    return known & ~resting if GAPS else known


def known_simd(floats, least, most):
    """`resolved.known` of all lanes."""
    far = load(floats, FAR_SPEED)
    return (most <= load(floats, SAFE_SPEED)) | ((least >= far) & (most <= FAR_RANGE * far))
