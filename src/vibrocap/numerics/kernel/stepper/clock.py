"""The time since a motion began, which many small lengths add up to without their rounding adding up too."""

from vibrocap.numerics.kernel.lane import stepper


def go_on(floats, length):
    """Add a length to the clock: what its sum rounds off is carried along."""
    before = stepper.clock
    after = before + length
    taken = after - before
    rest = stepper.clock_rest + ((before - (after - taken)) + (length - taken))
    stepper.clock = after + rest
    stepper.clock_rest = rest - (stepper.clock - after)


def set_clock(floats, time):
    """Put the clock to a time."""
    stepper.clock, stepper.clock_rest = time, 0.0
