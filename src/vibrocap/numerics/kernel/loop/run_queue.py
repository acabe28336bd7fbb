"""Feeding the lanes of an ensemble: a lane that has ended its run writes the result and begins the next one.

Each run has its own steps, modes and events, so lanes end at different times; none waits for the slowest.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import every_lane, shared
from vibrocap.numerics.kernel.loop.one_step import start_lane
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD_SIZE

ROUNDS = 1000  # steps of all lanes at a time, unless a lane stops before


def advance_ensemble(floats, ints, trace, turns):
    """Advance all lanes, each through run after run, until no run is left; come back to the caller after many steps.

    Where MORE is set it also comes back as soon as a lane finds no run to begin. Returns whether a lane is running.
    """
    for _ in range(turns):
        busy = False
        for lane in every_lane():
            if lane.status != RUNNING and not hook.ends_trial(floats, ints, lane):
                if lane.run >= 0:
                    end_run(floats, ints, trace, lane)
                if shared.next_run < shared.last_run:
                    begin_run(floats, ints, trace, lane, shared.next_run)
                    shared.next_run += 1
                elif shared.more != 0:
                    return True
            busy = busy or lane.status == RUNNING
        if not busy:
            return False
        hook.advance(floats, ints, trace, ROUNDS)
    return True


def inverse_scale(floats, i, lane):
    return lane.inverse_scale[i]


def begin_run(floats, ints, trace, lane, run):
    """Put a run of the trace on a lane, at its start."""
    place = run * RUN_SIZE
    for i in range(STATES):
        lane.state[i] = trace[place + i]
    place += STATES
    for i in range(PARAMETERS):
        lane.parameter[i] = trace[place + i]
    place += PARAMETERS
    for i in range(STATES):
        lane.scale[i] = trace[place + i]
        lane.inverse_scale[i] = 1.0 / trace[place + i]
    place += STATES
    lane.time = trace[place]
    lane.period = trace[place + 1]
    lane.remaining = 0.0
    start_lane(floats, ints, trace, lane, run)
    lane.status = RUNNING
    lane.run = run
    lane.delay = trace[place + 2]
    if lane.delay != 0.0:
        lane.pending = 1
    lane.response = 0
    lane.since = 0
    lane.whole_periods = shared.period_budget
    lane.window_start = -1
    hook.begin_marks(ints, lane)
    for i in range(STATES):  # of the run before
        lane.start_state[i] = lane.state[i]
    for i in range(MEASURED_COUNT):
        lane.measured[i] = 0.0
    hook.begin_returns(floats, ints, lane)
    hook.on_period(floats, ints, trace, lane)


def end_run(floats, ints, trace, lane):
    """Write the result of the run on a lane to the trace, and free the lane."""
    hook.tell_returns(floats, ints, lane)
    place = shared.result_start + lane.run * RESULT_SIZE
    trace[place] = lane.status
    trace[place + 1] = lane.period_count
    trace[place + 2] = lane.time
    trace[place + 3] = lane.response
    trace[place + 4] = lane.since
    trace[place + 5] = lane.remaining
    trace[place + 6] = lane.window_start
    trace[place + 7] = lane.taylor_steps
    trace[place + 8] = lane.implicit_steps
    trace[place + 9] = lane.contact_residual
    trace[place + 10] = lane.refused_trials
    trace[place + 11] = lane.on_trial // 2
    place += RESULT_HEAD_SIZE
    for i in range(STATES):
        trace[place + i] = lane.start_state[i]
        trace[place + STATES + i] = lane.state[i]
    place += 2 * STATES
    for i in range(MEASURED_COUNT):
        trace[place + i] = lane.measured[i]
    lane.run = -1
