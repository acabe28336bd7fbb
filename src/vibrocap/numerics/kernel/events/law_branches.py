"""Several branches of law and machine, and bounds: which guard ends the present branch, and what changes there.

Which branch holds is written in switched states: whole numbers among the states, of rate zero. A guard is positive
within its branch; where one falls to zero, or is not positive where a step starts, the equations say what the states
are from there on. First stand the guards of the law, which are clearly positive after their own switch. Those of the
machine behind them may be zero there, as a stop that was just reached: then their first coefficient that is no rounding
decides. They are known to the order of the states, so that a state that stops where one of them vanishes is there to
rounding: what was just met is not met again. Last stand those of the equations' bounds: beyond one of them they have no
answer, and the run ends.

The first bound of a load that follows the motion, the divisor d of N = n/d, is reached with an infinite slope: as N
grows, so do the accelerations, and d falls like the root of the time that is left. Steps that halve that time again and
again would never get there. So how fast d falls is asked as well, and the run ends where d would be gone within a time
too short to matter.
"""

import math

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import SLIGHT, first_root, polynomial_slope, vanishing_order
from vibrocap.numerics.kernel.codes import BEYOND_BOUND, BOUND_REACHED, FIRST_SWITCH, MACHINE_SWITCHED, SWITCHED
from vibrocap.numerics.kernel.events.contact import DOUBT, jumped
from vibrocap.numerics.kernel.events.transitions import too_many_events
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.step.taylor import series_state, series_value, taylor_step, through_points, write_state

REPEATS = 7  # of a step, at most, until a guard vanishes at its end
NEARLY = 0.1  # of a step: a change of length below which Newton's method is trusted
AT_ONCE = 1e-12  # of a period: steps towards the end of a load that follows the motion are still ten times rounding


def within_bounds(floats, ints, trace, lane):
    for i in range(BRANCHES, SWITCHES):
        row = lane.guard_row[i]
        least = 0.0
        if FOLLOWS_LOAD and i == BRANCHES:  # its slope stands in the last place of its row
            least = max(0.0, -(floats[row + ORDER * LANES] * (AT_ONCE * lane.period)))
        if not (floats[row] > least):
            begin_branch(floats, ints, trace, lane, i)
            return False
    return True


def branch_holds(floats, ints, trace, lane):
    for i in range(BRANCHES):
        row = lane.guard_row[i]
        if floats[row] > (0.0 if i < LAW_BRANCHES else SLIGHT):
            continue
        if i >= LAW_BRANCHES and begins(floats, row, min(taylor_step(floats, ints, lane), lane.period)):
            continue
        lane.zero_progress += 1
        begin_branch(floats, ints, trace, lane, i)
        return False
    return True


def branch_in_doubt(floats, lane, h):
    doubt = False
    for i in range(BRANCHES):
        doubt = doubt or series_value(floats, lane.guard_row[i], h) <= DOUBT
    return doubt


def begins(floats, row, h):
    """Whether a guard grows from zero: its first coefficient that is no rounding over the step h is positive."""
    vanishing = vanishing_order(floats, row, h, SLIGHT)
    return vanishing == ORDER or floats[row + vanishing * LANES] > 0.0


def first_switch(floats, lane, event, h):
    """(event, time): the first guard that falls to zero before the event known so far, as FIRST_SWITCH + its number."""
    for i in range(SWITCHES):
        if LOCATED[i] == 0:
            continue
        row = lane.guard_row[i]
        vanishing, degree = 0, ORDER - 1
        if LAW_BRANCHES <= i < BRANCHES:
            degree = ORDER
            vanishing = vanishing_order(floats, row, h, SLIGHT)
            if vanishing == ORDER:
                continue  # rounding moves it over this step, as one that a stiff law makes short
            vanishing = min(vanishing, ORDER - 2)
            while vanishing > 0 and not (floats[row + vanishing * LANES] > 0.0):
                vanishing -= 1  # it grows, though at first by rounding only: `branch_holds` has looked farther ahead
        root, _touch = first_root(floats, row, degree, 1.0, vanishing, h)
        if root >= 0.0 and (root < h or event == 0):
            event = FIRST_SWITCH + i
            h = root
    return event, h


