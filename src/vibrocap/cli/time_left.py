"""The time that a piece of work still takes, in words, from how fast its share done has grown."""

import time
from collections.abc import Callable

MINUTE, HOUR, DAY = 60.0, 3600.0, 86_400.0
SETTLED = 1.0  # seconds of work before an estimate is worth showing


class TimeLeft:
    """Estimates from the first share reported on, which is above 0 for work that was resumed."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._begun: tuple[float, float] | None = None  # (when, share done) of the first report

    def words(self, share: float) -> str:
        """Such as "about 3 min left"; empty while nothing can be said."""
        now = self._clock()
        if self._begun is None:
            self._begun = (now, share)
        start, before = self._begun
        if share <= before or now - start < SETTLED:
            return ""
        return f"about {duration((now - start) * (1.0 - share) / (share - before))} left"


def duration(seconds: float) -> str:
    """A time in the unit that suits it, to two digits or so."""
    if seconds < 9.5:
        return f"{seconds:.1f} s"
    for limit, length, unit in ((99.5, 1.0, "s"), (99.5 * MINUTE, MINUTE, "min"), (47.5 * HOUR, HOUR, "h")):
        if seconds < limit:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds / DAY:.1f} days"
