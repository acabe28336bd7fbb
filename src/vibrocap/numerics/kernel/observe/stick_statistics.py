"""Sticking during a run: the time at rest and the number of rests in the window, and the word of its last period.

A phase is a stretch of time on one side. What is shorter than a sliver, cut off by the window's end, is no phase.
"""

from vibrocap.numerics.kernel.codes import LETTERS_PER_PLACE, WORD_PLACES
from vibrocap.numerics.kernel.generated import (
    LANES,
    LETTER_COUNT,
    LETTER_LENGTH,
    LETTER_SIDE,
    LETTERS,
    PERIOD,
    PHASE_LENGTH,
    PHASE_SIDE,
    SIDE,
    STICK_PHASES,
    STICK_TIME,
)

SLIVER = 1e-12  # of a period
NO_SIDE = 2.0  # before the first phase
NOT_SPELLING = -1.0  # count of letters before the last period


def begin_phases(real, lane):
    """The window begins."""
    real[PHASE_SIDE + lane] = NO_SIDE
    real[LETTER_COUNT + lane] = NOT_SPELLING


def begin_word(real, lane):
    """The last period begins."""
    real[LETTER_SIDE + lane] = NO_SIDE
    real[LETTER_LENGTH + lane] = 0.0
    real[LETTER_COUNT + lane] = 0.0


def spell(real, lane, h):
    """A piece of length h."""
    side = real[SIDE + lane]
    if side != real[PHASE_SIDE + lane]:
        end_phase(real, lane)
        real[PHASE_SIDE + lane] = side
        real[PHASE_LENGTH + lane] = 0.0
    real[PHASE_LENGTH + lane] += h
    if real[LETTER_COUNT + lane] == NOT_SPELLING:
        return
    if side != real[LETTER_SIDE + lane]:
        end_letter(real, lane)
        real[LETTER_SIDE + lane] = side
        real[LETTER_LENGTH + lane] = 0.0
    real[LETTER_LENGTH + lane] += h


def end_phases(real, lane):
    """The window ends, and with it the last phase and letter."""
    end_phase(real, lane)
    end_letter(real, lane)


def end_phase(real, lane):
    """Count the present phase of the window if it is a rest."""
    if real[PHASE_SIDE + lane] == 0.0 and real[PHASE_LENGTH + lane] > SLIVER * real[PERIOD + lane]:
        real[STICK_TIME + lane] += real[PHASE_LENGTH + lane]
        real[STICK_PHASES + lane] += 1.0


def end_letter(real, lane):
    """Write the letter of the present phase: 1 forward, 2 stuck, 3 back, as the last two bits of a place."""
    if real[LETTER_SIDE + lane] == NO_SIDE or real[LETTER_LENGTH + lane] <= SLIVER * real[PERIOD + lane]:
        return
    count = int(real[LETTER_COUNT + lane])
    if count < WORD_PLACES * LETTERS_PER_PLACE:
        place = LETTERS + count // LETTERS_PER_PLACE * LANES + lane
        real[place] = 4.0 * real[place] + (2.0 - real[LETTER_SIDE + lane])
    real[LETTER_COUNT + lane] = count + 1.0
