"""Several contacts of one machine: what friction does to each of them, whatever rests and whatever slides.

The velocities v of the contacts and their normal loads N depend on all friction forces R, as mechanics makes them, to
the first degree:

    v' = a = b - A R,     N = n - C R     (C is none where loads are constants)

A *mode* says of each contact whether it rests (side 0) or slides forward or back (+1, -1). The forces of a mode solve
one linear problem, in which a row stands for each contact, with s its side, rho its friction per load and d its drag:

    rests     (A R)_i = b_i                 slides     R_i + rho_i (C R)_i = rho_i n_i + d_i

Which mode holds is decided by the kernel, see `numerics/kernel/events/decision.py`; here are the forces that follow.
Rows are chosen by s^2, which is exactly 0 or 1, so that the equations are recorded once for all modes. Three forms of A
are known, each with the least work:

    independent   each contact is on a body of its own: A is diagonal, and the machine gives the force that holds each
    coupled       friction at one accelerates the others, or loads them (`Coupling`): one elimination
    distances     those between the contacts are imposed, so that all share one coordinate and A has rank one: those
                  that rest together hold one force, and how they share it is open, though the motion is not. Each is
                  shown the same share of its limit (as any other share would do, this one has the least distance from
                  the middles of what they can hold, over their widths)
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.friction.law import Law

# Shares of contacts that can hold nothing: what is added to widths so that no share is 0/0.
LEAST = 1e-150


@dataclasses.dataclass(frozen=True)
class Interval:
    """Friction forces that a contact can hold, or is left to hold once it has given way; per load where that follows
    the motion."""

    least: Any
    most: Any


@dataclasses.dataclass(frozen=True)
class Contact:
    """One contact at one instant, in the mode that its side says.

    number: 1 for the first; load: that its law is given; force: friction while it slides, per load where loads follow
    the motion; push: from outside on its body, along the line, while it slides and while it rests
    """

    number: int
    law: Law
    load: Any
    velocity: Any
    internal: tuple
    side: Any
    force: Any
    internal_rates: tuple
    push: Any = 0.0
    push_at_rest: Any = 0.0
    drag: Any = None

    @property
    def sticks(self) -> bool:
        """Whether it can rest."""
        return self.law.kind == "set-valued"

    @property
    def slips(self):
        """1 where it slides, 0 where it rests."""
        return self.side * self.side if self.sticks else 1.0

    @property
    def limit(self):
        """How far the forces reach that it can hold at rest."""
        return self.law.holding_limit(self.load)

    @property
    def middle(self):
        """Their middle."""
        return self.law.holding_middle(self.load)

    @property
    def static(self) -> Interval:
        """What it can hold at rest."""
        return Interval(self.middle - self.limit, self.middle + self.limit)

    @property
    def kinetic(self) -> Interval:
        """Between the forces of the slowest slides back and forward, which it can hold (`Law.holding_limit`)."""
        back, forward = (self.law.force(0.0, self.internal, side, self.load)[0] for side in (-1.0, 1.0))
        return Interval(back, forward)

    def losses(self) -> tuple:
        """(power lost by sliding, by bristles), per load where that follows the motion."""
        return self.law.losses(self.velocity, self.internal, self.side, self.load)


@dataclasses.dataclass(frozen=True)
class ContactForce:
    """What acts at one further contact.

    taken: by the machine in the place of friction, which it is less the push from outside; friction: R itself
    hold: R that would hold it, over the middle of what it can hold; limit: how far that reaches; None: it cannot rest
    normal: its load over the one that its law is given
    """

    contact: Contact
    taken: Any
    friction: Any
    hold: Any
    limit: Any
    normal: Any

    @property
    def losses(self) -> tuple:
        """(power lost by sliding, by bristles); a contact at rest does not slide."""
        sliding, bristles = (loss * self.normal for loss in self.contact.losses())
        return (self.contact.slips * sliding if self.contact.sticks else sliding), bristles


@dataclasses.dataclass(frozen=True)
class Rows:
    """The problem of all contacts at one instant, for a decision: see the head of this file.

    b, A: accelerations free of friction and the response to it, of independent contacts over that to their own
    n, C: loads and their response to friction; none where they are constants. All forces count as `taken`
    """

    b: tuple
    A: tuple[tuple, ...]
    n: tuple = ()
    C: tuple[tuple, ...] = ()


class Contacts:
    """The contacts of a machine at one instant, in the mode that their sides say.

    Asked in this order: the force that would hold the first one, `held`, given the modes of the others; then, with what
    the machine is given in the place of the friction at the first, those of the others.
    """

    def __init__(self, machine: Any, contacts: Sequence[Contact], t: Any, y: tuple, drive: Any):
        self.machine, self.first, self.others = machine, contacts[0], tuple(contacts[1:])
        self.coupling: Any = machine.coupling(t, y, drive) if machine.coupled else None
        self.holding = () if machine.coupled else machine.further_holding_forces(t, y, drive)
        self._own_hold = None if machine.coupled else machine.holding_force(t, y, drive)
        self.quotients: tuple = ()
        self._sums: tuple = ()
        if machine.coupled == "motion":
            self._solve()

    @property
    def all(self) -> tuple[Contact, ...]:
        """The first one before the others."""
        return (self.first, *self.others)

    # --- coupled: one elimination, the first contact last ----------------------------------------------------------

    def _solve(self) -> None:
        """Forces at the others as alpha - beta f, f: what the machine is given for the first."""
        given, rows, right, by_first = self.coupling, [], [], []
        for j, each in enumerate(self.others, start=1):
            slips, rests = each.slips, 1.0 - each.slips
            raised = None if given.load_response is None else given.load_response[j]
            slide_to = each.force if raised is None else each.force * given.loads[j]
            row = []
            for k in range(1, len(given.free)):
                slide = 1.0 if k == j else 0.0
                slide = slide if raised is None else slide + each.force * raised[k]
                row.append(rests * given.response[j][k] + slips * slide)
            rows.append(row)
            right.append(rests * given.free[j] + slips * (slide_to - each.push))
            by_first.append(
                rests * given.response[j][0] + (0.0 if raised is None else slips * (each.force * raised[0]))
            )
        (self._alpha, self._beta), quotients = eliminated(rows, [right, by_first])
        self.quotients = (*quotients, self.held)

    @property
    def held(self):
        """What the machine is given for the first contact where that rests."""
        if self._own_hold is not None:
            return self._own_hold
        if self.machine.coupled == "distances":
            return self._shared(0)
        given, first = self.coupling, self.coupling.response[0]
        held = given.free[0] - sum(a * r for a, r in zip(first[1:], self._alpha, strict=True))
        return held / (first[0] - sum(a * r for a, r in zip(first[1:], self._beta, strict=True)))

    def reaction(self) -> tuple | None:
        """(1, n, s) of the load of the first contact, N = n + s f; None: as the machine says."""
        given = self.coupling
        if given is None or given.load_response is None:
            return None
        row = given.load_response[0]
        own = given.loads[0] - sum(c * r for c, r in zip(row[1:], self._alpha, strict=True))
        return 1.0, own, sum(c * r for c, r in zip(row[1:], self._beta, strict=True)) - row[0]

    # --- distances: all that rest hold one force -------------------------------------------------------------------

    def _shared(self, at: int):
        """What one contact takes where it rests: its share of what must be held by those that rest."""
        given, each = self.coupling, self.all[at]
        if not each.sticks:
            return 0.0
        if not self._sums:
            held = width = 0.0
            for other in self.all:
                held = held + _own_share(other)
                width = width + (1.0 - other.slips) * (other.limit + LEAST if other.sticks else 0.0)
            self._sums = held, width
        held, width = self._sums
        middle, own = each.middle - each.push_at_rest, each.limit + LEAST
        total = given.free[at] / given.response[at][at] - (held - _own_share(each)) - middle
        return middle + total * (own / (width + each.slips * own))

    # --- what acts at the others ------------------------------------------------------------------------------------

    def forces(self, taken_first: Any) -> tuple[ContactForce, ...]:
        """Of the others, given what the machine takes for the first."""
        given: Any = self.coupling
        found, follows = [], self.machine.follows_load
        solved = []
        if self.machine.coupled == "motion":
            solved = [a - b * taken_first for a, b in zip(self._alpha, self._beta, strict=True)]
        for j, each in enumerate(self.others, start=1):
            normal: Any = 1.0
            slides = each.force if _none(each.push) else each.force - each.push
            if self.machine.coupled == "motion":
                taken = held = solved[j - 1]
            else:
                held = self.holding[j - 1] if not self.machine.coupled else self._shared(j)
                taken = held + each.slips * (slides - held) if each.sticks else slides
            if follows:
                row, forces = given.load_response[j], (taken_first, *solved)
                normal = given.loads[j] - sum(c * r for c, r in zip(row, forces, strict=True))
            push = each.push
            if each.sticks:
                push = each.push_at_rest + each.slips * (each.push - each.push_at_rest)
            friction = taken if _none(push) else taken + push
            hold = limit = None
            if each.sticks:
                rests = held if _none(each.push_at_rest) else held + each.push_at_rest
                hold, limit = rests - each.middle * normal, each.limit * normal
            found.append(ContactForce(each, taken, friction, hold, limit, normal))
        return tuple(found)

    def rows(self) -> Rows:
        """The problem that decides which of them rest."""
        given, n = self.coupling, 1 + len(self.others)
        if given is None:
            return Rows((self._own_hold, *self.holding), tuple(_unit(i, n) for i in range(n)))
        if self.machine.coupled == "distances":
            ones = tuple((1.0,) * n for _ in range(n))
            return Rows(
                tuple(b / row[i] for i, (b, row) in enumerate(zip(given.free, given.response, strict=True))), ones
            )
        if given.load_response is None:
            return Rows(given.free, given.response)
        return Rows(given.free, given.response, given.loads, given.load_response)

    def bounds(self, loads: Sequence[Any]) -> tuple[tuple, tuple[str, ...]]:
        """What is positive while the way to go on is certain: loads of the others, determinants of all modes.

        Of each mode that is within reach, from rest at the largest forces that can be held; there is one way to go on
        from rest for every b if and only if all have one sign (Samelson, Thrall and Wesler 1958; Cottle, Pang and Stone
        1992, ch. 3; for contacts Loetstedt 1981, Pfeiffer and Glocker 1996). Of constant loads they are principal
        minors of A, which is positive definite: always. Returns (bounds, kinds).
        """
        given, n, ways = self.coupling, 1 + len(self.others), []
        if given is None or given.load_response is None:
            return (), ()
        for i, each in enumerate(self.all):
            unit, raised = _unit(i, n), given.load_response[i]
            forces, rows = [each.force], []
            if each.sticks:
                forces = [each.middle + each.limit, each.middle - each.limit]
            for at_rest in forces:
                level = at_rest + each.slips * (each.force - at_rest)
                rows.append([slide + level * more for slide, more in zip(unit, raised, strict=True)])
            if each.sticks:
                still = [entry / given.response[i][i] for entry in given.response[i]]
                rows.append([s + each.slips * (r - s) for s, r in zip(still, rows[0], strict=True)])
            ways.append(rows)
        found = tuple(determinant(rows) for rows in itertools.product(*ways))
        return (*loads, *found), ("lift_off",) * len(loads) + ("ambiguous_contacts",) * len(found)


def _own_share(each: Contact):
    """What a contact at imposed distances takes of all that is held: its friction, or its middle at rest."""
    slides = each.force - each.push
    return slides + (1.0 - each.slips) * (each.middle - each.push_at_rest - slides) if each.sticks else slides


def _none(push: Any) -> bool:
    """Whether nothing pushes from outside."""
    return isinstance(push, float) and push == 0.0


def _unit(i: int, n: int) -> tuple[float, ...]:
    return tuple(1.0 if k == i else 0.0 for k in range(n))


def eliminated(rows: Sequence[Sequence], columns: Sequence[Sequence]) -> tuple[list[list], list]:
    """(solutions of a linear problem for several right-hand sides, all quotients), by elimination in order.

    The pivots are ratios of leading minors, which are positive where there is one way to go on.
    """
    n = len(rows)
    work = [[*row, *(column[i] for column in columns)] for i, row in enumerate(rows)]
    quotients: list = []
    for i, j in itertools.combinations(range(n), 2):
        factor = work[j][i] / work[i][i]
        quotients.append(factor)
        work[j] = [*([0.0] * (i + 1)), *(work[j][k] - factor * work[i][k] for k in range(i + 1, len(work[j])))]
    found: list[list] = []
    for column in range(n, n + len(columns)):
        values: list = [0.0] * n
        for i in reversed(range(n)):
            rest = work[i][column]
            for k in range(i + 1, n):
                rest = rest - work[i][k] * values[k]
            values[i] = rest / work[i][i]
        found.append(values)
        quotients += values
    return found, quotients


def determinant(rows: Sequence[Sequence]):
    """By its first row; for the two or three contacts of a machine."""
    if len(rows) == 1:
        return rows[0][0]
    found = 0.0
    for k, entry in enumerate(rows[0]):
        minor = [[*row[:k], *row[k + 1 :]] for row in rows[1:]]
        term = entry * determinant(minor)
        found = found + term if k % 2 == 0 else found - term
    return found
