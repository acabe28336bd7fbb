"""The contract of a drive, clause by clause: each takes a drive with its numbers and returns its fault, or None."""

import dataclasses
import math
import sys
from typing import Any

from vibrocap.contracts.samples import draws
from vibrocap.physics.drives.drive import Drive, Piecewise, half_points, segment_table

EPSILON = sys.float_info.epsilon
SAMPLES = 60
STEP = 1e-6  # of a period: of a difference quotient, which rounding then leaves to 1e-10 and a harmonic n to (n STEP)^2
SLOPE_ERROR = 1e-7


def periodic(drive: Any) -> str | None:
    """It repeats with `period`."""
    if not (math.isfinite(drive.period) and drive.period > 0.0):
        return f"period: should be positive, got {drive.period!r}"
    still = _unramped(drive)
    times, size = _sampled(still)
    for t in times:
        now, later = still.value(t), still.value(t + still.period)
        if not abs(later - now) <= _rounding(still) * size:
            return f"value: is {now:g} at time {t:g}, and {later:g} a period later ({still.period:g}); it should repeat"
    return None


def odd(drive: Any) -> str | None:
    """It is odd under half a period exactly where `odd` says so."""
    if drive.odd not in (True, False):
        return f"odd: should be True or False, got {drive.odd!r}"
    still = _unramped(drive)
    times, size = _sampled(still)
    asymmetry = max(abs(still.value(t + still.period / 2) + still.value(t)) for t in times)
    if (asymmetry <= _rounding(still) * size) != still.odd:
        return (
            f"odd: is {still.odd}, but value(t + period/2) + value(t) is up to {asymmetry:g}; a drive is odd where "
            "that is 0 at all times"
        )
    return None


def slopes(drive: Any) -> str | None:
    """Its `slope` is the rate of its value, and its `curvature` that of the slope, where it has them."""
    kind, step = type(drive), STEP * drive.period
    for name, below in (("slope", "value"), ("curvature", "slope")):
        if getattr(kind, name) is getattr(Drive, name):
            return None
        for t in _between_corners(drive):
            value = getattr(drive, name)(t)
            ends = [getattr(drive, below)(t + sign * step) for sign in (-1.0, 1.0)]
            rate, size = (ends[1] - ends[0]) / (2.0 * step), max(map(abs, ends)) / drive.period
            if not abs(value - rate) <= SLOPE_ERROR * (abs(rate) + size):
                return f"{name}: is {value:g} at time {t:g}, where the {below} changes at a rate of {rate:g}"
    return None


def _rounding(drive: Any) -> float:
    """Of a value over the size of the drive: that of the time counts once for each of the waves in a period."""
    return 64 * EPSILON * max(1.0, drive.period / drive.time_scale)


def _between_corners(drive: Any) -> list[float]:
    """Times within the first period at which the drive has a Taylor series."""
    if isinstance(drive, Piecewise):
        return [share * drive.period for share in half_points(segment_table(drive))]
    return [draw.uniform(0.1, 0.9) * drive.period for draw in draws(10)]


def _unramped(drive: Any) -> Any:
    """The time of a ramp is that since the start of the period: it is checked at rest."""
    return dataclasses.replace(drive, rate=0.0) if "rate" in drive.__dataclass_fields__ else drive


def _sampled(drive: Any) -> tuple[list[float], float]:
    """Times, of a drive with corners some between any two, and the size of the drive there."""
    times = [draw.uniform(0.0, 2.0) * drive.period for draw in draws(SAMPLES)]
    if isinstance(drive, Piecewise):
        times += [share * drive.period for share in half_points(segment_table(drive))]
    return times, max(abs(drive.value(t)) for t in times)


DRIVE_CLAUSES = (periodic, odd, slopes)
