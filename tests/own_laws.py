"""A law and a drive outside the package, as a user's file would hold them; `test_own_parts` loads this file."""

import math
from typing import ClassVar

from vibrocap.physics.drives.drive import Drive, Number, cos
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter, parameters


@parameters
class LongTail(Law):
    """Friction that drops like 1/(1 + |v|/v_s)."""

    low: NonNegative = parameter(0.15, "c", "coefficient at high speed", "level")
    high: NonNegative = parameter(0.45, "s", "coefficient at rest", "static level")
    knee: Positive = parameter(0.1, "q", "speed at which half of the drop is done", "Stribeck velocity")

    name: ClassVar[str] = "long-tail"
    kind: ClassVar = "set-valued"

    def steady_force(self, speed, load):
        """Force at a constant speed."""
        return load * (self.low + (self.high - self.low) / (1.0 + speed / self.knee))

    def force(self, velocity, internal, side, load):
        """Force while sliding to `side`."""
        return side * self.steady_force(side * velocity, load), ()

    def holding_limit(self, load):
        """Largest force at rest."""
        return load * self.high

    @property
    def passive(self) -> bool:
        """Always."""
        return True


@parameters
class ThirdHarmonic(Drive):
    """A cosine and a tenth of its third harmonic."""

    amplitude: Number = parameter(1.8, "h", "amplitude", "effort")
    frequency: Positive = parameter(1.0, "omega", "frequency", "frequency")

    name: ClassVar[str] = "third-harmonic"

    def value(self, t):
        """The sum of both."""
        return self.amplitude * (cos(self.frequency * t) + 0.1 * cos(3.0 * self.frequency * t))

    @property
    def period(self) -> float:
        """2 pi / omega."""
        return 2.0 * math.pi / self.frequency

    @property
    def odd(self) -> bool:
        """Always."""
        return True


class Unfinished(Law):
    """A class without a name is a help for others and no part."""
