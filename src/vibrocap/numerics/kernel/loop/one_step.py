"""The one step: series, its length, first event, next mode. It serves one recorded motion and many lanes alike.

Each contact of a lane slides (side +1 or -1) or sticks (side 0). Within a mode, the sides of all, every expression is
analytic, and no step crosses a change of side:

    sliding    ends where side * velocity falls to zero. A kinked law goes on with the other side; a set-valued law
               comes to rest, and whether it sticks is decided by the force that would hold it.
    sticking   ends where limit - |holding force| falls to zero; the contact then slides in the direction of that force.

At the start of a slide the velocity is zero by construction, and after a stick its slope is too: the event search is
told how many leading coefficients vanish, so that rounding cannot fake a root there.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, HUGE, first_root
from vibrocap.numerics.kernel.codes import DONE, GRAZE, NOT_FINITE, PLACE_PASSED, RUNNING, STEP_UNDERFLOW, UNDECIDED
from vibrocap.numerics.kernel.events.contact import NO_MOTION, cross, guard_series, pin, sides_hold
from vibrocap.numerics.kernel.events.transitions import settle
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.loop.start import ends_open
from vibrocap.numerics.kernel.step.resolved import excursion, resolved
from vibrocap.numerics.kernel.step.taylor import move_to

# A hold gives way where its series says so to rounding only if that is near the start of the series: the last stretch
# before is a step of its own, of this share of a whole one.
NEAR = 0.03
APPROACHES = 8  # times that an implicit step is made shorter before the event that it would end with
MOST_ZERO_PROGRESS = 12  # decisions in a row without advance, per contact, before one counts as undecided


def step(floats, ints, trace, lane):
    """One step of one lane: choose the side if it is open, step to the first event or the end of the step."""
    if lane.zero_progress > MOST_ZERO_PROGRESS * CONTACTS:
        lane.status = UNDECIDED
        return
    if not SEVERAL and not hook.within_bounds(floats, ints, trace, lane):
        return
    if not sides_hold(floats, ints, trace, lane):
        return  # the series must be made anew for other sides
    if SEVERAL and not hook.within_bounds(floats, ints, trace, lane):
        return  # of the mode that was decided: one that was only tried may have no loads
    if not hook.branch_holds(floats, ints, trace, lane):
        return
    if hook.tangent_waits(ints, lane):
        hook.enter_piece(floats, ints, lane)
        return
    remaining = lane.until - lane.time
    if lane.period_count == lane.whole_periods:
        remaining = min(remaining, lane.tail - lane.time)
    if remaining <= 0.0:
        hook.on_instant(floats, ints, trace, lane)
        turn_period(floats, ints, trace, lane)
        return
    h = hook.step_length(floats, ints, lane, remaining)
    if SEVERAL and h < 0.0:
        return  # the series must be made anew for a step of the other method
    if not (h > 0.0):
        lane.status = NOT_FINITE if h != h else STEP_UNDERFLOW
        return
    h = min(h, remaining)
    if h <= 4.0 * EPSILON * lane.time and h < remaining:
        lane.status = STEP_UNDERFLOW
        return
    while lane.stiff == 0 and not resolved(floats, lane, h):
        h *= 0.5
    longest = h
    event, c, h, touch = first_event(floats, ints, lane, h)
    # Alone on a slow manifold a step has a series throughout; lanes take implicit steps beside theirs.
    if SEVERAL and not (SLOWED and LANES == 1) and lane.stiff == 1 and (event != 0 or touch >= 0.0):
        for _ in range(APPROACHES):
            h = hook.shorter_step(floats, ints, lane, h if event != 0 else touch)
            if not (h > 0.0):
                return  # so near an event steps are explicit, and its series finds it
            event, c, h, touch = first_event(floats, ints, lane, h)
            if event == 0 and touch < 0.0:
                break
        if event != 0 or touch >= 0.0:
            hook.leave_implicit(ints, lane)
            return
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
        event, h = hook.repeated_step(floats, ints, lane, event, h)
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
            return
    settle(ints, lane)
    lane.zero_progress = 0
    if event == PLACE_PASSED:
        hook.on_place(floats, ints, lane)
    elif event != 0:
        cross(floats, ints, trace, lane, event, c, h)
    if lane.status != RUNNING:
        return
    if remaining - h <= 2.0 * EPSILON * lane.period:
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
