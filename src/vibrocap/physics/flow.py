"""The equations of a system at one instant: where machine, laws, drive and environment meet."""

import dataclasses
from typing import Any

from vibrocap.physics.contacts import Contact, ContactForce, Contacts, Rows
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Imposed, Machine

CONTACT_CHANNELS = ("contact_sliding", "bristle_loss", "contact_storage")  # of energy

# Where equations with a load that follows the motion cease to hold: the load vanishes, or no longer follows from the
# balance of forces, as friction and load raise one another without end (Painleve 1895).
BOUNDS = ("paradox", "lift_off", "lift_off", "stop_reached", "ambiguous_contacts")
LOCATED = (False, True, False, True, False)  # whether it is a located event, or is looked at where a step starts


@dataclasses.dataclass(frozen=True)
class Flow:
    """Everything that the equations say at one instant, as numbers or as recorded expressions."""

    rates: tuple  # y', one per state
    drive: Any  # what the machine feels
    command: Any  # the same before an actuator
    contact_velocity: Any
    friction: Any  # friction force R
    sliding_friction: Any  # R where the contact slides
    taken: Any  # by the machine in the place of friction: R less what pushes its body from outside
    outer_force: Any  # along the line of sliding, other than friction
    holding_force: Any  # R that would keep a resting contact at rest
    holding_middle: Any  # of the forces that the contact can hold at rest
    holding_limit: Any  # how far they reach from their middle; None where the law is not set-valued
    switches: tuple  # guards of the branches of the law, then of the machine, positive within the present ones
    law_switches: int  # how many of them are the laws'
    after_switch: tuple  # all states after each switch
    after_reversal: tuple  # of each contact: all states after it has turned to its side
    powers: tuple  # one per channel, positive into the system
    energy: Any  # of the machine
    contact_energy: Any  # stored in the contact
    bounds: tuple  # positive while the equations hold: those of a load that follows the motion, then the machine's
    bound_kinds: tuple  # place in BOUNDS of each of them
    loads: tuple  # normal load of the contact while it slips, and at rest; none with a constant load
    reaction: tuple | None  # of contacts that act on one another, that of the first: (b, n, s) of b N = n + s R
    quotients: tuple  # of contacts that act on one another: their divisors are among the bounds
    further: tuple[ContactForce, ...]  # what acts at the further contacts
    rows: Rows | None  # the problem of several contacts, which decides which of them rest
    contacts: tuple[Contact, ...]  # all of them


def _internal(system: Any, y) -> list[tuple]:
    """The internal states of the law of each contact, the first contact first; they stand last."""
    found, end = [], len(y)
    for law in (system.friction, *reversed(system.further_laws)):
        found.append(tuple(y[end - len(law.internal) : end]))
        end -= len(law.internal)
    return [found[0], *reversed(found[1:])]


def _further_contacts(system: Any, t, y, mechanical, sides) -> list[Contact]:
    """The further contacts in their modes."""
    found, velocities = [], system.placed.further_velocities(t, mechanical)
    loads, internals, ground = system.law_loads[1:], _internal(system, y)[1:], system.placed.ground_speed()
    for i, (law, load, velocity, own) in enumerate(zip(system.further_laws, loads, velocities, internals, strict=True)):
        side = sides[1 + i]
        force, rates = law.force(velocity, own, side, load)
        drag, push, push_at_rest = None, 0.0, 0.0
        if system.environment is not None:
            drag = system.environment.drag(velocity + ground, side)
            push, push_at_rest = -drag, -(system.environment.linear_drag * ground)
        found.append(Contact(2 + i, law, load, velocity, own, side, force, rates, push, push_at_rest, drag))
    return found


