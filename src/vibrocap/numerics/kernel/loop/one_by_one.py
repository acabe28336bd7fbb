"""The loop over lanes that takes one after another: of a recorded motion, and of a thread of a graphics card."""

from vibrocap.numerics.kernel.codes import RUNNING, TAPE_FULL, TOO_MANY_STEPS
from vibrocap.numerics.kernel.generated import IMPLICIT_STEPS, LANES, STATUS, STEP_LIMIT, TAYLOR_STEPS, jet
from vibrocap.numerics.kernel.interface import has_room
from vibrocap.numerics.kernel.loop.one_step import step


def advance(real, whole, tape, rounds):
    """Advance all running lanes by up to `rounds` steps, or until the first of them stops."""
    for _ in range(rounds):
        jet(real)
        stopped = False
        for lane in range(LANES):
            if whole[STATUS + lane] == RUNNING and has_room(real, whole, tape, lane):
                step(real, whole, tape, lane)
                if whole[STATUS + lane] == RUNNING:
                    steps = whole[TAYLOR_STEPS + lane] + whole[IMPLICIT_STEPS + lane]
                    if steps >= whole[STEP_LIMIT + lane]:
                        whole[STATUS + lane] = TOO_MANY_STEPS
                stopped = stopped or whole[STATUS + lane] != RUNNING
            elif whole[STATUS + lane] == TAPE_FULL:
                stopped = True
        if stopped:
            return
