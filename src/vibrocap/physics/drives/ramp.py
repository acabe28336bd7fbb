from typing import ClassVar

from vibrocap.physics.drives.drive import Drive, Number, Positive, parameter, parameters


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
