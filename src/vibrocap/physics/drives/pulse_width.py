import math
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from vibrocap.physics.drives.drive import (
    FREQUENCY,
    Number,
    PiecewiseWave,
    Positive,
    Segment,
    Share,
    parameter,
    parameters,
)

MOST_PULSES = 10_000


def _whole(value: Any) -> Any:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if number and value == int(value) and 2 <= value <= MOST_PULSES:
        return int(value)
    raise ValueError(f"should be a whole number from 2 to {MOST_PULSES}")


@parameters
class PulseWidth(PiecewiseWave):
    """Pulses of height h and -h whose mean follows m h sin(omega t), as a switched amplifier makes them.

    The period is cut into n equal cells. In cell i, whose middle is at t_i, the drive is h sgn(sin(omega t_i)) for the
    share m |sin(omega t_i)| of the cell, about its middle, and 0 for the rest: three levels, sampled once per cell.
    Odd under half a period where n is even.
    """

    amplitude: Number = parameter(1.0, "h", "height of the pulses", "effort")
    frequency: Positive = FREQUENCY
    modulation: Share = parameter(0.8, "m", "peak of the sine that the pulses follow, over their height", "share")
    pulses: Annotated[Any, BeforeValidator(_whole)] = parameter(6, "n", "cells in a period", "convention")

    name: ClassVar[str] = "pulse-width"
    source: ClassVar[str] = "holmes2003"
    shape_parameters: ClassVar = ("pulses",)

    def segments(self) -> tuple[Segment, ...]:
        segments, gap = [], 0.0
        for i in range(self.pulses):
            sine = math.sin(2.0 * math.pi * (i + 0.5) / self.pulses)
            if abs(sine) < 1e-12:
                gap = gap + 1.0 / self.pulses
                continue
            width = self.modulation * (abs(sine) / self.pulses)
            rest = 0.5 * (1.0 / self.pulses - width)
            segments += [Segment(gap + rest, (0.0,)), Segment(width, (math.copysign(1.0, sine),))]
            gap = rest
        return (*segments, Segment(gap, (0.0,)))
