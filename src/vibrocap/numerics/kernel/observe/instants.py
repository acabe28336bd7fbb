"""A recorded motion at any instant: its states and observables, for a page that draws it; and how a run begins."""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import polynomial_slope
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import alone
from vibrocap.numerics.kernel.memory_layout import PIECE_HEAD
from vibrocap.numerics.kernel.observe.one_instant import INSTANT, OBSERVED, take_sizes, write_observed
from vibrocap.numerics.kernel.step.taylor import series_state


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

    What depends on the law's forces is asked at a state consistent with the slopes, see `linear_system.py`.
    """
    s = share * alone.step
    series_state(floats, 0, s, INSTANT)
    write_observed(floats, ints, trace, s, out)


STORED_HEAD = 4  # wanted rows, instants, 1 where any row is an observable, bound of what is left of the equations
SEGMENT_SIZE = COEFFICIENTS + 2 if COEFFICIENTS > 0 else 0


def look_along(floats, ints, trace, pieces):
    """Look at so many pieces of a stored motion: states and observables, or what its pieces leave of the equations.

    The trace holds what is wanted, see `run/stored_motion.py`: a head, the wanted rows (states, then observables) with
    1 where a row depends on the law's forces, the pieces as a run records them with the numbers of the drive's segment
    behind, the number of instants up to the end of each piece, their times since the start of the piece. There the rows
    follow, one after the other.
    """
    rows, instants, bound = int(trace[0]), int(trace[1]), trace[3]
    piece = STORED_HEAD + 2 * rows
    ends = piece + pieces * (PIECE_SIZE + SEGMENT_SIZE)
    times = ends + pieces
    out, last = times + instants, times
    for p in range(pieces):
        take_piece(floats, ints, trace, piece)
        for i in range(SEGMENT_SIZE):
            alone.parameter[PRESENT + i] = trace[piece + PIECE_SIZE + i]
        piece += PIECE_SIZE + SEGMENT_SIZE
        first, last = last, times + int(trace[ends + p])
        for at in range(first, last):
            s = trace[at]
            series_state(floats, 0, s, INSTANT)
            if bound > 0.0:
                trace[at + instants] = left_of_equations(floats, ints, s, bound)
            else:
                write_rows(floats, ints, trace, s, at - times + out)
    return 0


def write_rows(floats, ints, trace, s, out):
    """Write the wanted rows; what depends on the law's forces at a state consistent with the slopes."""
    rows, instants, observed = int(trace[0]), int(trace[1]), trace[2] > 0.0
    if observed:
        observables(floats, alone.time + s, INSTANT, 0, OBSERVED)
    for k in range(rows):
        trace[out + k * instants] = floats[INSTANT + int(trace[STORED_HEAD + 2 * k])]
    if MAYBE_STIFF and observed and alone.stiff == 1:
        hook.consistent_state(floats, ints, 0, s, INSTANT)
        observables(floats, alone.time + s, INSTANT, 0, OBSERVED)
        for k in range(rows):
            if trace[STORED_HEAD + 2 * k + 1] > 0.0:
                trace[out + k * instants] = floats[INSTANT + int(trace[STORED_HEAD + 2 * k])]


def left_of_equations(floats, ints, s, bound):
    """h |y' - f(t, y)| over the natural size of a state; of an implicit step, or beyond the bound, along stiff
    directions where there are any."""
    left = 0.0
    rates(floats, alone.time + s, INSTANT, 0, OBSERVED)
    for i in range(STATES):
        slope = polynomial_slope(floats, alone.row[i], 1, ORDER, s)
        own = abs(floats[OBSERVED + i] - slope) * alone.step / alone.scale[i]
        if not (own <= left):  # also where it is no number
            left = own
    if MAYBE_STIFF and (alone.stiff == 1 or not (left <= bound)):
        distance = hook.fit_to_slopes(floats, 0, s, INSTANT)
        if distance > 0.0:
            left = distance
    return left
