"""What a posterior samples of a case that was fitted to motions: its unknowns and the starts of its records."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.record_model import RecordModel
from vibrocap.identification.inference.uncertainty import Uncertainty
from vibrocap.identification.problem.differing import own_name
from vibrocap.identification.problem.steady_prediction import steady_force
from vibrocap.physics.friction.law import Law


@dataclasses.dataclass(frozen=True, eq=False)
class Unseen:
    """A held-out record: its model and point, how its start follows the unknowns [starts, unknowns], and its own
    covariance [starts, starts]; begun: samples that found the start."""

    model: RecordModel
    point: np.ndarray
    follows: np.ndarray
    covariance: np.ndarray
    begun: int


class MotionSource:
    """See `posterior.Source`: coordinates are shares of the unknowns' ranges, then the free starts."""

    def __init__(self, model: RecordModel, point: np.ndarray, spread: Uncertainty, deviation: float):
        self.model, self.begin, self.spread, self.bounds = model, point, spread.covariance, model.bounds
        self.deviation, self.unseen = deviation, dict[str, Unseen]()
        starts = [own_name("start", course.name) + f".{state}" for course in model.courses for state in course.free]
        self.names = (*model.space.paths, *starts)
        self.unit, self.time = spread.unit, float(np.exp(np.mean(np.log(spread.inflation))))
        self.near = np.sqrt(self.time / spread.inflation)

    def density(self, table: np.ndarray) -> np.ndarray:
        """Logarithm [m] at coordinates [m, p]."""
        points = np.clip(self.begin + (table - self.begin) * self.near, *self.bounds)
        counts = self.model.counts(1.0)
        asked = [(k, point, count) for point in points for k, count in enumerate(counts)]
        squares = np.sum(self.model.at(asked).reshape(len(points), sum(counts)) ** 2, axis=1)
        known = np.array([np.sum(self.model.known(point) ** 2) for point in points])
        return -0.5 * (squares + known) / (self.unit * self.time)

    def values(self, table: np.ndarray) -> np.ndarray:
        """Unknowns and starts [m, p]."""
        return np.array([[*self.model.values(row), *self._starts(row)] for row in table])

    def _starts(self, point: np.ndarray) -> list[float]:
        starts = [(self.model.start(k, point), course) for k, course in enumerate(self.model.courses)]
        return [start[state] for start, each in starts for state in each.free]

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str = "friction") -> np.ndarray:
        """Steady friction [m, k] at velocities [k], of the law in a section of the case."""
        model, system = self.model, self.model.system
        units: Any = None if system.units is None else system.si
        turning = units is not None and units.of_part(section).effort == "torque"
        names = ("N m", "rad/s") if turning else ("N", "m/s")
        force, speed = (1.0, 1.0) if units is None else map(units.of_part(section).factor_of, names)
        forces = []
        for row in table:
            values = model.space.parameters(row[: len(model.space.paths)])
            law: Any = model.system.with_parameters(values).parts[section]
            assert isinstance(law, Law)
            forces.append(force * steady_force(law, velocity / speed, load / force))
        return np.array(forces)

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """(time [n], predictions [m, n], standard deviation of a measurement about them) of a record."""
        names = [course.name for course in self.model.courses]
        if name not in (*names, *self.unseen):
            raise ArgumentError("record", f"there is none called {name!r}; {suggestion(name, (*names, *self.unseen))}")
        if name in names:
            model, k, points, begun = self.model, names.index(name), table, 0
        else:
            model, k = self.unseen[name].model, 0
            points, begun = self._unseen_points(self.unseen[name], table), self.unseen[name].begun
        each = model.courses[k]
        made = np.array([model.predicted(k, point, len(each.instants))[begun:] for point in points])
        time = each.instants[begun:] * model.system.result_units.factor("time")
        return time, made, self.deviation * each.size

    def _unseen_points(self, unseen: Unseen, table: np.ndarray) -> np.ndarray:
        """Points of an unseen record: its start follows the unknowns, about where its first tenth put it."""
        many = len(self.model.space.paths)
        shares = table[:, :many]
        values, vectors = np.linalg.eigh(unseen.covariance)
        random = np.random.default_rng(len(table)).standard_normal((len(table), len(values)))
        own = random @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
        starts = unseen.point[many:] + (shares - unseen.point[:many]) @ unseen.follows.T + own
        return np.hstack([shares, starts])
