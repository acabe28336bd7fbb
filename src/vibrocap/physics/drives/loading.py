from typing import ClassVar

from vibrocap.physics.drives.drive import Number, Positive, Wave, parameter, parameters
from vibrocap.physics.elementary import cos


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
