"""Feeding the lanes of an ensemble: a lane that has ended its run writes the result and begins the next one.

Each run has its own steps, modes and events, so lanes end at different times; none waits for the slowest.
"""

from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated.ensemble import (
    DELAY,
    INVERSE_SCALE,
    LAST_RUN,
    MEASURED,
    MORE,
    NEXT_RUN,
    ON_TRIAL,
    PERIOD_BUDGET,
    REFUSED_TRIALS,
    REMAINING,
    RESPONSE,
    RESULT_START,
    RUN,
    SINCE,
    START_STATE,
    WINDOW_START,
)
from vibrocap.numerics.kernel.generated.lane import (
    CONTACT_RESIDUAL,
    IMPLICIT_STEPS,
    PARAMETER,
    PERIOD,
    PERIOD_COUNT,
    SCALE,
    STATE,
    STATUS,
    TAYLOR_STEPS,
    TIME,
    WHOLE_PERIODS,
)
from vibrocap.numerics.kernel.generated.sizes import (
    LANES,
    MEASURED_COUNT,
    PARAMETERS,
    RESULT_SIZE,
    RUN_SIZE,
    STATES,
)
from vibrocap.numerics.kernel.interface import (
    advance,
    begin_marks,
    begin_returns,
    ends_trial,
    on_period,
    tell_returns,
)
from vibrocap.numerics.kernel.loop.start import start_lane
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD_SIZE

ROUNDS = 1000  # steps of all lanes at a time, unless a lane stops before


def advance_ensemble(floats, ints, trace, turns):
    """Advance all lanes, each through run after run, until no run is left; come back to the caller after many steps.

    Where MORE is set it also comes back as soon as a lane finds no run to begin. Returns whether a lane is running.
    """
    for _ in range(turns):
        busy = False
        for lane in range(LANES):
            if ints[STATUS + lane] != RUNNING and not ends_trial(floats, ints, lane):
                if ints[RUN + lane] >= 0:
                    end_run(floats, ints, trace, lane)
                if ints[NEXT_RUN] < ints[LAST_RUN]:
                    begin_run(floats, ints, trace, lane, ints[NEXT_RUN])
                    ints[NEXT_RUN] += 1
                elif ints[MORE] != 0:
                    return True
            busy = busy or ints[STATUS + lane] == RUNNING
        if not busy:
            return False
        advance(floats, ints, trace, ROUNDS)
    return True


def inverse_scale(floats, i, lane):
    """One over the natural size of state i, of a lane or of all."""
    return floats[INVERSE_SCALE + i * LANES + lane]


def begin_run(floats, ints, trace, lane, run):
    """Put a run of the trace on a lane, at its start."""
    place = run * RUN_SIZE
    for i in range(STATES):
        floats[STATE + i * LANES + lane] = trace[place + i]
    place += STATES
    for i in range(PARAMETERS):
        floats[PARAMETER + i * LANES + lane] = trace[place + i]
    place += PARAMETERS
    for i in range(STATES):
        floats[SCALE + i * LANES + lane] = trace[place + i]
        floats[INVERSE_SCALE + i * LANES + lane] = 1.0 / trace[place + i]
    place += STATES
    floats[TIME + lane] = trace[place]
    floats[PERIOD + lane] = trace[place + 1]
    floats[REMAINING + lane] = 0.0
    start_lane(floats, ints, trace, lane, run)
    ints[STATUS + lane] = RUNNING
    ints[RUN + lane] = run
    floats[DELAY + lane] = 0.0
    ints[RESPONSE + lane] = 0
    ints[SINCE + lane] = 0
    ints[WHOLE_PERIODS + lane] = ints[PERIOD_BUDGET]
    ints[WINDOW_START + lane] = -1
    begin_marks(ints, lane)
    for i in range(STATES):  # of the run before
        floats[START_STATE + i * LANES + lane] = floats[STATE + i * LANES + lane]
    for i in range(MEASURED_COUNT):
        floats[MEASURED + i * LANES + lane] = 0.0
    begin_returns(floats, ints, lane)
    on_period(floats, ints, trace, lane)


def end_run(floats, ints, trace, lane):
    """Write the result of the run on a lane to the trace, and free the lane."""
    tell_returns(floats, ints, lane)
    place = ints[RESULT_START] + ints[RUN + lane] * RESULT_SIZE
    trace[place] = ints[STATUS + lane]
    trace[place + 1] = ints[PERIOD_COUNT + lane]
    trace[place + 2] = floats[TIME + lane]
    trace[place + 3] = ints[RESPONSE + lane]
    trace[place + 4] = ints[SINCE + lane]
    trace[place + 5] = floats[REMAINING + lane]
    trace[place + 6] = ints[WINDOW_START + lane]
    trace[place + 7] = ints[TAYLOR_STEPS + lane]
    trace[place + 8] = ints[IMPLICIT_STEPS + lane]
    trace[place + 9] = floats[CONTACT_RESIDUAL + lane]
    trace[place + 10] = ints[REFUSED_TRIALS + lane]
    trace[place + 11] = ints[ON_TRIAL + lane] // 2
    place += RESULT_HEAD_SIZE
    for i in range(STATES):
        trace[place + i] = floats[START_STATE + i * LANES + lane]
        trace[place + STATES + i] = floats[STATE + i * LANES + lane]
    place += 2 * STATES
    for i in range(MEASURED_COUNT):
        trace[place + i] = floats[MEASURED + i * LANES + lane]
    ints[RUN + lane] = -1
