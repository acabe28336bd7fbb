"""The entries of a stepper, for one motion that its caller moves on: `begin_motion`, `take_step`, `look_at`."""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated.places import SHOWN
from vibrocap.numerics.kernel.generated.sizes import COEFFICIENTS, CONTACTS, PRESENT, TABLE_NUMBERS
from vibrocap.numerics.kernel.lane import stepper
from vibrocap.numerics.kernel.loop.start import start_lane
from vibrocap.numerics.kernel.observe.drive_table import write_table
from vibrocap.numerics.kernel.observe.one_instant import INSTANT, take_sizes, write_observed


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
