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
from vibrocap.numerics.kernel.generated import (
    ARRIVING,
    CAME_FROM,
    CONTACT_RESIDUAL,
    CONTACT_STATE,
    EVENT_LIMIT,
    EVENTS,
    GUARD,
    HOLD,
    IDLE,
    KINKED,
    LANES,
    LIMIT,
    ORDER,
    PERIOD,
    SCALE,
    SET_VALUED,
    SIDE,
    STATE,
    STATES,
    STATUS,
    TIME,
    VELOCITY,
    WORK,
    ZEROS,
    contact_velocity,
    holding_force,
    holding_limit,
)
from vibrocap.numerics.kernel.interface import begin_branch, leave_piece, on_event, turned
from vibrocap.numerics.kernel.step.taylor import series_value, taylor_step

DOUBT = 1e-3  # share of the limit by which a holding force known from the slide before may err, with much to spare
JUMP = 1e-6  # share of the growth over a step (or 1e-10 of the force) from which an acceleration is no rounding


def side_holds(real, whole, tape, lane):
    """Whether the series may be followed: the contact really sticks, or really moves to its side, from here on."""
    side = real[SIDE + lane]
    if side == 0.0:
        # Asked at every start: where a step ends, the force jumps by the truncation error, perhaps over the limit.
        clear = abs(real[HOLD + lane]) < (1.0 - 1e-12) * real[LIMIT + lane]
        if clear and whole[ARRIVING + lane] == 0:
            return True
        return not decide(real, whole, tape, lane)
    if whole[ZEROS + lane] > 0:
        return leaves(real, whole, lane)
    if side * real[VELOCITY + lane] > 0.0:
        return True
    if KINKED and real[VELOCITY + lane] == 0.0:
        whole[ZEROS + lane] = 1
        return leaves(real, whole, lane)
    whole[IDLE + lane] += 1  # the velocity passed zero within the rounding of the last step
    cross(real, whole, tape, lane, 1, 0.0)
    return False


def decide(real, whole, tape, lane):
    """A contact at rest: stick, or slide on? Returns whether the series must be made anew.

    It sticks if the force needed to hold it is within the limit; at the limit, if that force does not grow beyond it.
    The velocity of a slide starts with one vanishing coefficient more than the excess of that force over the limit.
    """
    initial = whole[ARRIVING + lane] == 1 and real[CAME_FROM + lane] == 0.0
    whole[ARRIVING + lane] = 0
    h = min(taylor_step(real, whole, lane), real[PERIOD + lane])
    slides, direction, zeros = False, 0.0, 0
    for k in range(-1, 2, 2):
        leading = guard_series(real, lane, k, h)
        if leading < ORDER - 1 and real[GUARD + leading * LANES + lane] < 0.0:
            slides, direction, zeros = True, float(k), leading + 1
    came_from = real[CAME_FROM + lane]
    if not slides:
        if came_from != 0.0:
            on_event(real, whole, tape, lane, STICK, 0.0)
        real[CAME_FROM + lane] = 0.0
        return False
    real[SIDE + lane] = direction
    whole[ZEROS + lane] = zeros
    whole[IDLE + lane] += 1
    if came_from == -direction:
        on_event(real, whole, tape, lane, REVERSAL, 0.0)
    elif came_from == direction:
        on_event(real, whole, tape, lane, GRAZE, 0.0)
    elif not initial:
        on_event(real, whole, tape, lane, SLIP_FORWARD if direction > 0.0 else SLIP_BACK, 0.0)
    real[CAME_FROM + lane] = 0.0
    return True


def leaves(real, whole, lane):
    """Whether a contact that starts sliding from rest moves to its side; if not, the other side is tried.

    A contact leaves stick without acceleration, unless its law drops from a static to a kinetic level there.
    """
    side = real[SIDE + lane]
    if whole[ZEROS + lane] == 2:
        growth = abs(real[VELOCITY + 2 * LANES + lane]) * taylor_step(real, whole, lane)
        if abs(real[VELOCITY + LANES + lane]) > JUMP * max(growth, 1e-4 * real[LIMIT + lane]):
            whole[ZEROS + lane] = 1
    for k in range(whole[ZEROS + lane], ORDER):
        v = real[VELOCITY + k * LANES + lane]
        if v * side > 0.0:
            return True
        if v != 0.0:
            break
        whole[ZEROS + lane] = min(k + 1, ORDER)
        if k == ORDER - 1:
            return True  # at rest for good: nothing will happen on either side
    whole[IDLE + lane] += 1
    if SET_VALUED:
        real[CAME_FROM + lane] = side
        real[SIDE + lane] = 0.0
        whole[ARRIVING + lane] = 1
    else:
        real[SIDE + lane] = -side
        turned(real, lane)
    return False


def guard_series(real, lane, direction, h):
    """Write the series of limit - direction * holding force; returns how many leading coefficients are rounding only.

    A coefficient is rounding where, over the step h, it moves the guard by no more than the rounding of the forces.
    """
    noise = 64.0 * EPSILON * (real[LIMIT + lane] + abs(real[HOLD + lane]))
    zeros = 0
    power = 1.0
    for k in range(ORDER):
        guard = real[LIMIT + k * LANES + lane] - direction * real[HOLD + k * LANES + lane]
        real[GUARD + k * LANES + lane] = guard
        if zeros == k and abs(guard) * power <= noise:
            zeros = k + 1
        power *= h
    return zeros


