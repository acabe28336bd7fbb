"""The start of a motion on a lane: what follows from its states, parameters, natural sizes, time and period."""

from vibrocap.numerics.kernel.generated.ensemble import PAUSE, SLOW, SWEEPS, WAIT
from vibrocap.numerics.kernel.generated.equations import contact_velocity
from vibrocap.numerics.kernel.generated.facts import MANIFOLDS, SLOWED, STATE_OF, STICKS
from vibrocap.numerics.kernel.generated.lane import (
    CAME_FROM,
    CONTACT_RESIDUAL,
    EVENTS,
    GAVE_WAY,
    HOLD_RATE,
    IMPLICIT_STEPS,
    PATIENCE,
    PENDING,
    PERIOD,
    PERIOD_COUNT,
    SCALE,
    SERIES,
    SIDE,
    SIDE_TOLD,
    STATE,
    STIFF,
    TAYLOR_STEPS,
    TIME,
    TO_DECIDE,
    WORK,
    ZERO_PROGRESS,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.rows import VELOCITY_OF
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER, STATES
from vibrocap.numerics.kernel.interface import begin_drive
from vibrocap.numerics.kernel.step.resolved import forget
from vibrocap.numerics.kernel.step.taylor import hold_rate

NOT_TOLD = 9.0  # a side that is none: the sides at the start are no events
NO_SPEED_AT_START = 64.0 * 2.0**-52  # of a velocity's terms: rounding, as in `events.contact.jumped_to`


def start_lane(floats, ints, trace, lane, run):
    """Begin a motion; run: whose table of the drive it follows."""
    ints[PERIOD_COUNT + lane] = 0
    ints[STIFF + lane] = 0
    ints[PATIENCE + lane] = 0
    ints[TAYLOR_STEPS + lane] = 0
    ints[IMPLICIT_STEPS + lane] = 0
    ints[EVENTS + lane] = 0
    ints[ZERO_PROGRESS + lane] = 0
    ints[PENDING + lane] = 0
    floats[CONTACT_RESIDUAL + lane] = 0.0
    floats[HOLD_RATE + lane] = hold_rate(floats[PERIOD + lane], ORDER)
    forget(floats, lane)
    if SLOWED:
        for m in range(MANIFOLDS):
            floats[SLOW + m * LANES + lane] = 0.0
            floats[SWEEPS + m * LANES + lane] = 0.0
            floats[WAIT + m * LANES + lane] = 0.0
            floats[PAUSE + m * LANES + lane] = 0.0
    begin_drive(floats, ints, trace, lane, run)
    for c in range(CONTACTS):
        start_contact(floats, ints, lane, c)


def start_contact(floats, ints, lane, c):
    """The side of a contact: that of its velocity; at rest, the force decides, or the series of a law that creeps.

    A velocity that is no state is zero to rounding only, as where a motion is taken up again while the contact rests.
    """
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i * LANES + lane]
    v = contact_velocity(floats, floats[TIME + lane], WORK, c, lane)
    none = 0.0
    if VELOCITY_OF[c] != SERIES + STATE_OF[c] * (ORDER + 1) * LANES:
        none = NO_SPEED_AT_START * (abs(floats[WORK + STATE_OF[c]]) + floats[SCALE + STATE_OF[c] * LANES + lane])
    side = 0.0
    if abs(v) > none:
        side = 1.0 if v > 0.0 else -1.0
    ints[TO_DECIDE + c * LANES + lane] = 0
    ints[ZEROS + c * LANES + lane] = 0
    ints[GAVE_WAY + c * LANES + lane] = 0
    floats[CAME_FROM + c * LANES + lane] = 0.0
    floats[SIDE_TOLD + c * LANES + lane] = NOT_TOLD
    if side == 0.0:
        if STICKS[c] == 1:
            ints[TO_DECIDE + c * LANES + lane] = 1
        else:
            side = 1.0
            ints[ZEROS + c * LANES + lane] = 1
    floats[SIDE + c * LANES + lane] = side
