"""Recording a whole motion: the hooks that the loop calls in a run of which everything is kept (one lane).

Events of contacts are what their sides tell: of one that rests in a piece and did not in the one before, and so on. The
modes that are tried at an instant are none.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.codes import SWITCHED, TRACE_FULL
from vibrocap.numerics.kernel.events.transitions import change_of_side
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.memory_layout import EVENT_HEAD, PIECE_HEAD
from vibrocap.numerics.kernel.step.taylor import series_value


def has_room(floats, ints, trace, lane):
    """Whether the trace can take one more step; else the lane waits as TRACE_FULL."""
    piece = lane.pieces < lane.piece_limit
    events = lane.recorded_events + 4 + CONTACTS < lane.recorded_event_limit
    if not (piece and events):
        lane.status = TRACE_FULL
    return piece and events


def on_piece(floats, ints, trace, lane, h):
    record_sides(floats, ints, trace, lane)
    place = lane.piece_start + lane.pieces * PIECE_SIZE
    trace[place] = lane.period_count
    trace[place + 1] = lane.time
    trace[place + 2] = h
    trace[place + 3] = lane.stiff
    # Not in the order of the memory: LLVM would copy several at once, and a wide load waits until all narrow stores to
    # its place, of the coefficients just written, have left the processor. That was a seventh of the time of a motion.
    for i in range(STATES):
        trace[place + PIECE_HEAD + i] = lane.series[i * (ORDER + 1)]
    out = place + PIECE_HEAD + STATES - 1
    for k in range(1, ORDER + 1):
        for i in range(WHOLE_COUNT):
            trace[out + i * ORDER + k] = lane.series[WHOLE_ROWS[i] * (ORDER + 1) + k]
    for c in range(CONTACTS):
        trace[place + PIECE_SIZE - CONTACTS + c] = lane.side[c]
    lane.pieces += 1


def on_instant(floats, ints, trace, lane):
    """If there was an event at the last instant, what begins there is a piece of no length."""
    record_sides(floats, ints, trace, lane)
    last = lane.recorded_event_start + (lane.recorded_events - 1) * EVENT_SIZE
    if lane.recorded_events == 0 or trace[last] != lane.period_count:
        return
    if lane.time - trace[last + 1] <= 2.0 * EPSILON * lane.period:
        on_piece(floats, ints, trace, lane, 0.0)


def record_sides(floats, ints, trace, lane):
    """Record what has become of the sides since they were told last."""
    for c in range(CONTACTS):
        kind = change_of_side(floats, lane, c)
        if kind >= 0:
            write_event(floats, ints, trace, lane, kind, c, 0.0)


def on_event(floats, ints, trace, lane, kind, contact, s):
    """An event at time s after the lane's present time; where s is not 0 (a graze), the state is that of the series."""
    if kind >= SWITCHED:
        record_sides(floats, ints, trace, lane)  # what happened before
    write_event(floats, ints, trace, lane, kind, contact, s)


def write_event(floats, ints, trace, lane, kind, contact, s):
    """Write an event to the trace."""
    place = lane.recorded_event_start + lane.recorded_events * EVENT_SIZE
    trace[place] = lane.period_count
    trace[place + 1] = lane.time + s
    trace[place + 2] = kind
    for i in range(STATES):
        if s == 0.0:
            trace[place + EVENT_HEAD + i] = lane.state[i]
        else:
            trace[place + EVENT_HEAD + i] = series_value(floats, lane.row[i], s)
    trace[place + EVENT_HEAD + STATES] = contact + 1
    lane.recorded_events += 1


def on_period(floats, ints, trace, lane):
    for i in range(STATES):
        trace[lane.period_count * STATES + i] = lane.state[i]
