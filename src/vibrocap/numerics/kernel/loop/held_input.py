"""Passing to an instant with a drive that is an input, known up to that instant only: the last step ends there.

The input is a polynomial in the time since it was set, as the segment of a drive with corners is, and its numbers stand
at the same place behind the parameters. Where it is set, it may jump; that is no event of the state, which goes on as
it is: a stuck contact is asked at the next step whether it still holds. Only a contact velocity that the input itself
makes may jump. Times in the kernel count from where the present length began.
"""

from vibrocap.numerics.kernel.codes import DONE, RUNNING
from vibrocap.numerics.kernel.events.contact import jumped
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import stepper
from vibrocap.numerics.kernel.loop.one_step import start_sides
from vibrocap.numerics.kernel.loop.stepper import count_event, go_on
from vibrocap.numerics.kernel.step.resolved import forget


def begin_drive(floats, ints, trace, lane, run):
    """The input that was set before the motion begins."""
    for k in range(COEFFICIENTS + 1):
        stepper.parameter[PRESENT + 1 + k] = 0.0
    take_input(floats, ints)


def take_input(floats, ints):
    """The input that was set becomes the present one, from the time of the lane on."""
    if stepper.new_input == 1:
        stepper.new_input = 0
        stepper.parameter[PRESENT + 1] = stepper.time
        factor = 1.0
        for k in range(COEFFICIENTS):
            stepper.parameter[PRESENT + 2 + k] = stepper.input[k] * factor
            factor = factor / (k + 1.0)


def set_out(floats, ints, trace, length):
    """Times count from here; the steps go on up to the length."""
    passed = stepper.time
    stepper.parameter[PRESENT + 1] -= passed
    stepper.piece_time -= passed
    stepper.time = 0.0
    stepper.tail, stepper.until = length, length
    stepper.events = 0
    if stepper.new_input == 1:
        take_input(floats, ints)
        if FOLLOWS_LOAD:
            forget(floats, 0)
        if stepper.taylor_steps + stepper.implicit_steps == 0:
            start_sides(floats, ints, 0)  # the motion begins with this input
        elif VELOCITY_JUMPS:
            jumped(floats, ints, trace, 0)


def come_in(floats, ints, trace, length):
    """The lane stands at the instant that was asked for, at the event before its last step, or where the motion
    ended."""
    if stepper.stopped == 1:
        for i in range(SERIES):
            floats[i] = trace[BACKUP + i]
        for i in range(INT_COUNT):
            ints[i] = int(trace[BACKUP + SERIES + i])
        go_on(floats, stepper.time)
    elif stepper.status == DONE or length == 0.0:  # where the motion begins its input may not be set yet
        stepper.status = RUNNING
        go_on(floats, length)
    else:
        go_on(floats, stepper.time)
        stepper.ended = stepper.status


def keep_piece(floats, ints, trace, h):
    """A step of length h begins: where the motion is to stop before it, as an event has ended the last one, all is
    kept."""
    stepper.piece_time, stepper.piece_length = stepper.time, h
    if stepper.stopped == 1:
        for i in range(SERIES):
            trace[BACKUP + i] = floats[i]
        for i in range(INT_COUNT):
            trace[BACKUP + SERIES + i] = float(ints[i])


def keep_event(floats, ints, kind, contact, s):
    """An event is counted at once."""
    count_event(floats, ints, kind, contact, stepper.clock + (stepper.time + s))


def show_instant(floats, ints, point):
    """Put the last step in place and the state of the lane to `point`; the time since that step began.

    The time of the lane changes places with that of the step, and does so again when this is called again.
    """
    for i in range(STATES):
        floats[point + i] = stepper.state[i]
    if stepper.taylor_steps + stepper.implicit_steps == 0:
        return 0.0
    time = stepper.time
    stepper.time = stepper.piece_time
    stepper.piece_time = time
    return time - stepper.time


def side_shown(floats, ints, contact):
    return stepper.side[contact]
