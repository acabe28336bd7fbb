"""The reference as a sampled controller is given it: its value at each sample, and where one is due."""

from typing import Any, ClassVar

from vibrocap.arguments import ArgumentError
from vibrocap.physics.drives.drive import Drive, Piecewise, Segment
from vibrocap.quantities.dimensional import said

MOST_SAMPLES = 100_000  # samples in a period of the drive
WHOLE = 1e-9  # how far from a whole number the count of them may be


class SampledReference(Piecewise):
    """A drive between the samples of a controller: two segments for each sample, before and after its action.

    Samples are corners of the drive, k h exactly, so that no step crosses one. The coefficients of a segment are no
    polynomial: +1 from a sample to its action and -1 from there to the next sample, then r and r' at the sample.
    """

    name: ClassVar[str] = "sampled"
    odd = continuous = False  # type: ignore[override,assignment]
    degree = 2  # type: ignore[override,assignment]

    def __init__(self, drive: Any, controller: Any):
        """controller: whose `sample_time` and `delay` from a sample to its action count, None: it acts at once"""
        self.drive, self.sample_time, self.delay = drive, controller.sample_time, controller.delay

    @property
    def period(self) -> Any:
        return self.drive.period

    @property
    def time_scale(self) -> Any:
        return self.drive.time_scale

    @property
    def parts(self) -> Any:
        """How many samples a period of the drive has, to rounding."""
        return self.period / self.sample_time

    @property
    def count(self) -> int:
        return round(self.parts)

    def segments(self, t: Any = 0.0) -> tuple[Segment, ...]:
        period, whole = self.period, self.sample_time / self.period
        before = 0.5 * whole if self.delay is None else self.delay / period
        slope = self.drive.slope(t) if type(self.drive).slope is not Drive.slope else 0.0
        numbers = self.drive.value(t) * period, slope * (period * period)  # divided again, as those of a polynomial
        return Segment(before, (1.0, *numbers)), Segment(whole - before, (-1.0, *numbers))

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
        return self._coefficients(t)[1]

    def slope(self, t):
        return self._coefficients(t)[2]


def check_smooth(system: Any) -> None:
    """ArgumentError for a system whose controller rounds what it measures: its motions have no derivatives."""
    if getattr(system.controller, "quantum", None) is not None:
        what = "with rounded measurements motions have no derivatives, by which orbits are found"
        raise ArgumentError("controller.quantum", f"should be left out: {what}")


def check_samples(system: Any) -> None:
    """ArgumentError for a number of samples in a period that is not whole, a delay that is too long, a reference that
    jumps or has corners."""
    drive, controller, units = system.drive, system.controller, system.result_units
    h, period = controller.sample_time, drive.period

    def words(time: float) -> str:
        return said(time * units.factor("time"), units.unit("time"), 6)

    count = round(period / h)
    if not (1 <= count < MOST_SAMPLES and abs(count * h - period) <= WHOLE * period):
        least = f"at least {words(period / MOST_SAMPLES)}, got {words(h)}"
        raise ArgumentError(
            "controller.sample_time", f"should be a whole part of the period {words(period)} of the drive, {least}"
        )
    if controller.delay is not None and not controller.delay < h:
        what = f"should be less than the sample time {words(h)}, got {words(controller.delay)}"
        raise ArgumentError("controller.delay", what)
    if isinstance(drive, Piecewise):
        smooth = "a constant, harmonic, biharmonic or fourier waveform"
        raise ArgumentError("drive", f"should have no corners, {smooth}, with a {controller.name}; got {drive.name}")
