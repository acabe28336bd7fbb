"""The contract of a drive, clause by clause: each takes a drive with its numbers and says what is wrong, or None."""

import dataclasses
import math
import sys
from typing import Any

from vibrocap.contracts.samples import draws
from vibrocap.physics.drives.drive import Piecewise, half_points, segment_table

EPSILON = sys.float_info.epsilon
SAMPLES = 60


def periodic(drive: Any) -> str | None:
    """It repeats with `period`."""
    if not (math.isfinite(drive.period) and drive.period > 0.0):
        return f"period: should be positive, got {drive.period!r}"
    still = _unramped(drive)
    times, size = _sampled(still)
    for t in times:
        now, later = still.value(t), still.value(t + still.period)
        if not abs(later - now) <= 64 * EPSILON * size:
            return f"value: is {now:g} at time {t:g}, and {later:g} a period later ({still.period:g}); it should repeat"
    return None


def odd(drive: Any) -> str | None:
    """It is odd under half a period exactly where `odd` says so."""
    if drive.odd not in (True, False):
        return f"odd: should be True or False, got {drive.odd!r}"
    still = _unramped(drive)
    times, size = _sampled(still)
    asymmetry = max(abs(still.value(t + still.period / 2) + still.value(t)) for t in times)
    if (asymmetry <= 64 * EPSILON * size) != still.odd:
        return (
            f"odd: is {still.odd}, but value(t + period/2) + value(t) is up to {asymmetry:g}; a drive is odd where "
            "that is 0 at all times"
        )
    return None


def _unramped(drive: Any) -> Any:
    """The time of a ramp is that since the start of the period: it is checked at rest."""
    return dataclasses.replace(drive, rate=0.0) if "rate" in drive.__dataclass_fields__ else drive


def _sampled(drive: Any) -> tuple[list[float], float]:
    """Times, of a drive with corners some between any two, and the size of the drive there."""
    times = [draw.uniform(0.0, 2.0) * drive.period for draw in draws(SAMPLES)]
    if isinstance(drive, Piecewise):
        times += [share * drive.period for share in half_points(segment_table(drive))]
    return times, max(abs(drive.value(t)) for t in times)


DRIVE_CLAUSES = (periodic, odd)
