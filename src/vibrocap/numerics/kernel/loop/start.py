"""The start of a motion on a lane: what follows from its states, parameters, natural sizes, time and period.

And its end, where the sides must be those with which a motion starts that continues it.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import SLIGHT
from vibrocap.numerics.kernel.events.contact import DOUBT, moves_by_rounding, rests_beside, velocity_rounding
from vibrocap.numerics.kernel.events.transitions import MODE_HOLDS, UNRECORDED, await_decision
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.step.resolved import forget
from vibrocap.numerics.kernel.step.taylor import series_value, sticking_rate, write_state


def start_lane(floats, ints, trace, lane, run):
    """Begin a motion; run: whose table of the drive it follows."""
    lane.period_count = 0
    lane.stiff = 0
    lane.patience = 0
    lane.taylor_steps = 0
    lane.implicit_steps = 0
    lane.events = 0
    lane.zero_progress = 0
    lane.pending = 0
    lane.contact_residual = 0.0
    lane.sticking_rate = sticking_rate(lane.period, ORDER)
    forget(floats, lane)
    if SLOWED:
        for m in range(MANIFOLDS):
            lane.slow[m] = 0.0
            lane.sweeps[m] = 0.0
            lane.wait[m] = 0.0
            lane.pause[m] = 0.0
    hook.begin_drive(floats, ints, trace, lane, run)
    start_sides(floats, ints, lane)


def start_sides(floats, ints, lane):
    """Each contact slides to the side of its velocity; of one at rest the side is to be decided."""
    for c in range(CONTACTS):
        lane.transition[c] = MODE_HOLDS
        lane.gave_way[c] = 0
        lane.came_from[c] = 0.0
        lane.recorded_side[c] = UNRECORDED
        lane.side[c] = 1.0
    for c in range(CONTACTS):
        v = present_velocity(floats, lane, c)
        if not rests_to_rounding(floats, ints, lane, c, v, 1.0):
            lane.side[c] = 1.0 if v > 0.0 else -1.0


def ends_open(floats, ints, lane, h):
    """Whether the sides are to be decided once more at the end of a run, after a step of length h.

    What begins there must find what ends there: a velocity that counts as none at a start is none at an end, a hold
    that gives way at once has given way, a kinked law that has passed rest has turned.
    """
    opens = hook.branch_in_doubt(floats, lane, h)
    for c in range(CONTACTS):
        side = lane.side[c]
        if STICKS[c] == 1 and side == 0.0:
            force = series_value(floats, lane.sticking_force_row[c], h)
            limit = series_value(floats, lane.limit_row[c], h)
            opens = opens or abs(force) >= (1.0 - DOUBT) * limit
        elif STICKS[c] + KINKS[c] > 0 and lane.transition[c] == MODE_HOLDS:
            v = present_velocity(floats, lane, c)
            opens = rests_to_rounding(floats, ints, lane, c, v, 2.0) or opens or side * v < 0.0
            opens = opens or (KINKS[c] == 1 and moves_by_rounding(floats, lane, c, v))
    return opens


def rests_to_rounding(floats, ints, lane, c, v, share):
    """Whether the velocity v of a contact is none but for rounding; it is exactly zero then, and forces decide.

    A smooth law has a force for every velocity, and nothing is to be decided.

    share: of rounding; more at an end than at a start, so that what rests at the start has come to rest at the end
    """
    if v != 0.0 and (STICKS[c] + KINKS[c] == 0 or abs(v) > share * velocity_rounding(floats, lane, c, v)):
        return False
    if v != 0.0 and STICKS[c] == 0 and differs_from_rest(floats, lane, c, v):
        return False
    if not rests_beside(floats, lane, c):
        lane.state[STATE_OF[c]] -= v
    if STICKS[c] == 1:
        await_decision(floats, ints, lane, c)
    else:
        lane.transition[c] = 1
    return True


def differs_from_rest(floats, lane, c, v):
    """Whether friction tells v, the velocity of a contact at the state in WORK, from rest: rock creeps at 1e-11 m/s."""
    side = lane.side[c]
    lane.side[c] = 1.0 if v > 0.0 else -1.0
    rates(floats, lane.time, WORK, lane, WORK + STATES)
    floats[WORK + STATE_OF[c]] -= v
    rates(floats, lane.time, WORK, lane, WORK + 2 * STATES)
    lane.side[c] = side
    moving, still = floats[WORK + STATES + STATE_OF[c]], floats[WORK + 2 * STATES + STATE_OF[c]]
    return abs(moving - still) > SLIGHT * (abs(moving) + abs(still))


def present_velocity(floats, lane, c):
    """Velocity of a contact at the present state and time."""
    write_state(floats, lane, WORK)
    return contact_velocity(floats, lane.time, WORK, c, lane)
