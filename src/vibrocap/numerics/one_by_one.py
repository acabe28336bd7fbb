"""The loop over lanes that takes one after another: of a recorded motion, and of a thread of a graphics card."""

from vibrocap.numerics.generated import LANES, STATUS, jet
from vibrocap.numerics.lanes import RUNNING
from vibrocap.numerics.loop import step
from vibrocap.numerics.record import has_room


def advance(real, whole, tape, rounds):
    """Advance every running lane by up to `rounds` steps, or until it is done, has failed or the tape is full."""
    for _ in range(rounds):
        running = False
        for lane in range(LANES):
            running = running or whole[STATUS + lane] == RUNNING
        if not running:
            return
        jet(real)
        for lane in range(LANES):
            if whole[STATUS + lane] == RUNNING and has_room(real, whole, tape, lane):
                step(real, whole, tape, lane)
