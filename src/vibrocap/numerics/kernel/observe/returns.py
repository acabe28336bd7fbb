"""Settling by returns, of a system that nothing drives in time: its motions have periods of their own.

The section is where the velocity of a contact, whichever, falls to zero: whether it sticks there, turns back or passes
is the same at every return of a cycle. A motion that no contact comes to rest in returns where a coordinate is largest,
or one that turns has turned. The states at returns are marks as those at the starts of periods are (`settle.py`), and
a motion has settled when they repeat after as many returns as its cycle has; the window is then these returns, from one
to the other exactly. What rests or slides steadily makes no returns: there the marks at the starts of periods tell,
which have to stand still and begin anew at each return.
"""

import math

from vibrocap.numerics.kernel.arithmetic.roots import SLIGHT, bracketed_root, value_and_rate
from vibrocap.numerics.kernel.codes import DONE
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.observe.settle import remember, settled_response, still_settled
from vibrocap.numerics.kernel.observe.window import begin_sequence, begin_window, end_phases
from vibrocap.numerics.kernel.step.taylor import series_value

MOST_RETURNS = (MARK_COUNT - 8) // 4  # of a cycle: so many marks tell
OFTEN = 8  # passages of the place without a return to rest, from which on they are the returns
BEFORE = 1e-6  # of a step: a place that is passed so shortly before its end is passed at its end, by an event


def begin_returns(floats, ints, lane):
    lane.return_count = 0
    lane.left = 0
    lane.quiet_since = 0
    lane.by_place = 1
    lane.passed = 0
    lane.passed_at = -1
    lane.begun_at = -1.0
    lane.settled_at = 0.0


def quiet_since(ints, lane):
    """First period from which on there has been no return."""
    return lane.quiet_since


def response_sought(longest):
    """Longest response that the starts of periods tell: they have to stand still."""
    return 1


def place_passed(floats, ints, lane, h):
    """Time within the step at which the place is passed; -1.0: it is not.

    Not in the step that begins there: it may begin a little before, as an implicit step is not known exactly within.
    """
    if lane.taylor_steps + lane.implicit_steps == lane.passed_at:
        return -1.0
    row = lane.row[PLACE]
    turns = PLACE_TURN > 0.0
    target, direction = 0.0, -1.0
    if turns:
        start, end = floats[row], series_value(floats, row, h)
        direction = 1.0 if end > start else -1.0
        tiny = SLIGHT * (abs(start) + PLACE_TURN)
        target = direction * PLACE_TURN * (math.floor((direction * start + tiny) / PLACE_TURN) + 1.0)
    elif not (floats[row + LANES] * h > SLIGHT * lane.scale[PLACE]):
        return -1.0
    high, start, root = (1.0 - BEFORE) * h, floats[row], -1.0
    floats[row] = start - target
    if direction * value_and_rate(floats, row, LANES, ORDER, high, not turns)[0] >= 0.0:
        root = bracketed_root(floats, (row, LANES, ORDER), not turns, -direction, 0.0, high)
    floats[row] = start
    return root


def on_place(floats, ints, lane):
    """The lane stands where the place is passed. It is a return unless contacts come to rest in between."""
    lane.passed_at = lane.taylor_steps + lane.implicit_steps
    if lane.by_place == 0 and lane.left == 0:
        lane.passed += 1
        if lane.passed > OFTEN:
            lane.by_place = 1
            lane.return_count = 0
    if lane.by_place == 1:
        count_return(floats, ints, lane)


def on_return(floats, ints, lane):
    """The velocity of a contact has fallen to zero; the lane stands there."""
    lane.passed = 0
    if lane.by_place == 1 and lane.left == 0:
        lane.by_place = 0
        lane.return_count = 0
    if lane.by_place == 0:
        count_return(floats, ints, lane)


def count_return(floats, ints, lane):
    """At a return the motion may be found settled, so that the window begins; or the window ends, and the run.

    Where the cycle is found near the end of the budget, the run goes on for the returns that are measured.
    """
    if not (lane.threshold > 0.0):
        return
    count = lane.return_count
    lane.return_count = count + 1
    if lane.response == 0 or lane.left > 0:
        remember(floats, RETURN_MARKS, lane, count)
    if lane.left > 0:
        lane.left -= 1
        if lane.left == 0:
            if still_settled(floats, RETURN_MARKS, lane, count, lane.response):
                end_phases(floats, lane)
                lane.status = DONE
            else:
                lane.response = 0
                lane.begun_at = -1.0
        return
    if lane.response > 0:
        return
    now = elapsed(floats, ints, lane)
    lane.quiet_since = lane.period_count + 1
    lane.return_times[count % MARK_COUNT] = now
    response, since, remaining = settled_response(floats, RETURN_MARKS, lane, count, MOST_RETURNS)
    if response == 0:
        return
    lane.response = response
    lane.since = since
    lane.left = response
    lane.remaining = remaining
    lane.begun_at = now
    lane.settled_at = lane.return_times[since % MARK_COUNT]
    length = now - lane.return_times[(count - response) % MARK_COUNT]
    lane.whole_periods += 1 + int(2.0 * length / lane.period)
    begin_window(floats, ints, lane)
    begin_sequence(floats, lane)


def tell_returns(floats, ints, lane):
    """The run ends: what is told of its returns. A cycle that did not come back in twice its time has not settled."""
    lane.returns = 1.0 * lane.return_count
    lane.settled_time = lane.settled_at
    lane.cycle_time = 0.0
    if lane.begun_at >= 0.0:
        lane.cycle_time = elapsed(floats, ints, lane) - lane.begun_at
    if lane.left > 0:
        lane.response = 0


def elapsed(floats, ints, lane):
    """Time since the run began."""
    return lane.period_count * lane.period + lane.time
