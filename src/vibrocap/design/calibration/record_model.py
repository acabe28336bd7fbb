"""Measured records as least squares: the motions that a case makes under their forces, and the search for the best."""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from vibrocap.design.calibration.table_model import soft
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.design.search.variables import DesignSpace
from vibrocap.identification.inference.uncertainty import Uncertainty, uncertainty
from vibrocap.identification.problem import priors as known_before
from vibrocap.identification.problem.priors import Prior, prior_errors, prior_slopes
from vibrocap.identification.search.loss import Loss, finite
from vibrocap.motion.simulate import initial_state, simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.dimensions.units import state_keys, state_units
from vibrocap.physics.drives.table import DriveTable
from vibrocap.physics.system import System
from vibrocap.records.record import Record

STEP = 1e-6  # of the differences that give slopes: in shares of the ranges, and of a start's size
WIDEST = 10.0  # sizes by which a start may be off its guess
HORIZONS = ((0.125, 6, 15), (0.25, 4, 15), (0.5, 3, 15), (1.0, 2, 60))  # share of the records, candidates, evaluations
ROUNDS = 4  # of the search at most, each from points of its own, until two agree
SCANNED = 33  # points over the range of a parameter
PASSES = 8  # scans from minimum to minimum, at most
AGREE = 1e-3  # relative difference of the costs of rounds that end in the same minimum
FEWEST = 64  # samples of the shortest record within a horizon
COLUMN_OF = {"m": "displacement", "rad": "displacement", "m/s": "velocity", "rad/s": "velocity"}


@dataclasses.dataclass(frozen=True)
class Course:
    """A record as a case lives through it.

    system: the case, driven by the measured force; instants [n] of its time, measured [n] in the unit of its results
    size: of the errors, that of what was measured in all records
    start: initial states; free: names of those that are sought; steps [free]: their sizes
    """

    name: str
    system: System
    instants: np.ndarray
    measured: np.ndarray
    size: float
    start: Mapping[str, float]
    free: tuple[str, ...]
    steps: np.ndarray


def measured_column(system: System, predict: str) -> str | None:
    """The column of a record that holds a state of a motion; None where records have no such column."""
    return COLUMN_OF.get(_unit(system, predict))


def turns(system: System, predict: str) -> bool:
    """Whether a state is an angle or its rate, which only the record of a contact that turns holds."""
    return _unit(system, predict).startswith("rad")


def _unit(system: System, name: str) -> str:
    """The SI unit of a state, of a system without units too."""
    return state_units(system.parts)[name]


def courses(system: System, records: Sequence[Record], predict: str, known: Mapping[str, float]) -> list[Course]:
    """Records as a case lives through them. Errors of all count alike: they have been measured by one sensor."""
    column = str(measured_column(system, predict))
    size = float(np.sqrt(np.mean([np.var(getattr(record, column)) for record in records])))
    return [_course(system, record, predict, getattr(record, column), size, known) for record in records]


def _course(
    system: System, record: Record, predict: str, measured: np.ndarray, size: float, known: Mapping[str, float]
) -> Course:
    """A record as a case lives through it, from its first sample on.

    The measured force is a table of straight lines from sample to sample, behind whose end the record is over. The
    start of what is predicted is guessed by its first sample, and its rate by the first differences.
    """
    units = system.result_units
    times = (record.time - record.time[0]) / units.factor("time")
    values = record.force / units.factor("drive")
    table = DriveTable(times=(*times, 2.0 * times[-1] - times[-2]), values=(*values, values[0]), interpolation="linear")
    driven = dataclasses.replace(system, drive=table)
    scaled = measured / units.factor(predict)
    rates = np.gradient(scaled, times)
    start = initial_state(driven, known)
    keys = state_keys(units.states)
    known_names = {keys[name].name if name in keys else name for name in known}
    free = tuple(name for name in system.machine.states if name not in known_names and name not in system.switched)
    steps = []
    for name in free:
        first, step = 0.0, 1.0
        if name == predict:
            first, step = float(scaled[0]), float(np.std(scaled))
        elif _unit(system, name) == f"{_unit(system, predict)}/s":
            first, step = float(rates[0]), float(np.std(rates))
        start[name] = first
        steps.append(step)
    return Course(record.name, driven, times, measured, size, start, free, np.array(steps))


