"""What can be seen of a motion besides its states: the observables of its equations, at any instant."""

import dataclasses
import functools

import numpy as np

from vibrocap.motion.equations import equations
from vibrocap.numerics.expressions.graph import Expression, evaluate
from vibrocap.physics.system import System


@dataclasses.dataclass(frozen=True)
class Observer:
    """Observables and rates of integrals of a system, as functions of time, states and side of the contact."""

    system: System

    def __reduce__(self):
        return type(self), (self.system,)  # the equations are recorded anew

    @functools.cached_property
    def known(self) -> dict[str, Expression]:
        """What can be asked for, by name."""
        recording = equations(self.system)
        names = (*(f"{name}_work" for name in self.system.channels), "impulse")
        return recording.observables | dict(zip(names, recording.integrals, strict=True))

    def __call__(
        self, names: tuple[str, ...], t: np.ndarray, states: np.ndarray, side: np.ndarray, drive: tuple
    ) -> list[np.ndarray]:
        """Values by name at times t [n], with states [states, n] and sides [n]: an array [n] each.

        drive: (times since it began its period, parameter vector), see `Trajectory.drive_at`
        """
        found = evaluate([self.known[name] for name in names], drive[0], states, side, drive[1])
        return [np.broadcast_to(np.asarray(value, dtype=float), t.shape) for value in found]
