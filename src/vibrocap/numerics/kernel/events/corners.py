"""Drives with corners: polynomials in time, one after another, and no step across the instant at which one ends.

The table of a run stands on the trace, a row for each segment: the share of the drive's period at its end, then the
coefficients in powers of the share since its start. Those of the present segment stand among the parameters, in powers
of time, behind the period of the drive and the time at which the segment began; the equations are recorded with them.
A corner is no event of the state, which goes on as it is: a stuck contact is asked at the next step whether it still
holds. Only a contact velocity that the drive itself makes may jump.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.events.contact import jumped
from vibrocap.numerics.kernel.generated.facts import FOLLOWS_LOAD, VELOCITY_JUMPS
from vibrocap.numerics.kernel.generated.lane import (
    CYCLE,
    PARAMETER,
    PERIOD,
    PERIOD_COUNT,
    SEGMENT,
    SEGMENT_COUNT,
    TABLE,
    TABLE_START,
    TABLE_STRIDE,
    TAIL,
    TIME,
    UNTIL,
    WHOLE_PERIODS,
)
from vibrocap.numerics.kernel.generated.sizes import COEFFICIENTS, LANES, PRESENT
from vibrocap.numerics.kernel.step.resolved import forget


def begin_drive(floats, ints, trace, lane, run):
    """Find the table of a run, and the segment with which it begins."""
    ints[TABLE + lane] = ints[TABLE_START] + run * ints[TABLE_STRIDE]
    ints[CYCLE + lane] = 0
    if not take_segment(floats, ints, trace, lane, 0):  # at the end of the period, to rounding
        floats[UNTIL + lane] = floats[PERIOD + lane]


def at_corner(floats, ints, trace, lane):
    """Whether the lane, at the end of a step, stands at a corner within the period; then it is turned."""
    until, period = floats[UNTIL + lane], floats[PERIOD + lane]
    last = ints[PERIOD_COUNT + lane] == ints[WHOLE_PERIODS + lane]
    if until >= period or (last and floats[TAIL + lane] < until - 2.0 * EPSILON * period):
        return False
    floats[TIME + lane] = floats[UNTIL + lane]
    if not take_segment(floats, ints, trace, lane, ints[SEGMENT + lane] + 1):
        ints[CYCLE + lane] += 1
        take_segment(floats, ints, trace, lane, 0)
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)
    return True


def begin_drive_period(floats, ints, trace, lane):
    """The first segment again, unless the run ends here."""
    if ints[PERIOD_COUNT + lane] == ints[WHOLE_PERIODS + lane] and floats[TAIL + lane] <= 0.0:
        return
    ints[CYCLE + lane] = 0
    take_segment(floats, ints, trace, lane, 0)
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)


def drive_goes_over(floats, ints, trace, lane):
    """At the end of the last period: the first segment of the next one, in the time of this one."""
    floats[TIME + lane] = 0.0
    ints[CYCLE + lane] = 0
    take_segment(floats, ints, trace, lane, 0)
    floats[PARAMETER + (PRESENT + 1) * LANES + lane] += floats[PERIOD + lane]
    floats[TIME + lane] = floats[PERIOD + lane]
    floats[UNTIL + lane] = floats[PERIOD + lane]
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)
    return True


def take_segment(floats, ints, trace, lane, first):
    """The first segment from this number on that goes beyond the present time becomes the present one, if there is one.

    Segments without length are passed over. Returns whether one was found.
    """
    present = PARAMETER + PRESENT * LANES + lane
    period, slack = floats[present], 2.0 * EPSILON * floats[PERIOD + lane]
    began = ints[CYCLE + lane] * period  # of the drive, where a period of the run is several of its periods
    for i in range(first, ints[SEGMENT_COUNT]):
        row = ints[TABLE + lane] + i * (COEFFICIENTS + 1)
        share = 1.0 if i == ints[SEGMENT_COUNT] - 1 else trace[row]
        end = began + share * period
        if end > floats[PERIOD + lane] - slack:
            end = floats[PERIOD + lane]
        if end - floats[TIME + lane] > slack:
            ints[SEGMENT + lane] = i
            floats[UNTIL + lane] = end
            floats[present + LANES] = began + (trace[row - COEFFICIENTS - 1] if i > 0 else 0.0) * period
            scale = 1.0
            for k in range(COEFFICIENTS):
                floats[present + (2 + k) * LANES] = trace[row + 1 + k] * scale
                scale = scale / period
            if FOLLOWS_LOAD:
                forget(floats, lane)
            return True
    return False
