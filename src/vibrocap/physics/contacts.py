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
    coupled       friction at one accelerates the others, or loads them (`Contact.response`): one elimination
    distances     those between the contacts are imposed, so that all share one coordinate and A has rank one: those
                  that rest together hold one force, and how they share it is open, though the motion is not. Each is
                  shown the same share of its limit (as any other share would do, this one has the least distance from
                  the middles of what they can hold, over their widths)
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.events import AMBIGUOUS, BOUNDS
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Contact

# Shares of contacts that can hold nothing: what is added to widths so that no share is 0/0.
LEAST = 1e-150
_PARADOX, _LIFT_OFF, _AT_REST, _AMBIGUOUS = 0, 1, 2, BOUNDS.index(AMBIGUOUS)  # places in BOUNDS


@dataclasses.dataclass(frozen=True)
class RubbingContact:
    """One contact of a machine with its law at one instant, in the mode that its side says.

    given: what the machine says of it; load: that its law is given; force: friction while it slides, and losses: power
    lost by sliding and by bristles, per load where loads follow the motion; push: from outside on its body, along the
    line, while it slides and while it rests
    """

    given: Contact
    law: Law
    load: Any
    internal: tuple
    side: Any
    force: Any
    internal_rates: tuple
    losses: tuple
    push: Any = 0.0
    push_at_rest: Any = 0.0

    @property
    def velocity(self) -> Any:
        """Its sliding velocity."""
        return self.given.velocity

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
        return self.law.holding_centre(self.load)

    @property
    def reach(self) -> tuple:
        """Least and most that it can hold at rest, then the forces of the slowest slides back and forward, which it can
        hold once it has given way (`Law.holding_limit`)."""
        slowest = (self.law.force(0.0, self.internal, side, self.load)[0] for side in (-1.0, 1.0))
        return (self.middle - self.limit, self.middle + self.limit, *slowest)


@dataclasses.dataclass(frozen=True)
class ContactForce:
    """What acts at one contact.

    tangential: the force at the machine, friction less the push from outside; friction: R itself
    held: R that would hold it in the present modes of all others
    middle, limit: of what it could hold then, and how far that reaches; None: it cannot rest
    resting: the same three as they are solved where it does rest
    normal: its load over the one that its law is given; clear: positive while one force holds as it slides
    alone: (what the machine takes where it rests, its load then) of a contact that is solved by itself once all others
    are, the load None where it is given
    """

    contact: RubbingContact
    tangential: Any
    friction: Any
    held: Any
    middle: Any
    limit: Any
    resting: tuple[Any, Any, Any]
    normal: Any
    alone: tuple[Any, Any] = (None, None)
    clear: Any = 1.0

    @property
    def sliding(self) -> Any:
        """R while it slides."""
        return self.contact.force * self.normal

    @property
    def hold(self) -> Any:
        """R where it rests, over the middle of what it can hold; None: it cannot rest."""
        held, middle, limit = self.resting
        return None if limit is None else held - middle

    @property
    def losses(self) -> tuple:
        """(power lost by sliding, by bristles); a contact at rest does not slide."""
        sliding, bristles = (loss * self.normal for loss in self.contact.losses)
        return (self.contact.slips * sliding if self.contact.sticks else sliding), bristles


@dataclasses.dataclass(frozen=True)
class Rows:
    """The problem of all contacts at one instant, for a decision: see the head of this file.

    b, A: accelerations free of friction and the response to it, of independent contacts over that to their own
    n, C: loads and their response to friction; none where they are constants. All forces count as `tangential`
    """

    b: tuple
    A: tuple[tuple, ...]
    n: tuple = ()
    C: tuple[tuple, ...] = ()


