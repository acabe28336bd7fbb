"""Recording a whole motion: the hooks that the loop calls in a run of which everything is kept (one lane).

Events of contacts are what their sides tell: of one that rests in a piece and did not in the one before, and so on. The
modes that are tried at an instant are none.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.codes import REVERSAL, SLIP_BACK, SLIP_FORWARD, STICK, SWITCHED, TRACE_FULL
from vibrocap.numerics.kernel.generated.facts import KINKS, STICKS
from vibrocap.numerics.kernel.generated.lane import (
    PERIOD,
    PERIOD_COUNT,
    PIECE_LIMIT,
    PIECE_START,
    PIECES,
    RECORDED_EVENT_LIMIT,
    RECORDED_EVENT_START,
    RECORDED_EVENTS,
    SERIES,
    SIDE,
    SIDE_TOLD,
    STATE,
    STATUS,
    STIFF,
    TIME,
)
from vibrocap.numerics.kernel.generated.sizes import (
    CONTACTS,
    EVENT_SIZE,
    LANES,
    ORDER,
    PIECE_SIZE,
    ROWS,
    WHOLE_COUNT,
    WHOLE_ROWS,
)
from vibrocap.numerics.kernel.memory_layout import EVENT_HEAD, PIECE_HEAD
from vibrocap.numerics.kernel.step.taylor import series_value


def has_room(floats, ints, trace, lane):
    """Whether the trace can take one more step; else the lane waits as TRACE_FULL."""
    piece = ints[PIECES + lane] < ints[PIECE_LIMIT + lane]
    events = ints[RECORDED_EVENTS + lane] + 4 + CONTACTS < ints[RECORDED_EVENT_LIMIT + lane]
    if not (piece and events):
        ints[STATUS + lane] = TRACE_FULL
    return piece and events


def on_piece(floats, ints, trace, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""
    tell_sides(floats, ints, trace, lane)
    place = ints[PIECE_START + lane] + ints[PIECES + lane] * PIECE_SIZE
    trace[place] = ints[PERIOD_COUNT + lane]
    trace[place + 1] = floats[TIME + lane]
    trace[place + 2] = h
    trace[place + 3] = floats[SIDE + lane]
    trace[place + 4] = ints[STIFF + lane]
    # Not in the order of the memory: LLVM would copy several at once, and a wide load waits until all narrow stores to
    # its place, of the coefficients just written, have left the processor. That was a seventh of the time of a motion.
    for i in range(ROWS):
        trace[place + PIECE_HEAD + i] = floats[SERIES + i * (ORDER + 1) * LANES + lane]
    out = place + PIECE_HEAD + ROWS - 1
    for k in range(1, ORDER + 1):
        for i in range(WHOLE_COUNT):
            trace[out + i * ORDER + k] = floats[SERIES + (WHOLE_ROWS[i] * (ORDER + 1) + k) * LANES + lane]
    for c in range(1, CONTACTS):
        trace[place + PIECE_SIZE - CONTACTS + c] = floats[SIDE + c * LANES + lane]
    ints[PIECES + lane] += 1


def on_instant(floats, ints, trace, lane):
    """If there was an event at the last instant, what begins there is a piece of no length."""
    tell_sides(floats, ints, trace, lane)
    last = ints[RECORDED_EVENT_START + lane] + (ints[RECORDED_EVENTS + lane] - 1) * EVENT_SIZE
    if ints[RECORDED_EVENTS + lane] == 0 or trace[last] != ints[PERIOD_COUNT + lane]:
        return
    if floats[TIME + lane] - trace[last + 1] <= 2.0 * EPSILON * floats[PERIOD + lane]:
        on_piece(floats, ints, trace, lane, 0.0)


def tell_sides(floats, ints, trace, lane):
    """Record what has become of the sides since they were told last."""
    for c in range(CONTACTS):
        now, before = floats[SIDE + c * LANES + lane], floats[SIDE_TOLD + c * LANES + lane]
        if now != before:
            floats[SIDE_TOLD + c * LANES + lane] = now
            if abs(before) <= 1.0 and STICKS[c] + KINKS[c] > 0:
                kind = REVERSAL
                if now == 0.0:
                    kind = STICK
                elif before == 0.0:
                    kind = SLIP_FORWARD if now > 0.0 else SLIP_BACK
                write_event(floats, ints, trace, lane, kind, c, 0.0)


def on_event(floats, ints, trace, lane, kind, contact, s):
    """An event at time s after the lane's present time; where s is not 0 (a graze), the state is that of the series."""
    if kind >= SWITCHED:
        tell_sides(floats, ints, trace, lane)  # what happened before
    write_event(floats, ints, trace, lane, kind, contact, s)


def write_event(floats, ints, trace, lane, kind, contact, s):
    """Write an event to the trace."""
    place = ints[RECORDED_EVENT_START + lane] + ints[RECORDED_EVENTS + lane] * EVENT_SIZE
    trace[place] = ints[PERIOD_COUNT + lane]
    trace[place + 1] = floats[TIME + lane] + s
    trace[place + 2] = kind
    for i in range(ROWS):
        if s == 0.0:
            trace[place + EVENT_HEAD + i] = floats[STATE + i * LANES + lane]
        else:
            trace[place + EVENT_HEAD + i] = series_value(floats, SERIES + i * (ORDER + 1) * LANES + lane, s)
    trace[place + EVENT_HEAD + ROWS] = contact + 1
    ints[RECORDED_EVENTS + lane] += 1


def on_jump(floats, ints, lane, gained):
    """Pieces and events tell it."""


def on_period(floats, ints, trace, lane):
    """A period begins; the lane stands at its start."""
    for i in range(ROWS):
        trace[ints[PERIOD_COUNT + lane] * ROWS + i] = floats[STATE + i * LANES + lane]
