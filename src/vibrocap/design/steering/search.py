"""The search for a schedule to one target: tables of bursts, their sums, and runs of the best in whole."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint
from vibrocap.case.case import CaseError
from vibrocap.design.search.uncertainty import Uncertain
from vibrocap.design.steering.family import (
    FASTEST,
    FINE,
    PAUSES,
    SHORT,
    STILL,
    WINDOW,
    Family,
    periods_of,
    schedules_of,
    spread,
)
from vibrocap.design.steering.trials import RUN, Ends, Trials
from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.trust import Trust, residue
from vibrocap.physics.system import System

SETTLING = 300  # periods, within which a motion settles whose drift long bursts rely on
SETTLE = 1e-6  # to which it does
REST = 0.02  # of the tolerance, by which a machine may still move after a pause
KEPT = 16  # schedules that arrive by the sums of their bursts, which are run in whole
CLOSE = 256  # of those that come nearest, where none arrives
EACH = 4  # of these with the same first burst
SURE = 0.95  # of the tolerance, within which a sum of bursts counts as arriving
LONGEST = 10_000  # periods of a burst: a motion that does not arrive in so many does not travel there
CUTS = 8  # of a step between two factors, in each refinement
REFINEMENTS = 5
BATCH = 8  # brackets that are refined at a time, the soonest first
NEARER = 3  # refinements of those that come nearest, where none arrives
NEAR = 0.05  # of the way, within which a schedule counts as one to the target that misses it


@dataclasses.dataclass(frozen=True)
class Tried:
    """Schedules that were run in whole.

    bursts: [n, 2, 2], of which the first may have no length; time: until the last pause ends; cost: what is made small
    middle, half: of the range of the errors in all samples; own: the error of the system itself
    """

    bursts: np.ndarray
    time: np.ndarray
    cost: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    own: np.ndarray

    @property
    def worst(self) -> np.ndarray:
        """The worst error [n]; infinite where a run failed."""
        return np.nan_to_num(np.abs(self.middle) + self.half, nan=math.inf)

    @classmethod
    def joined(cls, parts: "Sequence[Tried]") -> "Tried":
        """All of them."""
        names = [field.name for field in dataclasses.fields(cls)]
        return cls(*(np.concatenate([getattr(each, name) for each in parts]) for name in names))


@dataclasses.dataclass(frozen=True)
class Brackets:
    """Schedules [n, 2, 2] of which the middle error changes its sign while the last factor goes from low to high [n].

    cost: [n] in order
    """

    bursts: np.ndarray
    low: np.ndarray
    high: np.ndarray
    cost: np.ndarray

    def some(self, chosen: Any) -> "Brackets":
        """Those that are chosen."""
        return Brackets(self.bursts[chosen], self.low[chosen], self.high[chosen], self.cost[chosen])


class Search:
    """The search for a schedule of one system to one target."""

    def __init__(
        self,
        system: System,
        start: Mapping[str, float],
        target: float,
        tolerance: float,
        least: str,
        uncertain: tuple[Sequence[Uncertain], np.ndarray],
        levels: int,
        threads: int | None,
    ):
        """least: "time" or "work"; uncertain: quantities, and samples of them"""
        self.system, self.start, self.threads = system, dict(start), threads
        self.target, self.tolerance, self.least = target, tolerance, least
        self.family = Family.of(system.drive, levels)
        self.trials = Trials(system, start, *uncertain, threads)
        self.here = self.start[str(system.cyclic)]
        self.drift, _ = self.settled_drift(self.family.factors)
        self.pause, self.tried = float(STILL), 0

    def ends(self, bursts: np.ndarray, pause: float | None = None, at_rest: bool = False) -> Ends:
        """The ends of bursts [n, bursts, 2], each followed by a pause."""
        self.tried += len(bursts)
        return self.trials.ends(schedules_of(bursts, self.pause if pause is None else pause), at_rest)

    def run(self, bursts: np.ndarray) -> Tried:
        """Schedules of bursts [n, 2, 2] in whole."""
        ends = self.ends(bursts)
        time = periods_of(bursts, self.pause) * self.system.drive.period
        away = ends.position - self.target
        return Tried(bursts, time, time if self.least == "time" else ends.work[:, 0], *spread(away), away[:, 0])

    def schedules(self, tell: Callable[[float], None], within: float = math.inf) -> Tried:
        """All schedules that were run in whole, those that arrive at least cost among them; within: the time there is.

        Raises CaseError for a machine that keeps moving while its drive pauses.
        """
        self._check_rest()
        self.pause = self._shortest_pause()
        tell(0.2)
        arriving, near, between, wide = self._candidates(within)
        tell(0.5)
        found = [self.run(np.concatenate([np.zeros((1, 2, 2)), arriving]))]
        for begin in range(0, len(between.cost), BATCH):
            found += self._between(between.some(slice(begin, begin + BATCH)), found, within)
            tell(0.5 + 0.4 * begin / len(between.cost))
        if not np.any(Tried.joined(found).worst <= self.tolerance):
            found.append(self.run(near))
            found += self._between(wide, found, within)
            found += self._nearer(Tried.joined(found))
        return Tried.joined(found)

    def _nearer(self, known: Tried) -> list[Tried]:
        """The schedules that come nearest with the last factor to both sides, in ever finer steps."""
        made = [known]
        step = float(self.family.factors[-1] / len(self.family.factors))
        for _ in range(NEARER):
            known = Tried.joined(made)
            best = known.bursts[np.argsort(known.worst, kind="stable")[:BATCH]]
            fine = np.repeat(best, CUTS + 1, axis=0)
            fine[:, -1, 1] += np.tile(np.linspace(-step, step, CUTS + 1), len(best))
            fine[:, -1, 1] = np.clip(fine[:, -1, 1], -1.0, 1.0)
            made.append(self.run(fine))
            step /= 0.5 * CUTS
        return made[1:]

    def _between(self, some: "Brackets", found: list[Tried], within: float) -> list[Tried]:
        """Schedules with the last factor between two others, in ever finer steps until each of them arrives.

        Those that would cost more than one that has arrived already are left out.
        """
        made: list[Tried] = []
        for _ in range(REFINEMENTS):
            known = Tried.joined([*found, *made])
            arrived = known.cost[(known.worst <= self.tolerance) & (known.time <= within)]
            some = some.some(some.cost < np.min(arrived, initial=math.inf))
            if not len(some.cost):
                break
            shape = len(some.cost), CUTS + 1
            fine = np.repeat(some.bursts, CUTS + 1, axis=0)
            fine[:, -1, 1] = np.linspace(some.low, some.high, CUTS + 1, axis=1).ravel()
            last = self.run(fine)
            made.append(last)
            low, high = _narrower(fine[:, -1, 1].reshape(shape), last.middle.reshape(shape))
            done = np.any((last.worst <= self.tolerance).reshape(shape), axis=1)
            some = dataclasses.replace(some, low=low, high=high).some(~done)
        return made

    def settled_drift(self, factors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(drift per drive period of the settled motion with each factor [factors], whether it settled)."""
        found = ensemble(
            self.trials.system,
            {"drive.factor_1": factors},
            measures=["mean_velocity"],
            initial=self.start,
            periods=SETTLING,
            settle=SETTLE,
            tolerance=RUN,
            threads=self.threads,
        )
        trust = Trust.of_runs(found, residue(self.system, "mean_velocity", SETTLE))
        velocity = np.where(trust.direction(found["mean_velocity"]) != 0.0, trust.known(found["mean_velocity"]), 0.0)
        return np.nan_to_num(velocity * self.system.drive.period), trust.ok

    @property
    def travelling(self) -> np.ndarray:
        """Numbers of the factors whose settled motions travel to the target."""
        way = self.target - self.here
        return np.flatnonzero(np.sign(way) * self.drift * LONGEST > abs(way))

    def _check_rest(self) -> None:
        """CaseError for a machine that keeps moving without its drive."""
        long, longer = (self.trials.ends(np.array([[(float(n), 0.0)]])) for n in (STILL, 2 * STILL))
        moved = float(np.max(np.nan_to_num(np.abs(longer.position - long.position), nan=math.inf)))
        if not moved <= REST * self.tolerance:
            by = "its run fails" if math.isinf(moved) else f"it still moves by {said_place(self.system, moved)}"
            what = f"should rest while its drive pauses, to be held at the target: without its drive {by}"
            what += f" from {STILL} to {2 * STILL} drive periods"
            raise CaseError([Complaint("system", what)], "the question")

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

    def _long_bursts(self) -> np.ndarray:
        """Bursts [n, 2] of the fastest settled motions towards the target, about as long as they have to be."""
        distance = self.target - self.here
        travelling = self.travelling
        fast = travelling[np.argsort(-np.abs(self.drift[travelling]), kind="stable")[:FASTEST]]
        if not len(fast):
            return np.zeros((0, 2))
        factor, drift = self.family.factors[fast], self.drift[fast]
        lengths = np.maximum(1.0, np.round(distance / drift))
        begun = self.ends(np.stack([lengths, factor], axis=-1)[:, None]).position[:, 0]
        lengths = np.round(lengths + np.nan_to_num(self.target - begun) / drift)[:, None] + WINDOW
        rows = np.stack([lengths, np.broadcast_to(factor[:, None], lengths.shape)], axis=-1).reshape(-1, 2)
        return rows[rows[:, 0] > SHORT]

    def _candidates(self, within: float) -> tuple[np.ndarray, np.ndarray, Brackets, Brackets]:
        """(bursts [n, 2, 2] that arrive, that come near, those that do between two factors, those that lie about it).

        By the sums of what each burst does, in every sample.
        """
        short, second = self.family.bursts(SHORT), self.family.bursts(FINE)
        firsts = np.concatenate([short.reshape(-1, 2), self._long_bursts()])
        after = self.ends(firsts[:, None])
        then = self.ends(second.reshape(-1, 1, 2), at_rest=True)
        away, count = after.position - self.target, self.trials.count
        further = then.position.reshape(*second.shape[:2], count)
        work = then.work[:, 0].reshape(second.shape[:2])
        pick = _Pick(self, within)
        none = np.zeros((1, 2))
        for first, errors, spent in zip(firsts, away, after.work[:, 0], strict=True):
            pick.alone(first, errors, float(spent))
            pick.row(first, second, errors + further, spent + work, np.array(errors))
        begun = away[: short.shape[0] * short.shape[1]].reshape(*short.shape[:2], count)
        own = after.work[: short.shape[0] * short.shape[1], 0].reshape(short.shape[:2])
        pick.row(none[0], short, begun, own, np.full(count, self.here - self.target))
        return pick.found()


