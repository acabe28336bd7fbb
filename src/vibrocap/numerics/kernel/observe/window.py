"""Measuring over a window: the hooks that the loop calls in a run of an ensemble, of which only measures are kept.

A run is followed without measuring until its window begins: when its stroboscopic state has settled, then for one
response period, or else for the last periods of its budget. Of what can be measured only the groups asked for are.
"""

import math

from vibrocap.numerics.kernel.codes import ASK_EXTREMES, ASK_INTEGRALS, ASK_MAGNITUDE, ASK_MODES, ASK_PEAK, ASK_SYMMETRY
from vibrocap.numerics.kernel.generated.branches import IMPACT
from vibrocap.numerics.kernel.generated.ensemble import (
    ASKED,
    ASYMMETRY,
    EVIDENCE_PERIODS,
    INTEGRAL,
    LARGEST,
    LEAST,
    MARKS,
    MEASURED,
    ON_TRIAL,
    PEAK,
    PERIOD_BUDGET,
    REMAINING,
    RESPONSE,
    SINCE,
    START_STATE,
    THRESHOLD,
    WINDOW,
    WINDOW_START,
)
from vibrocap.numerics.kernel.generated.facts import CYCLIC, MIRROR, TURN_COUNT, TURN_RADII, TURN_STATES
from vibrocap.numerics.kernel.generated.lane import (
    PERIOD,
    PERIOD_COUNT,
    SCALE,
    SERIES,
    STATE,
    TIME,
    TOLERANCE,
    WHOLE_PERIODS,
)
from vibrocap.numerics.kernel.generated.sizes import INTEGRANDS, LANES, MEASURED_COUNT, ORDER, STATES, SUMMED
from vibrocap.numerics.kernel.interface import (
    begin_drive_period,
    quiet_since,
    response_sought,
    starts_trial,
    take_evidence,
    trial_fails,
)
from vibrocap.numerics.kernel.observe.accumulators import gather_extremes, gather_functions
from vibrocap.numerics.kernel.observe.settle import LONGEST_PERIOD, remember, settled_response, still_settled
from vibrocap.numerics.kernel.observe.stick_statistics import begin_phases, begin_sequence, end_phases, spell
from vibrocap.numerics.kernel.step.taylor import series_value

FAR = 1e300  # beyond any number that is measured


def has_room(floats, ints, trace, lane):
    """Nothing is recorded, so there is always room."""
    return True


