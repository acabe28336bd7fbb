"""The reference as a sampled controller is given it: its value at each sample, and where one is due."""

from typing import Any, ClassVar

from vibrocap.arguments import ArgumentError
from vibrocap.physics.drives.drive import Drive, Piecewise, Segment

MOST_SAMPLES = 100_000  # samples in a period of the drive
WHOLE = 1e-9  # how far from a whole number the count of them may be


class SampledReference(Piecewise):
    """A drive between the samples of a controller: two segments for each sample, before and after its action.

    Samples are corners of the drive, k h exactly, so that no step crosses one. The coefficients of a segment are no
    polynomial: +1 from a sample to its action and -1 from there to the next sample, then r and r' at the sample.
    """

    name: ClassVar[str] = "sampled"

    def __init__(self, drive: Any, delay: Any, count: int):
        """delay: from a sample to its action, None: it acts at once; count: samples in a period of the drive"""
        self.drive, self.delay, self.count = drive, delay, count

    @property
    def period(self) -> Any:
        """That of the drive."""
        return self.drive.period

    @property
    def time_scale(self) -> Any:
        """That of the drive."""
        return self.drive.time_scale

    @property
    def odd(self) -> bool:
        """Never: samples know no symmetry."""
        return False

    @property
    def degree(self) -> int:
        """Three numbers, sign, r and r'."""
        return 2

    def segments(self) -> tuple[Segment, ...]:
        """Two for each sample."""
        period, whole = self.period, 1.0 / self.count
        before = 0.5 * whole if self.delay is None else self.delay / period
        found = []
        for k in range(self.count):
            t = k * (period / self.count)
            slope = self.drive.slope(t) if type(self.drive).slope is not Drive.slope else 0.0
            numbers = self.drive.value(t) * period, slope * (period * period)  # divided again, as those of a polynomial
            found += [Segment(before, (1.0, *numbers)), Segment(whole - before, (-1.0, *numbers))]
        return tuple(found)

    def _coefficients(self, t) -> tuple:
        present = vars(self).get("_present")
        if present is not None:
            return present[1]
        length = self.period / self.count
        number = t // length
        at, delay = number * length, 0.5 * length if self.delay is None else self.delay
        slope = self.drive.slope(at) if type(self.drive).slope is not Drive.slope else 0.0
        return 1.0 if t - at < delay else -1.0, self.drive.value(at), slope

    def sign(self, t):
        """+1 from a sample to its action, -1 from there to the next one."""
        return self._coefficients(t)[0]

    def value(self, t):
        """r at the last sample."""
        return self._coefficients(t)[1]

    def slope(self, t):
        """r' at the last sample."""
        return self._coefficients(t)[2]

    @property
    def continuous(self) -> bool:
        """Never."""
        return False


def check_smooth(system: Any) -> None:
    """ArgumentError for a system whose controller rounds what it measures: its motions have no derivatives."""
    if getattr(system.controller, "quantum", None) is not None:
        what = "with rounded measurements motions have no derivatives, by which orbits are found"
        raise ArgumentError("controller.quantum", f"should be left out: {what}")


def check_unsampled(system: Any, what: str) -> None:
    """ArgumentError for a system whose controller samples. what: is not found of those, in words."""
    if system.controller is not None and system.controller.sampled:
        name = system.controller.name
        raise ArgumentError("controller", f"should be continuous, got a {name}: {what} of sampled controllers")


def sample_count(drive: Any, controller: Any) -> int:
    """How many samples a period of the drive has.

    Raises ArgumentError where that is no whole number, and for a delay that is too long.
    """
    h, period = controller.sample_time, drive.period
    count = round(period / h)
    if not (1 <= count < MOST_SAMPLES and abs(count * h - period) <= WHOLE * period):
        least = f"at least {period / MOST_SAMPLES:g}, got {h:g}"
        raise ArgumentError(
            "controller.sample_time", f"should be a whole part of the period {period:g} of the drive, {least}"
        )
    if controller.delay is not None and not controller.delay < h:
        raise ArgumentError("controller.delay", f"should be less than the sample time {h:g}, got {controller.delay:g}")
    return count