def cross(real, whole, tape, lane, event, h):
    """Change the mode at the event at which the lane stands now, after a step of length h."""
    whole[EVENTS + lane] += 1
    if whole[EVENTS + lane] > whole[EVENT_LIMIT + lane]:
        whole[STATUS + lane] = TOO_MANY_EVENTS
        return
    leave_piece(real, whole, lane, event, h)
    if event == 1:
        come_to_rest(real, whole, lane, h)
        if SET_VALUED:
            rest(real, whole, tape, lane, h)
        else:
            real[SIDE + lane] = -real[SIDE + lane]
            whole[ZEROS + lane] = 1
            turned(real, lane)
            on_event(real, whole, tape, lane, REVERSAL, 0.0)
    elif event >= FIRST_SWITCH:
        whole[EVENTS + lane] -= 1  # counted where it happens
        begin_branch(real, whole, tape, lane, event - FIRST_SWITCH)
    else:
        real[SIDE + lane] = 1.0 if event > 0 else -1.0
        whole[ZEROS + lane] = 2
        on_event(real, whole, tape, lane, SLIP_FORWARD if event > 0 else SLIP_BACK, 0.0)


def rest(real, whole, tape, lane, h):
    """A set-valued contact is at rest, at time h of its series: it sticks or turns back where that is beyond doubt.

    The series of holding force and limit are those of a contact at rest; here it was sliding, so the equations are
    asked.

    Where the force that would hold it is near the limit, `decide` looks at the series of the contact held at rest.
    """
    came_from = real[SIDE + lane]
    for i in range(STATES):
        real[WORK + i] = real[STATE + i * LANES + lane]
    hold = holding_force(real, real[TIME + lane], WORK, lane)
    limit = holding_limit(real, real[TIME + lane], WORK, lane)
    if came_from * hold < -(1.0 + DOUBT) * limit:
        real[SIDE + lane] = -came_from
        whole[ZEROS + lane] = 1
        on_event(real, whole, tape, lane, REVERSAL, 0.0)
    elif abs(hold) < (1.0 - DOUBT) * limit:
        real[SIDE + lane] = 0.0
        on_event(real, whole, tape, lane, STICK, 0.0)
    else:
        real[CAME_FROM + lane] = came_from
        real[SIDE + lane] = 0.0
        whole[ARRIVING + lane] = 1


def jumped(real, whole, tape, lane):
    """The contact velocity has jumped at one instant, to that of the present state: to which side, if any, now?

    Whatever makes it jump (a corner of an imposed motion, an impact) has set the state, the time and the parameters
    before. A set-valued contact whose velocity is zero to rounding is set to rest, where the force decides, see
    `decide`; one that rested and does not move rests on. A smooth law knows no side.
    """
    if not (SET_VALUED or KINKED):
        return
    for i in range(STATES):
        real[WORK + i] = real[STATE + i * LANES + lane]
    v = contact_velocity(real, real[TIME + lane], WORK, lane)
    contact = CONTACT_STATE * LANES + lane
    before = real[CAME_FROM + lane] if real[SIDE + lane] == 0.0 else real[SIDE + lane]
    rounding = 64.0 * EPSILON * (abs(real[STATE + contact]) + real[SCALE + contact])
    whole[ZEROS + lane] = 0
    if SET_VALUED and abs(v) <= rounding:
        if real[SIDE + lane] != 0.0:
            real[STATE + contact] -= v
            real[CAME_FROM + lane] = before
            real[SIDE + lane] = 0.0
            whole[ARRIVING + lane] = 1
        return
    real[CAME_FROM + lane] = 0.0
    whole[ARRIVING + lane] = 0
    if v == 0.0:  # of a kinked law: its rates tell, see `side_holds`
        return
    side = 1.0 if v > 0.0 else -1.0
    if side == real[SIDE + lane]:
        return
    whole[EVENTS + lane] += 1
    if whole[EVENTS + lane] > whole[EVENT_LIMIT + lane]:
        whole[STATUS + lane] = TOO_MANY_EVENTS
        return
    real[SIDE + lane] = side
    if not SET_VALUED:
        turned(real, lane)
    if before == -side:
        on_event(real, whole, tape, lane, REVERSAL, 0.0)
    elif before == side:
        on_event(real, whole, tape, lane, GRAZE, 0.0)
    else:
        on_event(real, whole, tape, lane, SLIP_FORWARD if side > 0.0 else SLIP_BACK, 0.0)


def come_to_rest(real, whole, lane, h):
    """Set the contact velocity to exactly zero at the end of a step of length h, after noting what it was."""
    v = series_value(real, VELOCITY + lane, h)
    real[CONTACT_RESIDUAL + lane] = max(real[CONTACT_RESIDUAL + lane], abs(v))
    real[STATE + CONTACT_STATE * LANES + lane] -= v
