"""What `steer` finds: a schedule that arrives, as a system that runs, and what becomes of it in every sample."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import Case
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Length, Lengths, Number, Numbers, Time, Work
from vibrocap.quantities.dimensional import Dimensional
from vibrocap.results import Advised, Result


class SteeringStatus(Advised):
    """Whether a schedule arrives; `advice` says what to try."""

    ARRIVES = "arrives", "In every sample it ends within the tolerance of the target, and stays."
    NOT_IN_ALL_SAMPLES = (
        "not in all samples",
        "The schedule arrives as the system is given, but not in every sample of what is uncertain: ask for the "
        "tolerance that `worst_error` says, know the uncertain quantities better, or measure and steer again on the way.",
    )
    NOT_REACHED = (
        "not reached",
        "No schedule of the family comes so near: ask for the tolerance that `worst_error` says, or for more `levels`.",
    )


@dataclasses.dataclass(frozen=True)
class ScheduleSegment(Dimensional):
    """A segment of a schedule.

    kind: "travel" (the longest burst), "approach", "pause" or "hold"; start, end: its times; periods: of the drive;
    factor: by which the drive is multiplied; start_position, end_position: of the system as it is given
    """

    kind: str
    start: Time
    end: Time
    periods: Number
    factor: Number
    start_position: Length
    end_position: Length


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Steering(Result):
    """A schedule of the drive that brings a machine to a target and holds it there.

    system: with the drive on its schedule, of which one period is the whole of it; initial: where it starts
    target, tolerance: asked for; segments: of the schedule, with the positions that the system itself passes
    position: where the system itself ends; error: that less the target; worst_error: the largest size of an error in
        all samples, inf where a run failed
    arrival: time from which on the system itself stays within the tolerance, None where it does not; duration: of the
        schedule, the hold included; work: of the drive
    drift: per drive period, of the settled motion of the longest burst; settled: whether it is settled at all
    creep: how far the machine moves in ten times the hold, in the worst sample
    samples: values of what is uncertain, by path; positions: where each of them ends
    checked: how many of these, at the end, the search did not see; tried: schedules that were run
    """

    system: System
    initial: ByName
    target: Length
    tolerance: Length
    segments: tuple[ScheduleSegment, ...]
    position: Length
    error: Length
    worst_error: Length
    arrival: Time | None
    duration: Time
    work: Work
    drift: Length
    settled: bool
    creep: Length
    samples: dict[str, Numbers]
    positions: Lengths
    checked: int
    tried: int
    status: SteeringStatus

    @property
    def within(self) -> Number:
        """Share of the samples that end within the tolerance; 1 or 0 where nothing is uncertain."""
        if not len(self.positions):
            return float(abs(self.error) <= self.tolerance)
        return float(np.mean(np.abs(self.positions - self.target) <= self.tolerance))

    def motion(self, sample: int | None = None) -> Trajectory:
        """The motion of the system itself over the schedule, or that of a sample by its number."""
        system = self.system
        if sample is not None:
            system = system.with_parameters({path: float(x[sample]) for path, x in self.samples.items()})
        return simulate(system, periods=1, initial=self.initial, tolerance=CHECK)

    def case(self) -> Case:
        """The case that runs the schedule once."""
        return Case(self.system, self.initial, periods=1, tolerance=CHECK)

    def save(self, path: str | Path) -> Path:
        """Write a case file, which `vibrocap simulate` runs over the schedule."""
        return self.case().save(path)

    def table(self) -> list[dict[str, Any]]:
        """A row for each segment of the schedule."""
        return [dataclasses.asdict(each) for each in self.segments]

    @property
    def heading(self) -> str:
        return f"schedule to {self.said('target', 6)}: {self.status.value}"

    @property
    def facts(self) -> dict[str, str]:
        bursts = [f"{each.factor:g} x {each.periods:g}" for each in self.segments if each.factor]
        found = {
            "schedule": f"{' and '.join(bursts) or 'nothing'} (factor x periods), each followed by a pause",
            "ends at": f"{self.said('position')}, error {self.said('error', 3)}",
        }
        if len(self.positions):
            share = f"{100.0 * self.within:.4g} % of {len(self.positions)} samples within {self.said('tolerance', 4)}"
            found["uncertain"] = f"{share}, worst error {self.said('worst_error', 4)}"
        if self.arrival is not None:
            found["arrives"] = f"after {self.said('arrival', 6)} of {self.said('duration', 6)}"
        found["work"] = self.said("work", 6)
        found["creep"] = f"{self.said('creep', 3)} in ten times the hold"
        return found


CHECK = 1e-10  # tolerance of the motions that are shown
