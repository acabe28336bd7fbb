"""The loop over lanes that takes one after another: of a recorded motion, and of a thread of a GPU."""

from vibrocap.numerics.kernel.codes import BEGINNING, RUNNING, TOO_MANY_STEPS, TRACE_FULL
from vibrocap.numerics.kernel.generated.ensemble import STEP_LIMIT
from vibrocap.numerics.kernel.generated.lane import IMPLICIT_STEPS, STATUS, TAYLOR_STEPS
from vibrocap.numerics.kernel.generated.sizes import LANES
from vibrocap.numerics.kernel.interface import has_room, next_series
from vibrocap.numerics.kernel.loop.one_step import step
from vibrocap.numerics.kernel.loop.start import start_lane


def advance(floats, ints, trace, rounds):
    """Advance all running lanes by up to `rounds` steps, or until the first of them stops."""
    for lane in range(LANES):
        if ints[STATUS + lane] == BEGINNING:
            start_lane(floats, ints, trace, lane, 0)
            ints[STATUS + lane] = RUNNING
    for _ in range(rounds):
        next_series(floats, ints)
        stopped = False
        for lane in range(LANES):
            if ints[STATUS + lane] == RUNNING and has_room(floats, ints, trace, lane):
                step(floats, ints, trace, lane)
                if ints[STATUS + lane] == RUNNING:
                    steps = ints[TAYLOR_STEPS + lane] + ints[IMPLICIT_STEPS + lane]
                    if steps >= ints[STEP_LIMIT + lane]:
                        ints[STATUS + lane] = TOO_MANY_STEPS
                stopped = stopped or ints[STATUS + lane] != RUNNING
            elif ints[STATUS + lane] == TRACE_FULL:
                stopped = True
        if stopped:
            return
