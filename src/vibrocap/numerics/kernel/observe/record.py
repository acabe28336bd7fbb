"""Recording a whole motion: the hooks that the loop calls in a run of which everything is kept (one lane)."""

from vibrocap.numerics.kernel.codes import TAPE_FULL
from vibrocap.numerics.kernel.generated import (
    EVENT_SIZE,
    LANES,
    ORDER,
    PERIOD_COUNT,
    PIECE_LIMIT,
    PIECE_SIZE,
    PIECE_START,
    PIECES,
    RECORDED_EVENT_LIMIT,
    RECORDED_EVENT_START,
    RECORDED_EVENTS,
    ROWS,
    SERIES,
    SIDE,
    STATE,
    STATUS,
    STIFF,
    TIME,
)
from vibrocap.numerics.kernel.memory_layout import EVENT_HEAD, PIECE_HEAD
from vibrocap.numerics.kernel.step.taylor import series_value


def has_room(real, whole, tape, lane):
    """Whether the tape can take one more step; else the lane waits as TAPE_FULL."""
    piece = whole[PIECES + lane] < whole[PIECE_LIMIT + lane]
    events = whole[RECORDED_EVENTS + lane] + 4 < whole[RECORDED_EVENT_LIMIT + lane]
    if not (piece and events):
        whole[STATUS + lane] = TAPE_FULL
    return piece and events


def on_piece(real, whole, tape, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""
    place = whole[PIECE_START + lane] + whole[PIECES + lane] * PIECE_SIZE
    tape[place] = whole[PERIOD_COUNT + lane]
    tape[place + 1] = real[TIME + lane]
    tape[place + 2] = h
    tape[place + 3] = real[SIDE + lane]
    tape[place + 4] = whole[STIFF + lane]
    # Not in the order of the memory: LLVM would copy several at once, and a wide load waits until all narrow stores to
    # its place, of the coefficients just written, have left the processor. That was a seventh of the time of a motion.
    for k in range(ORDER + 1):
        for i in range(ROWS):
            tape[place + PIECE_HEAD + i * (ORDER + 1) + k] = real[SERIES + (i * (ORDER + 1) + k) * LANES + lane]
    whole[PIECES + lane] += 1


def on_event(real, whole, tape, lane, kind, s):
    """An event at time s after the lane's present time; where s is not 0 (a graze), the state is that of the series."""
    place = whole[RECORDED_EVENT_START + lane] + whole[RECORDED_EVENTS + lane] * EVENT_SIZE
    tape[place] = whole[PERIOD_COUNT + lane]
    tape[place + 1] = real[TIME + lane] + s
    tape[place + 2] = kind
    for i in range(ROWS):
        if s == 0.0:
            tape[place + EVENT_HEAD + i] = real[STATE + i * LANES + lane]
        else:
            tape[place + EVENT_HEAD + i] = series_value(real, SERIES + i * (ORDER + 1) * LANES + lane, s)
    whole[RECORDED_EVENTS + lane] += 1


def on_jump(real, whole, lane, gained):
    """Pieces and events tell it."""


def on_period(real, whole, tape, lane):
    """A period begins; the lane stands at its start."""
    for i in range(ROWS):
        tape[whole[PERIOD_COUNT + lane] * ROWS + i] = real[STATE + i * LANES + lane]
