from typing import ClassVar

from vibrocap.physics.drives.drive import FREQUENCY, Number, Positive, Wave, parameter, parameters
from vibrocap.physics.elementary import cos, sin


@parameters
class Harmonic(Wave):
    """Harmonic drive: h cos(omega tau) (Liu et al. 2019, eq. 4). Odd under half a period."""

    amplitude: Number = parameter(1.8, "h", "amplitude of the drive", "effort")
    frequency: Positive = FREQUENCY

    name: ClassVar[str] = "harmonic"
    source: ClassVar[str] = "liu2019"
    odd: ClassVar = True  # type: ignore[override,assignment]

    def value(self, t):
        return self.amplitude * cos(self.frequency * t)

    def slope(self, t):
        return -(self.amplitude * self.frequency * sin(self.frequency * t))

    def curvature(self, t):
        return -(self.amplitude * self.frequency * self.frequency * cos(self.frequency * t))
