"""The one step: series, its length, first event, next mode. It serves one recorded motion and many lanes alike.

Each contact of a lane slides (side +1 or -1) or sticks (side 0). Within a mode, the sides of all, every expression is
analytic, and no step crosses a change of side:

    sliding    ends where side * velocity falls to zero. A kinked law goes on with the other side; a set-valued law
               comes to rest, and whether it sticks is decided by the force that would hold it.
    sticking   ends where limit - |holding force| falls to zero; the contact then slides in the direction of that force.

At the start of a slide the velocity is zero by construction, and after a stick its slope is too: the event search is
told how many leading coefficients vanish, so that rounding cannot fake a root there.

A motion begins on a lane with what follows from its states, parameters, natural sizes, time and period; at its end the
sides must be those with which a motion starts that continues it.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, HUGE, SLIGHT, first_root
from vibrocap.numerics.kernel.codes import DONE, GRAZE, NOT_FINITE, PLACE_PASSED, RUNNING, STEP_UNDERFLOW, UNDECIDED
from vibrocap.numerics.kernel.events.contact import (
    DOUBT,
    NO_MOTION,
    cross,
    guard_series,
    moves_by_rounding,
    pin,
    rests_beside,
    sides_hold,
    velocity_rounding,
)
from vibrocap.numerics.kernel.events.transitions import MODE_HOLDS, UNRECORDED, await_decision, settle
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.step.resolved import excursion, forget, resolved
from vibrocap.numerics.kernel.step.taylor import move_to, series_value, sticking_rate, write_state


def start_lane(floats, ints, trace, lane, run):
    """Begin a motion; run: whose table of the drive it follows."""
    lane.period_count = 0
    lane.stiff = 0
    lane.patience = 0
    lane.taylor_steps = 0
    lane.implicit_steps = 0
    lane.events = 0
    lane.zero_progress = 0
    lane.pending = 0
    lane.contact_residual = 0.0
    lane.sticking_rate = sticking_rate(lane.period, ORDER)
    forget(floats, lane)
    if SLOWED:
        for m in range(MANIFOLDS):
            lane.slow[m] = 0.0
            lane.sweeps[m] = 0.0
            lane.wait[m] = 0.0
            lane.pause[m] = 0.0
    hook.begin_drive(floats, ints, trace, lane, run)
    start_sides(floats, ints, lane)


def start_sides(floats, ints, lane):
    """Each contact slides to the side of its velocity; of one at rest the side is to be decided."""
    for c in range(CONTACTS):
        lane.transition[c] = MODE_HOLDS
        lane.gave_way[c] = 0
        lane.came_from[c] = 0.0
        lane.recorded_side[c] = UNRECORDED
        lane.side[c] = 1.0
    for c in range(CONTACTS):
        v = present_velocity(floats, lane, c)
        if not rests_to_rounding(floats, ints, lane, c, v, 1.0):
            lane.side[c] = 1.0 if v > 0.0 else -1.0


def ends_open(floats, ints, lane, h):
    """Whether the sides are to be decided once more at the end of a run, after a step of length h.

    What begins there must find what ends there: a velocity that counts as none at a start is none at an end, a hold
    that gives way at once has given way, a kinked law that has passed rest has turned.
    """
    opens = hook.branch_in_doubt(floats, lane, h)
    for c in range(CONTACTS):
        side = lane.side[c]
        if STICKS[c] == 1 and side == 0.0:
            force = series_value(floats, lane.sticking_force_row[c], h)
            limit = series_value(floats, lane.limit_row[c], h)
            opens = opens or abs(force) >= (1.0 - DOUBT) * limit
        elif STICKS[c] + KINKS[c] > 0 and lane.transition[c] == MODE_HOLDS:
            v = present_velocity(floats, lane, c)
            opens = rests_to_rounding(floats, ints, lane, c, v, 2.0) or opens or side * v < 0.0
            opens = opens or (KINKS[c] == 1 and moves_by_rounding(floats, lane, c, v))
    return opens


def rests_to_rounding(floats, ints, lane, c, v, share):
    """Whether the velocity v of a contact is none but for rounding; it is exactly zero then, and forces decide.

    A smooth law has a force for every velocity, and nothing is to be decided.

    share: of rounding; more at an end than at a start, so that what rests at the start has come to rest at the end
    """
    if v != 0.0 and (STICKS[c] + KINKS[c] == 0 or abs(v) > share * velocity_rounding(floats, lane, c, v)):
        return False
    if v != 0.0 and STICKS[c] == 0 and differs_from_rest(floats, lane, c, v):
        return False
    if not rests_beside(floats, lane, c):
        lane.state[STATE_OF[c]] -= v
    if STICKS[c] == 1:
        await_decision(floats, ints, lane, c)
    else:
        lane.transition[c] = 1
    return True


def differs_from_rest(floats, lane, c, v):
    """Whether friction tells v, the velocity of a contact at the state in WORK, from rest: rock creeps at 1e-11 m/s."""
    side = lane.side[c]
    lane.side[c] = 1.0 if v > 0.0 else -1.0
    rates(floats, lane.time, WORK, lane, WORK + STATES)
    floats[WORK + STATE_OF[c]] -= v
    rates(floats, lane.time, WORK, lane, WORK + 2 * STATES)
    lane.side[c] = side
    moving, still = floats[WORK + STATES + STATE_OF[c]], floats[WORK + 2 * STATES + STATE_OF[c]]
    return abs(moving - still) > SLIGHT * (abs(moving) + abs(still))


def present_velocity(floats, lane, c):
    """Velocity of a contact at the present state and time."""
    write_state(floats, lane, WORK)
    return contact_velocity(floats, lane.time, WORK, c, lane)


# A hold gives way where its series says so to rounding only if that is near the start of the series: the last stretch
# before is a step of its own, of this share of a whole one.
NEAR = 0.03
APPROACHES = 8  # times that an implicit step is made shorter before the event that it would end with
EXPLICIT = -1  # in place of an event: an implicit step is to be made anew, an explicit one
MOST_ZERO_PROGRESS = 12  # decisions in a row without advance, per contact, before one counts as undecided


def step(floats, ints, trace, lane):
    """One step of one lane: its modes hold, its length, the first event within it, the move there, the next mode."""
    if not modes_hold(floats, ints, trace, lane):
        return  # the series must be made anew
    remaining = lane.until - lane.time
    if lane.period_count == lane.whole_periods:
        remaining = min(remaining, lane.tail - lane.time)
    if remaining <= 0.0:
        hook.on_instant(floats, ints, trace, lane)
        turn_period(floats, ints, trace, lane)
        return
    longest = length_of_step(floats, ints, lane, remaining)
    if not (longest > 0.0):
        return
    event, c, h = end_of_step(floats, ints, trace, lane, longest, remaining)
    if event == EXPLICIT:
        return
    if moves_on(floats, ints, trace, lane, event, h):
        next_mode(floats, ints, trace, lane, event, c, h, remaining)


def modes_hold(floats, ints, trace, lane):
    """Whether side and branch of all contacts hold from here on, within the bounds of the equations."""
    if lane.zero_progress > MOST_ZERO_PROGRESS * CONTACTS:
        lane.status = UNDECIDED
        return False
    if not SEVERAL and not hook.within_bounds(floats, ints, trace, lane):
        return False
    if not sides_hold(floats, ints, trace, lane):
        return False
    if SEVERAL and not hook.within_bounds(floats, ints, trace, lane):
        return False  # of the mode that was decided: one that was only tried may have no loads
    if not hook.branch_holds(floats, ints, trace, lane):
        return False
    if hook.tangent_waits(ints, lane):
        hook.enter_piece(floats, ints, lane)
        return False
    return True


def length_of_step(floats, ints, lane, remaining):
    """Length over which the series is as exact as the tolerance; none, 0 or less, where there is no such step."""
    h = hook.step_length(floats, ints, lane, remaining)
    if SEVERAL and h < 0.0:
        return h  # the series must be made anew for a step of the other method
    if not (h > 0.0):
        lane.status = NOT_FINITE if h != h else STEP_UNDERFLOW
        return 0.0
    h = min(h, remaining)
    if h <= 4.0 * EPSILON * lane.time and h < remaining:
        lane.status = STEP_UNDERFLOW
        return 0.0
    while lane.stiff == 0 and not resolved(floats, lane, h):
        h *= 0.5
    return h


def end_of_step(floats, ints, trace, lane, longest, remaining):
    """(event, its contact, length of the step): the first event, or the end; EXPLICIT: the step is to be made anew."""
    event, c, h, touch = first_event(floats, ints, lane, longest)
    # Alone on a slow manifold a step has a series throughout; lanes take implicit steps beside theirs.
    if SEVERAL and not (SLOWED and LANES == 1) and lane.stiff == 1 and (event != 0 or touch >= 0.0):
        for _ in range(APPROACHES):
            h = hook.shorter_step(floats, ints, lane, h if event != 0 else touch)
            if not (h > 0.0):
                return EXPLICIT, 0, h  # so near an event steps are explicit, and its series finds it
            event, c, h, touch = first_event(floats, ints, lane, h)
            if event == 0 and touch < 0.0:
                break
        if event != 0 or touch >= 0.0:
            hook.leave_implicit(ints, lane)
            return EXPLICIT, 0, h
    if 0.0 <= touch < h:
        hook.on_event(floats, ints, trace, lane, GRAZE, c, touch)
    if abs(event) == 2 and h > NEAR * longest:
        event, h = 0, (1.0 - 0.5 * NEAR) * h
    passed = hook.place_passed(floats, ints, lane, h)
    if passed > 0.0:
        event, h = PLACE_PASSED, passed
    if event == 1:
        event, h = hook.polished_step(floats, ints, lane, h, longest)
    elif event >= PLACE_PASSED:
        again = hook.made_again(floats, ints, lane, h)
        event, h = hook.polished_switch(floats, ints, lane, event, h, remaining, again)
    return event, c, h


def moves_on(floats, ints, trace, lane, event, h):
    """Whether the lane moves to the end of the step, told to all that watch it: its states are finite there."""
    hook.on_piece(floats, ints, trace, lane, h)
    hook.watch_load(floats, ints, lane, h)
    if lane.stiff == 0:
        lane.taylor_steps += 1
    else:
        lane.implicit_steps += 1
    move_to(floats, ints, lane, h)
    hook.follow_step(floats, event, h)
    if SHARED:
        pin(floats, lane)
    for i in range(STATES):
        if not (abs(lane.state[i]) <= HUGE):
            lane.status = NOT_FINITE
            return False
    settle(ints, lane)
    lane.zero_progress = 0
    return True


def next_mode(floats, ints, trace, lane, event, c, h, remaining):
    """What holds from the end of the step on: behind its event, and in the next period or beyond a corner."""
    if event == PLACE_PASSED:
        hook.on_place(floats, ints, lane)
    elif event != 0:
        cross(floats, ints, trace, lane, event, c, h)
    if lane.status == RUNNING and remaining - h <= 2.0 * EPSILON * lane.period:
        turn(floats, ints, trace, lane, event, h)


def turn(floats, ints, trace, lane, event, h):
    """What lies beyond a step of length h that went as far as it could: a corner of the drive, a period, the end.

    What happens at the last instant of a run belongs to it: it is decided by a step of no length.
    """
    if hook.at_corner(floats, ints, trace, lane):
        return
    left = lane.whole_periods - lane.period_count
    if left == 0 or (left == 1 and lane.tail <= 0.0):
        opens = ends_open(floats, ints, lane, h) or event != 0
        lane.time = lane.tail if left == 0 else lane.until
        if (left == 1 and hook.drive_goes_over(floats, ints, trace, lane)) or opens:
            return
    turn_period(floats, ints, trace, lane)


def turn_period(floats, ints, trace, lane):
    """Begin the next period, or end the run."""
    if lane.period_count == lane.whole_periods:
        lane.status = DONE
        return
    lane.period_count += 1
    lane.time = 0.0
    lane.events = 0
    hook.begin_drive_period(floats, ints, trace, lane)
    hook.on_period(floats, ints, trace, lane)
    if lane.period_count == lane.whole_periods and lane.tail <= 0.0:
        lane.status = DONE


def first_event(floats, ints, lane, h):
    """First event within the step, its contact, its time, and where a guard only touched zero (-1: nowhere).

    Events: 0: none, 1: velocity zero, +2 or -2: the hold gives way to that side, from FIRST_SWITCH on: a guard of the
    law's pieces or of the equations' bounds.
    """
    event = 0
    contact = 0
    touch = -1.0
    for c in range(CONTACTS):
        if STICKS[c] + KINKS[c] > 0:
            side = lane.side[c]
            if side == 0.0:
                crossed, length, touched = first_release(floats, lane, c, h)
            else:
                crossed, length, touched = first_rest(floats, ints, lane, c, side, h)
            if crossed != 0:
                event, contact, h = crossed, c, length
            if touched >= 0.0 and (touch < 0.0 or touched < touch):
                touch = touched
                if crossed == 0 and event == 0:
                    contact = c
    event, h = hook.first_switch(floats, lane, event, h)
    return event, contact, h, touch


def first_rest(floats, ints, lane, c, side, h):
    """(event, time, touch) of a contact that slides: where its velocity falls to zero."""
    row, vanishing = lane.velocity_row[c], lane.transition[c]
    if SEVERAL and vanishing >= ORDER - 1:
        return 0, h, -1.0
    if SEVERAL and STICKS[c] == 0 and vanishing == 0:
        scale = lane.scale[STATE_OF[c]]
        if abs(floats[row]) + excursion(floats, row, h) <= NO_MOTION * scale:
            return 0, h, -1.0  # at rest to rounding, as the middle one of three that are alike
    root, touch = first_root(floats, row, ORDER, side, vanishing, h)
    if root < 0.0:
        return 0, h, touch
    return 1, root, touch


def first_release(floats, lane, c, h):
    """(event, time, touch) of a contact that sticks: where its hold gives way."""
    force, limit = lane.sticking_force_row[c], lane.limit_row[c]
    event = 0
    earliest = -1.0
    growth = 0.0
    for k in range(ORDER - 1, 0, -1):  # can the force come near the limit at all?
        growth = growth * h + (abs(floats[force + k * LANES]) + abs(floats[limit + k * LANES]))
    if abs(floats[force]) + growth * h < floats[limit]:
        return 0, h, -1.0
    for direction in range(-1, 2, 2):
        vanishing = guard_series(floats, lane, c, direction, h)
        if vanishing > ORDER - 2 or floats[GUARD + vanishing * LANES + lane] < 0.0:
            continue  # `decide` has settled this start
        root, touch = first_root(floats, GUARD + lane, ORDER - 1, 1.0, vanishing, h)
        if touch >= 0.0 and (earliest < 0.0 or touch < earliest):
            earliest = touch
        if root >= 0.0 and (event == 0 or root < h):
            event = 2 * direction
            h = root
    return event, h, earliest
