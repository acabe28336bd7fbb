"""A recorded motion at any instant: its states and observables, for a page that draws it; and how a run begins."""

from vibrocap.numerics.kernel.generated import (
    LANES,
    OBSERVABLES,
    ORDER,
    ROOM,
    ROWS,
    SCALE,
    SERIES,
    SIDE,
    STATE,
    STATES,
    STEP,
    STIFF,
    TABLE_NUMBERS,
    TIME,
    WORK,
    beginning,
    drive_table,
    observables,
)
from vibrocap.numerics.kernel.interface import begin_drive, fitting_point
from vibrocap.numerics.kernel.memory_layout import PIECE_HEAD
from vibrocap.numerics.kernel.step.taylor import hold_rate, series_value

INSTANT = WORK
SEEN = INSTANT + STATES


def begin(real, whole, tape, out):
    """Write to the tape: room and natural sizes of the states, period, contact velocity, holding rate, segments.

    From `out` on, of the parameters and the states in memory; the sizes are put where the run looks for them, too.
    """
    for i in range(STATES):
        real[INSTANT + i] = real[STATE + i * LANES]
    beginning(real, 0.0, INSTANT, 1.0, 0, SEEN)
    for i in range(ROOM + STATES + 2):
        tape[out + i] = real[SEEN + i]
    tape[out + ROOM + STATES + 2] = hold_rate(real[SEEN + ROOM + STATES], ORDER)
    for i in range(STATES):
        real[SCALE + i * LANES] = real[SEEN + ROOM + i]
    drive_table(real, 0.0, INSTANT, 1.0, 0, SEEN)
    for i in range(TABLE_NUMBERS):
        tape[out + ROOM + STATES + 3 + i] = real[SEEN + i]


def take_piece(real, whole, tape, place):
    """Put the piece that begins at tape[place] into memory, as if the run stood at its start.

    Of a drive with corners the table stands at TABLE_START, and the segment of the piece becomes the present one.
    """
    real[TIME] = tape[place + 1]
    begin_drive(real, whole, tape, 0, 0)
    real[STEP] = tape[place + 2]
    real[SIDE] = tape[place + 3]
    whole[STIFF] = 1 if tape[place + 4] != 0.0 else 0
    for i in range(ROWS * (ORDER + 1)):
        real[SERIES + i] = tape[place + PIECE_HEAD + i]


def look_at(real, whole, tape, share, out):
    """Write states, then observables, at a share of the way through the piece in memory to the tape from `out` on.

    What depends on the law's forces is asked at a state that fits to the slopes, see `stiff_point.py`.
    """
    s = share * real[STEP]
    for i in range(STATES):
        state = series_value(real, SERIES + i * (ORDER + 1), s)
        tape[out + i] = state
        real[INSTANT + i] = state
    fitting_point(real, whole, 0, s, INSTANT)
    observables(real, real[TIME] + s, INSTANT, real[SIDE], 0, SEEN)
    for i in range(OBSERVABLES):
        tape[out + STATES + i] = real[SEEN + i]
