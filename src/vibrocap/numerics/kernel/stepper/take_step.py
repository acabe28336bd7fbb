"""The entries of a stepper, for one motion that its caller moves on: `begin_motion`, `take_step`, `look_at`."""

from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated.ensemble import STEP, STEP_LIMIT
from vibrocap.numerics.kernel.generated.equations import beginning, contact_velocity, observables
from vibrocap.numerics.kernel.generated.facts import STATE_OF, STICKS
from vibrocap.numerics.kernel.generated.lane import (
    HOLD_RATE,
    IMPLICIT_STEPS,
    PARAMETER,
    PERIOD,
    SCALE,
    SERIES,
    SIDE,
    SIDE_TOLD,
    STATE,
    STATUS,
    TABLE_START,
    TAYLOR_STEPS,
    TIME,
    TO_DECIDE,
    WORK,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.rows import VELOCITY_OF
from vibrocap.numerics.kernel.generated.sizes import (
    COEFFICIENTS,
    CONTACTS,
    OBSERVABLES,
    ORDER,
    PRESENT,
    STATES,
    TABLE_NUMBERS,
)
from vibrocap.numerics.kernel.generated.stepper import (
    BEGUN,
    ENDED,
    LENGTH,
    PIECE_LENGTH,
    SHOWN,
    SHOWN_SIDE,
    STEPS_PER_CALL,
    STOPPED,
    STOPPING,
)
from vibrocap.numerics.kernel.interface import (
    advance,
    begin_drive,
    come_in,
    consistent_state,
    set_out,
    show_instant,
    side_shown,
    under_way,
)
from vibrocap.numerics.kernel.observe.drive_table import write_table
from vibrocap.numerics.kernel.step.taylor import hold_rate

NOT_TOLD = 9.0  # a side that is none: the sides at the start are no events
NO_SPEED_AT_START = 64.0 * 2.0**-52  # of a velocity's terms: rounding, as in `events.contact.jumped_to`


def begin_motion(floats, ints, trace, _):
    """The motion begins, of the parameters and states in memory: natural sizes, period, drive and sides follow."""
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i]
    beginning(floats, 0.0, WORK, 1.0, 0, WORK + STATES)
    for i in range(STATES):
        floats[SCALE + i] = floats[WORK + STATES + i]
    floats[PERIOD] = floats[WORK + 2 * STATES]
    floats[HOLD_RATE] = hold_rate(floats[PERIOD], ORDER)
    if COEFFICIENTS > 0:
        floats[PARAMETER + PRESENT] = floats[PERIOD]
    if TABLE_NUMBERS > 0:
        write_table(floats, ints, trace, floats[PERIOD], ints[TABLE_START])
    begin_drive(floats, ints, trace, 0, 0)
    for c in range(CONTACTS):
        for i in range(STATES):
            floats[WORK + i] = floats[STATE + i]
        v = contact_velocity(floats, 0.0, WORK, c, 0)
        none = 0.0
        if c > 0 and VELOCITY_OF[c] != SERIES + STATE_OF[c] * (ORDER + 1):
            none = NO_SPEED_AT_START * (abs(floats[STATE + STATE_OF[c]]) + floats[SCALE + STATE_OF[c]])
        floats[SIDE_TOLD + c] = NOT_TOLD
        if abs(v) > none:
            floats[SIDE + c] = 1.0 if v > 0.0 else -1.0
        elif STICKS[c] == 1:
            ints[TO_DECIDE + c] = 1
        else:
            floats[SIDE + c] = 1.0
            ints[ZEROS + c] = 1
        floats[SHOWN_SIDE + c] = floats[SIDE + c]
    ints[BEGUN] = 1


def take_step(floats, ints, trace, to_event):
    """Go on by LENGTH, or (to_event: 1) to the first event if that is earlier; ENDED tells whether that failed."""
    if ints[ENDED] != RUNNING:
        return
    set_out(floats, ints, trace, floats[LENGTH])
    ints[STOPPING], ints[STOPPED] = to_event, 0
    ints[STEP_LIMIT] = ints[TAYLOR_STEPS] + ints[IMPLICIT_STEPS] + ints[STEPS_PER_CALL]
    while ints[STATUS] == RUNNING and ints[STOPPED] == 0 and under_way(floats, ints):
        advance(floats, ints, trace, 1)
    come_in(floats, ints, trace, floats[LENGTH])
    for c in range(CONTACTS):
        floats[SHOWN_SIDE + c] = side_shown(floats, ints, c)


def look_at(floats, ints, trace, _):
    """Write the states and then the observables at the clock to SHOWN of the trace."""
    s = show_instant(floats, ints, WORK)
    for i in range(STATES):
        trace[SHOWN + i] = floats[WORK + i]
    floats[STEP] = floats[PIECE_LENGTH]
    consistent_state(floats, ints, 0, s, WORK)
    observables(floats, floats[TIME] + s, WORK, floats[SIDE], 0, WORK + STATES)
    for i in range(OBSERVABLES):
        trace[SHOWN + STATES + i] = floats[WORK + STATES + i]
    show_instant(floats, ints, WORK)
