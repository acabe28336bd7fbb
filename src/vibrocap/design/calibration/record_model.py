"""Measured records as least squares: the motions that a case makes under their forces, and how they join; and what a
posterior samples of them.
"""

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.course import Course, Sensor, Unknowns
from vibrocap.design.calibration.table_model import beside
from vibrocap.identification.experiments.parameter_samples import Source, normal_draws
from vibrocap.identification.inference.uncertainty import Uncertainty, uncertainty
from vibrocap.identification.problem.coordinates import own_name
from vibrocap.identification.problem.prediction import steady_force
from vibrocap.identification.problem.priors import Prior, prior_errors, prior_slopes
from vibrocap.identification.search import Loss, finite
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.friction.law import Law
from vibrocap.studies.plan.variation import refusal

STEP = 1e-6  # of the differences that give slopes: in shares of the ranges, and of a start's size
KEPT = 1024  # tables of forces, which runs with other parameters share
WIDEST = 10.0  # sizes by which a start may be off its guess


class RecordModel:
    """Predictions of records at points: unknowns as shares of their ranges, then the free starts of the courses.

    Unknowns are first the shared ones, then those of each record. Starts count in sizes from their guesses. A course
    that follows another of the same record begins where that ends: the gaps between them, in sizes, are errors too,
    `weight` times (multiple shooting; Bock 1981). count: samples of each course from its first on.
    """

    def __init__(self, predict: str, unknowns: Unknowns, courses: Sequence[Course], tolerance: float, threads: int):
        self.predict, self.unknowns, self.courses, self.tolerance = predict, unknowns, courses, tolerance
        self.driven = functools.lru_cache(KEPT)(lambda k, sensor: courses[k].driven(sensor))
        self.system = self.driven(0, Sensor())
        self.threads = threads
        self.records = tuple(dict.fromkeys(course.name for course in courses))
        own = {name: unknowns.own(name) for name in self.records}
        self.ranges = [*unknowns.shared, *itertools.chain.from_iterable(own.values())]
        self.names = tuple(unknown.path for unknown in self.ranges)
        self.shared, self.many = len(unknowns.shared), len(self.ranges)
        cuts = self.shared + np.cumsum([0, *map(len, own.values())])
        of_record = {name: np.arange(*ends) for name, ends in zip(own, itertools.pairwise(cuts), strict=True)}
        ends = self.many + np.cumsum([0, *(len(course.free) for course in courses)])
        self.starts = [np.arange(begin, end) for begin, end in itertools.pairwise(ends)]
        self.places = [
            np.concatenate((of_record[course.name], start)) for course, start in zip(courses, self.starts, strict=True)
        ]
        self.coordinates = int(ends[-1])
        self.priors: tuple[Prior, ...] = ()
        self.weight = 1.0

    @property
    def divided(self) -> bool:
        """Whether a record has several courses."""
        return len(self.courses) > len(self.records)

    def followed(self, k: int) -> bool:
        """Whether another course continues a course."""
        return k + 1 < len(self.courses) and self.courses[k + 1].follows

    def pieces(self, name: str) -> list[int]:
        """The courses of a record."""
        return [k for k, course in enumerate(self.courses) if course.name == name]

    def values(self, point: np.ndarray) -> np.ndarray:
        """The unknowns at a point."""
        columns = point[: self.many, None]
        return np.array([unknown.at(column)[0] for unknown, column in zip(self.ranges, columns, strict=True)])

    def parameters(self, k: int, point: np.ndarray) -> tuple[dict[str, Any], Sensor]:
        """(parameters of the case by path, the sensor) in a course."""
        values = dict(zip(self.names, map(float, self.values(point)), strict=True))
        return self.unknowns.in_record(values, self.courses[k])

    def to_values(self, point: np.ndarray) -> np.ndarray:
        """Derivatives [coordinates, coordinates] of the unknowns by their shares; a start stays what it is."""
        own = [unknown.slope(float(x)) for unknown, x in zip(self.ranges, point, strict=False)]
        return np.diag([*own, *(1.0 for _ in range(self.coordinates - self.many))])

    def squares(self, point: np.ndarray, counts: Sequence[int]) -> float:
        """What a search minimises."""
        return float(np.sum(self.residuals(point, counts) ** 2))

    @property
    def noise(self) -> float:
        """Norm of the errors that the noise of the samples alone makes, as their second differences tell."""
        squares = [np.sum(np.diff(course.measured, 2) ** 2) / 6.0 / course.size**2 for course in self.courses]
        return math.sqrt(sum(squares))

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest coordinates."""
        own = np.arange(self.coordinates) < self.many
        return np.where(own, 0.0, -WIDEST), np.where(own, 1.0, WIDEST)

    def counts(self, share: float) -> tuple[int, ...]:
        """Samples of each course in a share of its time."""
        return tuple(max(2, round(share * len(course.measured))) for course in self.courses)

    def refuses(self, point: np.ndarray, courses: Iterable[int] | None = None) -> bool:
        """Whether a part refuses the unknowns of courses at a point; by default of all records."""
        asked = (self.pieces(name)[0] for name in self.records) if courses is None else courses
        return any(refusal(self.system, self.parameters(k, point)[0]) for k in asked)

    def start(self, k: int, point: np.ndarray) -> dict[str, float]:
        """The initial states of a course."""
        course = self.courses[k]
        moved = zip(course.free, course.steps * point[self.starts[k]], strict=True)
        return {**course.start, **{name: course.start[name] + by for name, by in moved}}

    def motion(self, k: int, point: np.ndarray, count: int) -> Trajectory | None:
        """The motion of a course up to a sample, or to where the next begins; None where a part refuses a point."""
        course = self.courses[k]
        end = course.joint if self.followed(k) else float(course.instants[count - 1])
        try:
            parameters, sensor = self.parameters(k, point)
            driven = self.driven(k, sensor)
            system = driven.with_parameters(parameters)
            periods = end / driven.drive.period
            return simulate(system, periods=periods, initial=self.start(k, point), tolerance=self.tolerance)
        except ValueError:
            return None

    def distrust(self, name: str, point: np.ndarray) -> str:
        """Why the motion of a whole record is not to be trusted, "" where it is."""
        for k in self.pieces(name):
            motion = self.motion(k, point, len(self.courses[k].measured))
            if motion is None:
                return "no motion: a part refuses its parameters"
            if not motion.certificate.ok:
                return motion.status.value
        return ""

    def predicted(self, k: int, point: np.ndarray, count: int) -> np.ndarray:
        """[count] what the case does in a course, in the unit of its results; NaN from where its run ends early."""
        return self._along(k, self.motion(k, point, count), count)

    def _along(self, k: int, motion: Trajectory | None, count: int) -> np.ndarray:
        predicted = np.full(count, np.nan)
        if motion is not None and len(motion.piece_start):
            instants = self.courses[k].instants[:count]
            reached = np.full(count, True) if motion.run_status.ok else instants <= motion.end
            known = motion.at(np.minimum(instants[reached], motion.end), self.predict)
            predicted[reached] = known * motion.system.result_units.factor(self.predict)
        return predicted

    def residuals(self, point: np.ndarray, counts: Sequence[int]) -> np.ndarray:
        """Predicted less measured, in their size, all courses in a row; then the gaps between them, and the priors."""
        runs = self.at([(k, point, count) for k, count in enumerate(counts)])
        errors, gaps = zip(*(np.split(run, [count]) for run, count in zip(runs, counts, strict=True)), strict=True)
        known = prior_errors(self.priors, self.names, self.values(point))
        return np.concatenate([*errors, *(self.weight * gap for gap in gaps), known])

    def at(self, asked: Iterable[tuple[int, np.ndarray, int]]) -> list[np.ndarray]:
        """Errors of several (course, point, count), each with the gaps [states] behind it where a course follows."""
        with ThreadPoolExecutor(self.threads) as pool:
            return list(pool.map(self._errors, asked))

    def _errors(self, asked: tuple[int, np.ndarray, int]) -> np.ndarray:
        k, point, count = asked
        course, motion = self.courses[k], self.motion(k, point, count)
        errors = finite((self._along(k, motion, count) - course.measured[:count]) / course.size)
        return np.concatenate([errors, self._gaps(k, motion, point)]) if self.followed(k) else errors

    def _gaps(self, k: int, motion: Trajectory | None, point: np.ndarray) -> np.ndarray:
        """Where a course ends less where the next begins, in the sizes of its states."""
        after, start = self.courses[k + 1], self.start(k + 1, point)
        if motion is None or not motion.run_status.ok:
            return np.full(len(after.free), WIDEST)
        ends = (float(motion.at(np.array([motion.end]), name)[0]) for name in after.free)
        return finite(np.array([end - start[name] for name, end in zip(after.free, ends, strict=True)]) / after.steps)

    def slopes(self, point: np.ndarray, counts: Sequence[int], moving: Any = None) -> np.ndarray:
        """[residuals, coordinates] by differences within bounds and parts; what is of one course moves it only.

        moving: coordinates whose columns are asked for; the others are zero.
        """
        bounds = self.bounds
        asked, moves = [], []
        for k, count in enumerate(counts):
            for i in (*range(self.shared), *self.places[k]):
                if moving is not None and i not in moving:
                    continue
                below, above = beside(point, i, STEP, bounds, lambda moved, k=k: self.refuses(moved, [k]))
                if below[i] < above[i]:
                    asked += [(k, above, count), (k, below, count)]
                    moves.append((k, i, above[i] - below[i]))
        runs = self.at(asked)
        begun, gap_rows = np.cumsum([0, *counts]), self.gap_rows(counts)
        jacobian = np.zeros((gap_rows[-1].stop + len(self.priors), self.coordinates))
        for (k, i, width), above, below in zip(moves, runs[::2], runs[1::2], strict=True):
            errors, gaps = np.split((above - below) / width, [counts[k]])
            jacobian[begun[k] : begun[k + 1], i] = errors
            jacobian[gap_rows[k], i] = self.weight * gaps
        for k in range(1, len(self.courses)):
            if self.courses[k].follows:
                jacobian[gap_rows[k - 1], self.starts[k]] = -self.weight * np.eye(len(self.starts[k]))
        jacobian[gap_rows[-1].stop :] = prior_slopes(self.priors, self.names, self.to_values(point))
        return jacobian

    def gap_rows(self, counts: Sequence[int]) -> list[slice]:
        """Rows of the gaps behind each course."""
        sizes = [len(self.courses[k + 1].free) if self.followed(k) else 0 for k in range(len(self.courses))]
        ends = sum(counts) + np.cumsum([0, *sizes])
        return [slice(int(begin), int(end)) for begin, end in itertools.pairwise(ends)]

    def growth(self, slopes: np.ndarray, counts: Sequence[int]) -> float:
        """Largest factor by which a change of the predicted quantity grows from the start of a record.

        Through the gaps it goes on from course to course.
        """
        largest, change = 0.0, np.zeros(0)
        begun, gap_rows = np.cumsum([0, *counts]), self.gap_rows(counts)
        unit = self.system.result_units.factor(self.predict)
        for k, course in enumerate(self.courses):
            if self.predict in course.free and not (course.follows and change.any()):
                change = (np.array(course.free) == self.predict) / (course.steps * unit)
            elif not course.follows:
                change = np.zeros(len(course.free))
            own = slopes[:, self.starts[k]] @ change
            largest = max(largest, course.size * float(np.max(np.abs(own[begun[k] : begun[k + 1]]))))
            change = own[gap_rows[k]] / self.weight
        return largest

    def carried(self, point: np.ndarray) -> np.ndarray:
        """The point at which states that nothing measured begin each course as the one before ends."""
        carried = point.copy()
        for k, course in enumerate(self.courses):
            if course.follows and course.guessed:
                before = self.motion(k - 1, carried, len(self.courses[k - 1].measured))
                gaps = dict(zip(course.free, self._gaps(k - 1, before, carried), strict=True))
                for name in course.guessed:
                    place = self.starts[k][course.free.index(name)]
                    carried[place] = np.clip(carried[place] + gaps[name], -WIDEST, WIDEST)
        return carried

    def refined(self, point: np.ndarray, counts: Sequence[int], most: int, moving: Any = slice(None)) -> Any:
        """The minimum near a point, as SciPy tells it, from so many evaluations at most; moving: coordinates sought."""
        from scipy.optimize import least_squares

        low, high = self.bounds
        begun = np.clip(point, low + 1e-9, high - 1e-9)

        def whole(x: np.ndarray) -> np.ndarray:
            whole_point = begun.copy()
            whole_point[moving] = x
            return whole_point

        def slopes(x: np.ndarray) -> np.ndarray:
            return self.slopes(whole(x), counts)[:, moving]

        how: dict[str, Any] = {"jac": slopes, "bounds": (low[moving], high[moving]), "xtol": 1e-10, "ftol": 1e-10}
        end = least_squares(lambda x: self.residuals(whole(x), counts), begun[moving], max_nfev=most, **how)
        end.x = whole(end.x)
        return end

    def spread(self, errors: np.ndarray, slopes: np.ndarray) -> Uncertainty:
        """What the residuals of a minimum of whole records leave uncertain of the coordinates.

        Where courses join, only changes that leave no gaps count.
        """
        from scipy.linalg import null_space

        counts = self.counts(1.0)
        parts = np.split(errors[: sum(counts)], np.cumsum(counts)[:-1])
        by_record = [np.concatenate([parts[k] for k in self.pieces(name)]) for name in self.records]
        own, gaps, known = np.split(slopes, [sum(counts), self.gap_rows(counts)[-1].stop])
        allowed = null_space(gaps) if len(gaps) else np.eye(self.coordinates)
        return uncertainty(by_record, own @ allowed, known @ allowed, allowed, Loss())


@dataclasses.dataclass(frozen=True, eq=False)
class Unseen:
    """A held-out record: its model and point, how its start follows the unknowns [starts, unknowns], and its own
    covariance [starts, starts]; begun: samples that found the start."""

    model: RecordModel
    point: np.ndarray
    follows: np.ndarray
    covariance: np.ndarray
    begun: int


class MotionSource(Source):
    """Coordinates are shares of the unknowns' ranges, then the free starts."""

    def __init__(self, model: RecordModel, point: np.ndarray, spread: Uncertainty, deviation: float):
        starts = [f"{own_name('start', course.name)}.{state}" for course in model.courses for state in course.free]
        names = (*model.names, *starts)
        super().__init__(names, point, spread.covariance, model.bounds, spread.unit, spread.inflation)
        self.model, self.deviation, self.unseen = model, deviation, dict[str, Unseen]()

    def cost(self, table: np.ndarray) -> np.ndarray:
        points, counts = np.clip(table, *self.bounds), self.model.counts(1.0)
        runs = [(k, point, count) for point in points for k, count in enumerate(counts)]
        errors = np.concatenate(self.model.at(runs)).reshape(len(points), sum(counts))
        values = np.array([self.model.values(point) for point in points])
        known = prior_errors(self.model.priors, self.model.names, values)
        return 0.5 * (np.sum(errors**2, axis=1) + np.sum(known**2, axis=1))

    def values(self, table: np.ndarray) -> np.ndarray:
        courses = list(enumerate(self.model.courses))
        starts = [[self.model.start(k, row)[state] for k, course in courses for state in course.free] for row in table]
        return np.array([[*self.model.values(row), *start] for row, start in zip(table, starts, strict=True)])

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str = "friction") -> np.ndarray:
        model, system = self.model, self.model.system
        units: Any = None if system.units is None else system.si
        turning = units is not None and units.of_part(section).effort == "torque"
        names = ("N m", "rad/s") if turning else ("N", "m/s")
        force, speed = (1.0, 1.0) if units is None else map(units.of_part(section).factor_of, names)
        forces = []
        for row in table:
            values, _ = model.parameters(0, row)
            law: Any = model.system.with_parameters(values).parts[section]
            assert isinstance(law, Law)
            forces.append(force * steady_force(law, velocity / speed, load / force))
        return np.array(forces)

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        names = [course.name for course in self.model.courses]
        if name not in (*names, *self.unseen):
            raise ArgumentError("record", f"there is none called {name!r}; {suggestion(name, (*names, *self.unseen))}")
        if name in names:
            model, k, points, begun = self.model, names.index(name), table, 0
        else:  # its start follows the unknowns, about where its first tenth put it
            unseen, many, k = self.unseen[name], self.model.shared, 0
            model, shares, begun = unseen.model, table[:, :many], unseen.begun
            random = np.random.default_rng(len(table)).standard_normal((len(table), len(unseen.covariance)))
            own = normal_draws(unseen.covariance, random)
            starts = unseen.point[many:] + (shares - unseen.point[:many]) @ unseen.follows.T + own
            points = np.hstack([shares, starts])
        course = model.courses[k]
        motions = np.array([model.predicted(k, point, len(course.instants))[begun:] for point in points])
        time = course.instants[begun:] * model.system.result_units.factor("time")
        return time, motions, self.deviation * course.size
