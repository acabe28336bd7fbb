from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.drives.drive import FREQUENCY, PiecewiseWave, Segment, Share, WithinOne, check_shares
from vibrocap.physics.parameters import Number, Positive, parameter, parameters


@parameters
class Trapezoid(PiecewiseWave):
    """Trapezoid wave: from -h up to h, there for a while, down to -h, and there for the rest of the period.

    A square wave whose actuator has a finite rate. Odd under half a period where it rises and falls equally fast and
    holds both levels equally long.
    """

    amplitude: Number = parameter(1.0, "h", "upper level; the lower one is -h", "effort")
    frequency: Positive = FREQUENCY
    rise: WithinOne = parameter(0.125, "r", "share of the period in which it rises", "share")
    hold: Share = parameter(0.375, "d", "share of the period at the upper level", "share")
    fall: WithinOne = parameter(0.125, "f", "share of the period in which it falls", "share")

    name: ClassVar[str] = "trapezoid"
    source: ClassVar[str] = "vibrocap"

    @model_validator(mode="after")
    def _within_a_period(self):
        check_shares(rise=self.rise, fall=self.fall)
        if self.rise + self.hold + self.fall > 1.0:
            raise ValueError(
                f"hold should leave rise + hold + fall at most 1, got {self.rise:g} + {self.hold:g} + {self.fall:g}"
            )
        return self

    def segments(self) -> tuple[Segment, ...]:
        rest = 1.0 - self.rise - self.hold - self.fall
        return (
            Segment(self.rise, (-1.0, 2.0 / self.rise)),
            Segment(self.hold, (1.0, 0.0)),
            Segment(self.fall, (1.0, -2.0 / self.fall)),
            Segment(rest, (-1.0, 0.0)),
        )
