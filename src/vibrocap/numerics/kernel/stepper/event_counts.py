"""Counting events: the hooks that the loop calls in a run of which no step is kept (one lane).

An event is counted by its kind and contact once its instant is passed: first the kinds that are of a contact, each for
all contacts, then those of none. The last one is remembered.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.codes import GRAZE, MACHINE_SWITCHED, SWITCHED
from vibrocap.numerics.kernel.generated.sizes import CONTACTS
from vibrocap.numerics.kernel.lane import stepper
from vibrocap.numerics.kernel.loop.start import change_of_side


def on_piece(floats, ints, trace, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""
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
