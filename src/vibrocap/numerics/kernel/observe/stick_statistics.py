"""Sticking during a run: time at rest and number of rests in the window, and the mode sequence of its last period.

A phase is a stretch of time on one side. What is shorter than a sliver, cut off by the window's end, is no phase.
"""

from vibrocap.numerics.kernel.codes import LETTERS_PER_PLACE, MODE_PLACES
from vibrocap.numerics.kernel.generated.places import LETTERS
from vibrocap.numerics.kernel.generated.sizes import LANES

SLIVER = 1e-12  # of a period: what a window cuts off a phase by rounding is no phase
NO_SIDE = 2.0  # before the first phase
NOT_SPELLING = -1.0  # count of letters before the last period


def begin_phases(floats, lane):
    """The window begins."""
    lane.phase_side = NO_SIDE
    lane.letter_count = NOT_SPELLING


def begin_sequence(floats, lane):
    """The last period begins."""
    lane.letter_side = NO_SIDE
    lane.letter_length = 0.0
    lane.letter_count = 0.0


def spell(floats, lane, h):
    """A piece of length h."""
    side = lane.side
    if side != lane.phase_side:
        end_phase(floats, lane)
        lane.phase_side = side
        lane.phase_length = 0.0
    lane.phase_length += h
    if lane.letter_count == NOT_SPELLING:
        return
    if side != lane.letter_side:
        end_letter(floats, lane)
        lane.letter_side = side
        lane.letter_length = 0.0
    lane.letter_length += h


def end_phases(floats, lane):
    """The window ends, and with it the last phase and letter."""
    end_phase(floats, lane)
    end_letter(floats, lane)


def end_phase(floats, lane):
    """Count the present phase of the window if it is a rest."""
    if lane.phase_side == 0.0 and lane.phase_length > SLIVER * lane.period:
        lane.stick_time += lane.phase_length
        lane.stick_phases += 1.0


def end_letter(floats, lane):
    """Write the letter of the present phase: 1 forward, 2 stuck, 3 back, as the last two bits of a place."""
    if lane.letter_side == NO_SIDE or lane.letter_length <= SLIVER * lane.period:
        return
    count = int(lane.letter_count)
    if count < MODE_PLACES * LETTERS_PER_PLACE:
        place = LETTERS + count // LETTERS_PER_PLACE * LANES + lane
        floats[place] = 4.0 * floats[place] + (2.0 - lane.letter_side)
    lane.letter_count = count + 1.0
