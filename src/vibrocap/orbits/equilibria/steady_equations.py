"""What vanishes at an equilibrium, with exact derivatives of first and second order: from the recorded equations."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate, evaluated, sensitivity
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
            text = f"should not be driven in time, but its drive is {system.drive.name}"
            raise ArgumentError("system", f"{text}: it has no equilibria; orbit(system) finds its steady motions")
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
        self.velocities = tuple(contact.velocity for contact in self.recording.contacts)
        self._jacobian = self._slopes(self.rates)
        self._velocity_slopes = self._slopes(self.velocities)

    def _slopes(self, expressions: Sequence[Expression]) -> tuple[Expression, ...]:
        """Derivatives by the unknowns, row by row."""
        return tuple(derivative(expression, int(k)) for expression in expressions for k in self.unknowns)

    @property
    def scales(self) -> np.ndarray:
        """Natural sizes of the unknowns."""
        return self.sizes[self.unknowns]

    def states(self, y: np.ndarray, switched: np.ndarray) -> list:
        """All states, of unknowns [unknowns, ...] and switched states [states, ...], the cyclic one at 0."""
        columns = [np.broadcast_to(number, y.shape[1:]) for number in switched]
        for place, value in zip(self.unknowns, y, strict=True):
            columns[place] = value
        return columns

    def values(
        self, expressions: Sequence[Expression], y: np.ndarray, sides: np.ndarray, switched: np.ndarray, row: Any = None
    ) -> np.ndarray:
        """Values [expressions, ...] of recorded expressions; what is not defined there is not finite."""
        row, shape = self.row if row is None else row, y.shape[1:]
        # Nothing depends on the time. Sides of several contacts are a tuple.
        side = tuple(np.broadcast_to(side, shape).astype(float) for side in sides)
        with np.errstate(all="ignore"):
            return evaluated(expressions, 0.0, self.states(y, switched), side, row, shape)

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
        return tuple(sensitivity(expression, node.index) for expression in expressions)

    @functools.cached_property
    def _curvatures(self) -> tuple[Expression, ...]:
        """Second derivatives of the rates by the states: of each entry of the Jacobian by each unknown."""
        return self._slopes(self._jacobian)

    @functools.cached_property
    def _parameter_slopes(self) -> tuple[Expression, ...]:
        """Derivatives by the parameter: of the rates, then of the entries of the Jacobian."""
        return self.by_parameter((*self.rates, *self._jacobian))
