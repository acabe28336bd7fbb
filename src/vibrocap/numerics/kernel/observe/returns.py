"""Settling by returns, of a system that nothing drives in time: its motions have periods of their own.

The section is where the velocity of a contact, whichever, falls to zero: whether it sticks there, turns back or passes
is the same at every return of a cycle. The states at these returns are marks as those at the starts of periods are
(`settle.py`), and a motion has settled when they repeat after as many returns as its cycle has; the window is then
these returns, from one to the other exactly. What rests or slides steadily makes no returns: there the marks at the
starts of periods tell, which have to stand still and begin anew at each return.
"""

from vibrocap.numerics.kernel.codes import DONE
from vibrocap.numerics.kernel.generated.ensemble import (
    BEGUN_AT,
    CYCLE_TIME,
    LEFT,
    QUIET_SINCE,
    REMAINING,
    RESPONSE,
    RETURN_COUNT,
    RETURN_MARKS,
    RETURN_TIMES,
    RETURNS,
    SETTLED_AT,
    SETTLED_TIME,
    SINCE,
    THRESHOLD,
)
from vibrocap.numerics.kernel.generated.lane import PERIOD, PERIOD_COUNT, STATUS, TIME, TOLERANCE, WHOLE_PERIODS
from vibrocap.numerics.kernel.generated.sizes import LANES, MARK_COUNT
from vibrocap.numerics.kernel.observe.settle import remember, settled_response

MOST_RETURNS = (MARK_COUNT - 8) // 4  # of a cycle: so many marks tell


def begin_returns(floats, ints, lane):
    """A run begins."""
    floats[BEGUN_AT + lane] = -1.0
    floats[SETTLED_AT + lane] = 0.0
    ints[RETURN_COUNT + lane] = 0
    ints[LEFT + lane] = 0
    ints[QUIET_SINCE + lane] = 0


def period_mark(ints, lane):
    """(number of the mark at the start of the present period, longest response looked for): it has to stand still."""
    return ints[PERIOD_COUNT + lane] - ints[QUIET_SINCE + lane], 1


def settled_by_returns(floats, ints, lane):
    """At a return: 1 where the motion is found settled, so that the window begins; -1 where it ends; else 0.

    Where the cycle is found near the end of the budget, the run goes on for the returns that are measured.
    """
    if not (floats[THRESHOLD + lane] > 0.0):
        return 0
    now = elapsed(floats, ints, lane)
    count = ints[RETURN_COUNT + lane]
    ints[RETURN_COUNT + lane] = count + 1
    if ints[LEFT + lane] > 0:
        ints[LEFT + lane] -= 1
        if ints[LEFT + lane] > 0:
            return 0
        ints[STATUS + lane] = DONE
        return -1
    if ints[RESPONSE + lane] > 0:
        return 0
    ints[QUIET_SINCE + lane] = ints[PERIOD_COUNT + lane] + 1
    remember(floats, RETURN_MARKS, lane, count)
    floats[RETURN_TIMES + count % MARK_COUNT * LANES + lane] = now
    response, since, remaining = settled_response(
        floats, RETURN_MARKS, lane, count, MOST_RETURNS, floats[THRESHOLD + lane], floats[TOLERANCE + lane]
    )
    if response == 0:
        return 0
    ints[RESPONSE + lane] = response
    ints[SINCE + lane] = since
    ints[LEFT + lane] = response
    floats[REMAINING + lane] = remaining
    floats[BEGUN_AT + lane] = now
    floats[SETTLED_AT + lane] = floats[RETURN_TIMES + since % MARK_COUNT * LANES + lane]
    length = now - floats[RETURN_TIMES + (count - response) % MARK_COUNT * LANES + lane]
    ints[WHOLE_PERIODS + lane] += 1 + int(2.0 * length / floats[PERIOD + lane])
    return 1


def tell_returns(floats, ints, lane):
    """The run ends: what is told of its returns. A cycle that did not come back in twice its time has not settled."""
    floats[RETURNS + lane] = 1.0 * ints[RETURN_COUNT + lane]
    floats[SETTLED_TIME + lane] = floats[SETTLED_AT + lane]
    floats[CYCLE_TIME + lane] = 0.0
    if floats[BEGUN_AT + lane] >= 0.0:
        floats[CYCLE_TIME + lane] = elapsed(floats, ints, lane) - floats[BEGUN_AT + lane]
    if ints[LEFT + lane] > 0:
        ints[RESPONSE + lane] = 0


def elapsed(floats, ints, lane):
    """Time since the run began."""
    return ints[PERIOD_COUNT + lane] * floats[PERIOD + lane] + floats[TIME + lane]
