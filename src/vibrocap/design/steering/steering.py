"""What `steer` finds: a schedule that arrives, as a system that runs, and what becomes of it in every sample."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import Case
from vibrocap.design.steering.family import schedules_of
from vibrocap.design.steering.search import Search
from vibrocap.design.steering.trials import Trials, most_events, with_schedule
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Length, Lengths, Number, Numbers, Time, Work
from vibrocap.quantities.dimensional import Dimensional
from vibrocap.results import Advised, Result

CHECK = 1e-10  # tolerance of the motions that are shown
HOLDS = 10  # times the hold, over which creep is measured
GRID = 64  # points of a period at which the position is looked at for the arrival


class SteeringStatus(Advised):
    """Whether a schedule arrives; `advice` says what to try."""

    ARRIVES = "arrives", "In every sample it ends within the tolerance of the target, and stays."
    NOT_IN_ALL_SAMPLES = (
        "not in all samples",
        "The schedule arrives as the system is given, but not in every sample of what is uncertain: ask for the "
        "tolerance that `worst_error` says, know what is uncertain better, or measure on the way and steer again.",
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

    rows = "segments"
    in_record = (
        "status target tolerance position error worst_error arrival duration work drift creep share_within settled "
        "checked tried segments samples positions"
    )

    @property
    def share_within(self) -> Number:
        """Share of the samples that end within the tolerance; 1 or 0 where nothing is uncertain."""
        if not len(self.positions):
            return float(abs(self.error) <= self.tolerance)
        return float(np.mean(np.abs(self.positions - self.target) <= self.tolerance))

    def motion(self, sample: int | None = None) -> Trajectory:
        """The motion of the system itself over the schedule, or that of a sample by its number."""
        system = self.system
        if sample is not None:
            system = system.with_parameters({path: float(x[sample]) for path, x in self.samples.items()})
        return simulate(system, initial=self.initial, **_run(self.system))

    def case(self) -> Case:
        """The case that runs the schedule once."""
        return Case(self.system, self.initial, **_run(self.system))

    def save(self, path: str | Path) -> Path:
        """Write a case file, which `vibrocap simulate` runs over the schedule."""
        return self.case().save(path)

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
            share = (
                f"{100.0 * self.share_within:.4g} % of {len(self.positions)} samples within {self.said('tolerance', 4)}"
            )
            found["uncertain"] = f"{share}, worst error {self.said('worst_error', 4)}"
        if self.arrival is not None:
            found["arrives"] = f"after {self.said('arrival', 6)} of {self.said('duration', 6)}"
        if any(each.factor for each in self.segments):
            what = "settled" if self.settled else "not settled"
            found["travels"] = f"{self.said('drift', 6)} per drive period, {what}, by the factor of the longest burst"
        found["work"] = self.said("work", 6)
        found["creep"] = f"{self.said('creep', 3)} in ten times the hold"
        return found


def steering_of(search: Search, bursts: np.ndarray, hold: int, fresh: Trials) -> Steering:
    """The schedule of bursts [bursts, 2] with its hold, checked in samples that the search did not see as well."""
    rows = [tuple(map(float, row)) for row in schedules_of(bursts[None], search.pause)[0] if row[0] > 0.0]
    rows = [*rows[:-1], (rows[-1][0] + hold, 0.0)] if rows else [(float(hold), 0.0)]
    scheduled = with_schedule(search.system, rows)
    motion = simulate(scheduled, initial=search.start, **_run(scheduled))
    trials = [search.trials, *([fresh] if search.trials.samples else [])]
    longer = [*rows[:-1], (rows[-1][0] + (HOLDS - 1) * hold, 0.0)]
    ends, later = ([each.ends(np.array([way])) for each in trials] for way in (rows, longer))
    places = np.concatenate([each.position[0, 1:] for each in ends])
    creeps = [np.abs(b.position - a.position).ravel() for a, b in zip(ends, later, strict=True)]
    error = float(motion.state[str(search.system.cyclic)]) - search.target if motion.status.ok else math.inf
    worst = float(np.max(np.nan_to_num(np.abs(places - search.target), nan=math.inf), initial=abs(error)))
    status = SteeringStatus.ARRIVES if worst <= search.tolerance else SteeringStatus.NOT_REACHED
    if status is SteeringStatus.NOT_REACHED and abs(error) <= search.tolerance:
        status = SteeringStatus.NOT_IN_ALL_SAMPLES
    longest = bursts[int(np.argmax(bursts[:, 0]))]
    (drift,), (settled,) = search.settled_drift(longest[1:])
    drawn = {path: np.concatenate([each.samples[path][1:] for each in trials]) for path in search.trials.samples}
    return Steering(
        system=scheduled,
        initial=search.start,
        target=search.target,
        tolerance=search.tolerance,
        segments=_segments(rows, bursts, motion),
        position=error + search.target,
        error=error,
        worst_error=worst,
        arrival=_arrival(motion, str(search.system.cyclic), search.target, search.tolerance),
        duration=motion.period,
        work=float(motion.at([motion.end], "drive_work")[0]),
        drift=float(drift),
        settled=bool(settled),
        creep=float(np.max(np.nan_to_num(np.concatenate(creeps), nan=math.inf))),
        samples=drawn,
        positions=places,
        checked=fresh.count - 1 if search.trials.samples else 0,
        tried=search.tried,
        status=status,
    )


def _run(system: Any) -> dict[str, Any]:
    """How the motion over the schedule of a system is run."""
    return {"periods": 1, "tolerance": CHECK, "max_events_per_period": most_events(system.drive.phases)}


def _segments(rows: list[tuple[float, float]], bursts: np.ndarray, motion: Trajectory) -> tuple[ScheduleSegment, ...]:
    """The segments of a schedule, with the positions that a motion passes."""
    times = motion.system.drive.wave.period * np.concatenate([[0.0], np.cumsum([row[0] for row in rows])])
    places = motion.at(np.minimum(times, motion.end), str(motion.system.cyclic))
    longest = float(np.max(bursts[:, 0]))
    found = []
    for k, (count, factor) in enumerate(rows):
        kind = "hold" if k == len(rows) - 1 else "pause"
        if factor:
            kind = "travel" if count == longest else "approach"
        found.append(ScheduleSegment(kind, *map(float, (times[k], times[k + 1], count, factor, *places[k : k + 2]))))
    return tuple(found)


def _arrival(motion: Trajectory, name: str, target: float, tolerance: float) -> float | None:
    """The time from which on a motion stays within the tolerance; None where it does not end there."""
    times = np.linspace(0.0, motion.end, max(2, math.ceil(GRID * motion.end / motion.system.drive.wave.period)))
    outside = np.abs(motion.at(times, name) - target) > tolerance
    if not motion.status.ok or outside[-1]:
        return None
    if not np.any(outside):
        return 0.0
    from scipy.optimize import brentq

    k = int(np.flatnonzero(outside)[-1])

    def beyond(t: float) -> float:
        return float(abs(motion.at([t], name)[0] - target) - tolerance)

    found: Any = brentq(beyond, times[k], times[k + 1], xtol=1e-12 * motion.end)
    return float(found)
