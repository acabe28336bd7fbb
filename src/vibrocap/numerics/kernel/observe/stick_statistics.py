"""Sticking of each contact during a run: time at rest and number of rests in the window, and the mode sequence of the
last period.

A phase is a stretch of time on one side. What is shorter than a sliver, cut off by the window's end, is no phase.
"""

from vibrocap.numerics.kernel.codes import LETTERS_PER_PLACE, MODE_PLACES
from vibrocap.numerics.kernel.generated.places import LETTERS
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES

SLIVER = 1e-12  # of a period: what a window cuts off a phase by rounding is no phase
NO_SIDE = 2.0  # before the first phase
NOT_SPELLING = -1.0  # count of letters before the last period


def begin_phases(floats, lane):
    """The window begins."""
    for c in range(CONTACTS):
        lane.phase_side[c] = NO_SIDE
        lane.letter_count[c] = NOT_SPELLING


def begin_sequence(floats, lane):
    """The last period begins."""
    for c in range(CONTACTS):
        lane.letter_side[c] = NO_SIDE
        lane.letter_length[c] = 0.0
        lane.letter_count[c] = 0.0


def spell(floats, lane, h):
    """A piece of length h."""
    for c in range(CONTACTS):
        side = lane.side[c]
        if side != lane.phase_side[c]:
            end_phase(floats, lane, c)
            lane.phase_side[c] = side
            lane.phase_length[c] = 0.0
        lane.phase_length[c] += h
        if lane.letter_count[c] != NOT_SPELLING:
            if side != lane.letter_side[c]:
                end_letter(floats, lane, c)
                lane.letter_side[c] = side
                lane.letter_length[c] = 0.0
            lane.letter_length[c] += h


def end_phases(floats, lane):
    """The window ends, and with it the last phase and letter of each contact."""
    for c in range(CONTACTS):
        end_phase(floats, lane, c)
        end_letter(floats, lane, c)


def end_phase(floats, lane, c):
    """Count the present phase of the window if it is a rest."""
    if lane.phase_side[c] == 0.0 and lane.phase_length[c] > SLIVER * lane.period:
        lane.stick_time[c] += lane.phase_length[c]
        lane.stick_phases[c] += 1.0


def end_letter(floats, lane, c):
    """Write the letter of the present phase: 1 forward, 2 stuck, 3 back, as the last two bits of a place."""
    if lane.letter_side[c] == NO_SIDE or lane.letter_length[c] <= SLIVER * lane.period:
        return
    count = int(lane.letter_count[c])
    if count < MODE_PLACES * LETTERS_PER_PLACE:
        place = LETTERS + (c * MODE_PLACES + count // LETTERS_PER_PLACE) * LANES + lane
        floats[place] = 4.0 * floats[place] + (2.0 - lane.letter_side[c])
    lane.letter_count[c] = count + 1.0
