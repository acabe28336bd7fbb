"""Measuring over a window: the hooks that the loop calls in a run of an ensemble, of which only measures are kept.

A run is followed without measuring until its window begins: when its stroboscopic state has settled, then for one
response period, or else for the last periods of its budget. Of what can be measured only the groups asked for are.

Sticking is told by phases, stretches of time on one side: time at rest and number of rests of each contact in the
window, and the mode sequence of the last period. What is shorter than a sliver, cut off by the window's end, is none.
"""

import math

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import HUGE
from vibrocap.numerics.kernel.codes import (
    ASK_EXTREMES,
    ASK_INTEGRALS,
    ASK_MAGNITUDE,
    ASK_MODES,
    ASK_PEAK,
    ASK_SYMMETRY,
    LETTERS_PER_PLACE,
    LONGEST_PERIOD,
    MODE_PLACES,
    SLIVER,
)
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import shared
from vibrocap.numerics.kernel.observe.accumulators import gather_extremes, gather_functions
from vibrocap.numerics.kernel.observe.settle import remember, settled_response, still_settled
from vibrocap.numerics.kernel.step.taylor import series_value


def on_piece(floats, ints, trace, lane, h):
    asked = shared.asked
    if lane.window_start < 0:
        return
    last = lane.whole_periods - lane.period_count <= shared.evidence_periods
    if shared.evidence_periods > 0 and (last or lane.response > 0):
        hook.take_evidence(floats, ints, lane, h)
    if asked == 0:
        return
    if asked & (ASK_INTEGRALS | ASK_MAGNITUDE | ASK_PEAK) != 0:
        gather_functions(floats, ints, lane, h)
    if asked & ASK_EXTREMES != 0:
        gather_extremes(floats, lane, h)
    if asked & ASK_MODES != 0:
        spell(floats, lane, h)
    if asked & ASK_SYMMETRY != 0:
        half = 0.5 * lane.period
        if lane.time <= half < lane.time + h:
            lane.asymmetry = min(lane.asymmetry, asymmetry(floats, lane, half - lane.time))


def on_jump(floats, ints, lane, gained):
    """Energy that an impact takes is work of a channel of its own."""
    if shared.asked & ASK_INTEGRALS != 0 and lane.window_start >= 0:
        lane.integral[IMPACT] += gained


def on_period(floats, ints, trace, lane):
    if hook.trial_fails(floats, ints, lane):
        return
    done = lane.period_count
    threshold = lane.threshold
    mark = done - hook.quiet_since(ints, lane)
    if threshold > 0.0 and mark >= 0:
        remember(floats, MARKS, lane, mark)
    response = lane.response
    ends = response > 0 and mark >= 0 and lane.on_trial == 0 and done == lane.whole_periods
    if ends and not still_settled(floats, MARKS, lane, mark, response):
        lane.response = 0
        lane.whole_periods = shared.period_budget
        if shared.period_budget - done >= lane.window:  # else the window goes on to the end
            lane.window_start = -1
        hook.begin_drive_period(floats, ints, trace, lane)  # which it does not where a run ends
    if threshold > 0.0 and lane.response == 0:
        response, since, remaining = 0, 0, 0.0
        if mark >= 0:
            longest = hook.response_sought(LONGEST_PERIOD)
            response, since, remaining = settled_response(floats, MARKS, lane, mark, longest)
        if response > 0 and done + response <= lane.whole_periods:
            lane.response = response
            lane.since = done - mark + since
            lane.remaining = remaining
            lane.whole_periods = done + response
            begin_window(floats, ints, lane)
    left = lane.whole_periods - done
    if lane.window_start < 0 and left == lane.window:
        begin_window(floats, ints, lane)
    if left == 1:
        begin_sequence(floats, lane)
    elif left == 0:
        end_phases(floats, lane)
    if threshold > 0.0 and lane.response == 0 and hook.starts_trial(floats, ints, lane):
        lane.response = 1
        lane.since = done
        lane.remaining = threshold
        lane.whole_periods = done + 1
        begin_window(floats, ints, lane)
        begin_sequence(floats, lane)


def begin_window(floats, ints, lane):
    """Measure from here on; what was measured before is forgotten."""
    lane.window_start = lane.period_count
    for i in range(MEASURED_COUNT):
        lane.measured[i] = 0.0
    for i in range(STATES):
        state = lane.state[i]
        lane.start_state[i] = state
        lane.largest[i] = state
        lane.least[i] = state
    for i in range(INTEGRANDS - SUMMED):
        lane.peak[CONTACTS + i] = -HUGE
    lane.asymmetry = HUGE
    for c in range(CONTACTS):
        lane.phase_side[c] = NO_SIDE
        lane.letter_count[c] = NOT_SPELLING


def asymmetry(floats, lane, s):
    """Distance, over natural sizes, of the state at time s of the piece from the mirrored one at the window's start."""
    largest = 0.0
    for i in range(STATES):
        if i != CYCLIC:
            state = series_value(floats, lane.row[i], s)
            away = abs(state - MIRROR[i] * lane.start_state[i])
            for k in range(TURN_COUNT):
                if i == TURN_STATES[k]:  # the chord between both on its circle
                    away = 2.0 * TURN_RADII[k] * abs(math.sin(0.5 * away / TURN_RADII[k]))
            largest = max(largest, away / lane.scale[i])
    return largest


NO_SIDE = 2.0  # before the first phase
NOT_SPELLING = -1.0  # count of letters before the last period


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
