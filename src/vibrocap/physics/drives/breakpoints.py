"""Waves with breakpoints: square, triangle and trapezoid waves, a switch that is on or off, and switched pulses."""

import math
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field, model_validator

from vibrocap.physics.drives.drive import (
    FREQUENCY,
    Number,
    Piecewise,
    PiecewiseWave,
    Positive,
    Segment,
    Share,
    Wave,
    WithinOne,
    check_shares,
    parameter,
    parameters,
)
from vibrocap.physics.elementary import sqrt


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
    joined: ClassVar[bool] = True

    def segments(self) -> tuple[Segment, ...]:
        fall = 1.0 - self.rise
        return Segment(self.rise, (-1.0, 2.0 / self.rise)), Segment(fall, (1.0, -2.0 / fall))


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
    joined: ClassVar[bool] = True

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
