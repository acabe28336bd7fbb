"""Several branches of law and machine, and bounds: which guard ends the present branch, and what changes there.

Which branch holds is written in switched states: whole numbers among the states, of rate zero. A guard is positive
within its branch; where one falls to zero, or is not positive where a step starts, the equations say what the states
are from there on. First stand the guards of the law, which are clearly positive after their own switch. Those of the
machine behind them may be zero there, as a stop that was just reached: then their first coefficient that is no rounding
decides. Last stand those of the equations' bounds: beyond one of them they have no answer, and the run ends.

The first bound of a load that follows the motion, the divisor d of N = n/d, is reached with an infinite slope: as N
grows, so do the accelerations, and d falls like the root of the time that is left. Steps that halve that time again and
again would never get there. So how fast d falls is asked as well, and the run ends where d would be gone within a time
too short to matter.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, first_root
from vibrocap.numerics.kernel.codes import (
    BEYOND_BOUND,
    BOUND_REACHED,
    FIRST_SWITCH,
    MACHINE_SWITCHED,
    SWITCHED,
    TOO_MANY_EVENTS,
)
from vibrocap.numerics.kernel.events.contact import jumped
from vibrocap.numerics.kernel.generated import (
    BOUND_KINDS,
    BRANCHES,
    EVENT_LIMIT,
    EVENTS,
    FOLLOWS_LOAD,
    IDLE,
    IMPACT,
    IMPLICIT_STEPS,
    LANES,
    LAW_BRANCHES,
    OCCURRED,
    ORDER,
    PERIOD,
    SERIES,
    SIDE,
    STATE,
    STATES,
    STATUS,
    SWITCH,
    SWITCHES,
    TAYLOR_STEPS,
    TIME,
    WINDOW_START,
    WORK,
    after_reversal,
    after_switch,
    contact_velocity,
    machine_energy,
    switches,
)
from vibrocap.numerics.kernel.interface import on_event, on_jump
from vibrocap.numerics.kernel.step.taylor import series_value, taylor_step, through_five

ROUNDING = 64.0 * EPSILON  # of a guard of the machine, whose natural size is one
AT_ONCE = 1e-12  # of a period: steps towards the end of a load that follows the motion are still ten times rounding


def within_bounds(real, whole, tape, lane):
    """Whether the equations hold at the start of the step; if not, the run ends."""
    for i in range(BRANCHES, SWITCHES):
        row = SWITCH + i * (ORDER + 1) * LANES + lane
        least = 0.0
        if FOLLOWS_LOAD and i == BRANCHES:  # its slope stands in the last place of its row
            least = max(0.0, -(real[row + ORDER * LANES] * (AT_ONCE * real[PERIOD + lane])))
        if not (real[row] > least):
            begin_branch(real, whole, tape, lane, i)
            return False
    return True


def branch_holds(real, whole, tape, lane):
    """Whether the present branch holds at the start of the step; if not, the next one begins."""
    for i in range(BRANCHES):
        row = SWITCH + i * (ORDER + 1) * LANES + lane
        if real[row] > (0.0 if i < LAW_BRANCHES else ROUNDING):
            continue
        if i >= LAW_BRANCHES and begins(real, row, min(taylor_step(real, whole, lane), real[PERIOD + lane])):
            continue
        whole[IDLE + lane] += 1
        begin_branch(real, whole, tape, lane, i)
        return False
    return True


def begins(real, row, h):
    """Whether a guard grows from zero: its first coefficient that is no rounding over the step h is positive."""
    zeros = vanishing(real, row, h)
    return zeros == ORDER or real[row + zeros * LANES] > 0.0


def vanishing(real, row, h):
    """How many leading coefficients of a guard of the machine move it by rounding only over the step h."""
    zeros = 0
    power = 1.0
    for k in range(ORDER):
        if zeros == k and abs(real[row + k * LANES]) * power <= ROUNDING:
            zeros = k + 1
        power *= h
    return zeros


def first_switch(real, lane, event, h):
    """(event, time): the first guard that falls to zero before the event known so far, as FIRST_SWITCH + its number."""
    for i in range(SWITCHES):
        row = SWITCH + i * (ORDER + 1) * LANES + lane
        zeros = 0
        if LAW_BRANCHES <= i < BRANCHES:
            zeros = min(vanishing(real, row, h), ORDER - 2)
            while zeros > 0 and not (real[row + zeros * LANES] > 0.0):
                zeros -= 1  # it grows, though at first by rounding only: `branch_holds` has looked farther ahead
        root, _touch = first_root(real, row, ORDER - 1, 1.0, zeros, h)
        if root >= 0.0 and (root < h or event == 0):
            event = FIRST_SWITCH + i
            h = root
    return event, h


def begin_branch(real, whole, tape, lane, which):
    """The states become those after switch `which`; behind a bound the run ends."""
    if which >= BRANCHES:
        on_event(real, whole, tape, lane, BOUND_REACHED + BOUND_KINDS[which - BRANCHES], 0.0)
        whole[STATUS + lane] = BEYOND_BOUND + BOUND_KINDS[which - BRANCHES]
        return
    whole[EVENTS + lane] += 1
    if whole[EVENTS + lane] > whole[EVENT_LIMIT + lane]:
        whole[STATUS + lane] = TOO_MANY_EVENTS
        return
    for i in range(STATES):
        real[WORK + i] = real[STATE + i * LANES + lane]
    after_switch(real, real[TIME + lane], WORK, real[SIDE + lane], lane, which, WORK + STATES)
    for i in range(STATES):
        real[STATE + i * LANES + lane] = real[WORK + STATES + i]
    strikes = False
    if which >= LAW_BRANCHES:
        strikes = hits(real, whole, lane)
    chosen = whole[TAYLOR_STEPS + lane] + whole[IMPLICIT_STEPS + lane] == 0
    if which < LAW_BRANCHES:
        on_event(real, whole, tape, lane, SWITCHED, 0.0)
    elif not (chosen and real[SWITCH + which * (ORDER + 1) * LANES + lane] < -ROUNDING):
        on_event(real, whole, tape, lane, MACHINE_SWITCHED + which - LAW_BRANCHES, 0.0)
        if OCCURRED >= 0 and whole[WINDOW_START + lane] >= 0:
            real[OCCURRED + (which - LAW_BRANCHES) * LANES + lane] += 1.0
    # else nothing happens: it is the branch in which the run starts
    if strikes:
        jumped(real, whole, tape, lane)


def hits(real, whole, lane):
    """Whether a switch of the machine, from the states in WORK to those behind them, changes the contact velocity.

    The energy that it takes is told to the observer.
    """
    time = real[TIME + lane]
    if IMPACT >= 0:
        gained = machine_energy(real, time, WORK + STATES, lane) - machine_energy(real, time, WORK, lane)
        on_jump(real, whole, lane, gained)
    return contact_velocity(real, time, WORK + STATES, lane) != contact_velocity(real, time, WORK, lane)


def turned(real, lane):
    """The states become those after a reversal to the present side."""
    for i in range(STATES):
        real[WORK + i] = real[STATE + i * LANES + lane]
    after_reversal(real, real[TIME + lane], WORK, real[SIDE + lane], lane, WORK + STATES)
    for i in range(STATES):
        real[STATE + i * LANES + lane] = real[WORK + STATES + i]


def guards_at(real, lane, s, out):
    """Write the guards at time s of the present series."""
    for i in range(STATES):
        real[WORK + i] = series_value(real, SERIES + i * (ORDER + 1) * LANES + lane, s)
    switches(real, real[TIME + lane] + s, WORK, real[SIDE + lane], lane, out)


def interpolated_guards(real, lane, h):
    """Write the series of the guards along an implicit step, through five points of its dense output."""
    out = WORK + STATES
    for point in range(5):
        guards_at(real, lane, 0.25 * point * h, out + point * SWITCHES)
    for i in range(SWITCHES):
        start = SWITCH + i * (ORDER + 1) * LANES + lane
        v0, v1, v2 = real[out + i], real[out + SWITCHES + i], real[out + 2 * SWITCHES + i]
        v3, v4 = real[out + 3 * SWITCHES + i], real[out + 4 * SWITCHES + i]
        through_five(real, start, v0, v1, v2, v3, v4, h)
