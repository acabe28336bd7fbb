"""What a posterior samples of a case that was fitted to motions: its unknowns and the starts of its records."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.record_model import RecordModel
from vibrocap.identification.inference.sampling import Source, normal_draws
from vibrocap.identification.inference.uncertainty import Uncertainty
from vibrocap.identification.problem.differing import own_name
from vibrocap.identification.problem.priors import prior_errors
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
        else:
            model, k = self.unseen[name].model, 0
            points, begun = self._unseen_points(self.unseen[name], table), self.unseen[name].begun
        course = model.courses[k]
        motions = np.array([model.predicted(k, point, len(course.instants))[begun:] for point in points])
        time = course.instants[begun:] * model.system.result_units.factor("time")
        return time, motions, self.deviation * course.size

    def _unseen_points(self, unseen: Unseen, table: np.ndarray) -> np.ndarray:
        """Points of an unseen record: its start follows the unknowns, about where its first tenth put it."""
        many = self.model.shared
        shares = table[:, :many]
        random = np.random.default_rng(len(table)).standard_normal((len(table), len(unseen.covariance)))
        own = normal_draws(unseen.covariance, random)
        starts = unseen.point[many:] + (shares - unseen.point[:many]) @ unseen.follows.T + own
        return np.hstack([shares, starts])
