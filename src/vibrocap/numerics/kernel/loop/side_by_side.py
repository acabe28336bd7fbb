"""The steps of all lanes at once: how long they are, whether they see all that the law holds, where an event ends them.

Contacts that turn within a step, or are too near rest to tell, and one search for the first events of all contacts and
lanes.
"""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import (
    all_lanes,
    bits,
    floor,
    load,
    max,
    min,
    square_root,
    store,
    where,
)
from vibrocap.numerics.kernel.arithmetic.roots import HUGE
from vibrocap.numerics.kernel.events.contact import JUMP, NO_MOTION
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at, every_lane, lanes
from vibrocap.numerics.kernel.loop.one_step import NEAR
from vibrocap.numerics.kernel.step.resolved import FAINT, excursion, known, learn
from vibrocap.numerics.kernel.step.slow_manifold import CUT
from vibrocap.numerics.kernel.step.taylor import (
    clear_of_bounds,
    holding_terms,
    last_terms,
    least_of_four,
    reach,
    rough_logarithm,
    series_length,
    series_value,
    sign_in_doubt,
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
                ahead, change = ahead_simd(floats, c, side, none, none, h)
                fine = fine & (off | ahead)
                if SHARP and c == SHARP_CONTACT:
                    fine = fine & resolved_simd(floats, side, lanes.velocity[c], change, h, slow)
        fine = fine | ~slow
        if bits(~fine) == 0:
            break
        h = where(fine, h, CUT * h)
    return h


def ahead_simd(floats, c, side, one, two, h):
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
    return least_of_four(first, second, third, fourth) > 0.0, change


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


NEWTON = 1e-9  # of the root: after a Newton step so short the error is its square, below rounding


def first_events(floats, ints, plain, slow, longest, h):
    """(lanes that remain plain, lengths of their steps, in which of them an event ends the step, of which contact).

    In each lane the first contact of which more is to be known than a bound has its guard looked at, in all lanes
    together; again where a further contact has such a guard over what is then the step.
    """
    none = plain & ~plain
    event = none
    which = 0.0 * h
    again, looked, waiting = plain, which - 1.0, -1
    for _ in range(CONTACTS):
        searched, sticking, later, contacts, waiting = none, none, none, waiting, 0
        for c in range(CONTACTS):
            asked = again & (looked < 1.0 * c) if SEVERAL else again
            if STICKS[c] + KINKS[c] == 0 or (contacts >> c) & 1 == 0:
                continue
            own = lanes.side[c]
            one = lanes.transition[c] == 1
            two = lanes.transition[c] == 2
            if LACUNARY:
                plain = plain & ~two
            stuck, direction, fine, stays = none, own, ~none, none
            if STICKS[c] == 1:
                stuck = own == 0.0
                if bits(again & (stuck | two)) != 0:
                    direction, fine, stays = sticking_simd(floats, c, stuck, two, longest, h)
            ahead, change = ahead_simd(floats, c, own, one, two, h)
            ahead = ahead & ~stuck
            if SEVERAL and KINKS[c] == 1 and bits(plain & ~ahead) != 0:
                ahead = ahead | still_simd(floats, ints, c, h)
            for m in range(MANIFOLDS):
                if SLOWED and SLOW_CONTACT[m] == c:
                    fine = fine & (ahead | ~(lanes.slow[m] > 0.0))
            if SHARP and c == SHARP_CONTACT:
                fine = fine & resolved_simd(floats, own, lanes.velocity[c], change, h, plain & fine)
            ahead = ahead | stays
            if SEVERAL:
                open_still = asked & searched & ~(ahead & fine)
                later = later | open_still
                waiting += (1 << c) if bits(open_still) != 0 else 0
                asked = asked & ~searched
            plain = plain & (fine | ~asked)
            asked = asked & plain & ~ahead
            if bits(asked) != 0:
                guard_simd(floats, asked, c, own, stuck, direction, one, two, h)
                searched = searched | asked
                sticking = sticking | (asked & stuck)
                looked = where(asked, 1.0 * c, looked)
        if bits(searched) == 0:
            break
        leading, last, changes = signs_simd(floats)
        plain = plain & (~searched | ((leading > 0.0) & (changes <= 1.0)))
        sure = plain & searched & (changes == 1.0)
        if bits(sure) != 0:
            root = root_simd(floats, leading, last, sure)
            # As in `one_step.end_of_step`: the last stretch is a step of its own.
            early = sure & sticking & (root > NEAR)
            h = where(sure, h * root, h)
            h = where(early, (1.0 - 0.5 * NEAR) * h, h)
            which = where(sure, looked, which)
            event = (event & ~sure) | (sure & ~early)
        again = later & plain
        if bits(again) == 0:
            break
    return plain, h, event, which


def sticking_simd(floats, c, stuck, two, longest, h):
    """(direction in which a stuck contact is pushed, where nothing but a slip to that side need be looked for, where it
    stays beyond doubt)."""
    limit = lanes.limit[c]
    sticking_force = lanes.sticking_force[c]
    growth = 0.0 * h
    change = 0.0 * h
    for k in range(ORDER - 1, 0, -1):
        force = load(floats, at.sticking_force_row[c] + k * LANES)
        term = abs(force)
        if not LIMIT_CONSTANT:
            term = term + abs(load(floats, at.limit_row[c] + k * LANES))
        growth = growth * h + term
        change = change * h + force
    direction = where(sticking_force + 0.5 * h * change > 0.0, 1.0, -1.0)
    below_limit = abs(sticking_force) < (1.0 - 1e-12) * limit
    sure = below_limit & (limit + direction * sticking_force > growth * h)
    if bits(stuck & below_limit & ~sure) != 0:
        sure = sure | (below_limit & (least_of_guard(floats, c, direction, h) > 0.0))
    # A contact that starts with an acceleration, though it left stick, has dropped from static to kinetic friction.
    threshold = max(1e-4 * limit, abs(load(floats, at.velocity_row[c] + 2 * LANES)) * longest)
    steady = ~two | (abs(load(floats, at.velocity_row[c] + LANES)) <= JUMP * threshold)
    fine = where(stuck, where(sure, 1.0, 0.0), where(steady, 1.0, 0.0)) > 0.0
    return direction, fine, stuck & (limit - abs(sticking_force) > growth * h)


def least_of_guard(floats, c, direction, h):
    """A bound from below of limit + direction * sticking_force over the step, as `taylor.least_of_cubic`."""
    force, limit = at.sticking_force_row[c], at.limit_row[c]
    others = 0.0 * h
    for k in range(ORDER - 1, 3, -1):
        others = others * h + abs(load(floats, limit + k * LANES) + direction * load(floats, force + k * LANES))
    first = load(floats, limit) + direction * load(floats, force)
    second = (load(floats, limit + LANES) + direction * load(floats, force + LANES)) * h
    third = (load(floats, limit + 2 * LANES) + direction * load(floats, force + 2 * LANES)) * h * h
    fourth = load(floats, limit + 3 * LANES) + direction * load(floats, force + 3 * LANES)
    return least_of_four(first, second, third, (fourth - others * h) * h * h * h)


def root_simd(floats, first, last, wanted):
    """The root of the polynomial in WORK, over the unit interval, in the lanes that have one there.

    first, last: its values at both ends. As `roots.bracketed_root`, Newton's method kept inside the bracket by halving,
    from the root of the parabola with the same ends and the same slope at the start.
    """
    slope = load(floats, WORK + LANES)
    x = 2.0 * first / (square_root(slope * slope - 4.0 * first * (last - first - slope)) - slope)
    low = 0.0 * x
    high = low + 1.0
    x = where((x > 0.0) & (x < 1.0), x, 0.5)
    for _ in range(80):
        y, d = guard_at(floats, x)
        above = y > 0.0
        low = where(above, x, low)
        high = where(above, high, x)
        following = x - y / d
        done = abs(following - x) <= NEWTON * x
        inside = (low < following) & (following < high)
        halved = 0.5 * (low + high)
        closed = ~done & ~inside & ((halved == low) | (halved == high))
        following = where(inside | done, following, where(closed, high, halved))
        x = where(wanted, following, x)
        wanted = wanted & ~done & ~closed
        if bits(wanted) == 0:
            break
    return x