class RecordModel:
    """Predictions of records at points: shares of the unknowns' ranges, then the free starts of each course in turn.

    Starts count in sizes from their guesses. count: samples of each course from its first on.
    """

    def __init__(self, predict: str, space: DesignSpace, courses: Sequence[Course], tolerance: float, threads: int):
        self.predict, self.space, self.courses, self.tolerance = predict, space, courses, tolerance
        self.system = courses[0].system
        self.threads = threads
        ends = len(space.paths) + np.cumsum([0, *(len(course.free) for course in courses)])
        self.places = [np.arange(begin, end) for begin, end in itertools.pairwise(ends)]
        self.coordinates = int(ends[-1])
        self.priors: tuple[Prior, ...] = ()

    def values(self, point: np.ndarray) -> np.ndarray:
        """The unknowns at a point."""
        ranges: Any = self.space.variables
        return np.array([variable.at(x) for variable, x in zip(ranges, point, strict=False)], dtype=float)

    def known(self, point: np.ndarray) -> np.ndarray:
        """Errors of the priors."""
        return prior_errors(self.priors, self.space.paths, self.values(point))

    def known_slopes(self, point: np.ndarray) -> np.ndarray:
        """Their derivatives [priors, coordinates]."""
        return prior_slopes(self.priors, self.space.paths, self.to_values(point))

    def to_values(self, point: np.ndarray) -> np.ndarray:
        """Derivatives [coordinates, coordinates] of the unknowns by their shares; a start stays what it is."""
        many = len(self.space.paths)
        own = [self.space.derivative(k, float(point[k])) for k in range(many)]
        return np.diag([*own, *(1.0 for _ in range(self.coordinates - many))])

    def squares(self, point: np.ndarray, counts: Sequence[int]) -> float:
        """What a search minimises."""
        return float(np.sum(self.errors(point, counts) ** 2) + np.sum(self.known(point) ** 2))

    @property
    def noise(self) -> float:
        """Norm of the errors that the noise of the samples alone makes, as their second differences tell."""
        squares = [np.sum(np.diff(course.measured, 2) ** 2) / 6.0 / course.size**2 for course in self.courses]
        return math.sqrt(sum(squares))

    def growth(self, slopes: np.ndarray) -> float:
        """Largest factor by which a change of the predicted quantity grows from the start of a course."""
        largest = 0.0
        for course, places in zip(self.courses, self.places, strict=True):
            for name, step, place in zip(course.free, course.steps, places, strict=True):
                if name == self.predict:
                    unit = course.system.result_units.factor(self.predict)
                    largest = max(largest, float(np.max(np.abs(slopes[:, place]))) * course.size / (step * unit))
        return largest

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest coordinates."""
        own = np.arange(self.coordinates) < len(self.space.paths)
        return np.where(own, 0.0, -WIDEST), np.where(own, 1.0, WIDEST)

    def counts(self, share: float) -> tuple[int, ...]:
        """Samples of each course in a share of its time."""
        return tuple(max(2, round(share * len(course.instants))) for course in self.courses)

    def start(self, k: int, point: np.ndarray) -> dict[str, float]:
        """The initial states of a course."""
        course = self.courses[k]
        moved = zip(course.free, course.steps * point[self.places[k]], strict=True)
        return {**course.start, **{name: course.start[name] + by for name, by in moved}}

    def motion(self, k: int, point: np.ndarray, count: int) -> Trajectory | None:
        """The motion of a course up to a sample; None at a point that a part refuses."""
        course = self.courses[k]
        periods = course.instants[count - 1] / course.system.drive.period
        try:
            system = course.system.with_parameters(self.space.parameters(point[: len(self.space.paths)]))
            return simulate(system, periods=periods, initial=self.start(k, point), tolerance=self.tolerance)
        except ValueError:
            return None

    def distrust(self, k: int, point: np.ndarray) -> str:
        """Why the motion of a whole course is not to be trusted, "" where it is."""
        motion = self.motion(k, point, len(self.courses[k].instants))
        if motion is None:
            return "no motion: a part refuses its parameters"
        return "" if motion.certificate.ok else motion.status.value

    def predicted(self, k: int, point: np.ndarray, count: int) -> np.ndarray:
        """[count] what the case does in a course, in the unit of its results; NaN from where its run ends early."""
        predicted, motion = np.full(count, np.nan), self.motion(k, point, count)
        if motion is None or not len(motion.piece_start):
            return predicted
        instants = self.courses[k].instants[:count]
        reached = np.full(count, True) if motion.run_status.ok else instants <= motion.end
        known = motion.at(np.minimum(instants[reached], motion.end), self.predict)
        predicted[reached] = known * motion.system.result_units.factor(self.predict)
        return predicted

    def errors(self, point: np.ndarray, counts: Sequence[int]) -> np.ndarray:
        """Predicted less measured, in their size, all courses in a row."""
        return self.at([(k, point, count) for k, count in enumerate(counts)])

    def at(self, asked: Iterable[tuple[int, np.ndarray, int]]) -> np.ndarray:
        """Errors of several (course, point, count), in a row."""
        with ThreadPoolExecutor(self.threads) as pool:
            return np.concatenate(list(pool.map(self._errors, asked)))

    def _errors(self, asked: tuple[int, np.ndarray, int]) -> np.ndarray:
        k, point, count = asked
        course = self.courses[k]
        return finite((self.predicted(k, point, count) - course.measured[:count]) / course.size)

    def slopes(self, point: np.ndarray, counts: Sequence[int]) -> np.ndarray:
        """[errors, coordinates] by differences within the bounds; a start moves its own course only."""
        low, high = self.bounds
        ends = np.cumsum([0, *counts])
        jacobian = np.zeros((ends[-1], self.coordinates))
        asked, widths = [], []
        for k, count in enumerate(counts):
            for i in (*range(len(self.space.paths)), *self.places[k]):
                below, above = point.copy(), point.copy()
                below[i], above[i] = max(point[i] - STEP, low[i]), min(point[i] + STEP, high[i])
                asked += [(k, above, count), (k, below, count)]
                widths.append((k, i, above[i] - below[i]))
        values, place = self.at(asked), 0
        for k, i, width in widths:
            n = counts[k]
            jacobian[ends[k] : ends[k + 1], i] = (values[place : place + n] - values[place + n : place + 2 * n]) / width
            place += 2 * n
        return jacobian

    def refined(self, point: np.ndarray, counts: Sequence[int], most: int, moving: Any = slice(None)) -> Any:
        """The minimum near a point, as SciPy tells it, from so many evaluations at most; moving: coordinates sought."""
        from scipy.optimize import least_squares

        low, high = self.bounds
        begun = np.clip(point, low + 1e-9, high - 1e-9)

        def whole(x: np.ndarray) -> np.ndarray:
            whole_point = begun.copy()
            whole_point[moving] = x
            return whole_point

        def errors(x: np.ndarray) -> np.ndarray:
            return np.concatenate([self.errors(whole(x), counts), self.known(whole(x))])

        def slopes(x: np.ndarray) -> np.ndarray:
            return np.concatenate([self.slopes(whole(x), counts), self.known_slopes(whole(x))])[:, moving]

        how: dict[str, Any] = {"jac": slopes, "bounds": (low[moving], high[moving]), "xtol": 1e-10, "ftol": 1e-10}
        end = least_squares(errors, begun[moving], max_nfev=most, **how)
        end.x = whole(end.x)
        return end


def searched(model: RecordModel, starts: int, seed: int, report: Any) -> tuple[np.ndarray, bool]:
    """(best point, whether the search has settled, as two rounds end alike)."""
    counts, best, again = model.counts(1.0), (math.inf, np.zeros(0), False), False
    for k in range(ROUNDS):
        point, settled = _round(model, starts, seed + k, report and (lambda share, k=k: report((k + share) / ROUNDS)))
        cost, point = _beyond_kinks(model, point, counts)
        again = abs(cost - best[0]) <= _alike(model, cost, counts)
        best = min(best, (cost, point, settled), key=lambda minimum: minimum[0])
        if again:
            break
    return best[1], again and best[2]


def _round(model: RecordModel, starts: int, seed: int, report: Any) -> tuple[np.ndarray, bool]:
    """(best point, whether the search has settled), over longer and longer stretches of the records."""
    many = len(model.space.paths)
    points = np.zeros((starts, model.coordinates))
    points[:, :many] = sample_points(many, starts, seed)
    shortest = min(len(course.instants) for course in model.courses)
    settled = False
    for k, (share, kept, most) in enumerate(HORIZONS):
        if share * shortest < FEWEST and share < 1.0:
            continue
        counts = model.counts(share)
        costs = [float(np.sum(soft(model.errors(point, counts)))) for point in points]
        ends = [model.refined(points[i], counts, most) for i in np.argsort(costs, kind="stable")[:kept]]
        ends.sort(key=lambda end: end.cost)
        points, settled = np.array([end.x for end in ends]), ends[0].status > 0
        if report:
            report((k + 1) / len(HORIZONS))
    return points[0], settled


def _scan(model: RecordModel, point: np.ndarray, counts: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """(points [parameters, SCANNED, coordinates] along each parameter over its range, sums of squares there)."""
    many = len(model.space.paths)
    points = np.tile(point, (many, SCANNED, 1))
    for k in range(many):
        points[k, :, k] = np.linspace(0.0, 1.0, SCANNED)
    squares = [model.squares(row, counts) for row in points.reshape(-1, len(point))]
    return points, np.reshape(squares, (many, SCANNED))


def _beyond_kinks(model: RecordModel, point: np.ndarray, counts: Sequence[int]) -> tuple[float, np.ndarray]:
    """(sum of squares, point) of the least minimum that is seen along single parameters.

    Where a level of friction decides how often a contact sticks, the squares have a minimum for each number of times.
    """
    least = model.squares(point, counts)
    for _ in range(PASSES):
        points, squares = _scan(model, point, counts)
        if np.min(squares) >= least - _alike(model, least, counts):
            break
        end = model.refined(points[np.unravel_index(np.argmin(squares), squares.shape)], counts, HORIZONS[-1][-1])
        least, point = 2.0 * float(end.cost), end.x
    return least, point


def spread_of(model: RecordModel, point: np.ndarray, errors: np.ndarray, slopes: np.ndarray) -> Uncertainty:
    """What the errors of a minimum, with the priors, leave uncertain of the coordinates."""
    parts = np.split(errors, np.cumsum(model.counts(1.0))[:-1])
    return uncertainty(parts, slopes, np.eye(model.coordinates), Loss(), model.known_slopes(point))


def with_priors(model: RecordModel, point: np.ndarray, priors: Sequence[Prior]) -> np.ndarray:
    """The minimum with priors, from that without; the model is given them, with their weights."""
    counts, names, model.priors = model.counts(1.0), model.space.paths, tuple(priors)
    for k in range(known_before.WEIGHTINGS if priors else 0):
        before, to_values = model.priors, model.to_values(point)
        spread = spread_of(model, point, model.errors(point, counts), model.slopes(point, counts))
        if k == 0:
            model.priors = known_before.pulled(
                priors, names, model.values(point), to_values @ spread.covariance @ to_values.T
            )
        model.priors = known_before.weighted(model.priors, names, spread.unit, spread.inflation)
        if known_before.settled(before, model.priors):
            break
        point = model.refined(_beyond_kinks(model, point, counts)[1], counts, 60).x
    return point


def _alike(model: RecordModel, cost: float, counts: Sequence[int]) -> float:
    """By how much squares differ where they are alike: a share of them, or what runs are exact to."""
    return max(AGREE * cost, sum(counts) * model.tolerance**2)
