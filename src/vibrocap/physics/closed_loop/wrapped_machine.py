"""A machine behind what makes its effort: an actuator or a controller."""

from collections.abc import Callable, Mapping
from typing import Any


class WrappedMachine:
    """A machine with further states behind its own, whose effort follows from them; all else is the machine's own."""

    machine: Any

    def _extend(self, machine: Any, own: Any) -> None:
        """Put the states of an actuator or a controller behind those of the machine."""
        self.machine = machine
        self.states = (*machine.states, *own.states)
        self.symmetry = (*machine.symmetry, *((-1,) * len(own.states)))
        self.switched = (*machine.switched, *own.switched)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.machine, name)

    def _own(self, y) -> tuple:
        return tuple(y[: len(self.machine.states)])

    def _passed(self, t, y, drive, frictions) -> tuple:
        raise NotImplementedError

    def felt(self, t, y, drive, frictions) -> Any:
        """What the machine feels."""
        return self._passed(t, y, drive, frictions)[1]

    def actuator(self, t, y, frictions) -> Mapping[str, Any]:
        """Of an imposed motion, which has none of them."""
        return {}


def _of_states(name: str) -> Callable:
    return lambda self, t, y: getattr(self.machine, name)(t, self._own(y))


def _of_effort(name: str) -> Callable:
    def function(self, t, y, drive, frictions):
        return getattr(self.machine, name)(t, *self._passed(t, y, drive, frictions), frictions)

    return function


for _name in ("energy", "momentum", "line_momentum", "scene", "bounds"):
    setattr(WrappedMachine, _name, _of_states(_name))
for _name in ("outer_force", "wall_force", "powers", "equations_of_motion"):
    setattr(WrappedMachine, _name, _of_effort(_name))
