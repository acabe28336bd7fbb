from typing import ClassVar

from vibrocap.physics.drives.drive import FREQUENCY, Number, Positive, Wave, parameter, parameters
from vibrocap.physics.elementary import cos, sin


@parameters
class Biharmonic(Wave):
    """Biharmonic drive: h cos(omega tau) + h2 cos(2 omega tau + psi). Odd under half a period only if h2 = 0."""

    amplitude: Number = parameter(1.8, "h", "amplitude of the drive", "effort")
    frequency: Positive = FREQUENCY
    second_amplitude: Number = parameter(0.0, "h2", "amplitude of the second harmonic", "effort")
    second_phase: Number = parameter(0.0, "psi", "phase of the second harmonic", "phase", over=" [rad]")

    name: ClassVar[str] = "biharmonic"
    source: ClassVar[str] = "vibrocap"

    def value(self, t):
        first = self.amplitude * cos(self.frequency * t)
        return first + self.second_amplitude * cos(2.0 * self.frequency * t + self.second_phase)

    def slope(self, t):
        second = 2.0 * self.second_amplitude * sin(2.0 * self.frequency * t + self.second_phase)
        return -(self.frequency * (self.amplitude * sin(self.frequency * t) + second))

    def curvature(self, t):
        second = 4.0 * self.second_amplitude * cos(2.0 * self.frequency * t + self.second_phase)
        return -(self.frequency * self.frequency * (self.amplitude * cos(self.frequency * t) + second))

    @property
    def odd(self) -> bool:
        return self.second_amplitude == 0.0
