from typing import ClassVar

from vibrocap.physics.drives.drive import Drive, Number, Positive, parameter, parameters


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
