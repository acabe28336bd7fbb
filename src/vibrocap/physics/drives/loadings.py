"""Loadings, with which contacts and machines are tested: a constant, a ramp, both with an oscillation."""

from typing import ClassVar

from vibrocap.physics.drives.drive import Drive, Number, Positive, Wave, parameter, parameters
from vibrocap.physics.elementary import cos


@parameters
class Constant(Drive):
    """Constant drive F, for motions that nothing shakes: a block on a running belt, a mass that coasts.

    Its period is no property of the motion but the unit of time in which periods are counted.
    """

    force: Number = parameter(0.0, "F", "force or torque of the drive", "effort")
    duration: Positive = parameter(1.0, "T", "length of one period, as counted", "duration")

    name: ClassVar[str] = "constant"
    source: ClassVar[str] = "vibrocap"

    def value(self, t):
        return self.force

    def slope(self, t):
        return 0.0

    def curvature(self, t):
        return 0.0

    @property
    def period(self) -> float:
        return self.duration

    @property
    def odd(self) -> bool:
        return self.force == 0.0


@parameters
class Ramp(Drive):
    """Ramp F + q t, from which a break-away force is read (Canudas de Wit et al. 1995, section IV).

    It lasts for one period; in further periods it begins anew, as a saw-tooth.
    """

    rate: Number = parameter(1.0, "q", "rate of the force", "effort rate")
    start: Number = parameter(0.0, "F", "force at the start", "effort")
    duration: Positive = parameter(1.0, "T", "length of the ramp, the period", "duration")

    name: ClassVar[str] = "ramp"
    source: ClassVar[str] = "canudas1995"

    def value(self, t):
        return self.start + self.rate * t

    @property
    def period(self) -> float:
        return self.duration

    @property
    def odd(self) -> bool:
        return self.start == 0.0 and self.rate == 0.0


@parameters
class Loading(Wave):
    """Loading F + q t + h cos(omega t): what a contact is tested with, in one form for all tests (`laboratory`).

    A level with an oscillation makes some laws creep, a ramp breaks the contact away. The ramp begins anew in each
    period, as that of `Ramp` does. Odd under half a period only without level and ramp.
    """

    level: Number = parameter(0.3, "F", "mean force or torque, that at the start of the ramp", "effort")
    rate: Number = parameter(0.0, "q", "rate of the ramp", "effort rate")
    amplitude: Number = parameter(0.1, "h", "amplitude of the oscillation", "effort")
    frequency: Positive = parameter(1.0, "omega", "frequency of the oscillation; a period is 2 pi over it", "frequency")

    name: ClassVar[str] = "loading"
    source: ClassVar[str] = "canudas1995"

    def value(self, t):
        return self.level + self.rate * t + self.amplitude * cos(self.frequency * t)

    @property
    def odd(self) -> bool:
        return self.level == 0.0 and self.rate == 0.0
