"""A machine on several contacts, seen as a machine on the first of them: the others become branches of the machine.

Which way a further contact slides, or that it rests, is a switched state of its own, `side_2` for instance: +1, -1, 0.
Guards end each branch, as for a stop that is struck:

    sliding    side v >= 0; where v falls to zero it becomes exactly 0, and the contact rests
    resting    |holding force - middle| <= limit; beyond it the contact slides to the side of that force

No time passes between the two, so that a contact which nothing can hold turns at once. A kinked law goes from one side
to the other. Here each contact is on a body of its own and the bodies touch through springs, dampers and drives alone,
so that the force which would hold a contact depends on no friction at the others (`Machine.further_holding_forces`):
the modes are decided contact by contact, and there is always exactly one way to go on. Contacts that act on one another
are decided together, see `coupled_contacts.py`.
"""

from collections.abc import Sequence
from typing import Any

from vibrocap.physics.friction.law import Law
from vibrocap.physics.states import contact_states, turns

# So little speed is none, and so little force: what multiplies one over it is exactly zero where it should not count.
LEAST = 1e-150


class FurtherContact:
    """One further contact at one instant: its mode, its friction, and what ends its branch.

    number: 2 for the second; velocity: its sliding velocity; own: its states; hold: the force that would hold it
    environment: whose drag acts on its body, or None
    """

    imposed = False  # whether its velocity is a function of time and of the state of the first contact

    def __init__(self, number: int, law: Law, load, velocity, own: tuple, hold, scale, environment: Any = None):
        self.number, self.law, self.load, self.scale = number, law, load, scale
        self.velocity, self.hold, self.own = velocity, hold, own
        self.sticks, self.turns = law.kind == "set-valued", turns(law, environment is not None)
        self.side, self.internal = (own[0], own[1:]) if self.turns else (1.0, own)
        force, self.internal_rates = law.force(velocity, self.internal, self.side, load)
        sliding_loss, self.bristle_loss = law.losses(velocity, self.internal, self.side, load)
        slipping = self.side * self.side if self.sticks else 1.0
        self.friction = hold + slipping * (force - hold) if self.sticks else force
        self.sliding_loss = slipping * sliding_loss if self.sticks else sliding_loss
        self.drag = None if environment is None else environment.drag(velocity, self.side)

    @property
    def taken(self):
        """By the machine in the place of friction: with the drag on the body, which is none at rest."""
        return self.friction if self.drag is None else self.friction + self.drag

    @property
    def rates(self) -> tuple:
        """Rates of its own states."""
        return (*((0.0,) if self.turns else ()), *self.internal_rates)

    @property
    def stored_energy(self):
        """Energy in its bristles."""
        return self.law.stored_energy(self.internal)

    def guards(self) -> tuple:
        """Guards of its branches, then those of the pieces of its law."""
        if not self.turns:
            return ()
        sliding = self.side * self.side
        rests = 1.0 - sliding
        stops = rests + self.side * self.velocity / self.scale
        forward = back = 0.0  # of a kinked law a side is sought only where the run starts
        if self.sticks:
            forward, back = self._margins()
        push = self._push()
        pieces = self.law.switches(self.velocity, self.internal, self.side, self.load)
        return stops, sliding + rests * (forward - push), sliding + rests * (back + push), *pieces

    @property
    def limit(self):
        """How far the forces reach that it can hold at rest."""
        return self.law.holding_limit(self.load)

    @property
    def middle(self):
        """Their middle."""
        return self.law.holding_middle(self.load)

    def _margins(self) -> tuple:
        """Shares of its limit by which the force that holds it may grow forward and back."""
        limit, middle = self.limit, self.middle
        return (limit - (self.hold - middle)) / (limit + LEAST), (limit + (self.hold - middle)) / (limit + LEAST)

    def _push(self):
        """Beyond all margins where a contact that should rest slides."""
        return self.velocity / LEAST

    def after(self, which: int) -> tuple[Any, tuple]:
        """(sliding velocity, own states) after guard number `which`."""
        if which == 0:
            if self.sticks:
                return 0.0, (0.0,)
            return 0.0, (-self.side, *self.law.after_reversal(self.internal, -self.side, self.load))
        if which < 3:
            return self.velocity, (1.0 if which == 1 else -1.0, *self.internal)
        internal = self.law.after_switch(which - 3, self.velocity, self.internal, self.side, self.load)
        return self.velocity, (self.side, *internal)


