"""The step of all lanes at once: its length, and whether it sees all that the law holds."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import all_lanes, bits, max, min, store, where
from vibrocap.numerics.kernel.arithmetic.roots import HUGE
from vibrocap.numerics.kernel.generated.branches import BRANCHES, LOCATED, SWITCHES
from vibrocap.numerics.kernel.generated.equations import unresolved
from vibrocap.numerics.kernel.generated.facts import GAPS, KINKS, SHARP_CONTACT, SHARP_INTERNAL, STICKS
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER
from vibrocap.numerics.kernel.lane import at, every_lane, lanes
from vibrocap.numerics.kernel.step.resolved import FAINT, excursion, known, learn
from vibrocap.numerics.kernel.step.taylor import (
    clear_of_bounds,
    holding_terms,
    last_terms,
    reach,
    rough_logarithm,
    series_length,
)


def taylor_steps(floats):
    """(`taylor.taylor_step`, last term, last but one, where no bound is near) of all lanes.

    The step is 0 where a coefficient is too large.
    """
    every = all_lanes()
    last, before = last_terms(floats, every)
    last, before = holding_terms(floats, every, last, before)
    h, newest = series_length(floats, every, last, before)
    clear = clear_of_bounds(floats, every, h)
    if BRANCHES < SWITCHES and bits(~clear) != 0:
        wanted = rough_logarithm(lanes.tolerance)
        for i in range(BRANCHES, SWITCHES):
            if LOCATED[i] == 1:
                row = at.guard_row[i] + every
                bound = min(h, reach(wanted, abs(floats[row + (ORDER - 1) * LANES]), ORDER - 1))
                bound = min(bound, reach(wanted, abs(floats[row + (ORDER - 2) * LANES]), ORDER - 2))
                h = where(clear, h, bound)
    return where(newest <= HUGE, h, 0.0), last, before, clear


def resolved_simd(floats, side, start, change, h, moving):
    """Lanes whose step of length h sees all that the law holds; `change`: bound of how far the velocity goes.

    moving: the lanes that are asked about
    """
    every = all_lanes()
    fine = ~moving
    speed = abs(start)
    least, most = speed - change, speed + change
    resting = speed <= FAINT * change
    if not SHARP_INTERNAL:
        fine = fine | (side == 0.0) | known_lanes(floats, resting, least, most)
        open_still = bits(~fine)
        if open_still != 0:
            store(floats, at.step, h)
            for lane in every_lane():
                if (open_still >> lane) & 1:
                    length = lane.step
                    reached = excursion(floats, lane.velocity_row[SHARP_CONTACT], length)
                    own = abs(lane.velocity[SHARP_CONTACT])
                    learn(floats, lane, length, own - reached, own + reached)
            fine = fine | known_lanes(floats, resting, least, most)
    if bits(~fine) == 0:
        return fine
    low, high = start - change, start + change
    if STICKS[SHARP_CONTACT] + KINKS[SHARP_CONTACT] > 0:
        low = where(side > 0.0, max(low, 0.0), low)
        high = where(side < 0.0, min(high, 0.0), high)
    return fine | (unresolved(floats, every, h, h, start, start, low, high, 0.0) == 0.0)


def known_lanes(floats, resting, least, most):
    """Where nothing can hide (`resolved.known`), but for starts from rest of a law whose series has gaps there."""
    asked = known(floats, all_lanes(), least, most)
    return asked & ~resting if GAPS else asked
