"""The stretch of time over which something is measured: named in times, or as the last so many whole periods."""

from vibrocap.arguments import ArgumentError, is_whole, shown
from vibrocap.motion.trajectory import Trajectory

WINDOW = 10  # whole drive periods


def usual_window(periods: float) -> int:
    """The last periods that are measured where no one says how many: ten, or all where a run has fewer."""
    return int(min(WINDOW, max(1, periods)))


def whole_periods(motion: Trajectory) -> int:
    return len(motion.sections) - 1


def window_times(
    motion: Trajectory, window: tuple[float, float] | None = None, periods: int | None = None
) -> tuple[float, float]:
    """(start, end) of a window: the given times, the last `periods` whole periods, or else the whole motion.

    The last whole periods end at the last period mark that the motion reached, even if it went on from there.

    Raises ValueError where the window is empty, not within the motion, or asks for more periods than the motion has.
    """
    if window is not None and periods is not None:
        raise ArgumentError("window and periods", "should not both be given")
    if periods is not None:
        done = whole_periods(motion)
        if not is_whole(periods, 1):
            raise ArgumentError("periods", f"should be a whole number from 1 on, got {periods!r}")
        if periods > done:
            raise ArgumentError("periods", f"should be at most {done}, the whole periods of the motion, got {periods}")
        return period_mark(motion, done - int(periods)), period_mark(motion, done)
    if window is None:
        if motion.end <= motion.start_time:
            raise ValueError("the motion has no length: nothing can be measured")
        return motion.start_time, motion.end
    try:
        start, end = (float(t) for t in window)
    except (TypeError, ValueError):
        raise ArgumentError("window", f"should be a pair of times (start, end), got {window!r}") from None
    if not (motion.start_time <= start < end <= motion.end + 1e-12 * abs(motion.end)):
        limits = "start before end, between start_time and end of the motion"
        raise ArgumentError("window", f"should be (start, end), {limits}, got {shown(window)}")
    return start, end


def period_mark(motion: Trajectory, index: float) -> float:
    """Time at which so many drive periods of the motion are over; they count from its start."""
    return motion.start_time + index * motion.period


def period_index(motion: Trajectory, period: int) -> int:
    """The index, from 0, of a whole period that may be counted from the end (-1 is the last).

    Raises ValueError where the motion has no such period.
    """
    done = whole_periods(motion)
    if not is_whole(period, -done, done - 1):
        why = f"should be a whole number from {-done} to {done - 1} for this motion, got {period!r}"
        raise ArgumentError("period", why)
    return int(period) % done


def period_times(motion: Trajectory, period: int) -> tuple[float, float]:
    """(start, end) of a whole period, see `period_index`."""
    index = period_index(motion, period)
    return period_mark(motion, index), period_mark(motion, index + 1)