def on_piece(floats, ints, trace, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""
    asked = ints[ASKED]
    if ints[WINDOW_START + lane] < 0:
        return
    last = ints[WHOLE_PERIODS + lane] - ints[PERIOD_COUNT + lane] <= ints[EVIDENCE_PERIODS]
    if ints[EVIDENCE_PERIODS] > 0 and (last or ints[RESPONSE + lane] > 0):
        take_evidence(floats, ints, lane, h)
    if asked == 0:
        return
    if asked & (ASK_INTEGRALS | ASK_MAGNITUDE | ASK_PEAK) != 0:
        gather_functions(floats, ints, lane, h)
    if asked & ASK_EXTREMES != 0:
        gather_extremes(floats, lane, h)
    if asked & ASK_MODES != 0:
        spell(floats, lane, h)
    if asked & ASK_SYMMETRY != 0:
        half = 0.5 * floats[PERIOD + lane]
        if floats[TIME + lane] <= half < floats[TIME + lane] + h:
            floats[ASYMMETRY + lane] = min(
                floats[ASYMMETRY + lane], asymmetry(floats, lane, half - floats[TIME + lane])
            )


def on_event(floats, ints, trace, lane, kind, contact, s):
    """Events are not recorded."""


def on_jump(floats, ints, lane, gained):
    """Energy that an impact takes is work of a channel of its own."""
    if ints[ASKED] & ASK_INTEGRALS != 0 and ints[WINDOW_START + lane] >= 0:
        floats[INTEGRAL + IMPACT * LANES + lane] += gained


def on_period(floats, ints, trace, lane):
    """A period begins; the lane stands at its start."""
    if trial_fails(floats, ints, lane):
        return
    done = ints[PERIOD_COUNT + lane]
    threshold = floats[THRESHOLD + lane]
    mark = done - quiet_since(ints, lane)
    if threshold > 0.0 and mark >= 0:
        remember(floats, MARKS, lane, mark)
    response = ints[RESPONSE + lane]
    ends = response > 0 and mark >= 0 and ints[ON_TRIAL + lane] == 0 and done == ints[WHOLE_PERIODS + lane]
    if ends and not still_settled(floats, MARKS, lane, mark, response, threshold, floats[TOLERANCE + lane]):
        ints[RESPONSE + lane] = 0
        ints[WHOLE_PERIODS + lane] = ints[PERIOD_BUDGET]
        if ints[PERIOD_BUDGET] - done >= ints[WINDOW + lane]:  # else the window goes on to the end
            ints[WINDOW_START + lane] = -1
        begin_drive_period(floats, ints, trace, lane)  # which it does not where a run ends
    if threshold > 0.0 and ints[RESPONSE + lane] == 0:
        response, since, remaining = 0, 0, 0.0
        if mark >= 0:
            longest = response_sought(LONGEST_PERIOD)
            response, since, remaining = settled_response(
                floats, MARKS, lane, mark, longest, threshold, floats[TOLERANCE + lane]
            )
        if response > 0 and done + response <= ints[WHOLE_PERIODS + lane]:
            ints[RESPONSE + lane] = response
            ints[SINCE + lane] = done - mark + since
            floats[REMAINING + lane] = remaining
            ints[WHOLE_PERIODS + lane] = done + response
            begin_window(floats, ints, lane)
    left = ints[WHOLE_PERIODS + lane] - done
    if ints[WINDOW_START + lane] < 0 and left == ints[WINDOW + lane]:
        begin_window(floats, ints, lane)
    if left == 1:
        begin_sequence(floats, lane)
    elif left == 0:
        end_phases(floats, lane)
    if threshold > 0.0 and ints[RESPONSE + lane] == 0 and starts_trial(floats, ints, lane):
        ints[RESPONSE + lane] = 1
        ints[SINCE + lane] = done
        floats[REMAINING + lane] = threshold
        ints[WHOLE_PERIODS + lane] = done + 1
        begin_window(floats, ints, lane)
        begin_sequence(floats, lane)


def begin_window(floats, ints, lane):
    """Measure from here on; what was measured before is forgotten."""
    ints[WINDOW_START + lane] = ints[PERIOD_COUNT + lane]
    for i in range(MEASURED_COUNT):
        floats[MEASURED + i * LANES + lane] = 0.0
    for i in range(STATES):
        state = floats[STATE + i * LANES + lane]
        floats[START_STATE + i * LANES + lane] = state
        floats[LARGEST + i * LANES + lane] = state
        floats[LEAST + i * LANES + lane] = state
    for i in range(INTEGRANDS - SUMMED):
        floats[PEAK + (1 + i) * LANES + lane] = -FAR
    floats[ASYMMETRY + lane] = FAR
    begin_phases(floats, lane)


def asymmetry(floats, lane, s):
    """Distance, over natural sizes, of the state at time s of the piece from the mirrored one at the window's start."""
    largest = 0.0
    for i in range(STATES):
        if i != CYCLIC:
            state = series_value(floats, SERIES + i * (ORDER + 1) * LANES + lane, s)
            away = abs(state - MIRROR[i] * floats[START_STATE + i * LANES + lane])
            for k in range(TURN_COUNT):
                if i == TURN_STATES[k]:  # the chord between both on its circle
                    away = 2.0 * TURN_RADII[k] * abs(math.sin(0.5 * away / TURN_RADII[k]))
            largest = max(largest, away / floats[SCALE + i * LANES + lane])
    return largest
