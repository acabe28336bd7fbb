"""Feeding the lanes of an ensemble: a lane that has ended its run writes the result and begins the next one.

Each run has its own steps, modes and events, so lanes end at different times; none waits for the slowest.
"""

from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated import (
    ARRIVING,
    CAME_FROM,
    CONTACT_RESIDUAL,
    EVENTS,
    HOLD_RATE,
    IDLE,
    IMPLICIT_STEPS,
    INVERSE_SCALE,
    LANES,
    LAST_RUN,
    MEASURED,
    MEASURED_COUNT,
    MORE,
    NEXT_RUN,
    ORDER,
    PARAMETER,
    PARAMETERS,
    PATIENCE,
    PENDING,
    PERIOD,
    PERIOD_BUDGET,
    PERIOD_COUNT,
    REMAINING,
    RESPONSE,
    RESULT_SIZE,
    RESULT_START,
    RUN,
    RUN_SIZE,
    SCALE,
    SET_VALUED,
    SIDE,
    SINCE,
    START_STATE,
    STATE,
    STATES,
    STATUS,
    STIFF,
    TAYLOR_STEPS,
    TIME,
    WHOLE_PERIODS,
    WINDOW_START,
    ZEROS,
)
from vibrocap.numerics.kernel.interface import advance, begin_drive, on_period
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD_SIZE
from vibrocap.numerics.kernel.step.resolved import forget
from vibrocap.numerics.kernel.step.taylor import hold_rate

ROUNDS = 1000  # steps of all lanes at a time, unless a lane stops before


def advance_ensemble(real, whole, tape, turns):
    """Advance all lanes, each through run after run, until no run is left; come back to the caller after many steps.

    Where MORE is set it also comes back as soon as a lane finds no run to begin. Returns whether a lane is running.
    """
    for _ in range(turns):
        busy = False
        for lane in range(LANES):
            if whole[STATUS + lane] != RUNNING:
                if whole[RUN + lane] >= 0:
                    end_run(real, whole, tape, lane)
                if whole[NEXT_RUN] < whole[LAST_RUN]:
                    begin_run(real, whole, tape, lane, whole[NEXT_RUN])
                    whole[NEXT_RUN] += 1
                elif whole[MORE] != 0:
                    return True
            busy = busy or whole[STATUS + lane] == RUNNING
        if not busy:
            return False
        advance(real, whole, tape, ROUNDS)
    return True


def begin_run(real, whole, tape, lane, run):
    """Put a run of the tape on a lane, at its start."""
    place = run * RUN_SIZE
    for i in range(STATES):
        real[STATE + i * LANES + lane] = tape[place + i]
    place += STATES
    for i in range(PARAMETERS):
        real[PARAMETER + i * LANES + lane] = tape[place + i]
    place += PARAMETERS
    for i in range(STATES):
        real[SCALE + i * LANES + lane] = tape[place + i]
        real[INVERSE_SCALE + i * LANES + lane] = 1.0 / tape[place + i]
    place += STATES
    real[TIME + lane] = tape[place]
    real[PERIOD + lane] = tape[place + 1]
    real[HOLD_RATE + lane] = hold_rate(tape[place + 1], ORDER)
    real[SIDE + lane] = tape[place + 2]
    forget(real, lane)
    real[CAME_FROM + lane] = 0.0
    begin_drive(real, whole, tape, lane, run)
    real[REMAINING + lane] = 0.0
    real[CONTACT_RESIDUAL + lane] = 0.0
    whole[ARRIVING + lane] = 0
    whole[ZEROS + lane] = 0
    if real[SIDE + lane] == 0.0:  # at rest
        if SET_VALUED:
            whole[ARRIVING + lane] = 1
        else:
            real[SIDE + lane] = 1.0
            whole[ZEROS + lane] = 1
    whole[STATUS + lane] = RUNNING
    whole[RUN + lane] = run
    whole[PERIOD_COUNT + lane] = 0
    whole[STIFF + lane] = 0
    whole[PATIENCE + lane] = 0
    whole[TAYLOR_STEPS + lane] = 0
    whole[IMPLICIT_STEPS + lane] = 0
    whole[EVENTS + lane] = 0
    whole[IDLE + lane] = 0
    whole[PENDING + lane] = 0
    whole[RESPONSE + lane] = 0
    whole[SINCE + lane] = 0
    whole[WHOLE_PERIODS + lane] = whole[PERIOD_BUDGET]
    whole[WINDOW_START + lane] = -1
    for i in range(STATES):  # of the run before
        real[START_STATE + i * LANES + lane] = real[STATE + i * LANES + lane]
    for i in range(MEASURED_COUNT):
        real[MEASURED + i * LANES + lane] = 0.0
    on_period(real, whole, tape, lane)


def end_run(real, whole, tape, lane):
    """Write the result of the run on a lane to the tape, and free the lane."""
    place = whole[RESULT_START] + whole[RUN + lane] * RESULT_SIZE
    tape[place] = whole[STATUS + lane]
    tape[place + 1] = whole[PERIOD_COUNT + lane]
    tape[place + 2] = real[TIME + lane]
    tape[place + 3] = whole[RESPONSE + lane]
    tape[place + 4] = whole[SINCE + lane]
    tape[place + 5] = real[REMAINING + lane]
    tape[place + 6] = whole[WINDOW_START + lane]
    tape[place + 7] = whole[TAYLOR_STEPS + lane]
    tape[place + 8] = whole[IMPLICIT_STEPS + lane]
    tape[place + 9] = real[CONTACT_RESIDUAL + lane]
    place += RESULT_HEAD_SIZE
    for i in range(STATES):
        tape[place + i] = real[START_STATE + i * LANES + lane]
        tape[place + STATES + i] = real[STATE + i * LANES + lane]
    place += 2 * STATES
    for i in range(MEASURED_COUNT):
        tape[place + i] = real[MEASURED + i * LANES + lane]
    whole[RUN + lane] = -1
