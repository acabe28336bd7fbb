"""Contacts that act on one another: which of them rest is decided together.

Friction at one contact accelerates the others too, or changes their loads (`Coupling`):

    a = b - A R,     N = n - C R

Every contact rests (a_i = 0, |R_i| <= mu_s N_i), or slides to a side s_i (R_i = s_i mu N_i): a mode. Friction follows
from the modes by one linear problem, in which a row stands for each contact,

    rests     (A R)_i = b_i                 slides     R_i + s_i mu (C R)_i = s_i mu n_i

For every b there is exactly one mode of all contacts that goes on from rest if and only if the determinants of these
problems have one sign for all modes; without loads that depend on friction they are the principal minors of A, then a
P-matrix (Samelson, Thrall and Wesler 1958; Cottle, Pang and Stone 1992, ch. 3; for contacts Loetstedt 1981, Pfeiffer
and Glocker 1996). Guards change one contact at a time, without time passing between them; for such matrices that ends
at the one set that holds (Murty 1974). Where a determinant of a mode that is within reach falls to zero, a run ends as
"ambiguous contacts": from there on some forces would leave two ways to go on, or none.

Where the distances between the contacts are imposed (`Machine.coupled` is "distances") all share one coordinate, A has
the rank one, and how contacts that rest together share a force is open, though the motion is not:

- While a distance dwells, two contacts can rest together. They rest while the force that must be held is within what
  all of them can hold; each is shown the same share of its limit. This is a choice: only the sum is known.
- While it does not, at most one of the two can rest. Contact i at rest would let contact j depart to the side of
  b_j - b_i, so j counts with its largest force to that side. Whatever the levels, exactly one set holds then, as the
  sum of all friction falls with the velocity of the one coordinate.

A contact gives way at the largest force that it can hold; only then does its friction fall to that of sliding.
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.contacts import LEAST, FurtherContact, MachineOnContacts
from vibrocap.physics.coupled_contact import (
    AT_REST,
    BEYOND_REST,
    EARLY,
    PUSHED,
    ROUNDING,
    STILL,
    WIDE,
    WITHIN_REST,
    CoupledContact,
    Held,
    ImposedContact,
    Mode,
    above,
    determinant,
    eliminated,
    kinetic,
    sign,
    static,
)
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.friction.law import Law
from vibrocap.physics.states import turns

EVEN = 1e-10  # of the acceleration by all loads: contacts whose accelerations differ by less may rest together


class CoupledContacts(MachineOnContacts):
    """A machine whose contacts act on one another, with the laws of its further contacts, seen as one on the first."""

    def __init__(self, machine: Any, laws: Sequence[Law], environment: Any, first: Law):
        super().__init__(machine, laws, environment)
        if machine.coupled == "distances":
            names = (f"stick_{i}" for i, law in enumerate(laws, start=2) if law.kind == "set-valued")
            self.switch_events = (*self.switch_events, *names)
        self.first, self.side, self.internal, self.push, self.push_at_rest = first, 1.0, (), 0.0, 0.0
        if machine.follows_load:
            kept = (f"contact_storage_{i}" for i, law in enumerate(laws, start=2) if law.internal)
            self.channels = (*self.channels, *kept)

    def seen(self, side, internal, outside) -> "CoupledContacts":
        """The same while the first contact slides to a side, or rests, and something pushes its body from outside."""
        found = object.__new__(type(self))
        vars(found).update(vars(self), side=side, internal=internal)
        if outside is not None:
            found.push, found.push_at_rest = outside.push, outside.push_at_rest
        return found

    @property
    def law_loads(self) -> tuple:
        """The load that the law of each further contact is given: 1 where loads follow the motion."""
        loads = self.machine.further_loads()
        return (1.0,) * len(loads) if self.machine.follows_load else loads

    def scales(self, time=1.0) -> tuple:
        """Natural size of each state."""
        found = list(self.machine.scales(time))
        for law, load in zip(self.laws, self.law_loads, strict=True):
            own = (1.0,) if turns(law, self.environment is not None) else ()
            found += [*own, *law.internal_scales(load)]
        return tuple(found)

    # --- the joint problem --------------------------------------------------------------------------------------------

    def _contacts(self, t, y) -> list[Mode]:
        """Each further contact as it is now."""
        velocities, found = self.machine.further_velocities(t, self._own(y)), []
        for law, load, velocity, place in zip(self.laws, self.law_loads, velocities, self._places, strict=True):
            own = tuple(y[place])
            side, internal = (own[0], own[1:]) if turns(law, self.environment is not None) else (1.0, own)
            force = law.force(velocity, internal, side, load)[0]
            drag = 0.0 if self.environment is None else self.environment.drag(velocity, side)
            slips = side * side if law.kind == "set-valued" else 1.0
            found.append(Mode(law, load, velocity, own, slips, force, drag))
        return found

    def _solved(self, t, y, drive) -> tuple[list, list, list]:
        """(alpha, beta, quotients) of the forces at the further contacts, alpha - beta f.

        f: what the machine is given in the place of the friction at its first contact. Of independent contacts.
        """
        given = self.machine.coupling(t, self._own(y), drive)
        rows, right, by_first = [], [], []
        for j, mode in enumerate(self._contacts(t, y), start=1):
            slips, rests, force, slides = mode.slips, 1.0 - mode.slips, mode.force, mode.force
            raised = None if given.load_response is None else given.load_response[j]
            row = []
            for k in range(1, len(given.free)):
                slide = 1.0 if k == j else 0.0
                if raised is not None:
                    slide = slide + force * raised[k]
                row.append(rests * given.response[j][k] + slips * slide)
            rows.append(row)
            if raised is not None:
                slides = force * given.loads[j]
            if self.environment is not None:
                slides = slides + mode.drag
            right.append(rests * given.free[j] + slips * slides)
            by_first.append(rests * given.response[j][0] + (0.0 if raised is None else slips * (force * raised[0])))
        (alpha, beta), quotients = eliminated(rows, [right, by_first])
        return alpha, beta, quotients

    def quotients(self, t, y, drive) -> list:
        """Whose divisors are watched as bounds: before one of them vanishes they grow without end."""
        if self.machine.coupled == "distances":
            return []
        return [*self._solved(t, y, drive)[2], self.holding_force(t, y, drive)]

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

    def _speed(self, further: int = 0):
        """Natural speed of a further contact; at imposed distances about the largest that there is, with the drive's.

        That of the drive, at three instants, decides how far a contact at rest is from it by rounding.
        """
        machine = self.machine
        if machine.coupled != "distances":
            return machine.scales()[machine.states.index(machine.contacts[further])]
        still, drive, squares = (0.0,) * len(machine.states), machine.imposed, LEAST
        for share in (0.0, 0.125, 0.25):
            t = share * drive.period
            for velocity in (machine.contact_velocity(t, still), *machine.further_velocities(t, still)):
                squares = squares + velocity * velocity
        return WIDE * self._natural_speed + sqrt(squares)

    @property
    def _natural_speed(self):
        machine = self.machine
        return machine.scales(machine.imposed.period)[machine.states.index(machine.contact_state)]

    def _meeting(self, t, y, trigger: int = 0) -> tuple:
        """(whether the first contact slides, further contacts) as they are decided at one instant: all together.

        Those that are at rest to rounding count as at rest, though they may have come from a slide, and so does the
        further contact by number that has just come there.
        """
        size, found = self._speed(), []
        for number, mode in enumerate(self._contacts(t, y), start=2):
            if mode.law.kind == "set-valued":
                moves = above(mode.velocity / size, PUSHED if number == trigger else AT_REST)
                side = sign(mode.velocity)  # where a velocity has jumped, the law knows nothing of the side before
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

    @property
    def _sticks(self) -> bool:
        return self.first.kind == "set-valued"

    def _decided(self, t, y, drive, force, trigger: int = 0) -> dict[int, Any]:
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

    def arriving_force(self, t, y, drive):
        """As `holding_force`, at the instant at which the first contact comes to rest.

        Where others meet it there, far beyond what it can hold or nothing at all, as they are decided together.
        """
        hold = self.holding_force(t, y, drive)
        if self.machine.coupled != "distances" or not self._sticks:
            return hold
        alone, limit, middle = 1.0, *static(self.first, self.machine.load())
        still = self.seen(0.0, self.internal, None)
        still.push, still.push_at_rest = self.push, self.push_at_rest
        for mode in self._meeting(t, y)[1]:
            alone = alone * (mode.slips if mode.law.kind == "set-valued" else 1.0)
        side = still._decided(t, y, drive, 0.0)[1]
        return hold + (1.0 - alone) * (middle + 2.0 * limit * side - self.push_at_rest - hold)

    # --- as a machine on its first contact ----------------------------------------------------------------------------

    def holding_force(self, t, y, drive):
        """Friction force that would keep the first contact at rest, less what pushes its body from outside."""
        if self.machine.coupled == "distances":
            return self._held(t, y, drive, 1).force - self.push_at_rest
        given = self.machine.coupling(t, self._own(y), drive)
        first, (alpha, beta, _) = given.response[0], self._solved(t, y, drive)
        held = given.free[0] - sum(a * r for a, r in zip(first[1:], alpha, strict=True))
        return held / (first[0] - sum(a * r for a, r in zip(first[1:], beta, strict=True)))

    def further(self, t, y, drive, force=0.0) -> tuple[CoupledContact, ...]:
        """The further contacts at one instant; force: in the place of the friction at the first."""
        machine, modes = self.machine, self._contacts(t, y)
        normals, together, taken = [1.0] * len(modes), [0.0] * len(modes), []
        if machine.coupled == "distances":
            for j, mode in enumerate(modes):
                sliding = mode.force + mode.drag
                if mode.law.kind == "set-valued":
                    held = self._held(t, y, drive, 2 + j, force)
                    together[j], sliding = held.together, held.force + mode.slips * (sliding - held.force)
                taken.append(sliding)
        else:
            alpha, beta, _ = self._solved(t, y, drive)
            taken = [a - b * force for a, b in zip(alpha, beta, strict=True)]
            given = machine.coupling(t, self._own(y), drive)
            if given.load_response is not None:
                forces = (force, *taken)
                normals = [
                    load - sum(c * r for c, r in zip(row, forces, strict=True))
                    for load, row in zip(given.loads[1:], given.load_response[1:], strict=True)
                ]
        kind = ImposedContact if machine.coupled == "distances" else CoupledContact
        usual, found = machine.further_loads() if machine.follows_load else [1.0] * len(modes), []
        for j, mode in enumerate(modes):
            own = mode.law, mode.load, mode.velocity, mode.own, taken[j]
            each = kind(2 + j, *own, self._speed(j), self.environment, normals[j], usual[j])
            if isinstance(each, ImposedContact):
                each.together = together[j]
            found.append(each)
        return tuple(found)

    def rates(self, t, y, drive, force) -> tuple:
        """y', with the friction of all contacts; of contacts that rest exactly zero."""
        further = self.further(t, y, drive, force)
        own = list(self.machine.rates(t, self._own(y), drive, force, *(each.taken for each in further)))
        if self.machine.coupled == "motion":
            slipping = self.side * self.side if self.first.kind == "set-valued" else 1.0
            shares = {self.machine.contact_state: slipping}
            for each, name in zip(further, self.machine.contacts, strict=True):
                shares[name] = each.side * each.side if each.sticks else 1.0
            own = [shares.get(name, 1.0) * rate for name, rate in zip(self.machine.states, own, strict=True)]
        return *own, *(rate for each in further for rate in each.rates)

    def switches(self, t, y, drive, force) -> tuple:
        """Guards of the machine, then of each further contact."""
        further = self.further(t, y, drive, force)
        own = self.machine.switches(t, self._own(y), drive, force)
        joins = (each.joins() for each in self._joining(further))
        return *own, *(guard for each in further for guard in each.guards()), *joins

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
        states, decided = list(y), self._decided(t, y, drive, force, each.number)
        others = [1.0 - self.side * self.side] if self._sticks else []
        others += [1.0 - other.side * other.side for other in joining if other is not each]
        alone = 1.0
        for rests in others:
            alone = alone * (1.0 - rests)
        share = each.velocity / each.scale
        # The end of its slide is located on the series, from which the velocity at that instant differs by an error.
        joins = each.together if which >= places[-1] else 0.0
        early = 0.5 + 0.5 * sign(each.side * share - (EARLY + ROUNDING * joins))
        stops = alone * (1.0 - decided[each.number] * decided[each.number]) * (1.0 - early)
        stops = stops * above(share, AT_REST) * (1.0 - above(share, STILL))
        moved = each.velocity * (1.0 - stops)
        if self._sticks:
            # The first contact, which meets it but has not been asked yet, is sent on: just beyond what is rounding
            # to a kernel where it turns, and within it where it comes to rest.
            velocity, turns_to = self.machine.contact_velocity(t, self._own(y)), decided[1]
            waits = self.side * self.side * (1.0 - above(velocity / self._speed(), AT_REST)) * (1.0 - early)
            waits = waits * above(self.side - turns_to, 0.5)
            sent = turns_to * BEYOND_REST - (1.0 - turns_to * turns_to) * self.side * WITHIN_REST
            moved = moved + waits * (sent * self._natural_speed - velocity)
        self._move(states, self.machine.contacts[each.number - 2], each, moved)
        for other in joining:
            side = other.side + (1.0 - early) * (decided[other.number] - other.side)
            states[self._places[other.number - 2]] = (side,)
        return tuple(states)

    def _joining(self, further: Sequence[CoupledContact]) -> list[ImposedContact]:
        """Those that may come to rest together with others."""
        return [each for each in further if isinstance(each, ImposedContact) and each.sticks]

    def outer_force(self, t, y, drive, force=0.0):
        """Force from outside, friction at the further contacts included."""
        found = self.machine.outer_force(t, self._own(y), drive)
        for each in self.further(t, y, drive, force):
            found = found - each.taken
        return found

    def powers(self, t, y, drive, force) -> tuple:
        """Powers of the machine's channels, then of each further contact."""
        further = self.further(t, y, drive, force)
        own = self.machine.powers(t, self._own(y), drive, force, *(each.taken for each in further))
        losses = ((-each.sliding_loss, *((-each.bristle_loss,) if each.law.internal else ())) for each in further)
        lost, kept = [loss for lost in losses for loss in lost], []
        if self.machine.follows_load:
            stored = [each for each in further if each.law.internal]
            kept = [each.sliding_loss + each.bristle_loss - each.friction * each.velocity for each in stored]
        return *own, *lost, *kept

    def energy(self, t, y):
        """Energy of the machine, and what its further contacts store."""
        return self.machine.energy(t, self._own(y)) if self.machine.follows_load else super().energy(t, y)

    def reaction(self, t, y, drive) -> Any:
        """Load of the first contact, with the friction that it makes at the others."""
        given = self.machine.coupling(t, self._own(y), drive)
        if given.load_response is None:
            return self.machine.reaction(t, self._own(y), drive)
        alpha, beta, _ = self._solved(t, y, drive)
        row = given.load_response[0]
        own = given.loads[0] - sum(c * r for c, r in zip(row[1:], alpha, strict=True))
        return 1.0, own, sum(c * r for c, r in zip(row[1:], beta, strict=True)) - row[0]

    def further_bounds(self, t, y, drive, force) -> tuple[tuple, tuple[str, ...]]:
        """What is positive while the way to go on is certain: loads of the further contacts, determinants of all modes.

        Of each mode that is within reach, from rest at the largest forces that can be held. Returns (bounds, kinds).
        """
        machine = self.machine
        if machine.coupled == "distances":
            return (), ()
        given, own, n = machine.coupling(t, self._own(y), drive), self._own(y), 1 + len(self.laws)
        load = 1.0 if machine.follows_load else machine.load()
        velocity = machine.contact_velocity(t, own)
        slips = self.side * self.side if self.first.kind == "set-valued" else 1.0
        contacts = [(self.first, load, slips, self.first.force(velocity, self.internal, self.side, load)[0])]
        contacts += [(mode.law, mode.load, mode.slips, mode.force) for mode in self._contacts(t, y)]
        ways = []
        for i, (law, at, slips, sliding) in enumerate(contacts):
            unit = [1.0 if k == i else 0.0 for k in range(n)]
            forces, rows = [sliding], []
            if law.kind == "set-valued" and given.load_response is not None:
                limit, middle = law.holding_limit(at), law.holding_middle(at)
                forces = [middle + limit, middle - limit]
            for force_at_rest in forces:
                level = force_at_rest + slips * (sliding - force_at_rest)
                raised = (0.0,) * n if given.load_response is None else given.load_response[i]
                rows.append([slide + level * more for slide, more in zip(unit, raised, strict=True)])
            if law.kind == "set-valued":
                still = [each / given.response[i][i] for each in given.response[i]]
                rows.append([s + slips * (r - s) for s, r in zip(still, rows[0], strict=True)])
            ways.append(rows)
        found = tuple(determinant(rows) for rows in itertools.product(*ways))
        loads = () if given.load_response is None else tuple(each.normal for each in self.further(t, y, drive, force))
        return (*loads, *found), ("lift_off",) * len(loads) + ("ambiguous_contacts",) * len(found)

    def vertical_momentum(self, t, y) -> Any:
        """None: the load is one of several."""
        return None

    def _move(self, states: list, name: str, each: FurtherContact, velocity) -> None:
        if self.machine.coupled == "distances":
            place = self.machine.states.index(self.machine.contact_state)
            states[place] = states[place] + (velocity - each.velocity)
        else:
            super()._move(states, name, each, velocity)
