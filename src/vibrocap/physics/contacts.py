"""Several contacts of one machine: what friction does to each of them, whatever rests and whatever slides.

The velocities v of the contacts and their normal loads N are affine in all friction forces R, as mechanics makes them:

    v' = a = b - A R,     N = n - C R     (C is none where loads are constants)

A *mode* says of each contact whether it rests (side 0) or slides forward or back (+1, -1). The forces of a mode solve
one linear problem with a row for each contact, with s its side, rho its friction per load and d its drag:

    rests     (A R)_i = b_i                 slides     R_i + rho_i (C R)_i = rho_i n_i + d_i

The kernel decides which mode holds (`numerics/kernel/events/decision.py`); here are the forces that follow. Rows are
chosen by s^2, exactly 0 or 1, so that the equations are recorded once for all modes. Three forms of A are known:

    independent   each contact is on a body of its own: A is diagonal, and the machine gives the force that holds each
    coupled       friction at one accelerates the others, or loads them (`Contact.response`): one elimination
    distances     those between the contacts are imposed, so that all share one coordinate and A has rank one: those
                  that rest together hold one force, and how they share it is open, though the motion is not. Each is
                  shown the same share of its limit, which is nearest to the middles of what they can hold"""

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
        return self.given.velocity

    @property
    def sticks(self) -> bool:
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
    loads: normal load of a contact by itself, while it slips and at rest, or of all; none of constant loads
    divisors: by which all is solved; they vanish only where a bound does
    """

    def __init__(self, machine: Any, contacts: Sequence[RubbingContact]):
        self.all = tuple(contacts)
        self.given, self.follows_load = [contact.given for contact in contacts], machine.follows_load
        self.shared = machine.imposes_distances
        self.several, self.coupled = (
            len(self.all) > 1,
            any(contact.response for contact in self.given) and not self.shared,
        )
        self.bounds: tuple = ()
        self.bound_kinds: tuple[int, ...] = ()
        self.loads: tuple = ()
        self.mean_loads: tuple = ()
        self.load_response: tuple[tuple, ...] = ()
        self.divisors: tuple = ()
        self._sums: tuple = ()
        if self.coupled and self.several:
            if self.follows_load:
                rows: list[Any] = [contact.reaction for contact in self.given]
                self.mean_loads = tuple(own for own, *_ in rows)
                self.load_response = tuple(tuple(-raised for raised in more) for _, *more in rows)
            self.acting = self._coupled()
        else:
            self.acting = tuple(self._alone(i, contact) for i, contact in enumerate(self.all))

    # --- each by itself --------------------------------------------------------------------------------------------

    def _held(self, i: int, contact: RubbingContact) -> Any:
        """What the machine takes where a contact rests."""
        if self.shared:
            return self._share(i)
        if not self.coupled:
            return contact.given.holding_force
        if not contact.sticks:
            return 0.0  # nothing would hold it, where a command cancels its friction
        (response,) = self.divisors = contact.given.response
        return contact.given.acceleration / response

    def _alone(self, i: int, contact: RubbingContact) -> ContactForce:
        """What acts at a contact that no other one accelerates or loads."""
        force, middle, limit, normal, at_rest, held = contact.force, None, None, 1.0, None, self._held(i, contact)
        clear: Any = 1.0
        if contact.sticks:
            middle, limit = contact.middle, contact.limit
        if self.follows_load:
            assert contact.given.reaction is not None
            own, slope = contact.given.reaction
            clear, moved = 1.0 - slope * force, own - slope * contact.push
            normal, at_rest = self.loads = moved / clear, own + slope * held
            self.divisors += (clear,)
            bounds = clear, normal
            if limit is not None:
                jams = (1.0 - slope * (middle - limit)) * (1.0 - slope * (middle + limit))
                resting = 1.0 - contact.slips
                bounds = (
                    contact.slips * clear
                    + resting * (0.5 * (moved + jams + sqrt((moved - jams) * (moved - jams)))),  # the larger
                    contact.slips * normal + resting,
                    contact.slips + resting * moved,
                )
                limit, middle = limit * at_rest, middle * at_rest
            self.bounds += bounds
            self.bound_kinds += (_PARADOX, _LIFT_OFF, _AT_REST)[: len(bounds)]
        friction, hold = force * normal, held + contact.push_at_rest
        tangential = friction - contact.push
        if contact.sticks:
            friction = hold + contact.slips * (friction - hold)
            tangential = held + contact.slips * (tangential - held)  # exactly `held` at rest
        return ContactForce(
            contact, tangential, friction, hold, middle, limit, (hold, middle, limit), normal, (held, at_rest), clear
        )

    # --- coupled: one linear problem -------------------------------------------------------------------------------

    def _coupled(self) -> tuple[ContactForce, ...]:
        """All forces, of contacts that accelerate or load one another."""
        rows, right = [], []
        for i, rubbing in enumerate(self.all):
            slips, rests = rubbing.slips, 1.0 - rubbing.slips
            slide, slide_to = self._sliding_row(i, rubbing.force)
            row = zip(rubbing.given.response, slide, strict=True)
            rows.append([rests * response + slips * own for response, own in row])
            right.append(rests * rubbing.given.acceleration + slips * (slide_to - rubbing.push))
        forces, self.divisors = solution(rows, right)
        modes, determinants = self._modes() if self.mean_loads else (), []
        for i, (contact, force) in enumerate(zip(self.all, forces, strict=True)):
            normal: Any = 1.0
            if self.mean_loads:
                normal = self.mean_loads[i] - sum(c * r for c, r in zip(self.load_response[i], forces, strict=True))
            push, middle, limit = contact.push, None, None
            held, at_rest = self._would_hold(i, rows, right)
            resting: tuple = force + contact.push_at_rest, None, None
            if contact.sticks:
                push = contact.push_at_rest + contact.slips * (contact.push - contact.push_at_rest)
                middle, limit = contact.middle * at_rest, contact.limit * at_rest
                resting = resting[0], contact.middle * normal, contact.limit * normal
            own = resting, normal, (None, None), modes[0] if modes else 1.0
            determinants.append(
                ContactForce(contact, force, force + push, held + contact.push_at_rest, middle, limit, *own)
            )
        if self.mean_loads:
            self.loads = tuple(determinant.normal for determinant in determinants)
            self.bounds = *modes, *self.loads
            self.bound_kinds = (_AMBIGUOUS,) * len(modes) + (_LIFT_OFF,) * len(determinants)
        return tuple(determinants)

    def _would_hold(self, i: int, rows: Sequence[Sequence], right: Sequence) -> tuple[Any, Any]:
        """(what the machine would take of a contact at rest, its load then over the one that its law is given)."""
        own = self.all[i].given
        forces, _ = solution(
            [own.response if j == i else row for j, row in enumerate(rows)],
            [own.acceleration if j == i else value for j, value in enumerate(right)],
        )
        if not self.mean_loads:
            return forces[i], 1.0
        return forces[i], self.mean_loads[i] - sum(c * r for c, r in zip(self.load_response[i], forces, strict=True))

    def _sliding_row(self, i: int, force: Any) -> tuple[list, Any]:
        """R_i + force (C R)_i = force n_i, without the drag on its body."""
        if not self.mean_loads:
            return [*_unit(i, len(self.all))], force
        row = zip(_unit(i, len(self.all)), self.load_response[i], strict=True)
        return [own + force * raised for own, raised in row], force * self.mean_loads[i]

    # --- distances: all that rest hold one force -------------------------------------------------------------------

    def _share(self, at: int):
        """What one contact takes where it rests: its share of what must be held by those that rest."""
        contact = self.all[at]
        if not contact.sticks:
            return 0.0
        if not self._sums:
            held = width = 0.0
            for other in self.all:
                held = held + _own_share(other)
                width = width + (1.0 - other.slips) * (other.limit + LEAST if other.sticks else 0.0)
            self._sums = held, width
        held, width = self._sums
        middle, own = contact.middle - contact.push_at_rest, contact.limit + LEAST
        total = contact.given.acceleration / contact.given.response[at] - (held - _own_share(contact)) - middle
        return middle + total * (own / (width + contact.slips * own))

    def rows(self) -> Rows | None:
        """The problem that decides which of them rest; None where there is one."""
        n = len(self.all)
        if not self.several:
            return None
        if self.shared:
            b = tuple(contact.acceleration / contact.response[i] for i, contact in enumerate(self.given))
            return Rows(b, ((1.0,) * n,) * n)
        if not self.coupled:
            return Rows(tuple(contact.holding_force for contact in self.given), tuple(_unit(i, n) for i in range(n)))
        b, response = (tuple(getattr(contact, name) for contact in self.given) for name in ("acceleration", "response"))
        return Rows(b, response, self.mean_loads, self.load_response)

    def _modes(self) -> tuple:
        """What is positive while there is one way to go on: the determinants of all modes, first of the present one.

        Of each mode that is within reach, from rest at the largest forces that can be held; there is one way to go on
        from rest for every b if and only if all have one sign (Samelson, Thrall and Wesler 1958; Cottle, Pang and Stone
        1992, ch. 3; for contacts Loetstedt 1981, Pfeiffer and Glocker 1996). Of constant loads they are principal
        minors of A, which is positive definite: always.
        """
        modes = []
        for i, contact in enumerate(self.all):
            if not contact.sticks:
                modes.append([self._sliding_row(i, contact.force)[0]])
                continue
            most = (contact.middle + contact.limit, contact.middle - contact.limit)
            rows = [self._sliding_row(i, level + contact.slips * (contact.force - level))[0] for level in most]
            still = [entry / contact.given.response[i] for entry in contact.given.response]
            modes.append([[s + contact.slips * (r - s) for s, r in zip(still, rows[0], strict=True)], *rows])
        return tuple(determinant(rows) for rows in itertools.product(*modes))


def _own_share(contact: RubbingContact):
    """What a contact at imposed distances takes of all that is held: its friction, or its middle at rest."""
    slides = contact.force - contact.push
    return (
        slides + (1.0 - contact.slips) * (contact.middle - contact.push_at_rest - slides) if contact.sticks else slides
    )


def _unit(i: int, n: int) -> tuple[float, ...]:
    return tuple(1.0 if k == i else 0.0 for k in range(n))


def solution(rows: Sequence[Sequence], right: Sequence) -> tuple[list, tuple]:
    """(solution of a linear problem, its pivots), by elimination in order.

    The pivots are ratios of leading minors, which are positive where there is one way to go on.
    """
    n, work = len(rows), [[*row, value] for row, value in zip(rows, right, strict=True)]
    for i, j in itertools.combinations(range(n), 2):
        factor = work[j][i] / work[i][i]
        work[j] = [a - factor * b if k > i else 0.0 for k, (a, b) in enumerate(zip(work[j], work[i], strict=True))]
    unknowns: list = []  # the last first
    for i in reversed(range(n)):
        rest = work[i][n] - sum(a * x for a, x in zip(work[i][n - 1 : i : -1], unknowns, strict=True))
        unknowns.append(rest / work[i][i])
    return unknowns[::-1], tuple(work[i][i] for i in range(n))


def determinant(rows: Sequence[Sequence]):
    """By its first row; for the two or three contacts of a machine."""
    if len(rows) == 1:
        return rows[0][0]
    total = 0.0
    for k, entry in enumerate(rows[0]):
        minor = [[*row[:k], *row[k + 1 :]] for row in rows[1:]]
        term = entry * determinant(minor)
        total = total + term if k % 2 == 0 else total - term
    return total
