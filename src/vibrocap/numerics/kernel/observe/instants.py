"""A recorded motion at any instant: its states and observables, for a page that draws it; and how a run begins."""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.generated.sizes import (
    CONTACTS,
    ORDER,
    PIECE_SIZE,
    RATE_ROWS,
    ROOM,
    STATES,
    WHOLE_COUNT,
    WHOLE_ROWS,
)
from vibrocap.numerics.kernel.lane import alone
from vibrocap.numerics.kernel.memory_layout import PIECE_HEAD
from vibrocap.numerics.kernel.observe.one_instant import INSTANT, OBSERVED, take_sizes, write_observed
from vibrocap.numerics.kernel.step.taylor import series_value


def begin(floats, ints, trace, out):
    """Write to the trace: room and natural sizes of the states, period.

    From `out` on, of the parameters and the states in memory; the sizes are put where the run looks for them, too.
    """
    take_sizes(floats)
    for i in range(ROOM + STATES + 1):
        trace[out + i] = floats[OBSERVED + i]


def take_piece(floats, ints, trace, place):
    """Put the piece that begins at trace[place] into memory, as if the run stood at its start.

    Of a drive with corners the table stands at TABLE_START, and the segment of the piece becomes the present one.
    """
    alone.time = trace[place + 1]
    hook.begin_drive(floats, ints, trace, 0, 0)
    alone.step = trace[place + 2]
    for c in range(CONTACTS):
        alone.side[c] = trace[place + PIECE_SIZE - CONTACTS + c]
    alone.stiff = 1 if trace[place + 3] != 0.0 else 0
    for i in range(STATES):
        floats[alone.row[i]] = trace[place + PIECE_HEAD + i]
    out = place + PIECE_HEAD + STATES - 1
    for i in range(WHOLE_COUNT):
        for k in range(1, ORDER + 1):
            floats[alone.row[WHOLE_ROWS[i]] + k] = trace[out + i * ORDER + k]
    for i in range(STATES):
        if RATE_ROWS[i] >= 0:
            for k in range(1, ORDER + 1):
                rate = floats[alone.row[RATE_ROWS[i]] + k - 1]
                floats[alone.row[i] + k] = rate * (1.0 / k)


def look_at(floats, ints, trace, share, out):
    """Write states, then observables, at a share of the way through the piece in memory to the trace from `out` on.

    What depends on the law's forces is asked at a state consistent with the slopes, see `stiff_point.py`.
    """
    s = share * alone.step
    for i in range(STATES):
        floats[INSTANT + i] = series_value(floats, alone.row[i], s)
    write_observed(floats, ints, trace, s, out)
