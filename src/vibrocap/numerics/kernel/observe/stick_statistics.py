"""Sticking during a run: time at rest and number of rests in the window, and the mode sequence of its last period.

A phase is a stretch of time on one side. What is shorter than a sliver, cut off by the window's end, is no phase.
"""

from vibrocap.numerics.kernel.codes import LETTERS_PER_PLACE, MODE_PLACES
from vibrocap.numerics.kernel.generated.ensemble import (
    LETTER_COUNT,
    LETTER_LENGTH,
    LETTER_SIDE,
    LETTERS,
    PHASE_LENGTH,
    PHASE_SIDE,
    STICK_PHASES,
    STICK_TIME,
)
from vibrocap.numerics.kernel.generated.lane import PERIOD, SIDE
from vibrocap.numerics.kernel.generated.sizes import LANES

SLIVER = 1e-12  # of a period
NO_SIDE = 2.0  # before the first phase
NOT_SPELLING = -1.0  # count of letters before the last period


def begin_phases(floats, lane):
    """The window begins."""
    floats[PHASE_SIDE + lane] = NO_SIDE
    floats[LETTER_COUNT + lane] = NOT_SPELLING


def begin_sequence(floats, lane):
    """The last period begins."""
    floats[LETTER_SIDE + lane] = NO_SIDE
    floats[LETTER_LENGTH + lane] = 0.0
    floats[LETTER_COUNT + lane] = 0.0


def spell(floats, lane, h):
    """A piece of length h."""
    side = floats[SIDE + lane]
    if side != floats[PHASE_SIDE + lane]:
        end_phase(floats, lane)
        floats[PHASE_SIDE + lane] = side
        floats[PHASE_LENGTH + lane] = 0.0
    floats[PHASE_LENGTH + lane] += h
    if floats[LETTER_COUNT + lane] == NOT_SPELLING:
        return
    if side != floats[LETTER_SIDE + lane]:
        end_letter(floats, lane)
        floats[LETTER_SIDE + lane] = side
        floats[LETTER_LENGTH + lane] = 0.0
    floats[LETTER_LENGTH + lane] += h


def end_phases(floats, lane):
    """The window ends, and with it the last phase and letter."""
    end_phase(floats, lane)
    end_letter(floats, lane)


def end_phase(floats, lane):
    """Count the present phase of the window if it is a rest."""
    if floats[PHASE_SIDE + lane] == 0.0 and floats[PHASE_LENGTH + lane] > SLIVER * floats[PERIOD + lane]:
        floats[STICK_TIME + lane] += floats[PHASE_LENGTH + lane]
        floats[STICK_PHASES + lane] += 1.0


def end_letter(floats, lane):
    """Write the letter of the present phase: 1 forward, 2 stuck, 3 back, as the last two bits of a place."""
    if floats[LETTER_SIDE + lane] == NO_SIDE or floats[LETTER_LENGTH + lane] <= SLIVER * floats[PERIOD + lane]:
        return
    count = int(floats[LETTER_COUNT + lane])
    if count < MODE_PLACES * LETTERS_PER_PLACE:
        place = LETTERS + count // LETTERS_PER_PLACE * LANES + lane
        floats[place] = 4.0 * floats[place] + (2.0 - floats[LETTER_SIDE + lane])
    floats[LETTER_COUNT + lane] = count + 1.0
