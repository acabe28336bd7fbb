"""Measuring over a window: the hooks that the loop calls in a run of an ensemble, of which only measures are kept.

A run is followed without measuring until its window begins: when its stroboscopic state has settled, then for one
response period, or else for the last periods of its budget.
"""

from vibrocap.numerics.generated import (
    LANES,
    MEASURED,
    MEASURED_COUNT,
    PERIOD_COUNT,
    REMAINING,
    RESPONSE,
    SINCE,
    START_STATE,
    STATE,
    STATES,
    THRESHOLD,
    WHOLE_PERIODS,
    WINDOW,
    WINDOW_START,
)
from vibrocap.numerics.settle import remember, settled_response


def has_room(real, whole, tape, lane):
    """Nothing is recorded, so there is always room."""
    return True


def on_piece(real, whole, tape, lane, h):
    """A step of length h was accepted; its series still stands in memory, the lane at its start."""


def on_event(real, whole, tape, lane, kind, s):
    """Events are not recorded."""


def on_period(real, whole, tape, lane):
    """A period begins; the lane stands at its start."""
    done = whole[PERIOD_COUNT + lane]
    if real[THRESHOLD + lane] > 0.0 and whole[RESPONSE + lane] == 0:
        remember(real, whole, lane)
        response, since, remaining = settled_response(real, whole, lane)
        if response > 0 and done + response <= whole[WHOLE_PERIODS + lane]:
            whole[RESPONSE + lane] = response
            whole[SINCE + lane] = since
            real[REMAINING + lane] = remaining
            whole[WHOLE_PERIODS + lane] = done + response
            begin_window(real, whole, lane)
            return
    if whole[WINDOW_START + lane] < 0 and done == whole[WHOLE_PERIODS + lane] - whole[WINDOW + lane]:
        begin_window(real, whole, lane)


def begin_window(real, whole, lane):
    """Measure from here on."""
    whole[WINDOW_START + lane] = whole[PERIOD_COUNT + lane]
    for i in range(STATES):
        real[START_STATE + i * LANES + lane] = real[STATE + i * LANES + lane]
    for i in range(MEASURED_COUNT):
        real[MEASURED + i * LANES + lane] = 0.0
