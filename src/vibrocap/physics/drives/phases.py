from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.drives.drive import Piecewise, Segment
from vibrocap.physics.parameters import NonNegative, Number, parameter, parameters

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
