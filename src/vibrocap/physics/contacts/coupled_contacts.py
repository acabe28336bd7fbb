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

A contact gives way at the largest force that it can hold; only then does its friction fall to that of sliding.
Where the distances between the contacts are imposed, all share one coordinate: see `imposed_distances.py`.
"""

import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.contacts.coupled_contact import CoupledContact, Mode, determinant, eliminated
from vibrocap.physics.contacts.machine_on_contacts import MachineOnContacts
from vibrocap.physics.friction.law import Law
from vibrocap.physics.states import turns


class CoupledContacts(MachineOnContacts):
    """A machine whose contacts act on one another, with the laws of its further contacts, seen as one on the first."""

    def __init__(self, machine: Any, laws: Sequence[Law], environment: Any, first: Law):
        super().__init__(machine, laws, environment)
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
        return [*self._solved(t, y, drive)[2], self.holding_force(t, y, drive)]

    # --- as a machine on its first contact ----------------------------------------------------------------------------

    def holding_force(self, t, y, drive):
        """Friction force that would keep the first contact at rest, less what pushes its body from outside."""
        given = self.machine.coupling(t, self._own(y), drive)
        first, (alpha, beta, _) = given.response[0], self._solved(t, y, drive)
        held = given.free[0] - sum(a * r for a, r in zip(first[1:], alpha, strict=True))
        return held / (first[0] - sum(a * r for a, r in zip(first[1:], beta, strict=True)))

    def further(self, t, y, drive, force=0.0) -> tuple[CoupledContact, ...]:
        """The further contacts at one instant; force: in the place of the friction at the first."""
        machine, modes = self.machine, self._contacts(t, y)
        normals = [1.0] * len(modes)
        alpha, beta, _ = self._solved(t, y, drive)
        taken = [a - b * force for a, b in zip(alpha, beta, strict=True)]
        given = machine.coupling(t, self._own(y), drive)
        if given.load_response is not None:
            forces = (force, *taken)
            normals = [
                load - sum(c * r for c, r in zip(row, forces, strict=True))
                for load, row in zip(given.loads[1:], given.load_response[1:], strict=True)
            ]
        usual, found = machine.further_loads() if machine.follows_load else [1.0] * len(modes), []
        for j, mode in enumerate(modes):
            scale = machine.scales()[machine.states.index(machine.contacts[j])]
            own = mode.law, mode.load, mode.velocity, mode.own, taken[j], scale
            found.append(CoupledContact(2 + j, *own, self.environment, normals[j], usual[j]))
        return tuple(found)

    def arriving_force(self, t, y, drive):
        """As `holding_force`, at the instant at which the first contact comes to rest."""
        return self.holding_force(t, y, drive)

    def rates(self, t, y, drive, force) -> tuple:
        """y', with the friction of all contacts; of contacts that rest exactly zero."""
        further = self.further(t, y, drive, force)
        own = list(self.machine.rates(t, self._own(y), drive, force, *(each.taken for each in further)))
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
        return *own, *(guard for each in further for guard in each.guards())

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
