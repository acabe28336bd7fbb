"""Whether a step of all lanes sees all that the law holds, see `resolved.py`."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, load, store, where
from vibrocap.numerics.kernel.generated import (
    FAR_SPEED,
    KINKED,
    LANES,
    ORDER,
    SAFE_SPEED,
    SET_VALUED,
    SHARP_INTERNAL,
    SPARSE,
    STEP,
    VELOCITY,
    unresolved_abreast,
)
from vibrocap.numerics.kernel.step.resolved import FAINT, FAR_RANGE, excursion, learn
from vibrocap.numerics.kernel.step.taylor_simd import greater, lesser


def excursion_abreast(real, row, h):
    """`resolved.excursion` of all lanes."""
    total = abs(load(real, row + ORDER * LANES))
    for k in range(ORDER - 1, 0, -1):
        total = total * h + abs(load(real, row + k * LANES))
    return total * h


def resolved_abreast(real, side, start, change, h, moving):
    """Lanes whose step of length h sees all that the law holds; `change`: bound of how far the velocity goes.

    moving: the lanes that are asked about
    """
    fine = ~moving
    if not SHARP_INTERNAL:
        fine = fine | (side == 0.0)
    speed = abs(start)
    least, most = speed - change, speed + change
    if not SHARP_INTERNAL:
        fine = fine | known_abreast(real, least, most)
        open_still = bits(~fine)
        if open_still != 0:
            store(real, STEP, h)
            for lane in range(LANES):
                if (open_still >> lane) & 1:
                    length = real[STEP + lane]
                    reach = excursion(real, VELOCITY + lane, length)
                    learn(real, lane, length, abs(real[VELOCITY + lane]) - reach, abs(real[VELOCITY + lane]) + reach)
            fine = fine | known_abreast(real, least, most)
    telling = moving | ~moving
    if SPARSE:
        telling = ~moving | (side == 0.0) | ~(velocity_tail_abreast(real, h) > FAINT * (speed + change))
    if bits(~fine) == 0:
        return fine & telling
    low, high = start - change, start + change
    if KINKED or SET_VALUED:
        low = where(side > 0.0, greater(low, 0.0 * low), low)
        high = where(side < 0.0, lesser(high, 0.0 * high), high)
    return (fine | (unresolved_abreast(real, h, h, start, start, low, high) == 0.0)) & telling


def velocity_tail_abreast(real, h):
    """`resolved.velocity_tail` of the velocity of all lanes."""
    power = h
    for _ in range(ORDER - 2):
        power = power * h
    last, before = load(real, VELOCITY + ORDER * LANES), load(real, VELOCITY + (ORDER - 1) * LANES)
    return (abs(last) * h + abs(before)) * power


def known_abreast(real, least, most):
    """`resolved.known` of all lanes."""
    far = load(real, FAR_SPEED)
    return (most <= load(real, SAFE_SPEED)) | ((least >= far) & (most <= FAR_RANGE * far))
