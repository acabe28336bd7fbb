"""Measuring over a window: the hooks that the loop calls in a run of an ensemble, of which only measures are kept.

A run is followed without measuring until its window begins: when its stroboscopic state has settled, then for one
response period, or else for the last periods of its budget. Of what can be measured only the groups asked for are.
"""

from vibrocap.numerics.kernel.codes import ASK_EXTREMES, ASK_INTEGRALS, ASK_MAGNITUDE, ASK_PEAK, ASK_SYMMETRY, ASK_WORD
from vibrocap.numerics.kernel.generated import (
    ASKED,
    ASYMMETRY,
    CYCLIC,
    IMPACT,
    INTEGRAL,
    INTEGRANDS,
    LANES,
    LARGEST,
    LEAST,
    MEASURED,
    MEASURED_COUNT,
    MIRROR,
    ORDER,
    PEAK,
    PERIOD,
    PERIOD_COUNT,
    REMAINING,
    RESPONSE,
    SCALE,
    SERIES,
    SINCE,
    START_STATE,
    STATE,
    STATES,
    SUMMED,
    THRESHOLD,
    TIME,
    TOLERANCE,
    WHOLE_PERIODS,
    WINDOW,
    WINDOW_START,
)
from vibrocap.numerics.kernel.observe.accumulators import gather_extremes, gather_functions
from vibrocap.numerics.kernel.observe.settle import remember, settled_response
from vibrocap.numerics.kernel.observe.stick_statistics import begin_phases, begin_word, end_phases, spell
from vibrocap.numerics.kernel.step.taylor import series_value

FAR = 1e300  # beyond any number that is measured


def has_room(real, whole, tape, lane):
    """Nothing is recorded, so there is always room."""
    return True


def on_piece(real, whole, tape, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""
    asked = whole[ASKED]
    if asked == 0 or whole[WINDOW_START + lane] < 0:
        return
    if asked & (ASK_INTEGRALS | ASK_MAGNITUDE | ASK_PEAK) != 0:
        gather_functions(real, whole, lane, h)
    if asked & ASK_EXTREMES != 0:
        gather_extremes(real, lane, h)
    if asked & ASK_WORD != 0:
        spell(real, lane, h)
    if asked & ASK_SYMMETRY != 0:
        half = 0.5 * real[PERIOD + lane]
        if real[TIME + lane] <= half < real[TIME + lane] + h:
            real[ASYMMETRY + lane] = min(real[ASYMMETRY + lane], asymmetry(real, lane, half - real[TIME + lane]))


def on_event(real, whole, tape, lane, kind, s):
    """Events are not recorded."""


def on_jump(real, whole, lane, gained):
    """Energy that an impact takes is work of a channel of its own."""
    if whole[ASKED] & ASK_INTEGRALS != 0 and whole[WINDOW_START + lane] >= 0:
        real[INTEGRAL + IMPACT * LANES + lane] += gained


def on_period(real, whole, tape, lane):
    """A period begins; the lane stands at its start."""
    done = whole[PERIOD_COUNT + lane]
    threshold = real[THRESHOLD + lane]
    if threshold > 0.0 and whole[RESPONSE + lane] == 0:
        remember(real, lane, done)
        response, since, remaining = settled_response(real, lane, done, threshold, real[TOLERANCE + lane])
        if response > 0 and done + response <= whole[WHOLE_PERIODS + lane]:
            whole[RESPONSE + lane] = response
            whole[SINCE + lane] = since
            real[REMAINING + lane] = remaining
            whole[WHOLE_PERIODS + lane] = done + response
            begin_window(real, whole, lane)
    left = whole[WHOLE_PERIODS + lane] - done
    if whole[WINDOW_START + lane] < 0 and left == whole[WINDOW + lane]:
        begin_window(real, whole, lane)
    if left == 1:
        begin_word(real, lane)
    elif left == 0:
        end_phases(real, lane)


def begin_window(real, whole, lane):
    """Measure from here on; what was measured before is forgotten."""
    whole[WINDOW_START + lane] = whole[PERIOD_COUNT + lane]
    for i in range(MEASURED_COUNT):
        real[MEASURED + i * LANES + lane] = 0.0
    for i in range(STATES):
        state = real[STATE + i * LANES + lane]
        real[START_STATE + i * LANES + lane] = state
        real[LARGEST + i * LANES + lane] = state
        real[LEAST + i * LANES + lane] = state
    for i in range(INTEGRANDS - SUMMED):
        real[PEAK + (1 + i) * LANES + lane] = -FAR
    real[ASYMMETRY + lane] = FAR
    begin_phases(real, lane)


def asymmetry(real, lane, s):
    """Distance, over natural sizes, of the state at time s of the piece from the mirrored one at the window's start."""
    largest = 0.0
    for i in range(STATES):
        if i != CYCLIC:
            state = series_value(real, SERIES + i * (ORDER + 1) * LANES + lane, s)
            away = abs(state - MIRROR[i] * real[START_STATE + i * LANES + lane])
            largest = max(largest, away / real[SCALE + i * LANES + lane])
    return largest
