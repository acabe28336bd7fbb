from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.drives.drive import Piecewise, Segment, check_shares
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters


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
