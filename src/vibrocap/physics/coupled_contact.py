"""One contact among several that act on one another: its mode, its friction, and the linear problem of all of them.

See `coupled_contacts.py`, which says what that problem is.
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.contacts import LEAST, FurtherContact
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.friction.law import Law

STILL = 1e-9  # of the natural speed: so slow a contact that comes to rest is stopped, a faster one has jumped
PUSHED = 1e-7  # of the natural speed, from which on a contact that should rest is seen to slide
ROUNDING = 1e-12  # of the natural speed
AT_REST = 1e-14  # of the natural speed: less is none; the guards of a kernel take somewhat more for rounding
WIDE = 8.0  # natural speeds are that of imposed distances: the speeds below are far less than what is at rest there
BEYOND_REST, WITHIN_REST = 2e-14, 2e-15  # of the natural speed, around what `jumped` of a kernel takes for rounding
EARLY = 2e-14  # of the natural speed, at which a contact has yet to come to rest where it is said to
BEYOND = 1e-12  # of a limit: by so much a force exceeds what can be held


@dataclasses.dataclass(frozen=True)
class Mode:
    """One contact in its present mode: share of sliding (0 or 1), friction and drag of one that slides.

    force: per load where loads follow the motion
    """

    law: Law
    load: Any
    velocity: Any
    own: tuple
    slips: Any
    force: Any
    drag: Any = 0.0


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


class CoupledContact(FurtherContact):
    """One further contact at one instant whose friction is known from the joint problem.

    taken: in the place of friction, whatever its mode; normal: its load, over that which its law is given; usual: what
    that is about
    """

    def __init__(self, number: int, law: Law, load, velocity, own: tuple, taken, scale, environment, normal, usual):
        super().__init__(number, law, load, velocity, own, taken, scale, environment)
        self.normal, self.usual, self._taken = normal, usual, taken
        self.friction = taken if self.drag is None else taken - self._slips * self.drag
        self.sliding_loss, self.bristle_loss = self.sliding_loss * normal, self.bristle_loss * normal

    @property
    def _slips(self):
        return self.side * self.side if self.sticks else 1.0

    @property
    def taken(self):
        """By the machine in the place of friction."""
        return self._taken

    @property
    def limit(self):
        """How far the forces reach that it can hold at rest."""
        return self.law.holding_limit(self.load) * self.normal

    @property
    def middle(self):
        """Their middle."""
        return self.law.holding_middle(self.load) * self.normal

    def _margins(self) -> tuple:
        """By how much the force at rest may grow forward and back, over what can be held about."""
        limit, over = self.limit, self.hold - self.middle
        size = self.law.holding_limit(self.load) * self.usual + LEAST
        return (limit - over) / size, (limit + over) / size


class ImposedContact(CoupledContact):
    """One whose velocity is not a state of its own, so that it is at rest to rounding, and may jump with the drive.

    together: how many other contacts rest that can rest together with it
    """

    imposed = True
    together: Any = 0.0

    def joins(self) -> Any:
        """Guard of a contact that slides, though with one at rest that keeps its distance: they rest together."""
        slides = self.side * self.side
        return 1.0 - slides + self.side * self.velocity / self.scale - slides * (ROUNDING * self.together)

    def _push(self):
        share = self.velocity / (PUSHED * self.scale)
        cube = share * share * share
        return cube * cube * cube


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
