"""The time since a motion began, which many small lengths add up to without their rounding adding up too."""

from vibrocap.numerics.kernel.generated.stepper import CLOCK, CLOCK_REST


def go_on(floats, length):
    """Add a length to the clock: what its sum rounds off is carried along."""
    before = floats[CLOCK]
    after = before + length
    taken = after - before
    rest = floats[CLOCK_REST] + ((before - (after - taken)) + (length - taken))
    floats[CLOCK] = after + rest
    floats[CLOCK_REST] = rest - (floats[CLOCK] - after)


def set_clock(floats, time):
    """Put the clock to a time."""
    floats[CLOCK], floats[CLOCK_REST] = time, 0.0
