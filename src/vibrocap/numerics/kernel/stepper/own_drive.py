"""Passing to an instant with the case's own drive: by steps of the kernel's own choice, the last reaching beyond it.

The instant is read from the series of that step, so that the motion does not depend on where it is looked at. What
happens later within the step waits until the clock has come to it.
"""

from vibrocap.numerics.kernel.arithmetic.roots import polynomial_value
from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated.lane import (
    IMPLICIT_STEPS,
    PARAMETER,
    PERIOD,
    PERIOD_COUNT,
    SERIES,
    SIDE,
    SIDE_TOLD,
    STATE,
    STATUS,
    STIFF,
    TAYLOR_STEPS,
    TIME,
)
from vibrocap.numerics.kernel.generated.sizes import COEFFICIENTS, CONTACTS, ORDER, PRESENT, STATES
from vibrocap.numerics.kernel.generated.stepper import (
    CLOCK,
    ENDED,
    PIECE_CLOCK,
    PIECE_LENGTH,
    PIECE_SEGMENT,
    PIECE_STIFF,
    PIECE_TIME,
    STOPPED,
    WAITING,
    WAITING_CONTACT,
    WAITING_EVENTS,
    WAITING_KIND,
    WAITING_TIME,
)
from vibrocap.numerics.kernel.stepper.clock import go_on, set_clock
from vibrocap.numerics.kernel.stepper.event_counts import count_event


def time_reached(floats, ints):
    """The end of the last step, beyond the clock."""
    return ints[PERIOD_COUNT] * floats[PERIOD] + floats[TIME]


def set_out(floats, ints, trace, length):
    """The clock goes on, and the steps after it."""
    go_on(floats, length)


def under_way(floats, ints):
    """Whether the last step does not yet reach beyond the clock."""
    return time_reached(floats, ints) <= floats[CLOCK]


def come_in(floats, ints, trace, length):
    """The clock stands at the instant that was asked for, at an event before, or where the motion ended."""
    if ints[STOPPED] == 1:
        set_clock(floats, floats[PIECE_CLOCK])
    elif ints[STATUS] != RUNNING and time_reached(floats, ints) <= floats[CLOCK]:
        set_clock(floats, time_reached(floats, ints))
        ints[ENDED] = ints[STATUS]
    waiting = ints[WAITING_EVENTS]
    left = 0
    for i in range(waiting):
        kind, contact, time = ints[WAITING_KIND + i], ints[WAITING_CONTACT + i], floats[WAITING_TIME + i]
        if time <= floats[CLOCK]:
            count_event(floats, ints, kind, contact, time)
        else:
            ints[WAITING_KIND + left], ints[WAITING_CONTACT + left], floats[WAITING_TIME + left] = kind, contact, time
            left += 1
    ints[WAITING_EVENTS] = left


def keep_piece(floats, ints, trace, h):
    """A step of length h begins; what was told before is past."""
    floats[PIECE_CLOCK], floats[PIECE_TIME], floats[PIECE_LENGTH] = time_reached(floats, ints), floats[TIME], h
    ints[PIECE_STIFF] = ints[STIFF]
    if COEFFICIENTS > 0:
        for i in range(COEFFICIENTS + 2):
            floats[PIECE_SEGMENT + i] = floats[PARAMETER + PRESENT + i]
    for i in range(ints[WAITING_EVENTS]):
        count_event(floats, ints, ints[WAITING_KIND + i], ints[WAITING_CONTACT + i], floats[WAITING_TIME + i])
    ints[WAITING_EVENTS] = 0


def keep_event(floats, ints, kind, contact, s):
    """An event waits until the clock has come to it. There is room for all that can happen at one instant."""
    place = ints[WAITING_EVENTS]
    if place < WAITING:
        ints[WAITING_KIND + place], ints[WAITING_CONTACT + place] = kind, contact
        floats[WAITING_TIME + place] = ints[PERIOD_COUNT] * floats[PERIOD] + (floats[TIME] + s)
        ints[WAITING_EVENTS] = place + 1


def within_step(floats, ints):
    """Whether the clock stands within a step whose series is in memory."""
    return ints[ENDED] == RUNNING and ints[TAYLOR_STEPS] + ints[IMPLICIT_STEPS] > 0


def show_instant(floats, ints, point):
    """Put the step in place in which the clock stands, and its state there to `point`; the time since it began.

    What is in place then changes places with that of the lane, and does so again when this is called again.
    """
    if not within_step(floats, ints):
        for i in range(STATES):
            floats[point + i] = floats[STATE + i]
        return 0.0
    s = floats[CLOCK] - floats[PIECE_CLOCK]
    for i in range(STATES):
        floats[point + i] = polynomial_value(floats, SERIES + i * (ORDER + 1), 1, ORDER, s)
    time, stiff = floats[TIME], ints[STIFF]
    floats[TIME], ints[STIFF] = floats[PIECE_TIME], ints[PIECE_STIFF]
    floats[PIECE_TIME], ints[PIECE_STIFF] = time, stiff
    for c in range(CONTACTS):
        side = floats[SIDE + c]
        floats[SIDE + c] = floats[SIDE_TOLD + c]
        floats[SIDE_TOLD + c] = side
    if COEFFICIENTS > 0:
        for i in range(COEFFICIENTS + 2):
            number = floats[PARAMETER + PRESENT + i]
            floats[PARAMETER + PRESENT + i] = floats[PIECE_SEGMENT + i]
            floats[PIECE_SEGMENT + i] = number
    return s


def side_shown(floats, ints, contact):
    """Side of a contact (0: the first) at the clock."""
    return floats[SIDE_TOLD + contact] if within_step(floats, ints) else floats[SIDE + contact]
