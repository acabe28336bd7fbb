"""The equations of a system at one instant: where machine, laws, drive and environment meet."""

import dataclasses
from typing import Any

from vibrocap.physics.contacts import ContactForce, Contacts, Rows, RubbingContact
from vibrocap.physics.events import BOUNDS
from vibrocap.physics.machines.machine import Contact
from vibrocap.physics.names import laws_by_state

CONTACT_CHANNELS = ("contact_sliding", "bristle_loss", "contact_storage")  # of energy


@dataclasses.dataclass(frozen=True)
class Flow:
    """Everything that the equations say at one instant, as numbers or as recorded expressions."""

    rates: tuple  # y', one per state
    drive: Any  # what the machine feels
    command: Any  # the same before an actuator
    reference: Any  # what the drive says, the same where there is no controller
    contacts: tuple[ContactForce, ...]  # what acts at each contact
    outer_force: Any  # along the line of sliding, other than friction
    switches: tuple  # guards of the branches of the law, then of the machine, positive within the present ones
    law_switches: int  # how many of them are the laws'
    after_switch: tuple  # all states after each switch
    after_reversal: tuple  # of each contact: all states after it has turned to its side
    powers: tuple  # one per channel, positive into the system
    energy: Any  # of the machine
    contact_energy: Any  # stored in all contacts
    bounds: tuple  # positive while the equations hold: those of a load that follows the motion, then the machine's
    bound_kinds: tuple  # place in BOUNDS of each of them
    loads: tuple  # normal load of a contact while it slips, and at rest, see `Contacts`; none with a constant load
    divisors: tuple  # by which forces at contacts are solved; they vanish only where a bound does
    rows: Rows | None  # the problem of several contacts, which decides which of them rest

    @property
    def tangential(self) -> tuple:
        """By the machine in place of friction, at each contact: R less what pushes its body from outside."""
        return tuple(contact.tangential for contact in self.contacts)

    def reaction(self, contact: int) -> Any:
        """Of the ground at a contact, counted from 0; None where the machine does not say."""
        affine = self.contacts[contact].contact.given.reaction
        if affine is None:
            return None
        own, *slopes = affine
        rubs = own + sum(slope * taken for slope, taken in zip(slopes, self.tangential, strict=True))
        factor = self.contacts[contact].contact.given.factor
        return rubs if isinstance(factor, float) and factor == 1.0 else rubs / factor


def _internal(system: Any, y) -> list[tuple]:
    """The internal states of the law of each contact, the first contact first; they stand last."""
    internal_states, start = {}, len(system.placed.states)
    for number, law in laws_by_state(system.parts):
        internal_states[number] = tuple(y[start : start + len(law.internal)])
        start += len(law.internal)
    return [internal_states[number] for number in sorted(internal_states)]


def _rubbing(system: Any, y, machine_contacts: tuple[Contact, ...], sides: tuple, outside: Any) -> list[RubbingContact]:
    rubbing, pushes = [], ((0.0, 0.0),) * len(machine_contacts) if outside is None else outside.pushes
    contacts_in_order = zip(
        machine_contacts, system.laws, system.law_loads, _internal(system, y), sides, pushes, strict=True
    )
    for contact, law, load, internal, side, (push, push_at_rest) in contacts_in_order:
        force, rates = law.force(contact.velocity, internal, side, load)
        losses = law.losses(contact.velocity, internal, side, load)
        own = contact, law, load, internal, side, force, rates, losses, push, push_at_rest
        rubbing.append(RubbingContact(*own))
    return rubbing


