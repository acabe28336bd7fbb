"""What can be seen of a motion besides its states: the observables of its equations, at any instant."""

import dataclasses
import functools

import numpy as np

from vibrocap.motion.equations import equations, parameters_at
from vibrocap.numerics.expressions.graph import Expression, evaluate
from vibrocap.physics.system import System


def drive_time(t: np.ndarray, within: np.ndarray, origin: float, period: float) -> np.ndarray:
    """Time since the drive began the period in which `within` lies, at times t; origin: when it begins one."""
    return (t - origin) - period * np.floor((within - origin) / period)


@dataclasses.dataclass(frozen=True)
class Observer:
    """Observables and rates of integrals of a system, as functions of time, states and side of the contact.

    origin: a time at which the drive begins a period
    """

    system: System
    origin: float = 0.0

    def __reduce__(self):
        return type(self), (self.system, self.origin)  # the equations are recorded anew

    @functools.cached_property
    def known(self) -> dict[str, Expression]:
        """What can be asked for, by name."""
        recording = equations(self.system)
        names = (*(f"{name}_work" for name in self.system.channels), "impulse")
        return recording.observables | dict(zip(names, recording.integrals, strict=True))

    def __call__(
        self, names: tuple[str, ...], t: np.ndarray, states: np.ndarray, side: np.ndarray, within: np.ndarray
    ) -> list[np.ndarray]:
        """Values by name at times t [n], with states [states, n] and sides [n]: an array [n] each.

        within: for each time another one inside its piece: at the end of a piece the drive is still that of the piece
        """
        period = self.system.drive.period
        local = drive_time(t, within, self.origin, period)
        parameters = parameters_at(self.system, drive_time(within, within, self.origin, period))
        found = evaluate([self.known[name] for name in names], local, states, side, parameters)
        return [np.broadcast_to(np.asarray(value, dtype=float), t.shape) for value in found]
