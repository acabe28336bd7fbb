"""The rounded triangle: the first three terms of a triangle wave."""

import math
from typing import ClassVar

from vibrocap.physics.drives.drive import Drive, Number, Positive, cos, parameter, parameters

TERMS = (1, 3, 5)


@parameters
class RoundedTriangle(Drive):
    """Triangle wave of peak h, rounded at its tips so that it has a Taylor series everywhere.

    The Fourier series up to the fifth harmonic has no corner and stays within 7 % of h of the exact wave:

        8 h/pi^2 [cos(omega tau) + cos(3 omega tau)/9 + cos(5 omega tau)/25]
    """

    amplitude: Number = parameter(1.0, "h", "peak of the unrounded wave", "effort")
    frequency: Positive = parameter(1.0, "omega", "drive frequency over the pendulum's natural frequency", "frequency")

    name: ClassVar[str] = "rounded-triangle"
    source: ClassVar[str] = "vibrocap"

    def value(self, t):
        """The sum of the three terms."""
        wave = sum(cos(n * self.frequency * t) / n**2 for n in TERMS)
        return 8.0 / math.pi**2 * self.amplitude * wave

    @property
    def period(self) -> float:
        """2 pi / omega."""
        return 2.0 * math.pi / self.frequency

    @property
    def odd(self) -> bool:
        """Always true: all harmonics are odd."""
        return True
