from typing import Annotated, ClassVar

from pydantic import Field

from vibrocap.physics.drives.drive import (
    FREQUENCY,
    Number,
    Piecewise,
    Positive,
    Segment,
    Wave,
    WithinOne,
    parameter,
    parameters,
)
from vibrocap.physics.elementary import sqrt

Phase = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, lt=1)]


@parameters
class OnOff(Wave, Piecewise):
    """A drive that is switched on and off: h_0 + h while it is on, h_0 while it is off.

    It is on for the share d of each period, from the share phi of it on (over the end of the period, where phi + d > 1,
    as everything repeats). So a solenoid, a coil under a capsule or a motor is driven by one switch. With h_0 = -h it
    pulls only while it is off; with h_0 = -h/2 and d = 1/2 it is a square wave, the one case that is odd under half a
    period.
    """

    amplitude: Number = parameter(1.0, "h", "addition while it is on", "effort")
    offset: Number = parameter(0.0, "h_0", "level while it is off", "effort")
    frequency: Positive = FREQUENCY
    duty: WithinOne = parameter(0.5, "d", "share of the period in which it is on", "share")
    phase: Phase = parameter(0.0, "phi", "share of the period at which it is switched on, less than 1", "share")

    name: ClassVar[str] = "on-off"
    source: ClassVar[str] = "vibrocap"

    def segments(self) -> tuple[Segment, ...]:
        """On for what lasts over the end of a period, off, on, off: of the first and the last one has no length."""
        over = self.duty - (1.0 - self.phase)  # how far it reaches over the end; below zero where it does not
        size = sqrt(over * over)
        before, after = 0.5 * (size + over), 0.5 * (size - over)  # max(over, 0), max(-over, 0)
        on, off = (self.offset + self.amplitude,), (self.offset,)
        return (
            Segment(before, on),
            Segment(self.phase - before, off),
            Segment(self.duty - before, on),
            Segment(after, off),
        )