def flow_of(system: Any, t, y, side) -> Flow:
    """The equations at time t and state y, sliding to `side` (+1, -1) or stuck (0, set-valued laws only).

    side: of several contacts a tuple, one for each, or one for all
    """
    machine = system.placed
    mechanical, count = y[: len(machine.states)], len(machine.contact_states)
    sides = side if isinstance(side, tuple) else (side,) * count
    machine = machine if system.controller is None else machine.sliding(sides)
    drive = system.timed_drive.value(t)
    machine_contacts = tuple(machine.contacts(t, mechanical, drive))
    outside = None
    if system.environment is not None:
        velocities = tuple(contact.velocity for contact in machine_contacts)
        outside = system.environment.outside(machine, t, mechanical, velocities, sides)
    rubbing = _rubbing(system, y, machine_contacts, sides, outside)
    contacts = Contacts(machine, rubbing)
    acting = contacts.acting
    frictions = tuple(force.tangential for force in acting)
    switches, outcomes, law_switches = _switches(system, machine, t, y, rubbing, drive, frictions)
    # A drive that imposes a motion works against all that acts on the body from outside.
    against_all = system.machine.imposes_motion or any(contact.response for contact in machine_contacts)
    worked_against = frictions if against_all else tuple(force.friction for force in acting)
    rates = machine.rates(t, mechanical, drive, frictions)
    if contacts.coupled:  # exactly zero of contacts at rest, whose forces follow from one problem
        moves = {name: contact.slips for name, contact in zip(machine.contact_states, rubbing, strict=True)}
        rates = tuple(moves.get(name, 1.0) * rate for name, rate in zip(machine.states, rates, strict=True))
    ends = machine.bounds(t, mechanical)
    kinds = (BOUNDS.index(kind) for kind in machine.bound_kinds[: len(ends)])
    outer_force = machine.outer_force(t, mechanical, drive, frictions)
    outer_force = outer_force + machine.wall_force(t, mechanical, drive, frictions)
    if outside is not None:
        outer_force = outer_force + outside.total
    storing = () if machine.follows_load else [contact for contact in rubbing if contact.law.internal]
    plain = system.actuator is None and system.controller is None
    internal_rates = (rate for contact in (*rubbing[1:], rubbing[0]) for rate in contact.internal_rates)
    return Flow(
        rates=(*rates, *internal_rates),
        drive=drive if plain else machine.felt(t, mechanical, drive, frictions),
        command=drive if system.controller is None else machine.commanded(t, mechanical, drive, frictions),
        reference=drive,
        contacts=acting,
        outer_force=outer_force,
        switches=switches,
        law_switches=law_switches,
        after_switch=outcomes,
        after_reversal=_after_reversals(system, y, sides),
        powers=(
            *machine.powers(t, mechanical, drive, worked_against),
            *_powers_lost(system, acting[1:]),
            *(() if outside is None else outside.powers),
            *_powers_lost(system, acting[:1]),
        ),
        energy=machine.energy(t, mechanical),
        contact_energy=sum((contact.law.stored_energy(contact.internal) for contact in storing), start=0.0),
        bounds=(*contacts.bounds, *ends),
        bound_kinds=(*contacts.bound_kinds, *kinds),
        loads=contacts.loads,
        divisors=contacts.divisors,
        rows=contacts.rows(),
    )


def _powers_lost(system: Any, contacts: tuple[ContactForce, ...]) -> tuple:
    """Powers lost at contacts; then, under loads that follow the motion, what they store."""
    lost, stored = [], []
    for contact in contacts:
        sliding, bristles = contact.losses
        lost += [-sliding, -bristles]
        if contact.contact.law.internal and system.machine.follows_load:
            stored.append(sliding + bristles - contact.friction * contact.contact.velocity)
    return (*lost, *stored)


def _switches(system: Any, machine: Any, t, y, contacts, drive, frictions) -> tuple[tuple, tuple, int]:
    """(guards of the pieces of all laws, then of the machine; all states after each of them; how many are laws')."""
    parts, mechanical = _internal(system, y), tuple(y[: len(machine.states)])
    asked = [(contact.law, contact.velocity, contact.internal, contact.side, contact.load) for contact in contacts]
    guards, outcomes = [], []
    for i, (law, *at) in enumerate(asked):
        own = law.switches(*at)
        guards += own
        for which in range(len(own)):
            outcomes.append(_with_internal(mechanical, parts, i, law.after_switch(which, *at)))
    count = len(guards)
    own = machine.switches(t, mechanical, drive, frictions)
    for which in range(len(own)):
        after = machine.after_switch(which, t, mechanical, drive, frictions)
        outcomes.append((*after, *y[len(mechanical) :]))
    return (*guards, *own), tuple(outcomes), count


def _after_reversals(system: Any, y, sides) -> tuple:
    """Of each contact, all states after it has turned to its side."""
    parts, mechanical = _internal(system, y), tuple(y[: len(system.placed.states)])
    laws = zip(system.laws, system.law_loads, sides, strict=True)
    return tuple(
        _with_internal(mechanical, parts, i, law.after_reversal(parts[i], side, load))
        for i, (law, load, side) in enumerate(laws)
    )


def _with_internal(mechanical: tuple, parts: list[tuple], number: int, own: Any) -> tuple:
    """All states, with other internal states of one law."""
    parts = [*parts[:number], tuple(own), *parts[number + 1 :]]
    return (*mechanical, *(value for part in (*parts[1:], parts[0]) for value in part))
