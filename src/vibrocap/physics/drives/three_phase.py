from typing import ClassVar

from vibrocap.physics.drives.drive import Piecewise, Positive, Segment, parameter, parameters
from vibrocap.physics.elementary import sqrt


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
