"""What vanishes at an equilibrium, with exact derivatives of first and second order: from the recorded equations."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate, sensitivity
from vibrocap.orbits.maps.closing_map import recorded_with
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.system import System

PASSES = 12  # over rows and columns, until both are of one size


def balanced(matrix: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(derivative [..., rows, unknowns] with rows and columns of one size, sizes of the rows, units of the unknowns).

    So rank and shortest step depend on no unit, nor on natural sizes decades from those of a state (Ruiz 2001).
    """
    even = matrix * sizes
    rows, units = np.ones(matrix.shape[:-1]), np.ones(matrix.shape[:-2] + matrix.shape[-1:]) * sizes
    for _ in range(PASSES):
        high, wide = (np.sqrt(np.max(np.abs(even), axis=axis, initial=0.0)) for axis in (-1, -2))
        high, wide = np.where(high > 0.0, high, 1.0), np.where(wide > 0.0, wide, 1.0)
        even = even / high[..., None] / wide[..., None, :]
        rows, units = rows * high, units / wide
    return even, rows, units


class SteadyEquations:
    """Rates of one form of system as functions of its states, in a mode that the sides of its contacts say.

    unknowns: numbers of the states whose rates vanish: all but the cyclic one, which travels, and those that are
    switched at events. Arrays of states are [unknowns, ...], of sides [contacts, ...]; a contact at rest has the side 0
    where its law is set-valued. `path` names a parameter by which derivatives are wanted, too.
    """

    def __init__(self, system: System, path: str | None = None):
        """Raises ArgumentError for a system that is driven in time."""
        if is_driven(system):
            said = f"should not be driven in time, but its drive is {system.drive.name}"
            raise ArgumentError("system", f"{said}: it has no equilibria; orbit(system) finds its steady motions")
        self.system = system
        recorded = system if path is None else recorded_with(system, path)
        self.recording = equations(recorded)
        self.graph, self.path = self.recording.graph, path
        # One of another form keeps the row of its own: the parameter is put in before anything is evaluated.
        self.row = np.array(parameter_values(recorded))
        self.index = -1 if path is None else self.recording.parameter_paths.index(path)
        if path is not None:
            self.row[self.index] = float(system.parameter(path))
        names, aside = system.state_names, {*system.switched, recorded.cyclic}
        self.unknowns = np.array([i for i, name in enumerate(names) if name not in aside], dtype=int)
        self.sizes = np.array(evaluate(self.recording.scales, 0.0, [0.0] * len(names), 1.0, self.row), dtype=float)
        self.sizes = np.where(self.sizes > 0.0, self.sizes, 1.0)
        self.rates = tuple(self.recording.rates[i] for i in self.unknowns)
        self.velocities = tuple(each.velocity for each in self.recording.contacts)
        self._jacobian = self._slopes(self.rates)
        self._velocity_slopes = self._slopes(self.velocities)

    def _slopes(self, expressions: Sequence[Expression]) -> tuple[Expression, ...]:
        """Derivatives by the unknowns, row by row."""
        return tuple(derivative(each, int(k)) for each in expressions for k in self.unknowns)

    @property
    def scales(self) -> np.ndarray:
        """Natural sizes of the unknowns."""
        return self.sizes[self.unknowns]

    def states(self, y: np.ndarray, switched: np.ndarray) -> list:
        """All states, of unknowns [unknowns, ...] and switched states [states, ...], the cyclic one at 0."""
        found = [np.broadcast_to(each, y.shape[1:]) for each in switched]
        for place, value in zip(self.unknowns, y, strict=True):
            found[place] = value
        return found

    def values(
        self, expressions: Sequence[Expression], y: np.ndarray, sides: np.ndarray, switched: np.ndarray, row: Any = None
    ) -> np.ndarray:
        """Values [expressions, ...] of recorded expressions; what is not defined there is not finite."""
        row, shape = self.row if row is None else row, y.shape[1:]
        if not expressions:
            return np.empty((0, *shape))
        # Nothing depends on the time. Sides of several contacts are a tuple.
        side = tuple(np.broadcast_to(each, shape).astype(float) for each in sides)
        with np.errstate(all="ignore"):
            found = evaluate(expressions, 0.0, self.states(y, switched), side, row)
        return np.stack([np.broadcast_to(np.asarray(value, dtype=float), shape) for value in found])

    def jacobian(self, y: np.ndarray, sides: np.ndarray, switched: np.ndarray, row: Any = None) -> np.ndarray:
        """Derivative of the rates by the states, [unknowns, unknowns, ...]."""
        n = len(self.unknowns)
        return self.values(self._jacobian, y, sides, switched, row).reshape(n, n, *y.shape[1:])

    def velocity_slopes(self, y: np.ndarray, sides: np.ndarray, switched: np.ndarray) -> np.ndarray:
        """Derivative of the sliding velocities by the states, [contacts, unknowns, ...]."""
        shape = len(self.velocities), len(self.unknowns), *y.shape[1:]
        return self.values(self._velocity_slopes, y, sides, switched).reshape(shape)

    def by_parameter(self, expressions: Sequence[Expression]) -> tuple[Expression, ...]:
        """Derivatives by the parameter of `path`, exact."""
        node = self.graph.node("parameter", self.index)
        return tuple(sensitivity(each, node.index) for each in expressions)

    @functools.cached_property
    def _curvatures(self) -> tuple[Expression, ...]:
        """Second derivatives of the rates by the states: of each entry of the Jacobian by each unknown."""
        return self._slopes(self._jacobian)

    @functools.cached_property
    def _parameter_slopes(self) -> tuple[Expression, ...]:
        """Derivatives by the parameter: of the rates, then of the entries of the Jacobian."""
        return self.by_parameter((*self.rates, *self._jacobian))


