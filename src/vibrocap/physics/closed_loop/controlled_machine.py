"""A machine under a controller: where what the controller measures and commands meets the machine's equations.

Where a controller orders the rate of a state, the machine's own equations give the force or torque. Rates are affine in
the effort u and in the friction forces R, so that u is affine in R:

    y_i' = f + f_u u + f_1 R_1 + f_2 R_2 + ... = w     =>     u = (w - f)/f_u - (f_1/f_u) R_1 - (f_2/f_u) R_2 - ...

(computed torque, or inverse dynamics: Spong, Hutchinson and Vidyasagar 2006, section 8.3; with coordinates that no
effort acts on, as a capsule under its pendulum, collocated partial linearisation: Spong 1994). With u put in, the
machine's contacts are again of the form a = b - A R, and whether they rest is decided as for any other machine.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from vibrocap.physics.closed_loop.actuator import WrappedMachine
from vibrocap.physics.controllers.controller import CURVATURE, SATURATED, SIDE
from vibrocap.physics.machines.machine import Contact

FAR = 1e6  # times the natural size and the reference: from there on what is measured has run away


class ControlledMachine(WrappedMachine):
    """A machine under a controller, as a machine whose drive is the reference. What is not said here is its own.

    A run ends where what is measured first has grown to `FAR` natural sizes and references: the loop is unstable.

    machine: the machine, or what stands behind the actuator; drive: the reference, whose slope may be asked for;
    sides: to which its contacts slide, where that is known (`sliding`)
    """

    sides: tuple = (1,)

    def __init__(self, machine: Any, controller: Any, drive: Any):
        self._extend(machine, controller)
        self.controller_part, self.reference_part = controller, drive
        self.switch_events = (*machine.switch_events, *controller.switch_events)
        self.channels = tuple("controller" if name == "drive" else name for name in machine.channels)
        self.bound_kinds = ("runaway", *controller.bound_kinds, *machine.bound_kinds)

    @property
    def measured_states(self) -> tuple[str, ...]:
        """The states on which the command depends by what is measured."""
        names = [name for name in self.controller_part.measures(self.machine) if name not in (SIDE, CURVATURE)]
        return tuple(name if name in self.machine.states else name.removesuffix("_rate") for name in names)

    def sliding(self, sides: tuple) -> "ControlledMachine":
        """The same while its contacts slide to these sides."""
        self.sides = sides
        return self

    @property
    def turns(self) -> Mapping[str, float]:
        return {name: turn for name, turn in self.machine.turns.items() if name not in self.measured_states}

    @property
    def symmetric(self) -> bool:
        """Where the machine is, and the command changes its sign with it."""
        signs = dict(zip(self.machine.states, self.machine.symmetry, strict=True))
        odd = self.controller_part.odd and all(signs[name] == -1 for name in self.measured_states)
        return odd and not self.controller_part.sampled and self.machine.symmetric

    def _parted(self, y) -> tuple[tuple, tuple]:
        """(states of the machine, of the controller)."""
        count = len(self.machine.states)
        return tuple(y[:count]), tuple(y[count : len(self.states)])

    def _measured(self, t, mechanical) -> tuple:
        still = (0.0,) * len(self.machine.contact_states)
        measurements, rates = [], None
        for name in self.controller_part.measures(self.machine):
            if name == SIDE:
                measurements.append(self.sides[0])
            elif name == CURVATURE:
                measurements.append(self.reference_part.curvature(t))
            elif name in self.machine.states:
                measurements.append(mechanical[self.machine.states.index(name)])
            else:
                rates = self.machine.rates(t, mechanical, 0.0, still) if rates is None else rates
                measurements.append(rates[self.machine.states.index(name.removesuffix("_rate"))])
        return tuple(measurements)

    def _given(self, t, y, reference) -> tuple:
        """What the functions of the controller are given."""
        mechanical, own = self._parted(y)
        slope = self.reference_part.slope(t) if self.controller_part.uses_slope else 0.0
        return t, self._measured(t, mechanical), own, reference, slope

    def _effort(self, t, y, reference) -> tuple[tuple, tuple, tuple]:
        """(states of the machine, u before its limit, u), of a controller that orders an acceleration; u as (free, by
        the force at each contact)."""
        part, (mechanical, own) = self.controller_part, self._parted(y)
        place = self.machine.states.index(part.accelerated(self.machine))
        rate = self.machine.evaluated("effects", t, mechanical)[0][place]
        raw = effort_for(rate, part.command(*self._given(t, y, reference)))
        held = dict(zip(part.states, own, strict=True)).get(SATURATED)
        if held is None:
            return mechanical, raw, raw
        free, *slopes = (term * (1.0 - held * held) for term in raw)
        return mechanical, raw, (free + held * part.limit, *slopes)

    @property
    def _by_forces(self) -> bool:
        return self.controller_part.orders == "acceleration"

    def _passed(self, t, y, drive, frictions) -> tuple:
        """(states of the machine, command)."""
        if self._by_forces:
            mechanical, _, effort = self._effort(t, y, drive)
            return mechanical, _under(effort, frictions)
        return self._parted(y)[0], self.controller_part.command(*self._given(t, y, drive))

    def commanded(self, t, y, reference, frictions):
        """u, what the machine or its actuator is told."""
        return self._passed(t, y, reference, frictions)[1]

    def felt(self, t, y, drive, frictions):
        """What the machine feels: u, or what the actuator makes of it."""
        mechanical, command = self._passed(t, y, drive, frictions)
        output = getattr(self.machine, "output", None)
        return command if output is None else output(mechanical)

    def scales(self, time=1.0) -> tuple:
        return (*self.machine.scales(time), *self.controller_part.scales(self.machine.effort_scale()))

    def contacts(self, t, y, drive) -> tuple:
        if self._by_forces:
            mechanical, _, effort = self._effort(t, y, drive)
            return contacts_under(self.machine, t, mechanical, effort)
        return self.machine.contacts(t, *self._passed(t, y, drive, ()))

    def rates(self, t, y, drive, frictions) -> tuple:
        own = self.controller_part.rates(*self._given(t, y, drive))
        return *self.machine.rates(t, *self._passed(t, y, drive, frictions), frictions), *own

    def equations_of_motion(self, t, y, drive, frictions) -> tuple | None:
        """Of the machine under u; None of a command that knows the friction, which is among their unknowns."""
        if self._by_forces:
            return None
        return self.machine.equations_of_motion(t, *self._passed(t, y, drive, frictions), frictions)

    def switches(self, t, y, drive, frictions) -> tuple:
        """Guards of the machine, then those of the controller."""
        if self.controller_part.sampled:
            own = self._due(t, y)
        elif self._by_forces:
            raw = _under(self._effort(t, y, drive)[1], frictions)
            own = self.controller_part.effort_switches(raw, *self._given(t, y, drive))
        else:
            own = self.controller_part.switches(*self._given(t, y, drive))
        return *self.machine.switches(t, *self._passed(t, y, drive, frictions), frictions), *own

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        (mechanical, command), (_, own) = self._passed(t, y, drive, frictions), self._parted(y)
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
        arguments, sign = self._given(t, y, reference), self.reference_part.sign(t)
        both = zip(
            self.controller_part.after_sample(*arguments), self.controller_part.after_action(arguments[2]), strict=True
        )
        return *(0.5 * (1.0 + sign) * sample + 0.5 * (1.0 - sign) * action for sample, action in both), sign

    def bounds(self, t, y) -> tuple:
        """What is measured has not run away, the command exists, and what the machine says."""
        mechanical, _ = self._parted(y)
        state = self.machine.states.index(self.measured_states[0])
        size = self.machine.scales(self.reference_part.period)[state]
        wanted, bounds = self.reference_part.value(t) / size, mechanical[state] / (FAR * size)
        own = self.controller_part.bounds(self._measured(t, mechanical))
        return 1.0 + wanted * wanted - bounds * bounds, *own, *self.machine.bounds(t, mechanical)


def _under(effort: Sequence[Any], frictions: Sequence[Any]) -> Any:
    """An effort, given the force at each contact."""
    return effort[0] + sum(slope * force for slope, force in zip(effort[1:], frictions, strict=True))


def effort_for(rate: Sequence[Any], wanted: Any) -> tuple:
    """u as (free, by the force at each contact), by which a rate (f, f_u, f_1, ...) is the one that is wanted."""
    free, by_effort, *by_friction = rate
    return (wanted - free) / by_effort, *(-(slope / by_effort) for slope in by_friction)


def put_in(value: Sequence[Any], effort: Sequence[Any]) -> tuple:
    """What is affine in the effort and the friction forces, in these alone under such an effort."""
    free, by_effort, *by_friction = value
    return tuple(own + by_effort * by for own, by in zip((free, *by_friction), effort, strict=True))


def contacts_under(machine: Any, t: Any, y: Sequence[Any], effort: Sequence[Any]) -> tuple[Contact, ...]:
    """The contacts of a machine whose effort depends on the forces at them: accelerations, responses and reactions."""
    contacts, (rates, loads) = [], machine.evaluated("effects", t, y)
    for contact, state, load in zip(machine.contacts(t, y, 0.0), machine.contact_states, loads, strict=True):
        acceleration, *slopes = put_in(rates[machine.states.index(state)], effort)
        response = tuple(-slope for slope in slopes)
        reaction = None if load is None else put_in(load, effort)
        contacts.append(Contact(contact.velocity, None, acceleration, response, reaction, contact.factor))
    return tuple(contacts)
