"""Waves of harmonics: one, two, or a Fourier series of seven."""

from typing import ClassVar

from vibrocap.physics.drives.drive import FREQUENCY, Frequency, Number, Wave, parameter, parameters
from vibrocap.physics.elementary import cos, sin


@parameters
class Harmonic(Wave):
    """Harmonic drive: h cos(omega tau) (Liu et al. 2019, eq. 4). Odd under half a period."""

    amplitude: Number = parameter(1.8, "h", "amplitude of the drive", "effort")
    frequency: Frequency = FREQUENCY

    name: ClassVar[str] = "harmonic"
    source: ClassVar[str] = "liu2019"
    odd: ClassVar = True  # type: ignore[override,assignment]

    def value(self, t):
        return self.amplitude * cos(self.frequency * t)

    def slope(self, t):
        return -(self.amplitude * self.frequency * sin(self.frequency * t))

    def curvature(self, t):
        return -(self.amplitude * self.frequency * self.frequency * cos(self.frequency * t))


@parameters
class Biharmonic(Wave):
    """Biharmonic drive: h cos(omega tau) + h2 cos(2 omega tau + psi). Odd under half a period only if h2 = 0."""

    amplitude: Number = parameter(1.8, "h", "amplitude of the drive", "effort")
    frequency: Frequency = FREQUENCY
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


HARMONICS = range(1, 8)


@parameters
class FourierSeries(Wave):
    """A smooth wave of up to seven harmonics: the sum over n of a_n cos(n omega t) + b_n sin(n omega t).

    It has no mean. Over all coefficients it is every shape twice over: a shift of time by a part of the period turns
    each pair (a_n, b_n) by n times that part, and changes no steady motion. A search over shapes therefore keeps b_1
    at 0. Without even harmonics the drive is odd under half a period; a search that is to break this symmetry begins
    with a_2 or b_2 away from 0.
    """

    frequency: Frequency = FREQUENCY
    cosine_1: Number = parameter(1.8, "a1", "cosine amplitude at omega", "effort")
    sine_1: Number = parameter(0.0, "b1", "sine amplitude at omega", "effort")
    cosine_2: Number = parameter(0.0, "a2", "cosine amplitude at 2 omega", "effort")
    sine_2: Number = parameter(0.0, "b2", "sine amplitude at 2 omega", "effort")
    cosine_3: Number = parameter(0.0, "a3", "cosine amplitude at 3 omega", "effort")
    sine_3: Number = parameter(0.0, "b3", "sine amplitude at 3 omega", "effort")
    cosine_4: Number = parameter(0.0, "a4", "cosine amplitude at 4 omega", "effort")
    sine_4: Number = parameter(0.0, "b4", "sine amplitude at 4 omega", "effort")
    cosine_5: Number = parameter(0.0, "a5", "cosine amplitude at 5 omega", "effort")
    sine_5: Number = parameter(0.0, "b5", "sine amplitude at 5 omega", "effort")
    cosine_6: Number = parameter(0.0, "a6", "cosine amplitude at 6 omega", "effort")
    sine_6: Number = parameter(0.0, "b6", "sine amplitude at 6 omega", "effort")
    cosine_7: Number = parameter(0.0, "a7", "cosine amplitude at 7 omega", "effort")
    sine_7: Number = parameter(0.0, "b7", "sine amplitude at 7 omega", "effort")

    name: ClassVar[str] = "fourier-series"
    source: ClassVar[str] = "vibrocap"

    def _coefficients(self):
        return [(n, getattr(self, f"cosine_{n}"), getattr(self, f"sine_{n}")) for n in HARMONICS]

    def value(self, t):
        angle = self.frequency * t
        return sum(a * cos(n * angle) + b * sin(n * angle) for n, a, b in self._coefficients())

    def slope(self, t):
        angle = self.frequency * t
        waves = (n * (b * cos(n * angle) - a * sin(n * angle)) for n, a, b in self._coefficients())
        return self.frequency * sum(waves)

    def curvature(self, t):
        angle = self.frequency * t
        waves = (n * n * (a * cos(n * angle) + b * sin(n * angle)) for n, a, b in self._coefficients())
        return -(self.frequency * self.frequency * sum(waves))

    @property
    def odd(self) -> bool:
        return all(a == b == 0.0 for n, a, b in self._coefficients() if n % 2 == 0)
