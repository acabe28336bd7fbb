"""The sides of the contacts: who sticks, who slides which way, and what does an event change?

A set-valued law comes to rest where its velocity vanishes; whether it sticks is decided by the force that would hold
it, not by a velocity that is zero, and at every start anew. A kinked law goes on with the other side. A contact starts
to slide with a velocity of which one or more leading coefficients vanish, known here and not left to rounding.

Of several contacts all that are at rest at one instant are decided together (`decision.py`); what forces alone leave
open is decided here, contact by contact, as it is of one alone.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, SLIGHT, vanishing_order
from vibrocap.numerics.kernel.codes import FIRST_SWITCH, GRAZE
from vibrocap.numerics.kernel.events.transitions import (
    MODE_HOLDS,
    TIED,
    arrive,
    await_decision,
    give_way,
    open_arrivals,
    slide,
    too_many_events,
)
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import alone
from vibrocap.numerics.kernel.step.resolved import excursion
from vibrocap.numerics.kernel.step.taylor import STABLE, series_value, taylor_step, write_state

DOUBT = 1e-3  # share of the limit by which a holding force known from the step before may err, with much to spare
JUMP = 1e-6  # share of the growth over a step (or 1e-10 of the force) from which an acceleration is no rounding
NO_MOTION = 16.0 * EPSILON  # of the natural speed: rounding, where other contacts move the body as well
ROUNDINGS = 64.0  # of a state, or of the time, that add up in a motion
BEYOND = 1e-9  # of its limit: by so much the force on a contact at rest exceeds it only where something has jumped


def sides_hold(floats, ints, trace, lane):
    """Whether the series may be followed: every contact really sticks, or really moves to its side, from here on."""
    if SEVERAL:
        for c in range(CONTACTS):  # the forces on those that rest depend on the sides of these
            if STICKS[c] == 0 and KINKS[c] == 1 and not side_holds(floats, ints, trace, lane, c):
                return False
        if SHARED:
            part(floats, ints, lane)
        if open_still(floats, ints, lane):
            lane.zero_progress += 1
            hook.decide_together(floats, ints, lane)
            return False
    for c in range(CONTACTS):
        asked = STICKS[c] == 1 or (not SEVERAL and KINKS[c] == 1)
        if asked and not side_holds(floats, ints, trace, lane, c):
            return False
    return True


def part(floats, ints, lane):
    """Contacts that rest together move apart where their distance begins to change, however slowly."""
    for c in range(CONTACTS):
        if lane.transition[c] == TIED:
            vanishing = beyond_rounding(floats, ints, lane, c)
            if vanishing < ORDER:
                lane.transition[c] = TIED - vanishing


def open_still(floats, ints, lane):
    """Whether it is to be decided again which of several contacts rest: one has come to rest, or is forced beyond."""
    for c in range(CONTACTS):
        sticks = STICKS[c] == 1 and lane.side[c] == 0.0 and lane.transition[c] == MODE_HOLDS
        if sticks and abs(lane.sticking_force[c]) > (1.0 + BEYOND) * lane.limit[c]:
            await_decision(floats, ints, lane, c)
    return open_arrivals(ints, lane)


def side_holds(floats, ints, trace, lane, c):
    """Whether contact c really sticks, or really moves to its side."""
    side, velocity = lane.side[c], lane.velocity[c]
    if side == 0.0:
        # Asked at every start: where a step ends, the force jumps by the truncation error, perhaps over the limit.
        clear = abs(lane.sticking_force[c]) < (1.0 - 1e-12) * lane.limit[c]
        return (clear and lane.transition[c] == MODE_HOLDS) or not decide(floats, ints, trace, lane, c)
    if lane.transition[c] > 0:
        return leaves(floats, ints, lane, c)
    if KINKS[c] == 1 and moves_by_rounding(floats, lane, c, velocity):
        lane.transition[c] = 1
        if leaves(floats, ints, lane, c):
            return True
        lane.events += 1  # it turned together with another contact, or at a corner of its motion
        return False
    if side * velocity > 0.0:
        return True
    lane.zero_progress += 1  # the velocity passed zero within the rounding of the last step
    cross(floats, ints, trace, lane, 1, c, 0.0)
    return False


def moves_by_rounding(floats, lane, c, v):
    """Whether the velocity v of a kinked contact is too small to tell its side: the force that moves it does."""
    return abs(v) <= (NO_MOTION * lane.scale[STATE_OF[c]] if SEVERAL else 0.0)


def beyond_rounding(floats, ints, lane, c):
    """How many leading coefficients of a velocity, one of several, move it by rounding only over an explicit step."""
    h = min(taylor_step(floats, ints, lane), lane.period)
    if SLOWED and LANES == 1:  # one on manifolds of others is longer
        for m in range(MANIFOLDS):
            rate = max(alone.decay_rate, alone.own_decay[m] * alone.slow[m])
            h = min(h, STABLE / rate) if rate > 0.0 else h
    least = SLIGHT * lane.scale[STATE_OF[c]]
    return vanishing_order(floats, lane.velocity_row[c], h, least)


def decide(floats, ints, trace, lane, c):
    """A contact at rest: stick, or slide on? Returns whether the series must be made anew.

    It sticks if the force needed to hold it is within the limit; at the limit, if that force does not grow beyond it.
    The velocity of a slide starts with one vanishing coefficient more than the excess of that force over the limit.
    """
    lane.transition[c] = MODE_HOLDS
    h = min(taylor_step(floats, ints, lane), lane.period)
    direction, vanishing = 0.0, 0
    for k in range(-1, 2, 2):
        leading = guard_series(floats, lane, c, k, h)
        if leading < ORDER - 1 and floats[GUARD + leading * LANES + lane] < 0.0:
            direction, vanishing = float(k), leading + 1
    came_from = lane.came_from[c]
    lane.came_from[c] = 0.0
    if direction == 0.0:
        return False
    give_way(floats, ints, lane, c, direction, vanishing)
    lane.zero_progress += 1
    if came_from == direction:
        hook.on_event(floats, ints, trace, lane, GRAZE, c, 0.0)
    return True


def leaves(floats, ints, lane, c):
    """Whether a contact that starts sliding from rest moves to its side; if not, the other side is tried.

    A contact leaves stick without acceleration, unless its law drops from a static to a kinetic level there.
    """
    side, row = lane.side[c], lane.velocity_row[c]
    if lane.transition[c] == 2:
        growth = abs(floats[row + 2 * LANES]) * taylor_step(floats, ints, lane)
        if abs(floats[row + LANES]) > JUMP * max(growth, 1e-4 * lane.limit[c]):
            lane.transition[c] = 1
    if lane.transition[c] == ORDER:
        lane.transition[c] = 1  # it rested for good when it was last asked
    first = lane.transition[c]
    if SEVERAL and STICKS[c] == 0:
        lane.transition[c] = 1  # what else vanished may have done so while another contact rested
        first = max(1, beyond_rounding(floats, ints, lane, c))
        if first >= ORDER and hook.way_out(floats, lane, c) == side:
            lane.transition[c] = ORDER
            return True  # at rest to rounding, as the middle one of three that are alike
    for k in range(first, ORDER):
        v = floats[row + k * LANES]
        if v * side > 0.0:
            return True
        if v != 0.0:
            break
        lane.transition[c] = min(k + 1, ORDER)
        if k == ORDER - 1 and (STICKS[c] == 1 or hook.way_out(floats, lane, c) == side):
            return True  # at rest for good: nothing will happen on either side
    lane.zero_progress += 1
    if STICKS[c] == 1:
        arrive(floats, ints, lane, c)
    else:
        lane.side[c] = -side
        hook.turned(floats, lane, c)
    return False


def guard_series(floats, lane, c, direction, h):
    """Write the series of limit - direction * holding force; returns how many leading coefficients are rounding only.

    A coefficient is rounding where, over the step h, it moves the guard by no more than the rounding of the forces.
    """
    force, limit = lane.sticking_force_row[c], lane.limit_row[c]
    noise = ROUNDINGS * EPSILON * (floats[limit] + abs(floats[force]))
    for k in range(ORDER):
        floats[GUARD + k * LANES + lane] = floats[limit + k * LANES] - direction * floats[force + k * LANES]
    return vanishing_order(floats, GUARD + lane, h, noise)


def cross(floats, ints, trace, lane, event, c, h):
    """Change the mode at the event of contact c at which the lane stands now, after a step of length h."""
    if too_many_events(ints, lane):
        return
    hook.note_event(floats, ints, lane, event, c)
    hook.leave_piece(floats, ints, lane, event, c, h)
    if event == 1:
        if SEVERAL:
            meet(floats, ints, lane, c, h)
        else:
            come_to_rest(floats, ints, lane, c, h)
            if STICKS[c] == 1:
                rest(floats, ints, lane)
            else:
                turn_round(floats, ints, lane, c)
        hook.on_return(floats, ints, lane)
    elif event >= FIRST_SWITCH:
        lane.events -= 1  # counted where it happens
        hook.begin_branch(floats, ints, trace, lane, event - FIRST_SWITCH)
    else:
        if SEVERAL:
            give_way_together(floats, ints, lane, h)
        slide(floats, ints, lane, c, 1.0 if event > 0 else -1.0, 2)


def turn_round(floats, ints, lane, c):
    """A contact with a force for every velocity goes on to the other side."""
    slide(floats, ints, lane, c, -lane.side[c], 1)
    hook.turned(floats, lane, c)


def meet(floats, ints, lane, c, h):
    """One of several contacts is at rest, at time h of its series, perhaps with others: all are decided together."""
    came = STICKS[c] == 1
    come_to_rest(floats, ints, lane, c, h)
    if came:
        arrive(floats, ints, lane, c)
    else:
        turn_round(floats, ints, lane, c)
    for d in range(CONTACTS):
        if d != c and STICKS[d] == 1 and lane.side[d] != 0.0:
            row = lane.velocity_row[d]
            size = abs(floats[row]) + excursion(floats, row, h) + lane.scale[STATE_OF[d]]
            if abs(series_value(floats, row, h)) <= SLIGHT * size:
                come_to_rest(floats, ints, lane, d, h)
                arrive(floats, ints, lane, d)
                came = True
    if came:
        hook.decide_together(floats, ints, lane)


def give_way_together(floats, ints, lane, h):
    """All contacts at rest whose forces are at their limits at time h of the series give way there."""
    for d in range(CONTACTS):
        if STICKS[d] == 1 and lane.side[d] == 0.0:
            force = series_value(floats, lane.sticking_force_row[d], h)
            limit = series_value(floats, lane.limit_row[d], h)
            if limit - abs(force) <= SLIGHT * limit:
                give_way(floats, ints, lane, d, 1.0 if force > 0.0 else -1.0, 2)


def rest(floats, ints, lane):
    """A set-valued contact alone is at rest: it sticks or turns back where that is beyond doubt.

    The series of holding force and limit are those of a contact at rest; here it was sliding, so the equations are
    asked. Where that force is near the limit, `decide` looks at the series of the contact held at rest.
    """
    came_from = lane.side
    write_state(floats, lane, WORK)
    holding(floats, lane.time, WORK, lane, WORK + STATES)
    force, limit = floats[WORK + STATES], floats[WORK + STATES + 1]
    if came_from * force < -(1.0 + DOUBT) * limit:
        slide(floats, ints, lane, 0, -came_from, 1)
    elif abs(force) < (1.0 - DOUBT) * limit:
        lane.side = 0.0
    else:
        arrive(floats, ints, lane, 0)


def jumped(floats, ints, trace, lane):
    """Velocities have jumped at one instant, to those of the present state: to which sides, if any, now?

    Whatever makes them jump (a corner of an imposed motion, an impact) has set the state, the time and the parameters
    before. A set-valued contact whose velocity is zero to rounding is set to rest, where the force decides, see
    `decide`; one that rested and does not move rests on, but of several all are asked again. A smooth law has no side.
    """
    write_state(floats, lane, WORK)
    for c in range(CONTACTS):
        if STICKS[c] + KINKS[c] > 0:
            v = contact_velocity(floats, lane.time, WORK, c, lane)
            jumped_to(floats, ints, trace, lane, c, v)
    if SEVERAL and open_arrivals(ints, lane):
        hook.decide_together(floats, ints, lane)


def jumped_to(floats, ints, trace, lane, c, v):
    """The velocity of contact c has jumped to v."""
    if lane.transition[c] > 0:
        lane.transition[c] = MODE_HOLDS
    if STICKS[c] == 1 and abs(v) <= velocity_rounding(floats, lane, c, v):
        if lane.side[c] != 0.0:
            if not rests_beside(floats, lane, c):
                lane.state[STATE_OF[c]] -= v
            arrive(floats, ints, lane, c)
            hook.stay_in_piece(ints, lane)
        elif SEVERAL:
            await_decision(floats, ints, lane, c)
        return
    lane.came_from[c] = 0.0
    lane.transition[c] = MODE_HOLDS
    if v == 0.0:  # of a kinked law: its rates tell, see `side_holds`
        return
    side = 1.0 if v > 0.0 else -1.0
    if side == lane.side[c]:
        return
    if too_many_events(ints, lane):
        return
    lane.side[c] = side
    if STICKS[c] == 0:
        hook.turned(floats, lane, c)


def velocity_rounding(floats, lane, c, v):
    """By how much v, the velocity of a contact at the state in WORK, may be rounding: of its state, and of the time."""
    later = lane.time + ROUNDINGS * EPSILON * lane.period
    size = abs(lane.state[STATE_OF[c]]) + lane.scale[STATE_OF[c]]
    return ROUNDINGS * EPSILON * size + abs(contact_velocity(floats, later, WORK, c, lane) - v)


def come_to_rest(floats, ints, lane, c, h):
    """Set a contact velocity to exactly zero at the end of a step of length h, after noting what it was."""
    v = series_value(floats, lane.velocity_row[c], h)
    lane.contact_residual = max(lane.contact_residual, abs(v))
    if not rests_beside(floats, lane, c):
        lane.state[STATE_OF[c]] -= v


def rests_beside(floats, lane, c):
    """Whether another contact rests by the same state, which can make only one velocity exactly zero."""
    if SHARED:
        for d in range(CONTACTS):
            if d != c and STICKS[d] == 1 and STATE_OF[d] == STATE_OF[c] and lane.side[d] == 0.0:
                return True
    return False


def pin(floats, lane):
    """Where a contact at imposed distances rests, the state that all share is exactly what that says.

    Integrated, it would drift by the tolerance, and contacts that pass rest at one instant would do so one by one.
    """
    for c in range(CONTACTS):
        if STICKS[c] == 1 and lane.side[c] == 0.0:
            write_state(floats, lane, WORK)
            lane.state[STATE_OF[c]] -= contact_velocity(floats, lane.time, WORK, c, lane)
            return
