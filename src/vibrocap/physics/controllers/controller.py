"""The contract of a controller: one kind or family per file in this folder; what makes the command."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from vibrocap.physics.elementary import cos, exp, sin, sqrt
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.part import Part

__all__ = [
    "Controller",
    "NonNegative",
    "Number",
    "Positive",
    "cos",
    "exp",
    "parameter",
    "parameters",
    "sin",
    "sqrt",
]


class Controller(Part):
    """What every controller offers, as scalar functions of time, of what it measures, of its states and the reference.

    The reference r(tau) is the drive of the system, whose values are then no force but what the controller compares
    with what it measures; `reference` says what kind of quantity that is: a displacement, a speed, or a number (an
    angle). The command u takes the place of the drive before the machine, or before its actuator. All functions are
    called with numbers, and with symbols to record them, so they never branch on a value.

    states: names of its own states, which no machine, actuator or law uses. switched: those of them that are whole
    numbers, which say what branch holds (a limit reached or not), have the rate 0.0 and change only where a guard of
    `switches` falls to zero; a run starts with all of them at 0, and with the branch that its other states ask for.
    all_states: the names of all states that one of the class may have, where that depends on its parameters.
    switch_events: the name of what happens at each guard. effort_states: those of its states that count in units of the
    command; the others have no unit. odd: whether the command changes its sign with all that it is given.
    sampled: whether it acts at samples alone, every `sample_time` and `delay` later (None: at once). The last of its
    states is then whether a sample or an action came last, +1 or -1; `after_sample` and `after_action` say what the
    others are after each, and `command` is one of them.
    """

    name: ClassVar[str]
    reference: ClassVar[Literal["displacement", "speed", "number"]]
    states: Any = ()
    all_states: ClassVar[tuple[str, ...]] = ()
    switched: Any = ()
    switch_events: Any = ()
    effort_states: ClassVar[tuple[str, ...]] = ()
    odd: ClassVar[bool] = True
    sampled: ClassVar[bool] = False
    sample_time: Any
    delay: Any

    def measures(self, machine: Any) -> tuple[str, ...]:
        """What it measures of a machine: names of states ("position"), or of their rates ("position_rate").

        A rate must not depend on the command.
        """
        raise NotImplementedError

    @property
    def uses_slope(self) -> bool:
        """Whether it asks for the slope of the reference, which then must not jump."""
        return False

    def scales(self, effort) -> tuple:
        """Natural size of each of its states, given that of the command."""
        return tuple(1.0 if name in self.switched else effort for name in self.states)

    def command(self, t, measured, own, reference, slope):
        """u. measured: as `measures` names it; own: its states; reference, slope: r and r' (0 where not asked for)."""
        raise NotImplementedError

    def rates(self, t, measured, own, reference, slope) -> tuple:
        """Rates of its own states."""
        return ()

    def switches(self, t, measured, own, reference, slope) -> tuple:
        """Guards of its branches, each positive while its branch lasts; their natural size is 1."""
        return ()

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        """All of its own states after guard number `which` has fallen to zero."""
        raise NotImplementedError

    def after_sample(self, t, measured, own, reference, slope) -> tuple:
        """Of a sampled one: its states, but for the last, after a sample; reference, slope: r and r' at it."""
        raise NotImplementedError

    def after_action(self, own) -> tuple:
        """Of a sampled one: its states, but for the last, after the action that follows a sample."""
        raise NotImplementedError


LIMIT_EVENTS = ("command_saturated", "command_unsaturated", "command_saturated")