def polished_switch(floats, ints, lane, event, h, remaining, again):
    """Newton's method for the guard itself: its series leaves out what a force over the tolerance may be.

    What is met at the root of the series alone, a wall that no longer presses, may be met again at once. So is what
    the dense output of an implicit step tells, which is less exact than its end. Of a place, as of all that is affine
    in the states, the series tells all. Guards of the law in explicit steps are clearly positive behind it, and a bound
    ends the run.
    """
    which, out, before = event - FIRST_SWITCH, WORK + STATES, math.inf
    if which < 0 or not (again or (LAW_BRANCHES <= which < BRANCHES and POLISHED[which] == 1)):
        return event, h
    for _ in range(REPEATS):
        guards_at(floats, lane, h, out)
        left = abs(floats[out + which])
        slope = polynomial_slope(floats, lane.guard_row[which], LANES, ORDER, h)
        enough = 0.25 * SLIGHT if again else SLIGHT
        if left <= enough or left >= 0.5 * before or left >= -NEARLY * slope * h:
            break
        before = left
        h -= floats[out + which] / slope
        if h > remaining:
            hook.made_again(floats, ints, lane, remaining)
            return 0, remaining
        hook.made_again(floats, ints, lane, h)
    return 0 if again and floats[out + which] > SLIGHT else event, h


def begin_branch(floats, ints, trace, lane, which):
    """The states become those after switch `which`; behind a bound the run ends."""
    if which >= BRANCHES:
        hook.on_event(floats, ints, trace, lane, BOUND_REACHED + BOUND_KINDS[which - BRANCHES], -1, 0.0)
        lane.status = BEYOND_BOUND + BOUND_KINDS[which - BRANCHES]
        return
    if too_many_events(ints, lane):
        return
    write_state(floats, lane, WORK)
    after_switch(floats, lane.time, WORK, lane, which, WORK + STATES)
    take_state(floats, lane)
    strikes = which >= LAW_BRANCHES and hits(floats, ints, lane)
    at_start = lane.taylor_steps + lane.implicit_steps == 0
    if which < LAW_BRANCHES:
        hook.on_event(floats, ints, trace, lane, SWITCHED, -1, 0.0)
    elif not (at_start and floats[lane.guard_row[which]] < -SLIGHT):
        hook.on_event(floats, ints, trace, lane, MACHINE_SWITCHED + which - LAW_BRANCHES, -1, 0.0)
        if OCCURRED >= 0 and lane.window_start >= 0:
            lane.occurred[which - LAW_BRANCHES] += 1.0
    # else nothing happens: it is the branch in which the run starts
    if strikes:
        jumped(floats, ints, trace, lane)


def hits(floats, ints, lane):
    """Whether a switch of the machine, from the states in WORK to those behind them, changes a contact velocity.

    Or leaves at rest what was to slide, as a wall does that is pressed from now on. The energy that it takes is told to
    the observer.
    """
    time = lane.time
    if IMPACT >= 0:
        gained = machine_energy(floats, time, WORK + STATES, lane) - machine_energy(floats, time, WORK, lane)
        hook.on_jump(floats, ints, lane, gained)
    for c in range(CONTACTS):
        velocity = contact_velocity(floats, time, WORK + STATES, c, lane)
        blocked = not SEVERAL and velocity == 0.0 and lane.side[c] != 0.0
        if blocked or velocity != contact_velocity(floats, time, WORK, c, lane):
            return True
    return False


def turned(floats, lane, contact):
    """The states become those after a reversal of a contact to its present side."""
    write_state(floats, lane, WORK)
    after_reversal(floats, lane.time, WORK, lane, contact, WORK + STATES)
    take_state(floats, lane)


def take_state(floats, lane):
    """The state behind that in WORK becomes the present one."""
    for i in range(STATES):
        lane.state[i] = floats[WORK + STATES + i]


def way_out(floats, lane, c):
    """Side to which contact c, at rest for good in the present branch, slides from it: away from the wall that stops
    it, towards which it would slide without that wall. So it has turned as it struck, wherever its run is continued.
    """
    write_state(floats, lane, WORK)
    rates(floats, lane.time, WORK, lane, WORK + STATES)
    if floats[WORK + STATES + STATE_OF[c]] == 0.0:
        for i in range(LAW_BRANCHES, BRANCHES):
            after_switch(floats, lane.time, WORK, lane, i, WORK + STATES)
            rates(floats, lane.time, WORK + STATES, lane, WORK + 2 * STATES)
            towards = floats[WORK + 2 * STATES + STATE_OF[c]]
            if towards != 0.0 and floats[lane.guard_row[i]] > 0.0:
                return -1.0 if towards > 0.0 else 1.0
    return lane.side[c]


def guards_at(floats, lane, s, out):
    series_state(floats, lane, s, WORK)
    switches(floats, lane.time + s, WORK, lane, out)


def interpolated_guards(floats, lane, h):
    """Write the series of the guards along an implicit step, through five points of its dense output."""
    out = WORK + STATES
    for point in range(5):
        guards_at(floats, lane, 0.25 * point * h, out + point * SWITCHES)
    for i in range(SWITCHES):
        through_points(floats, lane.guard_row[i], out + i, SWITCHES, h)
