"""Tangents of motions: how a small change of the start grows, through events too.

After the states of a motion stand those of its tangent, which follow the variational equations delta' = J delta within
a piece. An event moves: with the guard g(t, y), what it changes y := D(t, y), and the rates f- before and f+ after it
(Leine and Nijmeijer 2004, ch. 7),

    delay   dt = -(g_y delta)/(dg/dt),          dg/dt = g_t + g_y f-
    leaving       delta := delta + f- dt        the change of the state at the event
    resetting     delta := D_y delta + D_t dt   where the states change there
    entering      delta := delta - f+ dt        back to one time for all

which is the saltation matrix in three steps: which piece follows is known only after the second. A contact that comes
to rest and sticks has lost one direction for good: its change of velocity v_y delta is exactly zero from there on. Only
then: at a reversal v_y delta = -v_t dt is left of it, which is zero where the velocity v(t, y) is a state, and is not
where a part of it is imposed.
"""

from vibrocap.numerics.kernel.arithmetic.roots import polynomial_slope
from vibrocap.numerics.kernel.codes import FIRST_SWITCH
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at, lanes
from vibrocap.numerics.kernel.step.taylor import write_state


def tangent_waits(ints, lane):
    return lane.pending == 1


def leave_piece(floats, ints, lane, event, contact, h):
    """At an event of a contact, at time h of the series: the tangent becomes the change of the state at the event."""
    if lane.pending == 1:  # two events at one instant, to rounding
        enter_piece(floats, ints, lane)
    out = guards_along(floats, lane)
    velocity = at.velocity_row[contact]
    if event == 1:
        change, slope = floats[out + 3 * contact], polynomial_slope(floats, velocity + lane, LANES, ORDER, h)
    elif event >= FIRST_SWITCH:
        which = event - FIRST_SWITCH
        change = floats[out + 3 * CONTACTS + which]
        slope = polynomial_slope(floats, lane.guard_row[which], LANES, ORDER, h)
    else:
        push = 1.0 if event > 0 else -1.0
        change = floats[out + 3 * contact + 2] - push * floats[out + 3 * contact + 1]
        slope = polynomial_slope(floats, lane.limit_row[contact], LANES, ORDER, h)
        slope -= push * polynomial_slope(floats, lane.sticking_force_row[contact], LANES, ORDER, h)
    delay = -change / slope if slope != 0.0 else 0.0
    for i in range(BASE):
        rate = polynomial_slope(floats, lane.row[i], LANES, ORDER, h)
        lane.state[BASE + i] += rate * delay
    state = STATE_OF[contact]
    if event == 1 and velocity == at.row[state]:
        lane.state[BASE + state] = 0.0  # to rounding
    lane.delay = delay
    lane.pending = 1


def stay_in_piece(ints, lane):
    """The contact is set to rest by what moves no event, a corner of the drive: its tangent waits, without a delay."""
    lane.pending = 1


def enter_piece(floats, ints, lane):
    for i in range(BASE):
        rate = lane.series[i * (ORDER + 1) + 1]
        lane.state[BASE + i] -= rate * lane.delay
    for c in range(CONTACTS):
        if STICKS[c] == 1 and lane.side[c] == 0.0:
            lane.state[BASE + STATE_OF[c]] -= floats[guards_along(floats, lane) + 3 * c]
    lane.delay = 0.0
    lane.pending = 0


def guards_along(floats, lane):
    """Where `guard_tangents` of the present state were written."""
    write_state(floats, lane, WORK)
    guard_tangents(floats, lane.time, WORK, lane, WORK + STATES)
    return WORK + STATES


def tangents_wait(ints, plain):
    """The plain lanes whose tangents are within a piece."""
    return plain & (lanes.pending == 0)
