"""A motion that goes on by any length of time, as its caller asks: `take_step`, after `begin_motion`; then `look_at`.

Nothing is recorded but how often each kind of event occurred, and which was the last. An event is counted by its kind
and contact once its instant is passed: first the kinds that are of a contact, each for all contacts, then those of
none. How a motion passes to the instant that is asked for differs with its drive: one of its own goes on by steps of
the kernel's own choice, from which the instant is read (`own_drive`); an input is known up to that instant only
(`held_input`).
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.codes import GRAZE, MACHINE_SWITCHED, RUNNING, SWITCHED
from vibrocap.numerics.kernel.events.transitions import change_of_side
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import stepper
from vibrocap.numerics.kernel.loop.one_step import start_lane
from vibrocap.numerics.kernel.observe.one_instant import INSTANT, take_sizes, write_observed, write_table


def begin_motion(floats, ints, trace, _):
    """The motion begins, of the parameters and states in memory: natural sizes, period, drive and sides follow."""
    stepper.period = take_sizes(floats)
    if COEFFICIENTS > 0:
        stepper.parameter[PRESENT] = stepper.period
    if TABLE_NUMBERS > 0:
        write_table(floats, ints, trace, stepper.period, stepper.table_start)
    start_lane(floats, ints, trace, 0, 0)
    stepper.begun = 1
    pass_by(floats, ints, trace, 0.0, 0)  # which contacts rest


def take_step(floats, ints, trace, to_event):
    """Go on by LENGTH, or (to_event: 1) to the first event if that is earlier; ENDED tells whether that failed."""
    if stepper.ended == RUNNING:
        pass_by(floats, ints, trace, stepper.length, to_event)


def pass_by(floats, ints, trace, length, to_event):
    """Advance by a length of time >= 0, and note the sides at the clock."""
    hook.set_out(floats, ints, trace, length)
    stepper.stopping, stepper.stopped = to_event, 0
    stepper.step_limit = stepper.taylor_steps + stepper.implicit_steps + stepper.steps_per_call
    while stepper.status == RUNNING and stepper.stopped == 0 and hook.under_way(floats, ints):
        hook.advance(floats, ints, trace, 1)
    hook.come_in(floats, ints, trace, length)
    for c in range(CONTACTS):
        stepper.shown_side[c] = hook.side_shown(floats, ints, c)


def look_at(floats, ints, trace, _):
    """Write the states and then the observables at the clock to SHOWN of the trace."""
    s = hook.show_instant(floats, ints, INSTANT)
    stepper.step = stepper.piece_length
    write_observed(floats, ints, trace, s, SHOWN)
    hook.show_instant(floats, ints, INSTANT)


def on_piece(floats, ints, trace, lane, h):
    record_sides(floats, ints, trace, lane)
    # At the instant at which this piece begins, with the sides that are decided now; one that is shorter than time can
    # tell lies between events of one instant.
    if stepper.time + h > stepper.time:
        stop_at_event(ints)
    hook.keep_piece(floats, ints, trace, h)


def on_instant(floats, ints, trace, lane):
    """The length that was asked for ends at an event."""
    record_sides(floats, ints, trace, lane)
    stop_at_event(ints)
    hook.keep_piece(floats, ints, trace, 0.0)


def stop_at_event(ints):
    """All events of one instant have been noticed; the motion stops at them if it is to."""
    if stepper.noticed > 0:
        stepper.noticed = 0
        stepper.stopped = stepper.stopping


def record_sides(floats, ints, trace, lane):
    """Count what has become of the sides since they were told last."""
    for c in range(CONTACTS):
        kind = change_of_side(floats, lane, c)
        if kind >= 0:
            notice(floats, ints, kind, c, 0.0)


def on_event(floats, ints, trace, lane, kind, contact, s):
    """An event at time s after the lane's present time."""
    if kind >= SWITCHED:
        record_sides(floats, ints, trace, lane)  # what happened before
    notice(floats, ints, kind, contact, s)


def notice(floats, ints, kind, contact, s):
    """Keep an event until its instant is passed. Bounds are none: the status tells them."""
    if kind <= SWITCHED or kind >= MACHINE_SWITCHED:
        if kind != GRAZE:
            stepper.noticed += 1
        hook.keep_event(floats, ints, kind, contact, s)


def count_event(floats, ints, kind, contact, time):
    """An event has occurred. Kinds are numbered without a gap: those of contacts, of their laws, of the machine."""
    number = kind if kind <= SWITCHED else SWITCHED + 1 + kind - MACHINE_SWITCHED
    place = number * CONTACTS + contact if kind < SWITCHED else SWITCHED * (CONTACTS - 1) + number
    stepper.counted[place] += 1
    stepper.last_kind, stepper.last_contact = number, contact + 1
    stepper.last_time = time


def on_period(floats, ints, trace, lane):
    """Nothing is kept by period."""


def go_on(floats, length):
    """Add a length to the clock: what its sum rounds off is carried along."""
    before = stepper.clock
    after = before + length
    taken = after - before
    rest = stepper.clock_rest + ((before - (after - taken)) + (length - taken))
    stepper.clock = after + rest
    stepper.clock_rest = rest - (stepper.clock - after)


def set_clock(floats, time):
    """Put the clock to a time."""
    stepper.clock, stepper.clock_rest = time, 0.0