class _Pick:
    """The best candidates so far: those that arrive, those that come near, those that do between two factors."""

    def __init__(self, search: Search, within: float):
        self.search, self.within = search, within
        self.arriving: list[tuple[float, Any]] = []
        self.near: list[tuple[float, Any]] = []
        self.between: list[tuple[float, Any]] = []
        self.wide: list[tuple[float, Any]] = []  # of which the samples lie too far apart, by their half range

    def alone(self, first: np.ndarray, errors: np.ndarray, work: float) -> None:
        """A burst with nothing after it."""
        rows = np.stack([np.zeros(2), first])
        middle, half = spread(errors)
        self._take(rows[None], np.abs(middle)[None] + half, np.array([work]))

    def row(
        self, first: np.ndarray, second: np.ndarray, errors: np.ndarray, work: np.ndarray, without: np.ndarray
    ) -> None:
        """A burst with all second ones [lengths, factors, 2]; errors: [lengths, factors, samples]; without: any."""
        search = self.search
        middle, half = spread(errors)
        bursts = np.stack([np.broadcast_to(first, second.shape), second], axis=-2)
        self._take(bursts.reshape(-1, 2, 2), (np.abs(middle) + half).ravel(), work.ravel())
        at_zero = len(search.family.factors) // 2
        factors = np.insert(search.family.factors, at_zero, 0.0)
        own, width = spread(without)
        middle, half = np.insert(middle, at_zero, own, axis=1), np.insert(half, at_zero, width, axis=1)
        work = np.insert(work, at_zero, 0.0, axis=1)
        width = np.minimum(half[:, :-1], half[:, 1:])
        crosses = np.argwhere(middle[:, :-1] * middle[:, 1:] < 0.0)
        narrow = [bool(width[i, j] <= SURE * search.tolerance) for i, j in crosses]
        for (i, j), sure in zip(crosses, narrow, strict=True):
            rows = np.array([first, (second[i, 0, 0], factors[j])])
            time = float(periods_of(rows, search.pause)) * search.system.drive.period
            if time <= self.within and sure:
                cost = time if search.least == "time" else float(0.5 * (work[i, j] + work[i, j + 1]))
                self.between.append((cost, (rows, factors[j], factors[j + 1])))
            elif time <= self.within and math.isfinite(width[i, j]):
                self.wide.append((float(width[i, j]), (rows, factors[j], factors[j + 1])))

    def _take(self, bursts: np.ndarray, worst: np.ndarray, work: np.ndarray) -> None:
        search = self.search
        time = periods_of(bursts, search.pause) * search.system.drive.period
        cost = time if search.least == "time" else work
        worst = np.where(time <= self.within, np.nan_to_num(worst, nan=math.inf), math.inf)
        fits = np.flatnonzero(worst <= SURE * search.tolerance)
        for k in fits[np.argsort(cost[fits], kind="stable")[:KEPT]]:
            self.arriving.append((float(cost[k]), bursts[k]))
        for k in np.argsort(worst, kind="stable")[:EACH]:
            if math.isfinite(worst[k]):
                self.near.append((float(worst[k]), bursts[k]))

    def found(self) -> tuple[np.ndarray, np.ndarray, Brackets, Brackets]:
        """What `Search._candidates` returns."""
        arriving, near = (
            np.array([bursts for _, bursts in sorted(some, key=lambda one: one[0])[:most]]).reshape(-1, 2, 2)
            for some, most in ((self.arriving, KEPT), (self.near, CLOSE))
        )
        return arriving, near, _brackets(self.between, 2 * KEPT), _brackets(self.wide, BATCH)


