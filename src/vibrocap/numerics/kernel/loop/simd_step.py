"""One step of all lanes at once: side by side where a step is plain, one by one where it takes decisions.

Every lane has a step, a mode and events of its own. What all lanes share is arithmetic: the series, the length of the
step, the proof that no event lies within it or the root where one does, and the state at its end. A lane on which more
is to be decided than that takes `one_step.step`, like a single motion; the others would do the same there.
"""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import (
    align_stack,
    bits,
    load,
    square_root,
    store,
    where,
    whole_above,
    whole_add,
    whole_equal,
    whole_reached,
    whole_set,
)
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.codes import NOT_FINITE, RUNNING, TOO_MANY_STEPS
from vibrocap.numerics.kernel.events.contact import JUMP, cross
from vibrocap.numerics.kernel.generated.branches import (
    BRANCHES,
    LOCATED,
    SIDES_AT_REST,
    SIDES_COUNT,
    SWITCH,
    SWITCHES,
    TURNING,
)
from vibrocap.numerics.kernel.generated.ensemble import LIFTED, STEP, STEP_LIMIT, WINDOW_START
from vibrocap.numerics.kernel.generated.equations import guard_at, guard_simd, jet
from vibrocap.numerics.kernel.generated.facts import (
    KINKED,
    LIMIT_CONSTANT,
    MAYBE_STIFF,
    SET_VALUED,
    SEVERAL,
    SHARP,
    SPARSE,
    WATCHED,
)
from vibrocap.numerics.kernel.generated.lane import (
    ARRIVING,
    DAMPED_STEP,
    DECAY_RATE,
    IDLE,
    IMPLICIT_STEPS,
    PATIENCE,
    PERIOD,
    SERIES,
    SIDE,
    STATE,
    STATUS,
    STIFF,
    TAYLOR_STEPS,
    TIME,
    TOLERANCE,
    UNTIL,
    WORK,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.rows import HOLD, LIMIT, REACTION, VELOCITY
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER, ROWS
from vibrocap.numerics.kernel.interface import look_at_load, on_piece, tangents_wait
from vibrocap.numerics.kernel.loop.one_step import NEAR, step, turn
from vibrocap.numerics.kernel.step.resolved_simd import excursion_simd, resolved_simd
from vibrocap.numerics.kernel.step.stabilised_simd import stabilised_steps
from vibrocap.numerics.kernel.step.taylor import GENTLE, series_value
from vibrocap.numerics.kernel.step.taylor_simd import greater, least_of_cubic, lesser, series_values, taylor_steps

NEWTON = 1e-9  # of the root: after a Newton step so short the error is its square, below rounding


def advance(floats, ints, trace, rounds):
    """Advance all running lanes by up to `rounds` steps, or until the first of them stops."""
    running = whole_equal(ints, STATUS, RUNNING)
    all_running = bits(running)
    for _ in range(rounds):
        jet(floats)
        waiting = all_running ^ step_simd(floats, ints, trace, running)
        if waiting != 0:
            for lane in range(LANES):
                if (waiting >> lane) & 1:
                    step(floats, ints, trace, lane)
        running = whole_equal(ints, STATUS, RUNNING)
        over = running & whole_reached(ints, TAYLOR_STEPS, IMPLICIT_STEPS, STEP_LIMIT)
        whole_set(ints, STATUS, TOO_MANY_STEPS, over)
        if bits(running & ~over) != all_running:
            return


def step_simd(floats, ints, trace, running):
    """One step of all lanes on which it is plain; returns these lanes, as bits."""
    align_stack()
    side = load(floats, SIDE)
    period = load(floats, PERIOD)
    remaining = load(floats, UNTIL) - load(floats, TIME)
    longest, last, before, clear = taylor_steps(floats, side)
    start = load(floats, VELOCITY)
    moving = running
    damped = running & ~running
    if KINKED:
        change = abs(load(floats, VELOCITY + LANES)) * longest
        moving = running & (0.1 * (abs(start) + change) >= load(floats, TOLERANCE))
    if MAYBE_STIFF:  # as in `stabilised.series_step`; a lane whose method is to be chosen anew is not plain
        rate = load(floats, DECAY_RATE)
        gentle = ~(rate * longest > GENTLE) & (ORDER * last * longest < GENTLE * before)
        gentle = gentle | whole_above(ints, ZEROS, 0) | (longest >= remaining)
        moving = moving & whole_equal(ints, STIFF, 0) & (gentle | whole_above(ints, PATIENCE, 1))
        if SEVERAL:
            moving = moving & (gentle | ~rest_simd(floats, side))
        longest, damped = stabilised_steps(floats, rate, longest, moving & ~gentle)
    h = lesser(longest, remaining)
    plain = moving & (h > 0.0) & ((h > 4.0 * EPSILON * period) | (h >= remaining))
    plain = plain & ~whole_above(ints, ZEROS, 2) & whole_equal(ints, ARRIVING, 0)
    plain = tangents_wait(ints, plain)
    for i in range(BRANCHES):
        row = SWITCH + i * (ORDER + 1) * LANES
        plain = plain & within_piece(floats, row, h)
        if SEVERAL and TURNING[i] >= 0:
            change = abs(load(floats, row + LANES)) * longest
            plain = plain & (0.1 * (abs(load(floats, row)) + change) >= load(floats, TOLERANCE))
    if BRANCHES < SWITCHES and bits(plain & ~clear) != 0:
        for i in range(BRANCHES, SWITCHES):
            row = SWITCH + i * (ORDER + 1) * LANES
            holds = load(floats, row) > 0.0
            if LOCATED[i] == 1:
                holds = within_piece(floats, row, h)
            plain = plain & (clear | holds)
    event = plain & ~plain
    if KINKED or SET_VALUED:
        one = whole_equal(ints, ZEROS, 1)
        two = whole_equal(ints, ZEROS, 2)
        if SPARSE:
            plain = plain & ~two
        stuck = event
        push = side
        if SET_VALUED:
            stuck = side == 0.0
            push, sure = hold_simd(floats, stuck, two, longest, h)
            plain = plain & sure
        ahead, change = ahead_simd(floats, side, stuck, one, two, h)
        if SHARP:
            plain = plain & resolved_simd(floats, side, start, change, h, plain)
        clear = ~plain | ahead
        if bits(~clear) != 0:
            leading, last, changes = guard_simd(floats, side, stuck, push, one, two, h)
            plain = plain & (clear | ((leading > 0.0) & (changes <= 1.0)))
            event = plain & ~clear & (changes == 1.0)
            if bits(event) != 0:
                root = root_simd(floats, leading, last, event)
                early = event & stuck & (root > NEAR)  # as in `one_step.step`: the last stretch is a step of its own
                h = where(event, h * root, h)
                h = where(early, (1.0 - 0.5 * NEAR) * h, h)
                event = event & ~early
    elif SHARP:
        plain = plain & resolved_simd(floats, side, start, excursion_simd(floats, VELOCITY, h), h, plain)
    end = series_values(floats, VELOCITY, h)
    if MAYBE_STIFF:
        store(floats, DAMPED_STEP, where(damped & ~plain, longest, 0.0))
    move_simd(floats, ints, trace, plain, h, end)
    finish_simd(floats, ints, trace, bits(plain & event), bits(plain & (remaining - h <= 2.0 * EPSILON * period)))
    return bits(plain)


def within_piece(floats, row, h):
    """Where a guard stays positive over the step beyond doubt, so that its branch lasts; or the true load does.

    As in `ahead_simd`: the Bernstein coefficients of its first four terms are a bound from below, less the sum of
    all others, which is largest at the end of the step.
    """
    others = abs(load(floats, row + (ORDER - 1) * LANES))
    if SEVERAL:  # the last coefficient is one of velocities only, but for a slope that makes the bound no smaller
        others = others + abs(load(floats, row + ORDER * LANES)) * h
    for k in range(ORDER - 2, 3, -1):
        others = others * h + abs(load(floats, row + k * LANES))
    return least_of_cubic(floats, row, others, h) > 0.0


def rest_simd(floats, side):
    """Where a contact sticks, of several."""
    rests = side == 0.0
    for i in range(SIDES_COUNT):
        rests = rests | (load(floats, STATE + SIDES_AT_REST[i] * LANES) == 0.0)
    return rests


def ahead_simd(floats, side, stuck, one, two, h):
    """(where a slide lasts the step beyond doubt, bound of how far its velocity goes).

    It lasts where the velocity's first four terms stay above the sum of all others. As Bernstein coefficients those
    four are a bound from below, see `roots.py`.
    """
    others = abs(load(floats, VELOCITY + ORDER * LANES))
    for k in range(ORDER - 1, 5, -1):
        others = others * h + abs(load(floats, VELOCITY + k * LANES))
    v1, v2, v3 = load(floats, VELOCITY + LANES), load(floats, VELOCITY + 2 * LANES), load(floats, VELOCITY + 3 * LANES)
    v4, v5 = load(floats, VELOCITY + 4 * LANES), load(floats, VELOCITY + 5 * LANES)
    after_five = others * h + abs(v5)
    after_four = after_five * h + abs(v4)
    change = (((after_four * h + abs(v3)) * h + abs(v2)) * h + abs(v1)) * h
    others = where(two, others, where(one, after_five, after_four))
    first = side * where(two, v2, where(one, v1, load(floats, VELOCITY)))
    second = side * where(two, v3, where(one, v2, v1)) * h
    third = side * where(two, v4, where(one, v3, v2)) * h * h
    fourth = (side * where(two, v5, where(one, v4, v3)) - others * h) * h * h * h
    third = third * (1.0 / 3.0)
    early = first + second * (1.0 / 3.0)
    late = early + (second * (1.0 / 3.0) + third)
    least = lesser(lesser(first, early), lesser(late, first + second + 3.0 * third + fourth))
    return (least > 0.0) & ~stuck, change


def hold_simd(floats, stuck, two, longest, h):
    """(direction in which a stuck contact is pushed, where nothing but a slip to that side need be looked for)."""
    limit = load(floats, LIMIT)
    hold = load(floats, HOLD)
    growth = 0.0 * h
    change = 0.0 * h
    for k in range(ORDER - 1, 0, -1):
        force = load(floats, HOLD + k * LANES)
        term = abs(force)
        if not LIMIT_CONSTANT:
            term = term + abs(load(floats, LIMIT + k * LANES))
        growth = growth * h + term
        change = change * h + force
    push = where(hold + 0.5 * h * change > 0.0, 1.0, -1.0)
    sure = (abs(hold) < (1.0 - 1e-12) * limit) & (limit + push * hold > growth * h)
    # A contact that starts with an acceleration, though it left stick, has dropped from static to kinetic friction.
    threshold = greater(abs(load(floats, VELOCITY + 2 * LANES)) * longest, 1e-4 * limit)
    steady = ~two | (abs(load(floats, VELOCITY + LANES)) <= JUMP * threshold)
    return push, where(stuck, where(sure, 1.0, 0.0), where(steady, 1.0, 0.0)) > 0.0


def root_simd(floats, first, last, wanted):
    """The root of the polynomial in WORK, over the unit interval, in the lanes that have one there.

    first, last: its values at both ends. As `roots.polished_root`: Newton's method, kept inside the bracket by halving,
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


def move_simd(floats, ints, trace, plain, h, end):
    """Put the lanes at the ends of their steps, with the contact velocity `end`, after the hook for measuring saw the
    pieces."""
    store(floats, STEP, h)
    measured = plain & whole_above(ints, WINDOW_START, -1)
    measuring = bits(measured)
    if measuring != 0:
        for lane in range(LANES):
            if (measuring >> lane) & 1:
                on_piece(floats, ints, trace, lane, floats[STEP + lane])
        if WATCHED:
            doubtful = bits(measured & (load(floats, LIFTED) == 0.0) & ~within_piece(floats, REACTION, h))
            if doubtful != 0:
                for lane in range(LANES):
                    if (doubtful >> lane) & 1:
                        look_at_load(floats, ints, lane, floats[STEP + lane])
    finite = plain
    for i in range(ROWS):
        row = SERIES + i * (ORDER + 1) * LANES
        following = end if row == VELOCITY else series_values(floats, row, h)
        finite = finite & (abs(following) <= 1e300)
        store(floats, STATE + i * LANES, where(plain, following, load(floats, STATE + i * LANES)))
    time = load(floats, TIME)
    store(floats, TIME, where(plain, time + h, time))
    whole_set(ints, STATUS, NOT_FINITE, plain & ~finite)
    whole_set(ints, ZEROS, 0, plain)
    whole_set(ints, IDLE, 0, plain)
    whole_add(ints, TAYLOR_STEPS, 1, plain)
    if MAYBE_STIFF:
        whole_add(ints, PATIENCE, -1, plain)


def finish_simd(floats, ints, trace, events, turns):
    """What follows a step: the contact comes to rest or slips, a segment of the drive or the period is over."""
    both = events | turns
    if both == 0:
        return
    for lane in range(LANES):
        if (both >> lane) & 1 and ints[STATUS + lane] == RUNNING:
            if (events >> lane) & 1:
                event = 1
                if floats[SIDE + lane] == 0.0:
                    event = 2 if series_value(floats, HOLD + lane, floats[STEP + lane]) > 0.0 else -2
                cross(floats, ints, trace, lane, event, floats[STEP + lane])
            if (turns >> lane) & 1:
                turn(floats, ints, trace, lane)
