"""Contacts of bodies whose distances are imposed: one coordinate for all, and those that meet decided together.

All contacts share one coordinate where the distances between them are imposed (`Machine.coupled` is "distances"). The
response A of `coupled_contacts.py` has the rank one then, and how contacts that rest together share a force is open,
though the motion is not:

- While a distance dwells, two contacts can rest together. They rest while the force that must be held is within what
  all of them can hold; each is shown the same share of its limit. This is a choice: only the sum is known.
- While it does not, at most one of the two can rest. Contact i at rest would let contact j depart to the side of
  b_j - b_i, so j counts with its largest force to that side. Whatever the levels, exactly one set holds then, as the
  sum of all friction falls with the velocity of the one coordinate.

At an instant at which the distances dwell all bodies have the velocity of the one coordinate. Where that is zero, as of
a worm that is its own mirror image, all contacts come to rest at once, and are decided at once: from the largest forces
that can be held, and if with friction that falls at once one that gives way would turn back, from those of sliding.
The coordinate is not moved then, or contacts that meet would push one another on for ever.

Conditions are written as numbers that are exactly 0 or 1, as the equations are recorded once and know no branches.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.contacts.coupled_contact import CoupledContact, Mode
from vibrocap.physics.contacts.coupled_contacts import CoupledContacts
from vibrocap.physics.contacts.machine_on_contacts import LEAST, FurtherContact
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.friction.law import Law

EVEN = 1e-10  # of the acceleration by all loads: contacts whose accelerations differ by less may rest together
# Speeds, of the speed of a contact at imposed distances: WIDE times about the largest that there is.
WIDE = 16.0
STILL = 1e-11  # so slow a contact that comes to rest is stopped, a faster one has jumped
PUSHED = 1e-9  # from which on a contact that should rest is seen to slide
TOGETHER = 3e-14  # within which a contact joins one at rest; more than what follows
EARLY = 64.0 * 2.0**-52  # what guards take for rounding (`law_branches.py`): one that is faster has yet to come to rest
AT_REST = 4.0 * 2.0**-52  # less is rounding, so that all that follows stays within what guards take for it
# Of the natural speed, around what `contact.jumped` takes for rest:
BEYOND_REST, WITHIN_REST = 128.0 * 2.0**-52, 8.0 * 2.0**-52
BEYOND = 1e-12  # of a limit: by so much a force exceeds what can be held


def sign(x):
    """Exactly +1 or -1; 0 of what is far below rounding."""
    return x / sqrt(x * x + LEAST)


def above(x, level):
    """Exactly 1 where abs(x) is above a level, else 0."""
    return 0.5 + 0.5 * sign(x * x - level * level)


def static(law: Law, load) -> tuple:
    """(limit, middle) of the forces that a contact can hold at rest."""
    return law.holding_limit(load), law.holding_middle(load)


def kinetic(law: Law, load) -> tuple:
    """(limit, middle) of the forces between those of the slowest slides forward and back."""
    forward, back = (law.force(0.0, (), side, load)[0] for side in (1.0, -1.0))
    return 0.5 * (forward - back), 0.5 * (forward + back)


@dataclasses.dataclass(frozen=True)
class Held:
    """The force that must be held of one contact at imposed distances, while others can share it.

    middle, limit: of what the contact itself can hold; total: what must be held, over that middle
    weight: the limits of those that rest and keep their distance from it; together: how many these are
    """

    middle: Any
    total: Any
    limit: Any
    weight: Any
    together: Any

    @property
    def force(self):
        """That is shown of the contact: all have the same share of their limit."""
        own = self.limit + LEAST
        return self.middle + self.total * (own / (own + self.weight))

    @property
    def side(self):
        """To which it slides from rest, 0 where it rests: one limit alone decides, whatever the share."""
        most = (self.limit + self.weight) * (1.0 + BEYOND)
        return 0.5 * (sign(self.total - most) + sign(self.total + most))


class ImposedContact(CoupledContact):
    """One whose velocity is not a state of its own, so that it is at rest to rounding, and may jump with the drive.

    together: how many other contacts rest that can rest together with it
    """

    imposed = True

    def __init__(self, *of_any, together):
        super().__init__(*of_any)
        self.together = together

    def joins(self) -> Any:
        """Guard of a contact that slides, though with one at rest that keeps its distance: they rest together."""
        slides = self.side * self.side
        return 1.0 - slides + self.side * self.velocity / self.scale - slides * (TOGETHER * self.together)

    def _push(self):
        share = self.velocity / (PUSHED * self.scale)
        cube = share * share * share
        return cube * cube * cube


class ImposedDistances(CoupledContacts):
    """A machine that imposes the distances of its contacts, with the laws of the further ones, as one on the first."""

    def __init__(self, machine: Any, laws: Sequence[Law], environment: Any, first: Law):
        super().__init__(machine, laws, environment, first)
        names = (f"stick_{i}" for i, law in enumerate(laws, start=2) if law.kind == "set-valued")
        self.switch_events = (*self.switch_events, *names)

    @property
    def _sticks(self) -> bool:
        return self.first.kind == "set-valued"

    @property
    def _natural_speed(self):
        """Of the one coordinate."""
        machine = self.machine
        return machine.scales(machine.imposed.period)[machine.states.index(machine.contact_state)]

    def _speed(self):
        """About the largest speed that there is, with that of the drive at three instants.

        It decides how far a contact at rest is from it by rounding.
        """
        machine, still, drive = self.machine, (0.0,) * len(self.machine.states), self.machine.imposed
        squares = LEAST
        for share in (0.0, 0.125, 0.25):
            t = share * drive.period
            for velocity in (machine.contact_velocity(t, still), *machine.further_velocities(t, still)):
                squares = squares + velocity * velocity
        return WIDE * (8.0 * self._natural_speed + sqrt(squares))

    # --- who rests, and who slides where ------------------------------------------------------------------------------

    def _held(self, t, y, drive, contact: int, force=None, among=None, levels=static) -> Held:
        """What must be held of a contact at imposed distances, and by whom, see the head of this file.

        contact: 1 for the first; force: in the place of the friction at the first, of others
        among: (whether the first slides, further contacts) where that is not as it is now
        levels: (limit, middle) of what a contact at rest can take
        """
        given, machine = self.machine.coupling(t, self._own(y), drive), self.machine
        inertia = 1.0 / given.response[0][0]
        far = EVEN * (machine.load() + sum(machine.further_loads())) / inertia
        at, weight, together = contact - 1, 0.0, 0.0
        slides, modes = (self.side * self.side, self._contacts(t, y)) if among is None else among
        rests = 1.0 - slides if self.first.kind == "set-valued" else 0.0
        others = []
        if contact != 1:
            others.append((0, Mode(self.first, machine.load(), 0.0, (), 1.0 - rests, 0.0 if force is None else force)))
        others += [(j, mode) for j, mode in enumerate(modes, start=1) if j != at]
        law, load = (self.first, machine.load()) if contact == 1 else (self.laws[at - 1], self.law_loads[at - 1])
        limit, middle = levels(law, load) if law.kind == "set-valued" else (1.0, 0.0)
        # What must be held, from outside too where the first contact rests; one that slides was given that force less.
        total = inertia * given.free[at] + (self.push_at_rest if contact == 1 else rests * self.push_at_rest) - middle
        for j, mode in others:
            sliding, resting = mode.force + mode.drag, 1.0 - mode.slips
            if mode.law.kind != "set-valued":
                total = total - sliding
                continue
            ahead = given.free[j] - given.free[at]
            departs = ahead / sqrt(ahead * ahead + far * far)
            most, mean = levels(mode.law, mode.load)
            total = total - (mode.slips * sliding + resting * (mean + departs * most))
            beside = resting * (1.0 - departs * departs)
            weight, together = weight + beside * most, together + beside
        return Held(middle, total, limit, weight, together)

    def _meeting(self, t, y, trigger: int = 0) -> tuple:
        """(whether the first contact slides, further contacts) as they are decided at one instant: all together.

        Those that are at rest to rounding count as at rest, though they may have come from a slide, and so does the
        further contact by number that has just come there.
        """
        size, found = self._speed(), []
        for number, mode in enumerate(self._contacts(t, y), start=2):
            if mode.law.kind == "set-valued":
                moves = above(mode.velocity / size, PUSHED if number == trigger else AT_REST)
                # Its own side as far as guards take either; where the velocity has jumped, the one to which it moves.
                side = mode.own[0]
                side = side + above(mode.velocity / size, EARLY) * (sign(mode.velocity) - side)
                mode = dataclasses.replace(
                    mode,
                    slips=mode.slips * moves,
                    own=(side,),
                    force=mode.law.force(mode.velocity, (), side, mode.load)[0],
                    drag=0.0 if self.environment is None else self.environment.drag(mode.velocity, side),
                )
            found.append(mode)
        velocity = self.machine.contact_velocity(t, self._own(y))
        return (self.side * self.side * above(velocity / size, AT_REST) if self._sticks else 1.0), found

    def decided(self, t, y, drive, force, trigger: int = 0) -> dict[int, Any]:
        """The side of each set-valued contact, by number, at an instant at which some of them come to rest.

        From the largest forces that can be held. Where friction then falls at once to that of sliding, and one that has
        given way would turn back, from that of sliding: which leaves one way to go on, too.
        """
        first, modes = among = self._meeting(t, y, trigger)
        given, machine = self.machine.coupling(t, self._own(y), drive), self.machine
        if self._sticks:  # as in `_meeting`
            velocity = machine.contact_velocity(t, self._own(y))
            force = self.first.force(velocity, (), sign(velocity), machine.load())[0] - self.push
        contacts = [Mode(self.first, machine.load(), 0.0, (self.side,), first, force), *modes]
        firm, sliding, all_slide, turns_back = [], [], 1.0, 0.0
        for number, mode in enumerate(contacts, start=1):
            ways = [mode.own[0] if mode.own else 1.0] * 2
            if mode.law.kind == "set-valued":
                asked = [self._held(t, y, drive, number, force, among, levels).side for levels in (static, kinetic)]
                ways = [mode.slips * ways[0] + (1.0 - mode.slips) * side for side in asked]
                all_slide = all_slide * (ways[0] * ways[0])
            firm.append(ways[0])
            sliding.append(ways[1])
        push = 0.0
        for mode, side in zip(contacts, firm, strict=True):
            taken = mode.force + mode.drag
            if mode.law.kind == "set-valued":
                limit, middle = kinetic(mode.law, mode.load)
                taken = mode.slips * taken + (1.0 - mode.slips) * (middle + side * limit)
            push = push - taken
        push = push + (1.0 - first) * self.push_at_rest
        for mode, side, free in zip(contacts, firm, given.free, strict=True):
            if mode.law.kind == "set-valued":
                ahead = sign(side * (free + given.response[0][0] * push))
                turns_back = turns_back + (1.0 - mode.slips) * 0.5 * (1.0 - ahead)
        falls = all_slide * above(turns_back, 0.25)
        found = {}
        for number, (mode, *ways) in enumerate(zip(contacts, firm, sliding, strict=True), start=1):
            if mode.law.kind == "set-valued":
                found[number] = ways[0] + falls * (ways[1] - ways[0])
        return found

    # --- as a machine on its first contact ----------------------------------------------------------------------------

    def quotients(self, t, y, drive) -> list:
        """None: the one coordinate has a mass."""
        return []

    def further_bounds(self, t, y, drive, force) -> tuple[tuple, tuple[str, ...]]:
        """None: there is always one way to go on."""
        return (), ()

    def holding_force(self, t, y, drive):
        """Friction force that would keep the first contact at rest, less what pushes its body from outside."""
        return self._held(t, y, drive, 1).force - self.push_at_rest

    def arriving_force(self, t, y, drive):
        """As `holding_force`, at the instant at which the first contact comes to rest.

        Where others meet it there, far beyond what it can hold or nothing at all, as they are decided together.
        """
        hold = self.holding_force(t, y, drive)
        if not self._sticks:
            return hold
        alone, limit, middle = 1.0, *static(self.first, self.machine.load())
        still = self.seen(0.0, self.internal, None)
        still.push, still.push_at_rest = self.push, self.push_at_rest
        for mode in self._meeting(t, y)[1]:
            alone = alone * (mode.slips if mode.law.kind == "set-valued" else 1.0)
        side = still.decided(t, y, drive, 0.0)[1]
        return hold + (1.0 - alone) * (middle + 2.0 * limit * side - self.push_at_rest - hold)

    def further(self, t, y, drive, force=0.0) -> tuple[ImposedContact, ...]:
        """The further contacts at one instant; force: in the place of the friction at the first."""
        found = []
        for number, mode in enumerate(self._contacts(t, y), start=2):
            taken, together = mode.force + mode.drag, 0.0
            if mode.law.kind == "set-valued":
                held = self._held(t, y, drive, number, force)
                taken, together = held.force + mode.slips * (taken - held.force), held.together
            # A contact with a force for every velocity may creep, and turns where nothing else happens.
            size = self._speed() if mode.law.kind == "set-valued" else self._natural_speed
            own = mode.law, mode.load, mode.velocity, mode.own, taken, size, self.environment, 1.0, 1.0
            found.append(ImposedContact(number, *own, together=together))
        return tuple(found)

    def rates(self, t, y, drive, force) -> tuple:
        """y', with the friction of all contacts."""
        further = self.further(t, y, drive, force)
        own = self.machine.rates(t, self._own(y), drive, force, *(each.taken for each in further))
        return *own, *(rate for each in further for rate in each.rates)

    def switches(self, t, y, drive, force) -> tuple:
        """Guards of the machine, then of each further contact, then of those that may join others at rest."""
        joining = self._joining(self.further(t, y, drive, force))
        return *super().switches(t, y, drive, force), *(each.joins() for each in joining)

    def after_switch(self, which, t, y, drive, force) -> tuple:
        """All states after guard number `which`."""
        further = self.further(t, y, drive, force)
        joining = self._joining(further)
        first = len(self.machine.switches(t, self._own(y), drive, force))
        places = [first + sum(len(each.guards()) for each in further[:k]) for k in range(len(further) + 1)]
        stops = dict(zip(places, further, strict=False)) | dict(enumerate(joining, start=places[-1]))
        each = stops.get(which)
        if each not in joining:
            return super().after_switch(which, t, y, drive, force)
        states, decided = list(y), self.decided(t, y, drive, force, each.number)
        others = [1.0 - self.side * self.side] if self._sticks else []
        others += [1.0 - other.side * other.side for other in joining if other is not each]
        alone = 1.0
        for rests in others:
            alone = alone * (1.0 - rests)
        share = each.velocity / each.scale
        # The end of its slide is located on the series, from which the velocity at that instant differs by an error.
        joins = each.together if which >= places[-1] else 0.0
        early = 0.5 + 0.5 * sign(each.side * share - (EARLY + TOGETHER * joins))
        turns_to = decided[each.number]
        astray = 0.5 - 0.5 * sign(turns_to * share + EARLY)  # it has gone too far to the side that it is to leave
        stops = alone * (1.0 - turns_to * turns_to * (1.0 - astray)) * (1.0 - early)
        stops = stops * above(share, AT_REST) * (1.0 - above(share, STILL))
        moved = each.velocity * (1.0 - stops)
        if self._sticks:
            # The first contact, which meets it but has not been asked yet, is sent on: just beyond what is rounding
            # to a kernel where it turns, and within it where it comes to rest.
            velocity, turns_to = self.machine.contact_velocity(t, self._own(y)), decided[1]
            waits = self.side * self.side * (1.0 - above(velocity / self._speed(), AT_REST)) * (1.0 - early)
            waits = waits * above(self.side - turns_to, 0.5)
            sent = turns_to * BEYOND_REST - (1.0 - turns_to * turns_to) * self.side * WITHIN_REST
            centre = y[self.machine.states.index(self.machine.contact_state)]
            moved = moved + waits * (sent * (self._natural_speed + centre * sign(centre)) - velocity)
        self._move(states, self.machine.contacts[each.number - 2], each, moved)
        for other in joining:
            side = other.side + (1.0 - early) * (decided[other.number] - other.side)
            states[self._places[other.number - 2]] = (side,)
        return tuple(states)

    def _joining(self, further: Sequence[Any]) -> list[ImposedContact]:
        """Those that may come to rest together with others."""
        return [each for each in further if each.sticks]

    def _move(self, states: list, name: str, each: FurtherContact, velocity) -> None:
        place = self.machine.states.index(self.machine.contact_state)
        states[place] = states[place] + (velocity - each.velocity)