@dataclasses.dataclass(frozen=True, eq=False)
class Mode:
    """A problem in one mode of the contacts with the parameter among the unknowns, over natural sizes.

        z = y/d,  q the share of the parameter's range:     f = F/d,  J = d^-1 (dF/dy) d,  with the same eigenvalues

    x = (z, q) is [unknowns + 1].
    """

    problem: SteadyEquations
    sides: np.ndarray
    switched: np.ndarray
    between: tuple[float, float]

    @property
    def count(self) -> int:
        """Of the unknowns without the parameter."""
        return len(self.problem.unknowns)

    @property
    def width(self) -> float:
        """Of the range."""
        return self.between[1] - self.between[0]

    def parameter(self, x: np.ndarray) -> float:
        """The value of the parameter."""
        return float(self.between[0] + x[-1] * self.width)

    def state(self, x: np.ndarray) -> np.ndarray:
        """The unknowns themselves."""
        return x[:-1] * self.problem.scales

    def point(self, y: np.ndarray, parameter: float) -> np.ndarray:
        """x of unknowns and a value of the parameter."""
        return np.append(y / self.problem.scales, (parameter - self.between[0]) / self.width)

    def values(self, expressions: Sequence[Expression], x: np.ndarray) -> np.ndarray:
        """Values [expressions] of recorded expressions at a point."""
        row = self.problem.row.copy()
        row[self.problem.index] = self.parameter(x)
        return self.problem.values(expressions, self.state(x), self.sides, self.switched, row)

    def rates(self, x: np.ndarray) -> np.ndarray:
        """f, [unknowns]."""
        return self.values(self.problem.rates, x) / self.problem.scales

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """J, [unknowns, unknowns]."""
        d = self.problem.scales
        return self.values(self.problem._jacobian, x).reshape(self.count, -1) * d / d[:, None]

    def derivative(self, x: np.ndarray) -> np.ndarray:
        """Of f by x, [unknowns, unknowns + 1]."""
        slope = self.values(self.problem._parameter_slopes[: self.count], x) * self.width / self.problem.scales
        return np.column_stack((self.jacobian(x), slope))

    def curvature(self, x: np.ndarray) -> np.ndarray:
        """Of J by x, [unknowns, unknowns, unknowns + 1]."""
        n, d = self.count, self.problem.scales
        by_states = self.values(self.problem._curvatures, x).reshape(n, n, n) * d
        by_parameter = self.values(self.problem._parameter_slopes[n:], x).reshape(n, n, 1) * self.width
        return np.concatenate((by_states, by_parameter), axis=2) * d[None, :, None] / d[:, None, None]
