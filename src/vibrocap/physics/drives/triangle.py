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
class Triangle(PiecewiseWave):
    """Triangle wave: from -h up to h over the share r of the period, and down again.

    Imposed as a displacement it is the two-phase motion of Chernousko (2002): one speed forward, another one back. Odd
    under half a period where r = 1/2.
    """

    amplitude: Number = parameter(1.0, "h", "peak of the wave, half of its stroke", "effort")
    frequency: Positive = FREQUENCY
    rise: WithinOne = parameter(0.5, "r", "share of the period in which it rises", "share")

    name: ClassVar[str] = "triangle"
    source: ClassVar[str] = "chernousko2002"

    def segments(self) -> tuple[Segment, ...]:
        fall = 1.0 - self.rise
        return Segment(self.rise, (-1.0, 2.0 / self.rise)), Segment(fall, (1.0, -2.0 / fall))
