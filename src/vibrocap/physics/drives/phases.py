"""Phases one after another: levels of a force, and displacements to and fro by phases of constant acceleration."""

from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.drives.drive import Piecewise, Segment, check_shares
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters

PHASES = range(1, 8)


@parameters
class Phases(Piecewise):
    """One level after another, each for its own duration: two, three, four or up to seven phases per period.

    As a force on the inner mass these are the acceleration profiles of the literature on capsules. A phase of duration
    0 is none, so that the number of phases is that of durations above 0. The period is the sum of the durations.
    """

    level_1: Number = parameter(1.0, "h1", "force or torque in phase 1", "effort")
    duration_1: NonNegative = parameter(1.0, "t1", "length of phase 1", "duration")
    level_2: Number = parameter(-0.5, "h2", "force or torque in phase 2", "effort")
    duration_2: NonNegative = parameter(2.0, "t2", "length of phase 2", "duration")
    level_3: Number = parameter(0.0, "h3", "force or torque in phase 3", "effort")
    duration_3: NonNegative = parameter(0.0, "t3", "length of phase 3", "duration")
    level_4: Number = parameter(0.0, "h4", "force or torque in phase 4", "effort")
    duration_4: NonNegative = parameter(0.0, "t4", "length of phase 4", "duration")
    level_5: Number = parameter(0.0, "h5", "force or torque in phase 5", "effort")
    duration_5: NonNegative = parameter(0.0, "t5", "length of phase 5", "duration")
    level_6: Number = parameter(0.0, "h6", "force or torque in phase 6", "effort")
    duration_6: NonNegative = parameter(0.0, "t6", "length of phase 6", "duration")
    level_7: Number = parameter(0.0, "h7", "force or torque in phase 7", "effort")
    duration_7: NonNegative = parameter(0.0, "t7", "length of phase 7", "duration")

    name: ClassVar[str] = "phases"
    source: ClassVar[str] = "fang2011; huda2015"

    @model_validator(mode="after")
    def _some_phase(self):
        if not self.period > 0.0:
            raise ValueError("duration_1 should be greater than 0, or another duration, got phases without any length")
        return self

    def segments(self) -> tuple[Segment, ...]:
        period = self.period
        return tuple(Segment(getattr(self, f"duration_{i}") / period, (getattr(self, f"level_{i}"),)) for i in PHASES)

    @property
    def period(self) -> float:
        return sum(getattr(self, f"duration_{i}") for i in PHASES)


@parameters
class ThreePhase(Piecewise):
    """Displacement from 0 to the stroke L and back, with the acceleration w1, then -w2, then w3 (Chernousko 2002).

    It starts and ends at rest, at 0. Its fastest speeds are u1 forward and u3 back,

        u1 = sqrt(2 L/(1/w1 + 1/w2)),  u3 = sqrt(2 L/(1/w3 + 1/w2)),

    its phases last u1/w1, (u1 + u3)/w2 and u3/w3. Imposed on the inner mass of a crawler it is the motion for which the
    best progress is known in closed form.
    """

    stroke: Positive = parameter(1.0, "L", "from the first to the farthest point", "effort")
    first_acceleration: Positive = parameter(
        1.0, "w1", "acceleration forward in the first phase", "effort acceleration"
    )
    second_acceleration: Positive = parameter(2.0, "w2", "acceleration back in the second phase", "effort acceleration")
    third_acceleration: Positive = parameter(
        1.0, "w3", "acceleration forward in the third phase", "effort acceleration"
    )

    name: ClassVar[str] = "three-phase"
    source: ClassVar[str] = "chernousko2002"
    joined: ClassVar[bool] = True

    def _speeds(self) -> tuple:
        forward = 1.0 / self.first_acceleration + 1.0 / self.second_acceleration
        back = 1.0 / self.third_acceleration + 1.0 / self.second_acceleration
        return sqrt(2.0 * self.stroke / forward), sqrt(2.0 * self.stroke / back)

    def segments(self) -> tuple[Segment, ...]:
        """w1 t^2/2; what follows with the same place and speed, twice."""
        forward, back = self._speeds()
        first, second, third = self.first_acceleration, self.second_acceleration, self.third_acceleration
        period = self.period
        time, square = period / self.stroke, 0.5 * period * period / self.stroke
        return (
            Segment(forward / first / period, (0.0, 0.0, first * square)),
            Segment(
                (forward + back) / second / period,
                (0.5 * forward * forward / first / self.stroke, forward * time, -second * square),
            ),
            Segment(back / third / period, (0.5 * back * back / third / self.stroke, -(back * time), third * square)),
        )

    def size(self):
        return self.stroke

    @property
    def period(self) -> float:
        forward, back = self._speeds()
        return (
            forward / self.first_acceleration
            + (forward + back) / self.second_acceleration
            + back / self.third_acceleration
        )


@parameters
class SevenPhase(Piecewise):
    """Displacement from 0 to the stroke L and back, each way with a start, a cruise and a stop, then a rest.

    The speed rises, stays and falls at constant rates, so that each way takes the cruise and half of start and stop
    at its cruising speed. Without cruises and rest (durations 0) it has four phases: two triangles of speed.
    """

    stroke: Positive = parameter(1.0, "L", "from the first to the farthest point", "effort")
    forward_start: Positive = parameter(1.0, "t1", "time in which it speeds up forward", "duration")
    forward_cruise: NonNegative = parameter(1.0, "t2", "time at a constant speed forward", "duration")
    forward_stop: Positive = parameter(0.5, "t3", "time in which it slows down forward", "duration")
    back_start: Positive = parameter(0.5, "t4", "time in which it speeds up back", "duration")
    back_cruise: NonNegative = parameter(0.5, "t5", "time at a constant speed back", "duration")
    back_stop: Positive = parameter(0.5, "t6", "time in which it slows down back", "duration")
    rest: NonNegative = parameter(0.5, "t7", "time at rest", "duration")

    name: ClassVar[str] = "seven-phase"
    source: ClassVar[str] = "huda2015"
    joined: ClassVar[bool] = True

    @model_validator(mode="after")
    def _told_apart(self):
        names = ("forward_start", "forward_stop", "back_start", "back_stop")
        check_shares(**{name: getattr(self, name) / self.period for name in names})
        return self

    def segments(self) -> tuple[Segment, ...]:
        period = self.period
        forward = period / (0.5 * self.forward_start + self.forward_cruise + 0.5 * self.forward_stop)
        back = period / (0.5 * self.back_start + self.back_cruise + 0.5 * self.back_stop)
        lengths = self.forward_start, self.forward_cruise, self.forward_stop
        t1, t2, t3 = (length / period for length in lengths)
        t4, t5, t6 = (length / period for length in (self.back_start, self.back_cruise, self.back_stop))
        return (
            Segment(t1, (0.0, 0.0, 0.5 * forward / t1)),
            Segment(t2, (0.5 * forward * t1, forward, 0.0)),
            Segment(t3, (forward * (0.5 * t1 + t2), forward, -0.5 * forward / t3)),
            Segment(t4, (1.0, 0.0, -0.5 * back / t4)),
            Segment(t5, (1.0 - 0.5 * back * t4, -back, 0.0)),
            Segment(t6, (0.5 * back * t6, -back, 0.5 * back / t6)),
            Segment(self.rest / period, (0.0, 0.0, 0.0)),
        )

    def size(self):
        return self.stroke

    @property
    def period(self) -> float:
        forward = self.forward_start + self.forward_cruise + self.forward_stop
        return forward + self.back_start + self.back_cruise + self.back_stop + self.rest
