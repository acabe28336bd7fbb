"""A motion in SI: the same names, times in seconds and values in their SI units."""

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.physics.units import Units

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory


@dataclasses.dataclass(frozen=True, eq=False)
class MotionInSI:
    """What `motion.si` gives: motion.si["position"] in m at motion.si.time in s, motion.si.unit("position") == "m".

    The motion itself is computed without units; each value is that of the motion times `units.factor(name)`.
    """

    motion: "Trajectory"

    @property
    def units(self) -> Units:
        """Factor and SI unit of every quantity."""
        return self.motion.system.si

    def unit(self, name: str) -> str:
        """SI unit of a quantity; "1" for one without."""
        return self.units.unit(name)

    @property
    def time(self) -> np.ndarray:
        """The motion's grid in s."""
        return self.motion.time * self.units.factor("time")

    @property
    def period(self) -> float:
        """The drive period in s."""
        return self.motion.period * self.units.factor("time")

    @property
    def end(self) -> float:
        """Time reached in s."""
        return self.motion.end * self.units.factor("time")

    @property
    def event_times(self) -> np.ndarray:
        """Times of the changes of the contact in s."""
        return self.motion.event_times * self.units.factor("time")

    @property
    def state(self) -> dict[str, float]:
        """The final state by name."""
        return {name: value * self.units.factor(name) for name, value in self.motion.state.items()}

    def at(self, t: Any, name: str) -> np.ndarray:
        """A named quantity at times t in s."""
        return self.motion.at(np.asarray(t, dtype=float) / self.units.factor("time"), name) * self.units.factor(name)

    def crossings(
        self, name: str, value: float, direction: int | None = None, modulo: float | None = None
    ) -> np.ndarray:
        """Times in s at which a quantity passes a value in its SI unit, see `Trajectory.crossings`."""
        factor = self.units.factor(name)
        found = self.motion.crossings(name, value / factor, direction, None if modulo is None else modulo / factor)
        return found * self.units.factor("time")

    def __getitem__(self, name: str) -> np.ndarray:
        return self.motion[name] * self.units.factor(name)