class MachineOnContacts:
    """A machine with the laws of its further contacts, as a machine on its first contact.

    Friction at the further contacts is a force from outside, and so is the drag of an environment on their bodies. All
    that is not said here is the machine's own.
    """

    def __init__(self, machine: Any, laws: Sequence[Law], environment: Any = None):
        self.machine, self.laws, self.environment = machine, tuple(laws), environment
        contacts, around = tuple(enumerate(self.laws, start=2)), environment is not None
        named = [contact_states(i, law, around) for i, law in contacts]
        self.states = (*machine.states, *(name for names in named for name in names))
        self.symmetry = (*machine.symmetry, *(sign for _, law in contacts for sign in _signs(law, around)))
        self.switched = (
            *machine.switched,
            *(f"side_{i}" for i, law in contacts if turns(law, around)),
            *(f"{name}_{i}" for i, law in contacts for name in law.switched),
        )
        self.switch_events = (
            *machine.switch_events,
            *(kind for i, law in contacts for kind in _events(i, law, around)),
        )
        losses = ((f"contact_sliding_{i}", *((f"bristle_loss_{i}",) if law.internal else ())) for i, law in contacts)
        self.channels = (*machine.channels, *(name for names in losses for name in names))
        self._places, start = [], len(machine.states)
        for names in named:
            self._places.append(slice(start, start + len(names)))
            start += len(names)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.machine, name)

    @property
    def symmetric(self) -> bool:
        """Whether machine and laws are their own mirror images."""
        return self.machine.symmetric and all(law.symmetric for law in self.laws)

    def scales(self, time=1.0) -> tuple:
        """Natural size of each state."""
        found = list(self.machine.scales(time))
        for law, load in zip(self.laws, self.machine.further_loads(), strict=True):
            own = (1.0,) if turns(law, self.environment is not None) else ()
            found += [*own, *law.internal_scales(load)]
        return tuple(found)

    def further(self, t, y, drive) -> tuple[FurtherContact, ...]:
        """The further contacts at one instant."""
        mechanical, machine = self._own(y), self.machine
        holds, loads = machine.further_holding_forces(t, mechanical, drive), machine.further_loads()
        sizes = machine.scales()
        found = []
        for i, (law, state, place) in enumerate(zip(self.laws, machine.contacts, self._places, strict=True)):
            at = machine.states.index(state)
            own = mechanical[at], tuple(y[place]), holds[i], sizes[at], self.environment
            found.append(FurtherContact(2 + i, law, loads[i], *own))
        return tuple(found)

    def _own(self, y) -> tuple:
        return tuple(y[: len(self.machine.states)])

    def contact_velocity(self, t, y):
        """Sliding velocity of the first contact."""
        return self.machine.contact_velocity(t, self._own(y))

    def holding_force(self, t, y, drive):
        """Friction force that would keep the first contact at rest."""
        return self.machine.holding_force(t, self._own(y), drive)

    def rates(self, t, y, drive, force) -> tuple:
        """y', with the friction of all contacts."""
        further = self.further(t, y, drive)
        own = self.machine.rates(t, self._own(y), drive, force, *(each.taken for each in further))
        return *own, *(rate for each in further for rate in each.rates)

    def switches(self, t, y, drive, force) -> tuple:
        """Guards of the machine, then of each further contact."""
        further = self.further(t, y, drive)
        return *self.machine.switches(t, self._own(y), drive, force), *(g for each in further for g in each.guards())

    def after_switch(self, which, t, y, drive, force) -> tuple:
        """All states after guard number `which`."""
        mechanical = self._own(y)
        guards = len(self.machine.switches(t, mechanical, drive, force))
        if which < guards:
            return *self.machine.after_switch(which, t, mechanical, drive, force), *y[len(mechanical) :]
        which, states = which - guards, list(y)
        for each, state, place in zip(self.further(t, y, drive), self.machine.contacts, self._places, strict=True):
            guards = len(each.guards())
            if 0 <= which < guards:
                velocity, states[place] = each.after(which)
                self._move(states, state, each, velocity)
            which -= guards
        return tuple(states)

    def _move(self, states: list, name: str, each: FurtherContact, velocity) -> None:
        """Give a further contact its velocity."""
        states[self.machine.states.index(name)] = velocity

    def energy(self, t, y):
        """Energy of the machine, and what its further contacts store."""
        found = self.machine.energy(t, self._own(y))
        for law, place in zip(self.laws, self._places, strict=True):
            if law.internal:
                found = found + law.stored_energy(tuple(y[place])[-len(law.internal) :])
        return found

    def momentum(self, t, y):
        """Momentum along the line of sliding."""
        return self.machine.momentum(t, self._own(y))

    def outer_force(self, t, y, drive):
        """Force from outside, friction and drag at the further contacts included."""
        found = self.machine.outer_force(t, self._own(y), drive)
        for each in self.further(t, y, drive):
            found = found - each.taken
        return found

    def further_drag_power(self, t, y):
        """Power of the drag on the bodies of the further contacts."""
        pairs = ((each.drag, each.velocity) for each in self.further(t, y, 0.0))
        return sum(-drag * velocity for drag, velocity in pairs if drag is not None)

    def powers(self, t, y, drive, force) -> tuple:
        """Powers of the machine's channels, then of each further contact."""
        further = self.further(t, y, drive)
        own = self.machine.powers(t, self._own(y), drive, force, *(each.friction for each in further))
        losses = ((-each.sliding_loss, *((-each.bristle_loss,) if each.law.internal else ())) for each in further)
        return *own, *(loss for lost in losses for loss in lost)

    def reaction(self, t, y, drive) -> Any:
        """Of the machine."""
        return self.machine.reaction(t, self._own(y), drive)

    def vertical_momentum(self, t, y) -> Any:
        """Of the machine."""
        return self.machine.vertical_momentum(t, self._own(y))


def _signs(law: Law, surrounded: bool) -> tuple[int, ...]:
    internal = (-1,) * len(law.internal) if law.internal_symmetry is None else law.internal_symmetry
    return (*((-1,) if turns(law, surrounded) else ()), *internal)


def _events(number: int, law: Law, surrounded: bool) -> tuple[str, ...]:
    """What happens at each guard of a further contact."""
    if not turns(law, surrounded):
        return ()
    internal = (0.0,) * len(law.internal)
    pieces = ("switch",) * len(law.switches(0.1, internal, 1, 1.0))
    if law.kind == "set-valued":
        return f"stick_{number}", f"slip_forward_{number}", f"slip_back_{number}"
    return f"reversal_{number}", "switch", "switch", *pieces
