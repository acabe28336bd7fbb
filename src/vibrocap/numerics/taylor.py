"""The Taylor step: how far the series of this step may be trusted, and the state at its end."""

import math

from vibrocap.numerics.generated import LANES, ORDER, ROWS, SCALE, SERIES, STATE, STATES, TIME, TOLERANCE

SAFETY = 0.9


def taylor_step(real, whole, lane):
    """Largest step whose last two terms stay below the tolerance (Jorba and Zou 2005, with a fixed order).

    The terms left out are smaller than the last one by about the ratio of step and radius of convergence. Infinite for a
    motion at rest; not a number if a coefficient is not.
    """
    last = 0.0
    before = 0.0
    for i in range(STATES):
        inverse = 1.0 / real[SCALE + i * LANES + lane]
        row = SERIES + i * (ORDER + 1) * LANES + lane
        last = max(last, abs(real[row + ORDER * LANES]) * inverse)
        before = max(before, abs(real[row + (ORDER - 1) * LANES]) * inverse)
        if not (abs(real[row + ORDER * LANES]) <= 1e300):
            return math.nan
    tolerance = math.log(real[TOLERANCE + lane])
    exponent = math.inf
    if last > 0.0:
        exponent = (tolerance - math.log(last)) / ORDER
    if before > 0.0:
        exponent = min(exponent, (tolerance - math.log(before)) / (ORDER - 1))
    return SAFETY * math.exp(exponent) if exponent < 700.0 else math.inf


def series_value(real, row, s):
    """Value at time s of the series whose first coefficient stands at real[row]."""
    result = real[row + ORDER * LANES]
    for k in range(ORDER - 1, -1, -1):
        result = result * s + real[row + k * LANES]
    return result


def move_to(real, whole, lane, s):
    """Put the lane at time s of its present series."""
    for i in range(ROWS):
        real[STATE + i * LANES + lane] = series_value(real, SERIES + i * (ORDER + 1) * LANES + lane, s)
    real[TIME + lane] += s
