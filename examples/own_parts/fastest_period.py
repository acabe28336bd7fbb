"""A result of one's own: the fastest period of a motion, in SI where the motion is."""

import dataclasses

import numpy as np

import vibrocap as vc
from vibrocap.motion.trajectory import Trajectory
from vibrocap.quantities.declared import Length, Number, Speed, Time
from vibrocap.quantities.dimensional import Dimensional, in_si
from vibrocap.quantities.opening import opened_in_si


@dataclasses.dataclass(frozen=True)
class FastestPeriod(Dimensional):
    """The whole drive period in which a motion travels farthest: distance, start and end, and its number."""

    distance: Length
    window: tuple[Time, Time]
    number: Number

    @property
    def speed(self) -> Speed:
        """Distance over time."""
        return self.distance / (self.window[1] - self.window[0])


@opened_in_si
def fastest_period(motion: Trajectory) -> FastestPeriod:
    """The period of the largest travel in either direction."""
    period = motion.system.drive.period
    marks = period * np.arange(int(motion.end / period) + 1)
    travel = np.diff(motion.at(marks, "position"))
    k = int(np.argmax(np.abs(travel)))
    return FastestPeriod(float(travel[k]), (float(marks[k]), float(marks[k + 1])), k)


if __name__ == "__main__":
    motion = vc.simulate(vc.read_case("examples/prototype-in-si.toml"), periods=5)
    fastest = fastest_period(motion)
    plain = fastest_period(motion.dimensionless)
    assert in_si(plain, motion.system).speed == fastest.speed != plain.speed
    print(f"{fastest.speed:.4f} {fastest.unit_of('speed')}")
