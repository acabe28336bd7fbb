"""What can be seen of a motion: observables and rates of integrals, of a few instants by NumPy, of many in one loop."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibrocap.motion.recording.equations import equations, integrals, parameter_values
from vibrocap.numerics.expressions.graph import Expression, evaluate, evaluated
from vibrocap.physics.names import name_and_number
from vibrocap.physics.system import System

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory
    from vibrocap.numerics.api import StoredMotion

STATE_FUNCTIONS = ("contact_velocity", "energy", "contact_energy", "momentum", "drive")  # not of the law
BLOCK = 65_520  # instants at a time


def of_law(name: str) -> bool:
    """Whether an observable depends on the forces or rates of the law."""
    return name_and_number(name)[0] not in STATE_FUNCTIONS


@dataclasses.dataclass(frozen=True)
class Observer:
    """Observables and rates of integrals of a system, as functions of time, states and side of the contact."""

    system: System

    def __reduce__(self):
        return type(self), (self.system,)  # the equations are recorded anew

    @functools.cached_property
    def known(self) -> dict[str, Expression]:
        """The observables, by name."""
        recording = equations(self.system)
        return recording.observables | integrals(recording)

    def __call__(
        self, names: tuple[str, ...], t: np.ndarray, states: np.ndarray, sides: tuple, drive: tuple
    ) -> np.ndarray:
        """Values by name at times t, with states [states, *t.shape] and the side of each contact: [names, *t.shape].

        drive: (times since it began its period, parameter vector), see `Trajectory.drive_at`
        """
        return evaluated([self.known[name] for name in names], drive[0], states, sides, drive[1], t.shape)

    def at_many(self, motion: "Trajectory", names: Sequence[str], index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """States, observables and rates of integrals, see `Trajectory.piece_observables`, in a compiled loop."""
        rows = [[*motion.state_names, *self.known].index(name) for name in names]
        laws = [name in self.known and of_law(name) for name in names]
        values, stored = np.empty((len(names), *s.shape)), self._stored(motion)
        for block, pieces, ends in blocks(motion, index, s):
            observed = stored.rows(rows, laws, pieces, ends, s[block].ravel())
            values[:, block] = observed.reshape(len(names), *s[block].shape)
        return values

    def left_at_many(self, motion: "Trajectory", bound: float, index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """What the pieces leave of the equations, see `evidence`, in a compiled loop."""
        values, stored = np.empty(s.shape), self._stored(motion)
        for block, pieces, ends in blocks(motion, index, s):
            values[block] = stored.left(bound, pieces, ends, s[block].ravel()).reshape(s[block].shape)
        return values

    def _stored(self, motion: "Trajectory") -> "StoredMotion":
        from vibrocap.numerics.api import StoredMotion  # which writes kernels

        recording, parameters = equations(self.system), parameter_values(self.system)
        scales = np.array(evaluate(recording.scales, 0.0, [], 1.0, parameters), dtype=float)
        return StoredMotion(recording, motion.series.order, parameters, scales)


def blocks(motion: "Trajectory", index: np.ndarray, s: np.ndarray):
    """(slice of index, pieces as a run records them, number of instants up to the end of each) of parts of a motion."""
    points = s[:1].size
    for first in range(0, len(index), BLOCK // points):
        block = slice(first, first + BLOCK // points)
        begins = np.flatnonzero(np.diff(index[block], prepend=-1))  # where another piece begins
        ends = points * np.append(begins[1:], len(index[block]))
        pieces = index[block][begins]
        local, parameters = motion.drive_at(pieces, 0.0 * pieces)
        segment = [parameter for parameter in parameters if np.ndim(parameter)]
        sides, numbers = motion.piece_sides[pieces], motion.series.numbers[pieces]
        head = 0.0 * local, local, motion.piece_length[pieces], motion.piece_implicit[pieces]
        yield block, np.column_stack((*head, numbers, sides, *segment)), ends
