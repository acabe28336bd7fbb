"""The contact's side: does it stick, which way does it slide, and what does an event change?

A set-valued law comes to rest where its velocity vanishes; whether it sticks is decided by the force that would hold
it, not by a velocity that is zero, and at every start anew. A kinked law goes on with the other side. A contact starts
to slide with a velocity of which one or more leading coefficients vanish, known here and not left to rounding.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.codes import (
    FIRST_SWITCH,
    GRAZE,
    REVERSAL,
    SLIP_BACK,
    SLIP_FORWARD,
    STICK,
    TOO_MANY_EVENTS,
)
from vibrocap.numerics.kernel.generated.equations import contact_velocity, holding_force, holding_limit
from vibrocap.numerics.kernel.generated.facts import CONTACT_STATE, KINKED, SET_VALUED
from vibrocap.numerics.kernel.generated.lane import (
    ARRIVING,
    CAME_FROM,
    CONTACT_RESIDUAL,
    EVENT_LIMIT,
    EVENTS,
    IDLE,
    PERIOD,
    SCALE,
    SIDE,
    STATE,
    STATUS,
    TIME,
    WORK,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.rows import GUARD, HOLD, LIMIT, VELOCITY
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER, STATES
from vibrocap.numerics.kernel.interface import begin_branch, leave_piece, on_event, stay_in_piece, turned
from vibrocap.numerics.kernel.step.taylor import series_value, taylor_step

DOUBT = 1e-3  # share of the limit by which a holding force known from the slide before may err, with much to spare
JUMP = 1e-6  # share of the growth over a step (or 1e-10 of the force) from which an acceleration is no rounding


def side_holds(floats, ints, trace, lane):
    """Whether the series may be followed: the contact really sticks, or really moves to its side, from here on."""
    side = floats[SIDE + lane]
    if side == 0.0:
        # Asked at every start: where a step ends, the force jumps by the truncation error, perhaps over the limit.
        clear = abs(floats[HOLD + lane]) < (1.0 - 1e-12) * floats[LIMIT + lane]
        if clear and ints[ARRIVING + lane] == 0:
            return True
        return not decide(floats, ints, trace, lane)
    if ints[ZEROS + lane] > 0:
        return leaves(floats, ints, lane)
    if side * floats[VELOCITY + lane] > 0.0:
        return True
    if KINKED and floats[VELOCITY + lane] == 0.0:
        ints[ZEROS + lane] = 1
        if leaves(floats, ints, lane):
            return True
        ints[EVENTS + lane] += 1  # it turned together with another contact, or at a corner of its motion
        on_event(floats, ints, trace, lane, REVERSAL, 0.0)
        return False
    ints[IDLE + lane] += 1  # the velocity passed zero within the rounding of the last step
    cross(floats, ints, trace, lane, 1, 0.0)
    return False


def decide(floats, ints, trace, lane):
    """A contact at rest: stick, or slide on? Returns whether the series must be made anew.

    It sticks if the force needed to hold it is within the limit; at the limit, if that force does not grow beyond it.
    The velocity of a slide starts with one vanishing coefficient more than the excess of that force over the limit.
    """
    initial = ints[ARRIVING + lane] == 1 and floats[CAME_FROM + lane] == 0.0
    ints[ARRIVING + lane] = 0
    h = min(taylor_step(floats, ints, lane), floats[PERIOD + lane])
    slides, direction, zeros = False, 0.0, 0
    for k in range(-1, 2, 2):
        leading = guard_series(floats, lane, k, h)
        if leading < ORDER - 1 and floats[GUARD + leading * LANES + lane] < 0.0:
            slides, direction, zeros = True, float(k), leading + 1
    came_from = floats[CAME_FROM + lane]
    if not slides:
        if came_from != 0.0:
            on_event(floats, ints, trace, lane, STICK, 0.0)
        floats[CAME_FROM + lane] = 0.0
        return False
    floats[SIDE + lane] = direction
    ints[ZEROS + lane] = zeros
    ints[IDLE + lane] += 1
    if came_from == -direction:
        on_event(floats, ints, trace, lane, REVERSAL, 0.0)
    elif came_from == direction:
        on_event(floats, ints, trace, lane, GRAZE, 0.0)
    elif not initial:
        on_event(floats, ints, trace, lane, SLIP_FORWARD if direction > 0.0 else SLIP_BACK, 0.0)
    floats[CAME_FROM + lane] = 0.0
    return True


def leaves(floats, ints, lane):
    """Whether a contact that starts sliding from rest moves to its side; if not, the other side is tried.

    A contact leaves stick without acceleration, unless its law drops from a static to a kinetic level there.
    """
    side = floats[SIDE + lane]
    if ints[ZEROS + lane] == 2:
        growth = abs(floats[VELOCITY + 2 * LANES + lane]) * taylor_step(floats, ints, lane)
        if abs(floats[VELOCITY + LANES + lane]) > JUMP * max(growth, 1e-4 * floats[LIMIT + lane]):
            ints[ZEROS + lane] = 1
    for k in range(ints[ZEROS + lane], ORDER):
        v = floats[VELOCITY + k * LANES + lane]
        if v * side > 0.0:
            return True
        if v != 0.0:
            break
        ints[ZEROS + lane] = min(k + 1, ORDER)
        if k == ORDER - 1:
            return True  # at rest for good: nothing will happen on either side
    ints[IDLE + lane] += 1
    if SET_VALUED:
        floats[CAME_FROM + lane] = side
        floats[SIDE + lane] = 0.0
        ints[ARRIVING + lane] = 1
    else:
        floats[SIDE + lane] = -side
        turned(floats, lane)
    return False


def guard_series(floats, lane, direction, h):
    """Write the series of limit - direction * holding force; returns how many leading coefficients are rounding only.

    A coefficient is rounding where, over the step h, it moves the guard by no more than the rounding of the forces.
    """
    noise = 64.0 * EPSILON * (floats[LIMIT + lane] + abs(floats[HOLD + lane]))
    zeros = 0
    power = 1.0
    for k in range(ORDER):
        guard = floats[LIMIT + k * LANES + lane] - direction * floats[HOLD + k * LANES + lane]
        floats[GUARD + k * LANES + lane] = guard
        if zeros == k and abs(guard) * power <= noise:
            zeros = k + 1
        power *= h
    return zeros


def cross(floats, ints, trace, lane, event, h):
    """Change the mode at the event at which the lane stands now, after a step of length h."""
    ints[EVENTS + lane] += 1
    if ints[EVENTS + lane] > ints[EVENT_LIMIT + lane]:
        ints[STATUS + lane] = TOO_MANY_EVENTS
        return
    leave_piece(floats, ints, lane, event, h)
    if event == 1:
        come_to_rest(floats, ints, lane, h)
        if SET_VALUED:
            rest(floats, ints, trace, lane, h)
        else:
            floats[SIDE + lane] = -floats[SIDE + lane]
            ints[ZEROS + lane] = 1
            turned(floats, lane)
            on_event(floats, ints, trace, lane, REVERSAL, 0.0)
    elif event >= FIRST_SWITCH:
        ints[EVENTS + lane] -= 1  # counted where it happens
        begin_branch(floats, ints, trace, lane, event - FIRST_SWITCH)
    else:
        floats[SIDE + lane] = 1.0 if event > 0 else -1.0
        ints[ZEROS + lane] = 2
        on_event(floats, ints, trace, lane, SLIP_FORWARD if event > 0 else SLIP_BACK, 0.0)


def rest(floats, ints, trace, lane, h):
    """A set-valued contact is at rest, at time h of its series: it sticks or turns back where that is beyond doubt.

    The series of holding force and limit are those of a contact at rest; here it was sliding, so the equations are
    asked.

    Where the force that would hold it is near the limit, `decide` looks at the series of the contact held at rest.
    """
    came_from = floats[SIDE + lane]
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i * LANES + lane]
    hold = holding_force(floats, floats[TIME + lane], WORK, lane)
    limit = holding_limit(floats, floats[TIME + lane], WORK, lane)
    if came_from * hold < -(1.0 + DOUBT) * limit:
        floats[SIDE + lane] = -came_from
        ints[ZEROS + lane] = 1
        on_event(floats, ints, trace, lane, REVERSAL, 0.0)
    elif abs(hold) < (1.0 - DOUBT) * limit:
        floats[SIDE + lane] = 0.0
        on_event(floats, ints, trace, lane, STICK, 0.0)
    else:
        floats[CAME_FROM + lane] = came_from
        floats[SIDE + lane] = 0.0
        ints[ARRIVING + lane] = 1


def jumped(floats, ints, trace, lane):
    """The contact velocity has jumped at one instant, to that of the present state: to which side, if any, now?

    Whatever makes it jump (a corner of an imposed motion, an impact) has set the state, the time and the parameters
    before. A set-valued contact whose velocity is zero to rounding is set to rest, where the force decides, see
    `decide`; one that rested and does not move rests on. A smooth law knows no side.
    """
    if not (SET_VALUED or KINKED):
        return
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i * LANES + lane]
    v = contact_velocity(floats, floats[TIME + lane], WORK, lane)
    contact = CONTACT_STATE * LANES + lane
    before = floats[CAME_FROM + lane] if floats[SIDE + lane] == 0.0 else floats[SIDE + lane]
    rounding = 64.0 * EPSILON * (abs(floats[STATE + contact]) + floats[SCALE + contact])
    ints[ZEROS + lane] = 0
    if SET_VALUED and abs(v) <= rounding:
        if floats[SIDE + lane] != 0.0:
            floats[STATE + contact] -= v
            floats[CAME_FROM + lane] = before
            floats[SIDE + lane] = 0.0
            ints[ARRIVING + lane] = 1
            stay_in_piece(ints, lane)
        return
    floats[CAME_FROM + lane] = 0.0
    ints[ARRIVING + lane] = 0
    if v == 0.0:  # of a kinked law: its rates tell, see `side_holds`
        return
    side = 1.0 if v > 0.0 else -1.0
    if side == floats[SIDE + lane]:
        return
    ints[EVENTS + lane] += 1
    if ints[EVENTS + lane] > ints[EVENT_LIMIT + lane]:
        ints[STATUS + lane] = TOO_MANY_EVENTS
        return
    floats[SIDE + lane] = side
    if not SET_VALUED:
        turned(floats, lane)
    if before == -side:
        on_event(floats, ints, trace, lane, REVERSAL, 0.0)
    elif before == side:
        on_event(floats, ints, trace, lane, GRAZE, 0.0)
    else:
        on_event(floats, ints, trace, lane, SLIP_FORWARD if side > 0.0 else SLIP_BACK, 0.0)


def come_to_rest(floats, ints, lane, h):
    """Set the contact velocity to exactly zero at the end of a step of length h, after noting what it was."""
    v = series_value(floats, VELOCITY + lane, h)
    floats[CONTACT_RESIDUAL + lane] = max(floats[CONTACT_RESIDUAL + lane], abs(v))
    floats[STATE + CONTACT_STATE * LANES + lane] -= v