def flow_of(system: Any, t, y, side) -> Flow:
    """The equations at time t and state y, sliding to `side` (+1, -1) or stuck (0, set-valued laws only).

    side: of several contacts a tuple, one for each, or one for all
    """
    machine, law, load = system.placed, system.friction, system.law_load
    mechanical, several = y[: len(machine.states)], bool(system.machine.contacts)
    sides = side if isinstance(side, tuple) else (side,) * (1 + len(system.machine.contacts))
    side, internal = sides[0], _internal(system, y)[0]
    sticks = law.kind == "set-valued"
    drive = system.drive.value(t)
    velocity = machine.contact_velocity(t, mechanical)
    others = _further_contacts(system, t, y, mechanical, sides) if several else []
    ground = machine.ground_speed()
    lost = sum((-each.drag * (each.velocity + ground) for each in others if each.drag is not None), 0.0)
    outside = None
    if system.environment is not None:
        outside = system.environment.outside(machine, t, mechanical, side, lost if others else None)
    held = None if several else machine.holding_force(t, mechanical, drive)
    force, internal_rates = law.force(velocity, internal, side, load)
    contacts = joint = None
    if several:
        pushes = () if outside is None else (outside.push, outside.push_at_rest)
        first = Contact(1, law, load, velocity, internal, side, force, internal_rates, *pushes)
        contacts = Contacts(machine, (first, *others), t, mechanical, drive)
        held = contacts.held
    hold = held if outside is None else held + outside.push_at_rest
    sliding_loss, bristle_loss = law.losses(velocity, internal, side, load)
    slipping = side * side if sticks else 1.0
    limit = law.holding_limit(load) if sticks else None
    middle = law.holding_middle(load)
    bounds = loads = ()
    if machine.follows_load:
        joint = None if contacts is None else contacts.reaction()
        inertia, own, slope = machine.reaction(t, mechanical, drive) if joint is None else joint
        clear = inertia - slope * force
        moved = own if outside is None else own - slope * outside.push
        moving, at_rest = loads = moved / clear, (own + slope * held) / inertia
        bounds = clear, moving
        force, sliding_loss, bristle_loss = force * moving, sliding_loss * moving, bristle_loss * moving
        if limit is not None:
            jams = (inertia - slope * (middle - limit)) * (inertia - slope * (middle + limit))
            resting = 1.0 - slipping
            bounds = (
                slipping * clear
                + resting * (0.5 * (moved + jams + sqrt((moved - jams) * (moved - jams)))),  # the larger
                slipping * moving + resting,
                slipping + resting * moved,
            )
            limit, middle = limit * at_rest, middle * at_rest
    sliding_friction = force
    taken = force if outside is None else force - outside.push
    if sticks:
        force = hold + slipping * (force - hold)
        taken = held + slipping * (taken - held)  # exactly `held` at rest
        sliding_loss = slipping * sliding_loss
    contact = -sliding_loss, -bristle_loss
    stored = law.stored_energy(internal)
    if system.stores_under_load:
        contact, stored = (*contact, sliding_loss + bristle_loss - force * velocity), 0.0
    further = () if contacts is None else contacts.forces(taken)
    taken_further = tuple(each.taken for each in further)
    switches, outcomes, law_switches = _switches(system, t, y, sides, velocity, others, (drive, taken, *taken_further))
    # A drive that imposes a motion works against all that acts on the body from outside.
    against_all = isinstance(system.machine, Imposed) or system.machine.coupled
    worked_against = [force, *(each.friction for each in further)]
    if against_all:
        worked_against = [taken, *taken_further]
    rates = machine.rates(t, mechanical, drive, taken, *taken_further)
    if system.machine.coupled == "motion":
        rates = _still(system, rates, sides)
    ends, kinds = machine.bounds(t, mechanical), machine.bound_kinds
    own_kinds = (0, 1, 2)
    if contacts is not None:  # a contact among others: what is a paradox alone leaves them without one answer
        own_kinds = (BOUNDS.index("ambiguous_contacts"), 1, 2)
        more, more_kinds = contacts.bounds([each.normal for each in further])
        ends, kinds = (*ends, *more), (*kinds[: len(ends)], *more_kinds)
    outer_force = machine.outer_force(t, mechanical, drive)
    for each in taken_further:
        outer_force = outer_force - each
    if type(system.machine).wall_force is not Machine.wall_force:
        outer_force = outer_force + machine.wall_force(t, mechanical, drive, taken)
    if outside is not None:
        rates = tuple(rate + more for rate, more in zip(rates, outside.accelerations, strict=True))
        outer_force = outer_force + outside.total
    energy = machine.energy(t, mechanical)
    if not machine.follows_load:
        for each in others:
            energy = energy + each.law.stored_energy(each.internal) if each.law.internal else energy
    return Flow(
        rates=(*rates, *(rate for each in others for rate in each.internal_rates), *internal_rates),
        drive=drive if system.actuator is None else machine.output(mechanical),
        command=drive,
        contact_velocity=velocity,
        friction=force,
        sliding_friction=sliding_friction,
        taken=taken,
        outer_force=outer_force,
        holding_force=hold,
        holding_middle=middle,
        holding_limit=limit,
        switches=switches,
        law_switches=law_switches,
        after_switch=outcomes,
        after_reversal=_after_reversals(system, y, sides),
        powers=(
            *machine.powers(t, mechanical, drive, *worked_against),
            *_further_powers(system, further),
            *(() if outside is None else outside.powers),
            *contact,
        ),
        energy=energy,
        contact_energy=stored,
        bounds=(*bounds, *ends),
        bound_kinds=(*own_kinds[: len(bounds)], *(BOUNDS.index(kind) for kind in kinds[: len(ends)])),
        loads=loads,
        reaction=joint,
        quotients=() if contacts is None else contacts.quotients,
        further=further,
        rows=None if contacts is None else contacts.rows(),
        contacts=() if contacts is None else contacts.all,
    )


def _still(system: Any, rates: tuple, sides: tuple) -> tuple:
    """Rates that are exactly zero of the velocities of contacts at rest, whose forces follow from one problem."""
    names = (system.machine.contact_state, *system.machine.contacts)
    moves = {
        name: side * side for name, side, law in zip(names, sides, system.laws, strict=True) if law.kind == "set-valued"
    }
    return tuple(moves.get(name, 1.0) * rate for name, rate in zip(system.placed.states, rates, strict=True))


def _further_powers(system: Any, further: tuple[ContactForce, ...]) -> tuple:
    """Powers lost at the further contacts; then, under loads that follow the motion, what they store."""
    lost, stored = [], []
    for each in further:
        sliding, bristles = each.losses
        lost += [-sliding, *((-bristles,) if each.contact.law.internal else ())]
        if each.contact.law.internal and system.machine.follows_load:
            stored.append(sliding + bristles - each.friction * each.contact.velocity)
    return (*lost, *stored)


def _switches(system: Any, t, y, sides, velocity, others, forces) -> tuple[tuple, tuple, int]:
    """(guards of the pieces of all laws, then of the machine; all states after each of them; how many are laws')."""
    machine, parts = system.placed, _internal(system, y)
    mechanical = tuple(y[: len(machine.states)])
    asked = [(system.friction, velocity, parts[0], sides[0], system.law_load)]
    asked += [(each.law, each.velocity, each.internal, each.side, each.load) for each in others]
    guards, outcomes = [], []
    for i, (law, *at) in enumerate(asked):
        own = law.switches(*at)
        guards += own
        for which in range(len(own)):
            outcomes.append(_with_internal(mechanical, parts, i, law.after_switch(which, *at)))
    count, (drive, *taken) = len(guards), forces
    own = machine.switches(t, mechanical, drive, *taken)
    for which in range(len(own)):
        after = machine.after_switch(which, t, mechanical, drive, *taken)
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
