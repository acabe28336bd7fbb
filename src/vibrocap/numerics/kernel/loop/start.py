"""The start of a motion on a lane: what follows from its states, parameters, natural sizes, time and period.

And its end, where the sides must be those with which a motion starts that continues it.
"""

from vibrocap.numerics.kernel.arithmetic.roots import SLIGHT
from vibrocap.numerics.kernel.events.contact import DOUBT, rests_beside, velocity_rounding
from vibrocap.numerics.kernel.generated.ensemble import PAUSE, SLOW, SWEEPS, WAIT
from vibrocap.numerics.kernel.generated.equations import contact_velocity, rates
from vibrocap.numerics.kernel.generated.facts import KINKS, MANIFOLDS, SLOWED, STATE_OF, STICKS
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
from vibrocap.numerics.kernel.generated.rows import HOLD_OF, LIMIT_OF
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER, ROWS, STATES
from vibrocap.numerics.kernel.interface import begin_drive, branch_in_doubt
from vibrocap.numerics.kernel.step.resolved import forget
from vibrocap.numerics.kernel.step.taylor import hold_rate, series_value

NOT_TOLD = 9.0  # a side that is none: the sides at the start are no events


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
    start_sides(floats, ints, lane)


def start_sides(floats, ints, lane):
    """Each contact slides to the side of its velocity; of one at rest the side is to be decided."""
    for c in range(CONTACTS):
        ints[TO_DECIDE + c * LANES + lane] = 0
        ints[ZEROS + c * LANES + lane] = 0
        ints[GAVE_WAY + c * LANES + lane] = 0
        floats[CAME_FROM + c * LANES + lane] = 0.0
        floats[SIDE_TOLD + c * LANES + lane] = NOT_TOLD
        floats[SIDE + c * LANES + lane] = 1.0
    for c in range(CONTACTS):
        v = present_velocity(floats, lane, c)
        if not rests_to_rounding(floats, ints, lane, c, v, 1.0):
            floats[SIDE + c * LANES + lane] = 1.0 if v > 0.0 else -1.0


def ends_open(floats, ints, lane, h):
    """Whether the sides are to be decided once more at the end of a run, after a step of length h.

    What begins there must find what ends there: a velocity that counts as none at a start is none at an end, a hold
    that gives way at once has given way, a kinked law that has passed rest has turned.
    """
    opens = branch_in_doubt(floats, lane, h)
    for c in range(CONTACTS):
        side = floats[SIDE + c * LANES + lane]
        if STICKS[c] == 1 and side == 0.0:
            hold, limit = series_value(floats, HOLD_OF[c] + lane, h), series_value(floats, LIMIT_OF[c] + lane, h)
            opens = opens or abs(hold) >= (1.0 - DOUBT) * limit
        elif STICKS[c] + KINKS[c] > 0 and ints[ZEROS + c * LANES + lane] == 0:
            v = present_velocity(floats, lane, c)
            opens = rests_to_rounding(floats, ints, lane, c, v, 2.0) or opens or side * v < 0.0
    return opens


def rests_to_rounding(floats, ints, lane, c, v, share):
    """Whether the velocity v of a contact is none but for rounding; it is exactly zero then, and forces decide.

    A smooth law has a force for every velocity, and nothing is to be decided.

    share: of rounding; more at an end than at a start, so that what rests at the start has come to rest at the end
    """
    if v != 0.0 and (STICKS[c] + KINKS[c] == 0 or abs(v) > share * velocity_rounding(floats, lane, c, v)):
        return False
    if v != 0.0 and STICKS[c] == 0 and told_from_rest(floats, lane, c, v):
        return False
    if not rests_beside(floats, lane, c):
        floats[STATE + STATE_OF[c] * LANES + lane] -= v
    if STICKS[c] == 1:
        floats[SIDE + c * LANES + lane] = 0.0
        ints[TO_DECIDE + c * LANES + lane] = 1
    else:
        ints[ZEROS + c * LANES + lane] = 1
    return True


def told_from_rest(floats, lane, c, v):
    """Whether friction tells v, the velocity of a contact at the state in WORK, from rest: rock creeps at 1e-11 m/s."""
    place, state, side = SIDE + c * LANES + lane, WORK + STATE_OF[c], floats[SIDE + c * LANES + lane]
    floats[place] = 1.0 if v > 0.0 else -1.0
    rates(floats, floats[TIME + lane], WORK, floats[SIDE + lane], lane, WORK + ROWS)
    floats[state] -= v
    rates(floats, floats[TIME + lane], WORK, floats[SIDE + lane], lane, WORK + 2 * ROWS)
    floats[place] = side
    moving, still = floats[WORK + ROWS + STATE_OF[c]], floats[WORK + 2 * ROWS + STATE_OF[c]]
    return abs(moving - still) > SLIGHT * (abs(moving) + abs(still))


def present_velocity(floats, lane, c):
    """Velocity of a contact at the present state and time."""
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i * LANES + lane]
    return contact_velocity(floats, floats[TIME + lane], WORK, c, lane)
