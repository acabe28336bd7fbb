"""steer(system, target): a schedule of the drive that brings a machine to a place and holds it there."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_one_of, check_whole, is_number, is_positive, shown
from vibrocap.case.case import Case, CaseError
from vibrocap.design.search.uncertainty import Uncertain, sample_points, samples_of, uncertain_quantities
from vibrocap.design.steering.family import (
    FASTEST,
    FINE,
    FINER,
    PAUSES,
    REFINEMENTS,
    SHORT,
    STILL,
    WINDOW,
    Family,
    periods_of,
    schedules_of,
)
from vibrocap.design.steering.steering import CHECK, ScheduleSegment, Steering, SteeringStatus
from vibrocap.design.steering.trials import RUN, Ends, Trials, with_schedule
from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.simulate import initial_state, simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Length, Time

SETTLING = 300  # periods, within which a motion settles whose drift long bursts rely on
TRAVELS = 1e-6  # of the largest drift, below which a motion does not travel
REST = 0.02  # of the tolerance, by which a machine may still move after a pause
KEPT = 32  # schedules that are run in whole: those that arrive soonest, and as many that come nearest
FRESH = 4  # times as many samples as the search has seen check what it found
HOLDS = 10  # times the hold, over which creep is measured
OBJECTIVES = ("time", "work")
GRID = 64  # points of a period at which the position is looked at for the arrival


@dataclasses.dataclass
class _Found:
    """Bursts that were run in whole: [n, bursts, 2], and their ends."""

    bursts: np.ndarray
    ends: Ends

    def errors(self, target: float) -> np.ndarray:
        """The worst error [n]; infinite where a run failed."""
        return np.max(np.nan_to_num(np.abs(self.ends.position - target), nan=math.inf), axis=1)


@shows_progress("Looking for a schedule")
def steer(
    system: System | Case,
    target: Length,
    *,
    tolerance: Length,
    uncertain: Mapping[Any, Any] | None = None,
    within: Time | None = None,
    least: str = "time",
    initial: ByName | None = None,
    hold: int = 10,
    samples: int = 16,
    levels: int = 16,
    threads: int | None = None,
    progress: Progress = None,
) -> Steering:
    """A schedule of the drive that brings a machine to a target and holds it there, the best of a stated family.

    The family: one burst or two, each of so many periods of the drive's own wave times a factor, begun anew and
    followed by a pause, in which the contact sticks. Factors are k/levels from -1 to 1: a negative one turns the drive
    round, and a machine without a preferred direction makes the mirror image of its motion. First bursts have every
    factor and up to 8 periods, or they are long: those of the six factors whose settled motions travel fastest towards
    the target, with each of ten whole numbers of periods about that which arrives. Second bursts have every factor and
    up to 4 periods. Lengths are multiples of a quarter of a period; of one, where the drive has corners of its own.
    Where none arrives, the last factor is refined to 1/64 of its step. Bursts add up, as nothing depends on the place
    and each pause ends at rest; by their sums the best are chosen, and these are run in whole.

    Found is a schedule that is feasible and the best of those that were run, not the best of all: a drive of another
    shape, or a feedback, may do better.

    system: a machine that travels under a drive that changes in time, and rests without
    target: the place where it is to be, in the position's own units, and in SI for a system in SI; tolerance: how far
        from there is near enough
    uncertain: {path: distribution}, as `robustness` takes it: every sample has to arrive, the corners of a box included
    within: the time in which the schedule may arrive; None: any
    least: what is made small, "time" or "work" of the drive
    initial: where it starts, by state; by default that of the case, else at rest at 0
    hold: drive periods of the last pause that are there to hold it
    samples: of what is uncertain, that the search sees; four times as many others check what it found
    threads: at most so many

    Returns a `Steering`, whose status says whether it arrives in every sample, and how near it comes if not. Raises
    CaseError with every complaint about the arguments before any work, and after it for a machine that does not rest
    while the drive pauses, a target that cannot be reached by this drive, and a time in which it cannot.
    """
    case = system if isinstance(system, Case) else Case(system)
    system = case.system
    complaints = Complaints()
    _check_system(system, complaints)
    if not is_number(target) or not math.isfinite(target):
        complaints.add("target", f"should be a finite number, got {shown(target)}")
    for name, value in (("tolerance", tolerance), ("within", 1.0 if within is None else within)):
        if not is_positive(value):
            complaints.add(name, f"should be positive, got {shown(value)}")
    for name, value, low, high in (("hold", hold, 1, 10_000), ("samples", samples, 1, 4096), ("levels", levels, 1, 64)):
        with complaints.collected():
            check_whole(name, value, low, high)
    with complaints.collected():
        check_one_of("least", least, OBJECTIVES)
    quantities = uncertain_quantities(system, uncertain, complaints) if uncertain else ()
    start: Mapping[str, float] = {}
    with complaints.collected():
        start = initial_state(system, case.initial if initial is None else initial)
    if complaints:
        raise CaseError(complaints, "the question")
    points = samples_of(quantities, samples, "worst").points
    search = _Search(system, start, float(target), float(tolerance), within, least, quantities, points, levels, threads)
    chosen = search.best(told(progress))
    return search.steering(chosen, hold)


def _check_system(system: System, complaints: Complaints) -> None:
    """Complaints about a system that cannot be steered."""
    if system.cyclic is None:
        complaints.add("system", "should be free to travel: this machine is held to its place")
    if system.controller is not None:
        complaints.add("system", "should have no controller, which does not let the drive pause; steer its machine")
        return
    if not is_driven(system):
        complaints.add("system", "should have a drive that changes in time")
        return
    try:
        with complaints.collected():
            with_schedule(system, [(1.0, 1.0), (1.0, 0.0)])
    except ValueError as error:
        complaints.add("system", f"should have a drive that can be scheduled: {error}")


class _Search:
    """The search for a schedule of one system to one target."""

    def __init__(
        self,
        system: System,
        start: Mapping[str, float],
        target: float,
        tolerance: float,
        within: float | None,
        least: str,
        quantities: tuple[Uncertain, ...],
        points: np.ndarray,
        levels: int,
        threads: int | None,
    ):
        self.system, self.start, self.quantities, self.threads = system, dict(start), quantities, threads
        self.target, self.tolerance, self.within, self.least = target, tolerance, within, least
        self.family = Family.of(system.drive, levels)
        self.trials = Trials(system, start, quantities, points, threads)
        self.period, self.here = system.drive.period, self.start[str(system.cyclic)]
        self.drift, self.settled = np.zeros(0), np.zeros(0, dtype=bool)
        self.pause, self.tried = float(STILL), 0

    def ends(self, bursts: np.ndarray, pause: float | None = None, at_rest: bool = False) -> Ends:
        """The ends of bursts [n, bursts, 2], each followed by a pause."""
        self.tried += len(bursts)
        return self.trials.ends(schedules_of(bursts, self.pause if pause is None else pause), at_rest)

    def best(self, tell: Any) -> np.ndarray:
        """The bursts [bursts, 2] of the best schedule."""
        tell = tell or (lambda share: None)
        self.drift, self.settled = self._settled_drift()
        tell(0.1)
        idle = self._check_rest()
        self.pause = self._shortest_pause()
        tell(0.3)
        first, d1, w1 = self._first_bursts()
        tell(0.6)
        second = self.family.bursts(FINE)[:, None]
        then = self.ends(second, at_rest=True)
        d2, w2 = then.position, then.work[:, 0]
        chosen = self._chosen(first, d1, w1, second, d2, w2)
        found = [idle]
        for count in (1, 2):
            some = np.array([each for each in chosen if len(each) == count])
            if len(some):
                found.append(_Found(some, self.ends(some)))
        tell(0.8)
        step = float(self.family.factors[0])
        for _ in range(REFINEMENTS):
            if self._arriving(found):
                break
            found += self._refined(found, step)
            step /= FINER
        tell(1.0)
        arriving = self._arriving(found, self.within)
        if arriving:
            return min(arriving, key=lambda each: each[0])[1]
        return self._nearest(found)

    def _settled_drift(self) -> tuple[np.ndarray, np.ndarray]:
        """(drift per drive period of the settled motion with each factor [factors], whether it settled)."""
        probe = self.trials.system
        found = ensemble(
            probe,
            {"drive.factor_1": self.family.factors},
            measures=["mean_velocity"],
            initial=self.start,
            periods=SETTLING,
            settle=1e-6,
            tolerance=RUN,
            threads=self.threads,
        )
        return np.nan_to_num(found["mean_velocity"] * self.period), found["settled"]

    def _check_rest(self) -> _Found:
        """The end of a pause from the start; CaseError for a machine that goes on moving."""
        none = np.zeros((1, 1, 2))
        long, longer = (self.trials.ends(np.array([[(float(n), 0.0)]])) for n in (STILL, 2 * STILL))
        moved = np.max(np.nan_to_num(np.abs(longer.position - long.position), nan=math.inf))
        if not moved <= REST * self.tolerance:
            by = "fails" if math.isinf(moved) else f"still moves by {self._said(moved)}"
            what = f"should rest while its drive pauses, to be held at the target: without its drive it {by}"
            raise CaseError([f"system: {what} from {STILL} to {2 * STILL} drive periods"], "the question")
        return _Found(none, long)

    def _shortest_pause(self) -> float:
        """The shortest pause after which the machine moves no more, whatever the factor of the burst before it."""
        bursts = np.stack([np.full(len(self.family.factors), float(FINE)), self.family.factors], axis=-1)[:, None]
        last = self.ends(bursts, STILL)
        for pause in PAUSES:
            ends = self.ends(bursts, pause)
            moved = np.abs(ends.position - last.position)
            sticks = self.system.friction.kind != "set-valued" or np.all(ends.speed[~np.isnan(moved)] == 0.0)
            if sticks and np.all(np.nan_to_num(moved) <= REST * self.tolerance):
                return float(pause)
        return float(STILL)

    def _first_bursts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(first bursts [n, 1, 2], the place after each [n, samples], work [n])."""
        bursts = [self.family.bursts(SHORT)]
        distance = self.target - self.here
        towards = self.drift * np.sign(distance)
        fast = np.argsort(-towards)[:FASTEST]
        fast = fast[towards[fast] > max(TRAVELS * np.max(np.abs(self.drift)), abs(distance) / SETTLING / 100)]
        if len(fast):
            factor, drift = self.family.factors[fast], self.drift[fast]
            about = np.maximum(1.0, np.round(distance / drift))
            begun = self.ends(np.stack([about, factor], axis=-1)[:, None]).position[:, 0]
            about = np.round(about + np.nan_to_num(self.target - begun) / drift)
            lengths = about[:, None] + WINDOW
            rows = np.stack([lengths, np.broadcast_to(factor[:, None], lengths.shape)], axis=-1).reshape(-1, 2)
            bursts.append(rows[rows[:, 0] > SHORT])
        found = np.concatenate(bursts)[:, None]
        ends = self.ends(found)
        return found, ends.position, ends.work[:, 0]

    def _chosen(
        self,
        first: np.ndarray,
        place: np.ndarray,
        work: np.ndarray,
        second: np.ndarray,
        further: np.ndarray,
        more: np.ndarray,
    ) -> list[np.ndarray]:
        """The bursts [1 or 2, 2] that are worth a run in whole, by the sums of what each burst does.

        place: [n, samples] after the first bursts; further: [m, samples] by the second ones; work, more: of both
        """
        away = place - self.target
        alone = np.max(np.nan_to_num(np.abs(away), nan=math.inf), axis=1)
        one, two = periods_of(first, self.pause), periods_of(second, self.pause)
        error = np.concatenate([alone[:, None], self._worst(away, further)], axis=1)  # [n, 1 + m]
        time = np.concatenate([one[:, None], one[:, None] + two], axis=1)
        cost = time if self.least == "time" else np.concatenate([work[:, None], work[:, None] + more], axis=1)
        late = np.full(error.shape, False) if self.within is None else time * self.period > self.within
        arrives = np.where(~late & (error <= 0.95 * self.tolerance), cost, math.inf)
        ways = [arrives, np.where(late, math.inf, error)]
        if self.within is not None:  # to say how long it takes where there is not the time
            ways.append(np.where(error <= 0.95 * self.tolerance, time, math.inf))
        picked: dict[tuple[int, int], None] = {}
        for way in ways:
            flat = np.argpartition(way, KEPT, axis=None)[:KEPT]
            flat = flat[np.isfinite(way.ravel()[flat])]
            picked |= dict.fromkeys((int(i), int(j)) for i, j in zip(*np.unravel_index(flat, way.shape), strict=True))
        return [first[i] if j == 0 else np.concatenate([first[i], second[j - 1]]) for i, j in picked]

    @staticmethod
    def _worst(away: np.ndarray, further: np.ndarray) -> np.ndarray:
        """The worst error [n, m] after each first burst and each second one, of errors and ways in every sample."""
        found = np.zeros((len(away), len(further)))
        for k in range(away.shape[1]):
            np.maximum(found, np.abs(away[:, k, None] + further[None, :, k]), out=found)
        return np.nan_to_num(found, nan=math.inf)

    def _refined(self, found: list[_Found], step: float) -> list[_Found]:
        """The nearest schedules again, with the last factor in finer steps."""
        refined = []
        for each in found:
            errors = each.errors(self.target)
            late = self.within is not None and periods_of(each.bursts, self.pause) * self.period > self.within
            nearest = np.argsort(np.where(late, math.inf, errors))[:FASTEST]
            near = each.bursts[nearest[np.isfinite(errors[nearest])]]
            near = near[near[:, -1, 0] > 0.0]
            if not len(near):
                continue
            shifts = step * np.arange(-FINER + 1, FINER) / FINER
            fine = np.repeat(near, len(shifts), axis=0)
            fine[:, -1, 1] = np.clip(fine[:, -1, 1] + np.tile(shifts, len(near)), -1.0, 1.0)
            refined.append(_Found(fine, self.ends(fine)))
        return refined

    def _arriving(self, found: list[_Found], within: float | None = None) -> list[tuple[tuple, np.ndarray]]:
        """((cost, worst error), bursts) of all that arrive in every sample, within a time."""
        arriving = []
        for each in found:
            errors, times = each.errors(self.target), periods_of(each.bursts, self.pause) * self.period
            costs = times if self.least == "time" else each.ends.work[:, 0]
            good = (errors <= self.tolerance) & (times <= (math.inf if within is None else within))
            arriving += [((float(costs[k]), float(errors[k])), each.bursts[k]) for k in np.flatnonzero(good)]
        return arriving

    def _nearest(self, found: list[_Found]) -> np.ndarray:
        """The bursts that come nearest; CaseError where they do not come near at all, or have not the time."""
        if self.within is not None and (late := self._arriving(found)):
            soonest = min(periods_of(bursts[None], self.pause)[0] for _, bursts in late) * self.period
            what = f"should be at least {self._said(soonest, 's')}, which the soonest schedule takes"
            raise CaseError([f"within: {what}, got {self._said(self.within, 's')}"], "the question")
        rows = [(each.errors(self.target), each) for each in found]
        if self.within is not None:
            rows = [
                (np.where(periods_of(each.bursts, self.pause) * self.period > self.within, math.inf, errors), each)
                for errors, each in rows
            ]
        errors, each = min(rows, key=lambda row: float(np.min(row[0])))
        k = int(np.argmin(errors))
        own = float(np.abs(each.ends.position[k, 0] - self.target))
        if math.isfinite(errors[k]) and own <= max(self.tolerance, 0.05 * abs(self.target - self.here)):
            return each.bursts[k]
        reached = np.concatenate([np.ravel(other.ends.position[:, 0]) for other in found])
        reached = reached[np.isfinite(reached)]
        span = f"{self._said(float(np.min(reached)))} to {self._said(float(np.max(reached)))}"
        towards = np.sign(self.target - self.here) * self.drift
        why = (
            "no settled motion of this drive travels there, with any factor, and short bursts"
            if not np.any(towards > TRAVELS * max(np.max(np.abs(self.drift)), 1e-300))
            else "the schedules of the family"
        )
        raise CaseError(
            [f"target: should be within reach: {why} reach from {span}, got {self._said(self.target)}"], "the question"
        )

    def _said(self, value: float, unit: str = "") -> str:
        """A place, or a time, in words with the unit that results have."""
        units = self.system.result_units
        if self.system.units is None:
            return f"{value:.6g}"
        factor = units.factor_of("s") if unit else units.factor(str(self.system.cyclic))
        return f"{value * factor:.6g} {unit or units.unit(str(self.system.cyclic))}"

    def steering(self, bursts: np.ndarray, hold: int) -> Steering:
        """The schedule of bursts [bursts, 2] with its hold, checked in samples that the search did not see as well."""
        rows = [tuple(map(float, row)) for row in schedules_of(bursts[None], self.pause)[0] if row[0] > 0.0]
        rows = [*rows[:-1], (rows[-1][0] + hold, 0.0)] if rows else [(float(hold), 0.0)]
        scheduled = with_schedule(self.system, rows)
        motion = simulate(scheduled, periods=1, initial=self.start, tolerance=CHECK)
        fresh = sample_points(len(self.quantities), FRESH * (self.trials.count - 1), 1) if self.quantities else None
        trials = [self.trials]
        if fresh is not None:
            trials.append(Trials(self.system, self.start, self.quantities, fresh, self.threads))
        longer = [*rows[:-1], (rows[-1][0] + (HOLDS - 1) * hold, 0.0)]
        ends, later = ([each.ends(np.array([way])) for each in trials] for way in (rows, longer))
        places = np.concatenate([each.position[0, 1:] for each in ends])
        creeps = [np.abs(b.position - a.position).ravel() for a, b in zip(ends, later, strict=True)]
        error = float(motion.state[str(self.system.cyclic)]) - self.target if motion.status.ok else math.inf
        worst = float(np.max(np.nan_to_num(np.abs(places - self.target), nan=math.inf), initial=abs(error)))
        status = SteeringStatus.ARRIVES if worst <= self.tolerance else SteeringStatus.NOT_REACHED
        if status is SteeringStatus.NOT_REACHED and abs(error) <= self.tolerance:
            status = SteeringStatus.NOT_IN_ALL_SAMPLES
        longest = bursts[int(np.argmax(bursts[:, 0]))]
        like = int(np.argmin(np.abs(self.family.factors - longest[1])))
        drawn = {path: np.concatenate([each.samples[path][1:] for each in trials]) for path in self.trials.samples}
        return Steering(
            system=scheduled,
            initial=self.start,
            target=self.target,
            tolerance=self.tolerance,
            segments=_segments(rows, bursts, motion, self.period),
            position=error + self.target,
            error=error,
            worst_error=worst,
            arrival=_arrival(motion, str(self.system.cyclic), self.target, self.tolerance, self.period),
            duration=motion.period,
            work=float(motion.at([motion.end], "drive_work")[0]),
            drift=float(self.drift[like]) if longest[0] else 0.0,
            settled=bool(self.settled[like]),
            creep=float(np.max(np.nan_to_num(np.concatenate(creeps), nan=math.inf))),
            samples=drawn,
            positions=places,
            checked=0 if fresh is None else len(fresh),
            tried=self.tried,
            status=status,
        )