def _brackets(some: list[tuple[float, Any]], most: int) -> Brackets:
    """The first of these, in order."""
    first = sorted(some, key=lambda one: one[0])[:most]
    rows = np.array([each[0] for _, each in first]).reshape(-1, 2, 2)
    low, high = (np.array([each[i] for _, each in first]) for i in (1, 2))
    return Brackets(rows, low, high, np.array([cost for cost, _ in first]))


def _narrower(factors: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(low, high) of the step [n] in which the middle error changes its sign, of factors and errors [n, points].

    Where it does so in none, as a sum is not the whole, the two steps about the least error.
    """
    size = np.nan_to_num(np.abs(middle), nan=math.inf)
    rows, last = np.arange(len(factors)), factors.shape[1] - 1
    crosses = middle[:, :-1] * middle[:, 1:] < 0.0
    step = np.argmax(crosses, axis=1)
    least = np.argmin(size, axis=1)
    any_ = np.any(crosses, axis=1)
    low = np.where(any_, step, np.maximum(least - 1, 0))
    high = np.where(any_, step + 1, np.minimum(least + 1, last))
    return factors[rows, low], factors[rows, high]


def said_place(system: System, value: float) -> str:
    """A place in words, with the unit that results have."""
    if system.units is None:
        return f"{value:.6g}"
    return f"{value * system.si.factor(str(system.cyclic)):.6g} {system.si.unit(str(system.cyclic))}"


def said_time(system: System, value: float) -> str:
    """A time in words, with the unit that results have."""
    return f"{value:.6g}" if system.units is None else f"{value * system.si.factor_of('s'):.6g} s"