class ControlledMachine:
    """A machine under a controller, as a machine whose drive is the reference. What is not said here is its own.

    machine: the machine, or what stands behind the actuator; drive: the reference, whose slope may be asked for
    """

    def __init__(self, machine: Any, controller: Any, drive: Any):
        self.machine, self.controller_part, self.reference_part = machine, controller, drive
        own = controller.states
        self.states = (*machine.states, *own)
        self.symmetry = (*machine.symmetry, *((-1,) * len(own)))
        self.switched = (*machine.switched, *controller.switched)
        self.switch_events = (*machine.switch_events, *controller.switch_events)
        self.channels = tuple("controller" if name == "drive" else name for name in machine.channels)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.machine, name)

    @property
    def measured_states(self) -> tuple[str, ...]:
        """The states on which the command depends by what is measured."""
        names, states = self.controller_part.measures(self.machine), self.machine.states
        return tuple(name if name in states else name.removesuffix("_rate") for name in names)

    @property
    def cyclic(self) -> Any:
        """That of the machine, but for one that is measured: then the motion depends on it."""
        return None if self.machine.cyclic in self.measured_states else self.machine.cyclic

    @property
    def turns(self) -> Mapping[str, float]:
        """Those of the machine that are not measured."""
        return {name: turn for name, turn in self.machine.turns.items() if name not in self.measured_states}

    @property
    def symmetric(self) -> bool:
        """Where the machine is, and the command changes its sign with it."""
        signs = dict(zip(self.machine.states, self.machine.symmetry, strict=True))
        odd = (
            self.controller_part.odd
            and not self.controller_part.sampled
            and all(signs[name] == -1 for name in self.measured_states)
        )
        return odd and self.machine.symmetric

    def _parted(self, y) -> tuple[tuple, tuple]:
        """(states of the machine, of the controller)."""
        count = len(self.machine.states)
        return tuple(y[:count]), tuple(y[count : len(self.states)])

    def _measured(self, t, mechanical) -> tuple:
        still = (0.0,) * len(self.machine.contact_states)
        found, rates = [], None
        for name in self.controller_part.measures(self.machine):
            if name in self.machine.states:
                found.append(mechanical[self.machine.states.index(name)])
            else:
                rates = self.machine.rates(t, mechanical, 0.0, still) if rates is None else rates
                found.append(rates[self.machine.states.index(name.removesuffix("_rate"))])
        return tuple(found)

    def _given(self, t, y, reference) -> tuple:
        """What the functions of the controller are given."""
        mechanical, own = self._parted(y)
        slope = self.reference_part.slope(t) if self.controller_part.uses_slope else 0.0
        return t, self._measured(t, mechanical), own, reference, slope

    def _passed(self, t, y, reference) -> tuple:
        """(states of the machine, command)."""
        return self._parted(y)[0], self.controller_part.command(*self._given(t, y, reference))

    def commanded(self, t, y, reference):
        """u, what the machine or its actuator is told."""
        return self.controller_part.command(*self._given(t, y, reference))

    def felt(self, t, y, reference):
        """What the machine feels: u, or what the actuator makes of it."""
        mechanical, command = self._passed(t, y, reference)
        output = getattr(self.machine, "output", None)
        return command if output is None else output(mechanical)

    def scales(self, time=1.0) -> tuple:
        """Natural size of each state."""
        return (*self.machine.scales(time), *self.controller_part.scales(self.machine.effort_scale()))

    def contacts(self, t, y, drive) -> tuple:
        """Of the machine, under u."""
        return self.machine.contacts(t, *self._passed(t, y, drive))

    def rates(self, t, y, drive, frictions) -> tuple:
        """y' of the machine under u, then of the controller."""
        own = self.controller_part.rates(*self._given(t, y, drive))
        return *self.machine.rates(t, *self._passed(t, y, drive), frictions), *own

    def switches(self, t, y, drive, frictions) -> tuple:
        """Guards of the machine, then those of the controller."""
        own = (
            self._due(t, y)
            if self.controller_part.sampled
            else self.controller_part.switches(*self._given(t, y, drive))
        )
        return *self.machine.switches(t, *self._passed(t, y, drive), frictions), *own

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        """All states after guard number `which`."""
        (mechanical, command), (_, own) = self._passed(t, y, drive), self._parted(y)
        guards = len(self.machine.switches(t, mechanical, command, frictions))
        if which < guards:
            return *self.machine.after_switch(which, t, mechanical, command, frictions), *own
        if self.controller_part.sampled:
            return *mechanical, *self._after_corner(t, y, drive)
        return *mechanical, *self.controller_part.after_switch(which - guards, *self._given(t, y, drive))

    def _due(self, t, y) -> tuple:
        """The guard of a sampled controller, 1 until a sample or an action is due: it falls where the corner is."""
        last = y[len(self.states) - 1]
        return (last * self.reference_part.sign(t) - (1.0 - last * last),)

    def _after_corner(self, t, y, reference) -> tuple:
        """The states of a sampled controller after a sample, where the sign of the segment is +1, or an action, -1."""
        given, sign = self._given(t, y, reference), self.reference_part.sign(t)
        both = zip(self.controller_part.after_sample(*given), self.controller_part.after_action(given[2]), strict=True)
        return *(0.5 * (1.0 + sign) * sample + 0.5 * (1.0 - sign) * action for sample, action in both), sign

    def actuator(self, t, y, frictions) -> Mapping[str, Any]:
        """Of an imposed motion, which has no controller."""
        return {}

    def bounds(self, t, y) -> tuple:
        """Of the machine."""
        return self.machine.bounds(t, self._parted(y)[0])

    def energy(self, t, y):
        """Of the machine: a controller stores none."""
        return self.machine.energy(t, self._parted(y)[0])

    def momentum(self, t, y):
        """Of the machine."""
        return self.machine.momentum(t, self._parted(y)[0])

    def outer_force(self, t, y, drive):
        """Of the machine, under u."""
        return self.machine.outer_force(t, *self._passed(t, y, drive))

    def wall_force(self, t, y, drive, frictions):
        """Of the machine, under u."""
        return self.machine.wall_force(t, *self._passed(t, y, drive), frictions)

    def powers(self, t, y, drive, frictions) -> tuple:
        """Of the machine: what would be the power of the drive is that of the controller."""
        return self.machine.powers(t, *self._passed(t, y, drive), frictions)

    def vertical_momentum(self, t, y) -> Any:
        """Of the machine."""
        return self.machine.vertical_momentum(t, self._parted(y)[0])

    def scene(self, t, y) -> tuple:
        """Of the machine."""
        return self.machine.scene(t, self._parted(y)[0])
