"""Drives with corners: polynomials in time, one after another, and no step across the instant at which one ends.

The table of a run stands on the trace, a row for each segment: the share of the drive's period at its end, then the
coefficients in powers of the share since its start. Those of the present segment stand among the parameters, in powers
of time, behind the period of the drive and the time at which the segment began; the equations are recorded with them.
A corner is no event of the state, which goes on as it is: a stuck contact is asked at the next step whether it still
holds. Only a contact velocity that the drive itself makes may jump.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.events.contact import jumped
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import shared
from vibrocap.numerics.kernel.step.resolved import forget


def begin_drive(floats, ints, trace, lane, run):
    """Find the table of a run, and the segment with which it begins."""
    lane.table = shared.table_start + run * shared.table_stride
    lane.cycle = 0
    if not take_segment(floats, ints, trace, lane, 0):  # at the end of the period, to rounding
        lane.until = lane.period


def at_corner(floats, ints, trace, lane):
    until, period = lane.until, lane.period
    last = lane.period_count == lane.whole_periods
    if until >= period or (last and lane.tail < until - 2.0 * EPSILON * period):
        return False
    lane.time = lane.until
    if not take_segment(floats, ints, trace, lane, lane.segment + 1):
        lane.cycle += 1
        take_segment(floats, ints, trace, lane, 0)
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)
    return True


def begin_drive_period(floats, ints, trace, lane):
    """The first segment again, unless the run ends here."""
    if lane.period_count == lane.whole_periods and lane.tail <= 0.0:
        return
    lane.cycle = 0
    take_segment(floats, ints, trace, lane, 0)
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)


def drive_goes_over(floats, ints, trace, lane):
    """At the end of the last period: the first segment of the next one, in the time of this one."""
    lane.time = 0.0
    lane.cycle = 0
    take_segment(floats, ints, trace, lane, 0)
    lane.parameter[PRESENT + 1] += lane.period
    lane.time = lane.period
    lane.until = lane.period
    if VELOCITY_JUMPS:
        jumped(floats, ints, trace, lane)
    return True


def take_segment(floats, ints, trace, lane, first):
    """The first segment from this number on that goes beyond the present time becomes the present one, if there is one.

    Segments without length are passed over. Returns whether one was found.
    """
    period, slack = lane.parameter[PRESENT], 2.0 * EPSILON * lane.period
    began = lane.cycle * period  # of the drive, where a period of the run is several of its periods
    for i in range(first, shared.segment_count):
        row = lane.table + i * (COEFFICIENTS + 1)
        share = 1.0 if i == shared.segment_count - 1 else trace[row]
        end = began + share * period
        if end > lane.period - slack:
            end = lane.period
        if end - lane.time > slack:
            lane.segment = i
            lane.until = end
            lane.parameter[PRESENT + 1] = began + (trace[row - COEFFICIENTS - 1] if i > 0 else 0.0) * period
            scale = 1.0
            for k in range(COEFFICIENTS):
                lane.parameter[PRESENT + 2 + k] = trace[row + 1 + k] * scale
                scale = scale / period
            if FOLLOWS_LOAD:
                forget(floats, lane)
            return True
    return False
