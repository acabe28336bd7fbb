from typing import ClassVar

from vibrocap.physics.drives.drive import (
    FREQUENCY,
    Number,
    PiecewiseWave,
    Positive,
    Segment,
    WithinOne,
    parameter,
    parameters,
)


@parameters
class Square(PiecewiseWave):
    """Square wave: h over the share d of the period, then -h. What a relay or a current in an H bridge exerts.

    Odd under half a period where d = 1/2.
    """

    amplitude: Number = parameter(1.0, "h", "level of the first part; that of the second is -h", "effort")
    frequency: Positive = FREQUENCY
    duty: WithinOne = parameter(0.5, "d", "share of the period at the first level", "share")

    name: ClassVar[str] = "square"
    source: ClassVar[str] = "vibrocap"

    def segments(self) -> tuple[Segment, ...]:
        return Segment(self.duty, (1.0,)), Segment(1.0 - self.duty, (-1.0,))
