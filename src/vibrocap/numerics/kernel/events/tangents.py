"""Tangents of motions: how a small change of the start grows, through events too.

After the states of a motion stand those of its tangent, which follow the variational equations delta' = J delta within
a piece. An event moves: with the guard g and the rates f- before and f+ after it (Leine and Nijmeijer 2004, ch. 7),

    delay   dt = -(grad g . delta)/(dg/dt)
    leaving       delta := delta + f- dt        the change of the state at the event
    resetting     delta := D delta              where the law changes its states there
    entering      delta := delta - f+ dt        back to one time for all

which is the saltation matrix in three steps: which piece follows is known only after the second. A contact that comes
to rest and sticks has lost one direction for good: its change of velocity is exactly zero from there on.
"""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import whole_equal
from vibrocap.numerics.kernel.codes import FIRST_SWITCH
from vibrocap.numerics.kernel.generated import (
    BASE,
    CONTACT_STATE,
    DELAY,
    HOLD,
    LANES,
    LIMIT,
    ORDER,
    PENDING,
    SERIES,
    SIDE,
    STATE,
    STATES,
    SWITCH,
    TIME,
    VELOCITY,
    WORK,
    guard_tangents,
)


def tangent_waits(whole, lane):
    """Whether the tangent has yet to enter the present piece."""
    return whole[PENDING + lane] == 1


def leave_piece(real, whole, lane, event, h):
    """At an event, at time h of the series: the tangent becomes the change of the state at the event."""
    for i in range(STATES):
        real[WORK + i] = real[STATE + i * LANES + lane]
    out = WORK + STATES
    guard_tangents(real, real[TIME + lane], WORK, real[SIDE + lane], lane, out)
    if event == 1:
        change, slope = real[out], series_slope(real, VELOCITY + lane, h)
    elif event >= FIRST_SWITCH:
        which = event - FIRST_SWITCH
        change, slope = real[out + 3 + which], series_slope(real, SWITCH + which * (ORDER + 1) * LANES + lane, h)
    else:
        push = 1.0 if event > 0 else -1.0
        change = real[out + 2] - push * real[out + 1]
        slope = series_slope(real, LIMIT + lane, h) - push * series_slope(real, HOLD + lane, h)
    delay = -change / slope if slope != 0.0 else 0.0
    for i in range(BASE):
        rate = series_slope(real, SERIES + i * (ORDER + 1) * LANES + lane, h)
        real[STATE + (BASE + i) * LANES + lane] += rate * delay
    if event == 1:
        real[STATE + (BASE + CONTACT_STATE) * LANES + lane] = 0.0  # to rounding
    real[DELAY + lane] = delay
    whole[PENDING + lane] = 1


def enter_piece(real, whole, lane):
    """A piece begins, whose series stands in memory: the change at the event becomes one at one time."""
    for i in range(BASE):
        rate = real[SERIES + (i * (ORDER + 1) + 1) * LANES + lane]
        real[STATE + (BASE + i) * LANES + lane] -= rate * real[DELAY + lane]
    whole[PENDING + lane] = 0


def series_slope(real, row, s):
    """Slope at time s of the series whose first coefficient stands at real[row]."""
    result = ORDER * real[row + ORDER * LANES]
    for k in range(ORDER - 1, 0, -1):
        result = result * s + k * real[row + k * LANES]
    return result


def tangents_wait(whole, plain):
    """The plain lanes whose tangents are within a piece."""
    return plain & whole_equal(whole, PENDING, 0)
