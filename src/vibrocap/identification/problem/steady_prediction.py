"""The steady curve of a law: its force at constant velocities, sample by sample, without the memory of the contact."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.identification.problem.parameter_roles import with_role
from vibrocap.identification.problem.prediction import Prediction, unchecked
from vibrocap.identification.problem.terms import forces_of_terms
from vibrocap.physics.friction.law import Law


def _of_column(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda column: function(column)


class Column(np.ndarray):
    """Numbers on which the formulas of a law compute all at once."""

    exp, log, sqrt = map(_of_column, (np.exp, np.log, np.sqrt))
    sin, cos, tanh, atan = map(_of_column, (np.sin, np.cos, np.tanh, np.arctan))


def steady_force(law: Law, velocity: Any, load: Any = 1.0, values: Mapping[str, Any] | None = None) -> np.ndarray:
    """Force of a law at constant velocities [...], odd unless the law is anisotropic; 0 at rest.

    values: parameters that replace the law's, numbers or arrays that broadcast with the velocity.
    """
    velocity = np.asarray(velocity, float)
    side = np.sign(velocity)
    speed = np.where(side == 0, 1.0, np.abs(velocity)).view(Column)
    columns = {name: np.asarray(value, float).view(Column) for name, value in (values or {}).items()}
    changed = unchecked(law, columns)
    with np.errstate(all="ignore"):
        if law.kind == "smooth":
            force, _ = changed.force(velocity.view(Column), (), 1.0, load)
            return np.asarray(force) + 0.0 * velocity
        if with_role(law, "back ratio"):
            force = changed.steady_force(speed, load, side)  # type: ignore[call-arg]
        else:
            force = changed.steady_force(speed, load)
    return np.asarray(side * force) + 0.0 * velocity


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyPrediction(Prediction):
    """The steady curve of a law, at the velocity of each sample."""

    def forces(self, table: np.ndarray, which: int) -> np.ndarray:
        """Force [m, n] of record number `which` at coordinates [m, p]."""
        record, names = self.records[which], self.space.names
        values = self.space.values(np.atleast_2d(table))
        columns = {name: values[:, [names.index(name)]] for name in self.law_names}
        rows = np.broadcast_to(record.velocity, (len(values), len(record)))
        forces = steady_force(self.template, rows, record.load, columns)
        return forces + forces_of_terms(names, values, record, np.asarray, forces)
