"""The loop over lanes that takes one after another: of a recorded motion, and of targets without lanes."""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.codes import BEGINNING, RUNNING, TOO_MANY_STEPS, TRACE_FULL
from vibrocap.numerics.kernel.lane import every_lane
from vibrocap.numerics.kernel.loop.one_step import start_lane, step


def advance(floats, ints, trace, rounds):
    for lane in every_lane():
        if lane.status == BEGINNING:
            start_lane(floats, ints, trace, lane, 0)
            lane.status = RUNNING
    for _ in range(rounds):
        hook.next_series(floats, ints)
        stopped = False
        for lane in every_lane():
            if lane.status == RUNNING and hook.has_room(floats, ints, trace, lane):
                step(floats, ints, trace, lane)
                if lane.status == RUNNING:
                    steps = lane.taylor_steps + lane.implicit_steps
                    if steps >= lane.step_limit:
                        lane.status = TOO_MANY_STEPS
                stopped = stopped or lane.status != RUNNING
            elif lane.status == TRACE_FULL:
                stopped = True
        if stopped:
            return
