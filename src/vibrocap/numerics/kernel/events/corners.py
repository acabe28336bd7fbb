"""Drives with corners: polynomials in time, one after another, and no step across the instant at which one ends.

The table of a run stands on the tape, a row for each segment: the share of the drive's period at its end, then the
coefficients in powers of the share since its start. Those of the present segment stand among the parameters, in powers
of time, behind the period of the drive and the time at which the segment began; the equations are recorded with them.
A corner is no event of the state, which goes on as it is: a stuck contact is asked at the next step whether it still
holds. Only a contact velocity that the drive itself makes may jump.
"""

from vibrocap.numerics.kernel.arithmetic.roots import EPSILON
from vibrocap.numerics.kernel.events.contact import jumped
from vibrocap.numerics.kernel.generated import (
    COEFFICIENTS,
    CYCLE,
    FOLLOWS_LOAD,
    LANES,
    PARAMETER,
    PERIOD,
    PERIOD_COUNT,
    PRESENT,
    SEGMENT,
    SEGMENT_COUNT,
    TABLE,
    TABLE_START,
    TABLE_STRIDE,
    TAIL,
    TIME,
    UNTIL,
    VELOCITY_JUMPS,
    WHOLE_PERIODS,
)
from vibrocap.numerics.kernel.step.resolved import forget


def begin_drive(real, whole, tape, lane, run):
    """Find the table of a run, and the segment with which it begins."""
    whole[TABLE + lane] = whole[TABLE_START] + run * whole[TABLE_STRIDE]
    whole[CYCLE + lane] = 0
    take_segment(real, whole, tape, lane, 0)


def at_corner(real, whole, tape, lane):
    """Whether the lane, at the end of a step to UNTIL, stands at a corner within the period; then it is turned."""
    last = whole[PERIOD_COUNT + lane] == whole[WHOLE_PERIODS + lane]
    if last and real[TAIL + lane] - real[TIME + lane] <= 2.0 * EPSILON * real[PERIOD + lane]:
        return False
    if real[UNTIL + lane] >= real[PERIOD + lane]:
        return False
    real[TIME + lane] = real[UNTIL + lane]
    if not take_segment(real, whole, tape, lane, whole[SEGMENT + lane] + 1):
        whole[CYCLE + lane] += 1
        take_segment(real, whole, tape, lane, 0)
    if VELOCITY_JUMPS:
        jumped(real, whole, tape, lane)
    return True


def begin_drive_period(real, whole, tape, lane):
    """The first segment again, unless the run ends here."""
    if whole[PERIOD_COUNT + lane] == whole[WHOLE_PERIODS + lane] and real[TAIL + lane] <= 0.0:
        return
    whole[CYCLE + lane] = 0
    take_segment(real, whole, tape, lane, 0)
    if VELOCITY_JUMPS:
        jumped(real, whole, tape, lane)


def take_segment(real, whole, tape, lane, first):
    """The first segment from this number on that goes beyond the present time becomes the present one, if there is one.

    Segments without length are passed over. Returns whether one was found.
    """
    present = PARAMETER + PRESENT * LANES + lane
    period, slack = real[present], 2.0 * EPSILON * real[PERIOD + lane]
    began = whole[CYCLE + lane] * period  # of the drive, where a period of the run is several of its periods
    for i in range(first, whole[SEGMENT_COUNT]):
        row = whole[TABLE + lane] + i * (COEFFICIENTS + 1)
        share = 1.0 if i == whole[SEGMENT_COUNT] - 1 else tape[row]
        end = began + share * period
        if end > real[PERIOD + lane] - slack:
            end = real[PERIOD + lane]
        if end - real[TIME + lane] > slack:
            whole[SEGMENT + lane] = i
            real[UNTIL + lane] = end
            real[present + LANES] = began + (tape[row - COEFFICIENTS - 1] if i > 0 else 0.0) * period
            scale = 1.0
            for k in range(COEFFICIENTS):
                real[present + (2 + k) * LANES] = tape[row + 1 + k] * scale
                scale = scale / period
            if FOLLOWS_LOAD:
                forget(real, lane)
            return True
    return False
