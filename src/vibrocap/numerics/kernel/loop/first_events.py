"""The first event of a contact within the steps of all lanes: one search for all contacts and lanes."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, load, max, square_root, where
from vibrocap.numerics.kernel.events.contact import JUMP
from vibrocap.numerics.kernel.generated.equations import guard_at, guard_simd, signs_simd
from vibrocap.numerics.kernel.generated.facts import (
    KINKS,
    LACUNARY,
    LIMIT_CONSTANT,
    MANIFOLDS,
    SEVERAL,
    SHARP,
    SHARP_CONTACT,
    SLOW_CONTACT,
    SLOWED,
    STICKS,
)
from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER
from vibrocap.numerics.kernel.lane import at, lanes
from vibrocap.numerics.kernel.loop.one_step import NEAR
from vibrocap.numerics.kernel.loop.turning_simd import ahead_simd, still_simd
from vibrocap.numerics.kernel.step.side_by_side import resolved_simd
from vibrocap.numerics.kernel.step.taylor import least_of_four

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
            ahead, change = ahead_simd(floats, c, own, stuck, one, two, h)
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
            # As in `one_step.step`: the last stretch is a step of its own.
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
