"""Passing to an instant with the case's own drive: by steps of the kernel's own choice, the last reaching beyond it.

The instant is read from the series of that step, so that the motion does not depend on where it is looked at. What
happens later within the step waits until the clock has come to it.
"""

from vibrocap.numerics.kernel.arithmetic.roots import value_and_rate
from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import alone, stepper
from vibrocap.numerics.kernel.loop.stepper import count_event, go_on, set_clock


def time_reached(floats, ints):
    """The end of the last step, beyond the clock."""
    return stepper.period_count * stepper.period + stepper.time


def set_out(floats, ints, trace, length):
    """The clock goes on, and the steps after it."""
    go_on(floats, length)


def under_way(floats, ints):
    """Whether the last step does not yet reach beyond the clock."""
    return time_reached(floats, ints) <= stepper.clock


def come_in(floats, ints, trace, length):
    """The clock stands at the instant that was asked for, at an event before, or where the motion ended."""
    if stepper.stopped == 1:
        set_clock(floats, stepper.piece_clock)
    elif stepper.status != RUNNING and time_reached(floats, ints) <= stepper.clock:
        set_clock(floats, time_reached(floats, ints))
        stepper.ended = stepper.status
    waiting = stepper.waiting_events
    left = 0
    for i in range(waiting):
        kind, contact, time = stepper.waiting_kind[i], stepper.waiting_contact[i], stepper.waiting_time[i]
        if time <= stepper.clock:
            count_event(floats, ints, kind, contact, time)
        else:
            stepper.waiting_kind[left], stepper.waiting_contact[left], stepper.waiting_time[left] = kind, contact, time
            left += 1
    stepper.waiting_events = left


def keep_piece(floats, ints, trace, h):
    """A step of length h begins; what was told before is past."""
    stepper.piece_clock, stepper.piece_time, stepper.piece_length = time_reached(floats, ints), stepper.time, h
    stepper.piece_stiff = stepper.stiff
    if COEFFICIENTS > 0:
        for i in range(COEFFICIENTS + 2):
            stepper.piece_segment[i] = stepper.parameter[PRESENT + i]
    for i in range(stepper.waiting_events):
        count_event(floats, ints, stepper.waiting_kind[i], stepper.waiting_contact[i], stepper.waiting_time[i])
    stepper.waiting_events = 0


def keep_event(floats, ints, kind, contact, s):
    """An event waits until the clock has come to it. There is room for all that can happen at one instant."""
    place = stepper.waiting_events
    if place < WAITING:
        stepper.waiting_kind[place], stepper.waiting_contact[place] = kind, contact
        stepper.waiting_time[place] = stepper.period_count * stepper.period + (stepper.time + s)
        stepper.waiting_events = place + 1


def within_step(floats, ints):
    """Whether the clock stands within a step whose series is in memory."""
    return stepper.ended == RUNNING and stepper.taylor_steps + stepper.implicit_steps > 0


def show_instant(floats, ints, point):
    """Put the step in place in which the clock stands, and its state there to `point`; the time since it began.

    What is in place then changes places with that of the lane, and does so again when this is called again.
    """
    if not within_step(floats, ints):
        for i in range(STATES):
            floats[point + i] = stepper.state[i]
        return 0.0
    s = stepper.clock - stepper.piece_clock
    for i in range(STATES):
        floats[point + i] = value_and_rate(floats, alone.row[i], 1, ORDER, s, False)[0]
    time, stiff = stepper.time, stepper.stiff
    stepper.time, stepper.stiff = stepper.piece_time, stepper.piece_stiff
    stepper.piece_time, stepper.piece_stiff = time, stiff
    for c in range(CONTACTS):
        side = stepper.side[c]
        stepper.side[c] = stepper.recorded_side[c]
        stepper.recorded_side[c] = side
    if COEFFICIENTS > 0:
        for i in range(COEFFICIENTS + 2):
            number = stepper.parameter[PRESENT + i]
            stepper.parameter[PRESENT + i] = stepper.piece_segment[i]
            stepper.piece_segment[i] = number
    return s


def side_shown(floats, ints, contact):
    return stepper.recorded_side[contact] if within_step(floats, ints) else stepper.side[contact]