class Contacts:
    """The contacts of a machine at one instant, in the mode that their sides say.

    acting: what acts at each; bounds, bound_kinds: what is positive while the way to go on is certain
    loads: normal load of a contact that answers to its own friction, while it slips and at rest; none of constant loads
    quotients: of contacts that act on one another: their divisors are among the bounds
    """

    def __init__(self, machine: Any, contacts: Sequence[RubbingContact]):
        self.all, self.others = tuple(contacts), tuple(contacts[1:])
        self.given, self.follows_load = [each.given for each in contacts], machine.follows_load
        self.shared = machine.imposes_distances
        self.coupled = any(each.response for each in self.given) and not self.shared
        self.bounds: tuple = ()
        self.bound_kinds: tuple[int, ...] = ()
        self.loads: tuple = ()
        self.mean_loads: tuple = ()
        self.load_response: tuple[tuple, ...] = ()
        self.quotients: tuple = ()
        self._sums: tuple = ()
        if self.coupled and self.follows_load:
            rows: list[Any] = [each.reaction for each in self.given]
            self.mean_loads = tuple(own / over for over, own, *_ in rows)
            self.load_response = tuple(tuple(-(raised / over) for raised in more) for over, _, *more in rows)
        if self.coupled:
            self.acting = self._solved()
        else:
            holding = range(len(self.all)) if self.shared else [each.holding_force for each in self.given]
            self.acting = tuple(
                self._alone(each, self._share(held) if self.shared else held, each.given.reaction)
                for each, held in zip(self.all, holding, strict=True)
            )

    # --- each by itself --------------------------------------------------------------------------------------------

    def _alone(self, each: RubbingContact, held: Any, reaction: Sequence[Any] | None) -> ContactForce:
        """What acts at a contact, given what the machine takes where it rests, and (b, n, s) of b N = n + s f."""
        force, middle, limit, normal, at_rest, clear = each.force, None, None, 1.0, None, 1.0
        if each.sticks:
            middle, limit = each.middle, each.limit
        if self.follows_load:
            assert reaction is not None
            inertia, own, slope = reaction
            clear, moved = inertia - slope * force, own - slope * each.push
            normal, at_rest = self.loads = moved / clear, (own + slope * held) / inertia
            bounds = clear, normal
            if limit is not None:
                jams = (inertia - slope * (middle - limit)) * (inertia - slope * (middle + limit))
                resting = 1.0 - each.slips
                bounds = (
                    each.slips * clear
                    + resting * (0.5 * (moved + jams + sqrt((moved - jams) * (moved - jams)))),  # the larger
                    each.slips * normal + resting,
                    each.slips + resting * moved,
                )
                limit, middle = limit * at_rest, middle * at_rest
            self.bounds += bounds
            self.bound_kinds += (_PARADOX, _LIFT_OFF, _AT_REST)[: len(bounds)]
        friction, hold = force * normal, held + each.push_at_rest
        tangential = friction - each.push
        if each.sticks:
            friction = hold + each.slips * (friction - hold)
            tangential = held + each.slips * (tangential - held)  # exactly `held` at rest
        return ContactForce(
            each, tangential, friction, hold, middle, limit, (hold, middle, limit), normal, (held, at_rest), clear
        )

    # --- coupled: one elimination, the last contact left is then by itself ------------------------------------------

    def _solved(self) -> tuple[ContactForce, ...]:
        """All forces: all but one contact are eliminated, which is then by itself."""
        held, alpha, beta, quotients = self._left(0)
        self.quotients = (*quotients, held)
        reaction = None
        if self.mean_loads:
            row = self.load_response[0]
            own = self.mean_loads[0] - sum(c * r for c, r in zip(row[1:], alpha, strict=True))
            reaction = 1.0, own, sum(c * r for c, r in zip(row[1:], beta, strict=True)) - row[0]
        last = self._alone(self.all[0], held, reaction)
        forces = last.tangential, *(a - b * last.tangential for a, b in zip(alpha, beta, strict=True))
        found = [last]
        for each, force, j in zip(self.others, forces[1:], range(1, len(self.all)), strict=True):
            normal: Any = 1.0
            if self.mean_loads:
                normal = self._load(j, forces)
            held, at_rest = self._by_itself(j)
            push, would, resting = each.push, held + each.push_at_rest, force + each.push_at_rest
            middle, limit, solved = None, None, (resting, None, None)
            if each.sticks:
                push = each.push_at_rest + each.slips * (each.push - each.push_at_rest)
                middle, limit = each.middle * at_rest, each.limit * at_rest
                solved = resting, each.middle * normal, each.limit * normal
            found.append(ContactForce(each, force, force + push, would, middle, limit, solved, normal))
        if self.mean_loads and self.others:
            # A contact among others: what is a paradox alone leaves them without one answer.
            more, kinds = self._modes([each.normal for each in found[1:]])
            self.bounds, self.bound_kinds = (*self.bounds, *more), (_AMBIGUOUS, *self.bound_kinds[1:], *kinds)
        return tuple(found)

    def _by_itself(self, at: int) -> tuple[Any, Any]:
        """(what the machine takes of a contact that would rest, its load then over the one that its law is given)."""
        held, alpha, beta, _ = self._left(at)
        if not self.mean_loads:
            return held, 1.0
        forces = [a - b * held for a, b in zip(alpha, beta, strict=True)]
        forces.insert(at, held)
        return held, self._load(at, forces)

    def _load(self, at: int, forces: Sequence[Any]) -> Any:
        """The load of a contact under all forces."""
        return self.mean_loads[at] - sum(c * r for c, r in zip(self.load_response[at], forces, strict=True))

    def _left(self, at: int) -> tuple[Any, list, list, list]:
        """(what the machine takes of a contact that would rest; alpha, beta; quotients): the forces at all others are
        alpha - beta f, f that at this one.
        """
        rows, right, by_this = [], [], []
        others = [k for k in range(len(self.all)) if k != at]
        for j in others:
            each = self.all[j]
            slips, rests = each.slips, 1.0 - each.slips
            raised = self.load_response[j] if self.mean_loads else ()
            slide_to = each.force * self.mean_loads[j] if raised else each.force
            row = []
            for k in others:
                slide = 1.0 if k == j else 0.0
                slide = slide + each.force * raised[k] if raised else slide
                row.append(rests * each.given.response[k] + slips * slide)
            rows.append(row)
            right.append(rests * each.given.acceleration + slips * (slide_to - each.push))
            pressed = slips * (each.force * raised[at]) if raised else 0.0
            by_this.append(rests * each.given.response[at] + pressed)
        (alpha, beta), quotients = eliminated(rows, [right, by_this])
        held: Any = 0.0  # nothing would, where a command cancels the friction of a contact that cannot rest
        if others or self.all[at].sticks:
            response = self.given[at].response
            held = self.given[at].acceleration - sum(response[k] * r for k, r in zip(others, alpha, strict=True))
            held = held / (response[at] - sum(response[k] * r for k, r in zip(others, beta, strict=True)))
        return held, alpha, beta, quotients

    # --- distances: all that rest hold one force -------------------------------------------------------------------

    def _share(self, at: int):
        """What one contact takes where it rests: its share of what must be held by those that rest."""
        each = self.all[at]
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
        total = each.given.acceleration / each.given.response[at] - (held - _own_share(each)) - middle
        return middle + total * (own / (width + each.slips * own))

    def rows(self) -> Rows | None:
        """The problem that decides which of them rest; None where there is one."""
        n = len(self.all)
        if n == 1:
            return None
        if self.shared:
            b = tuple(each.acceleration / each.response[i] for i, each in enumerate(self.given))
            return Rows(b, ((1.0,) * n,) * n)
        if not self.coupled:
            return Rows(tuple(each.holding_force for each in self.given), tuple(_unit(i, n) for i in range(n)))
        b, response = (tuple(getattr(each, name) for each in self.given) for name in ("acceleration", "response"))
        return Rows(b, response, self.mean_loads, self.load_response)

    def _modes(self, loads: Sequence[Any]) -> tuple[tuple, tuple[int, ...]]:
        """What is positive while the way to go on is certain: loads of the others, determinants of all modes.

        Of each mode that is within reach, from rest at the largest forces that can be held; there is one way to go on
        from rest for every b if and only if all have one sign (Samelson, Thrall and Wesler 1958; Cottle, Pang and Stone
        1992, ch. 3; for contacts Loetstedt 1981, Pfeiffer and Glocker 1996). Of constant loads they are principal
        minors of A, which is positive definite: always. Returns (bounds, kinds).
        """
        n, ways = len(self.all), []
        for i, each in enumerate(self.all):
            unit, raised = _unit(i, n), self.load_response[i]
            forces, rows = [each.force], []
            if each.sticks:
                forces = [each.middle + each.limit, each.middle - each.limit]
            for at_rest in forces:
                level = at_rest + each.slips * (each.force - at_rest)
                rows.append([slide + level * more for slide, more in zip(unit, raised, strict=True)])
            if each.sticks:
                still = [entry / each.given.response[i] for entry in each.given.response]
                rows.append([s + each.slips * (r - s) for s, r in zip(still, rows[0], strict=True)])
            ways.append(rows)
        found = tuple(determinant(rows) for rows in itertools.product(*ways))
        return (*loads, *found), (_LIFT_OFF,) * len(loads) + (_AMBIGUOUS,) * len(found)


def _own_share(each: RubbingContact):
    """What a contact at imposed distances takes of all that is held: its friction, or its middle at rest."""
    slides = each.force - each.push
    return slides + (1.0 - each.slips) * (each.middle - each.push_at_rest - slides) if each.sticks else slides


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
