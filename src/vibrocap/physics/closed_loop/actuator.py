"""What stands before a machine and makes its effort: what actuator and controller have in common, and the actuator."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from vibrocap.physics.elementary import HELD_AFTER, limit_guards, limited
from vibrocap.physics.names import CLIPPED, OUTPUT, SATURATED
from vibrocap.physics.parameters import Part, Positive, parameter, parameters


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


@parameters
class Actuator(Part):
    """What makes the force or torque u that the machine feels of the command c(tau) that the drive is.

        T u' = c - u,     |u| <= u_max,     |c| <= c_max

    a first-order lag with a limited output, as in front of most models of motors, valves and amplifiers (Astrom and
    Murray, Feedback Systems, 2008, sections 8.3 and 10.4). u stays at u_max as long as the command is beyond it and
    leaves it when that comes back, without winding up; c is cut off before the lag. Both limits are reached and left at
    located events, so that no step crosses a breakpoint of u. A motion starts with u = 0 unless its initial condition
    sets u.
    """

    time_constant: Positive = parameter(0.1, "T_a", "time constant of the lag", "duration")
    limit: Positive | None = parameter(None, "u_max", "largest force or torque; none where there is no limit", "effort")
    command_limit: Positive | None = parameter(
        None, "c_max", "where the command is cut off before the lag; none where it is not", "effort"
    )

    name: ClassVar[str] = "actuator"
    source: ClassVar[str] = "astrom2008"

    @property
    def states(self) -> tuple[str, ...]:
        """u, then which of the limits hold."""
        return OUTPUT, *self.switched

    @property
    def switched(self) -> tuple[str, ...]:
        """Of each limit that there is a state: 1 or -1 while it holds, 0 while it does not."""
        limits = ((SATURATED, self.limit), (CLIPPED, self.command_limit))
        return tuple(name for name, limit in limits if limit is not None)


class ActuatedMachine(WrappedMachine):
    """A machine behind an actuator, as a machine whose drive is the command. What is not said here is its own."""

    def __init__(self, machine: Any, actuator: Any):
        self._extend(machine, actuator)
        self.actuator_part = actuator
        events = {SATURATED: ("saturated", "unsaturated", "saturated"), CLIPPED: ("clipped", "unclipped", "clipped")}
        self.switch_events = (*machine.switch_events, *(kind for name in actuator.switched for kind in events[name]))
        self.locked = {**machine.locked, **({SATURATED: (OUTPUT,)} if SATURATED in actuator.states else {})}

    def _of_actuator(self, y) -> dict[str, Any]:
        return dict(zip(self.actuator_part.states, y[len(self.machine.states) :], strict=True))

    def _passed(self, t, y, drive, frictions) -> tuple:
        return self._own(y), self.output(y)

    def output(self, y):
        """u, what the machine feels."""
        return y[len(self.machine.states)]

    def scales(self, time=1.0) -> tuple:
        return (*self.machine.scales(time), self.machine.effort_scale(), *((1.0,) * len(self.actuator_part.switched)))

    def room(self) -> Mapping[str, tuple[Any, Any]]:
        limit = self.actuator_part.limit
        return {**self.machine.room(), **({} if limit is None else {OUTPUT: (-limit, limit)})}

    def commanded(self, y, command):
        clipped, limit = self._of_actuator(y).get(CLIPPED), self.actuator_part.command_limit
        return command if clipped is None else limited(clipped, command, limit)

    def contacts(self, t, y, drive) -> tuple:
        return self.machine.contacts(t, self._own(y), self.output(y))

    def rates(self, t, y, drive, frictions) -> tuple:
        """y' of the machine under u, and u' = (c - u)/T, or 0 at the limit."""
        rate = (self.commanded(y, drive) - self.output(y)) / self.actuator_part.time_constant
        saturated = self._of_actuator(y).get(SATURATED)
        rate = rate if saturated is None else (1.0 - saturated * saturated) * rate
        own = self.machine.rates(t, self._own(y), self.output(y), frictions)
        return *own, rate, *((0.0,) * len(self.actuator_part.switched))

    def _guards(self, y, drive) -> tuple:
        guards, own = [], self._of_actuator(y)
        command = self.commanded(y, drive)
        limits = self.actuator_part.limit, self.actuator_part.command_limit
        values, asked_for = (self.output(y), drive), (command, drive)
        for name, limit, value, asked in zip((SATURATED, CLIPPED), limits, values, asked_for, strict=True):
            if limit is not None:
                guards += limit_guards(own[name], value, asked, limit)
        return tuple(guards)

    def switches(self, t, y, drive, frictions) -> tuple:
        """Guards of the machine, then those of the limits."""
        return *self.machine.switches(t, self._own(y), self.output(y), frictions), *self._guards(y, drive)

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        mechanical, output = self._own(y), self.output(y)
        guards = len(self.machine.switches(t, mechanical, output, frictions))
        if which < guards:
            return *self.machine.after_switch(which, t, mechanical, output, frictions), *y[len(mechanical) :]
        number, side = divmod(which - guards, 3)
        own, name = self._of_actuator(y), self.actuator_part.switched[number]
        own[name] = HELD_AFTER[side]
        if name == SATURATED and side != 1:
            own[OUTPUT] = self.actuator_part.limit * own[name]
        return *mechanical, *own.values()