def _segments(
    rows: list[tuple[float, float]], bursts: np.ndarray, motion: Trajectory, period: float
) -> tuple[ScheduleSegment, ...]:
    """The segments of a schedule, with the positions that a motion passes."""
    times = period * np.concatenate([[0.0], np.cumsum([row[0] for row in rows])])
    places = motion.at(np.minimum(times, motion.end), str(motion.system.cyclic))
    longest = float(np.max(bursts[:, 0]))
    found = []
    for k, (count, factor) in enumerate(rows):
        kind = "hold" if k == len(rows) - 1 else "pause"
        if factor:
            kind = "travel" if count == longest else "approach"
        found.append(ScheduleSegment(kind, *map(float, (times[k], times[k + 1], count, factor, *places[k : k + 2]))))
    return tuple(found)


def _arrival(motion: Trajectory, name: str, target: float, tolerance: float, period: float) -> float | None:
    """The time from which on a motion stays within the tolerance; None where it does not end there."""
    times = np.linspace(0.0, motion.end, max(2, math.ceil(GRID * motion.end / period)))
    outside = np.abs(motion.at(times, name) - target) > tolerance
    if not motion.status.ok or outside[-1]:
        return None
    if not np.any(outside):
        return 0.0
    from scipy.optimize import brentq

    k = int(np.flatnonzero(outside)[-1])

    def beyond(t: float) -> float:
        return float(abs(motion.at([t], name)[0] - target) - tolerance)

    return float(brentq(beyond, times[k], times[k + 1], xtol=1e-12 * motion.end))
