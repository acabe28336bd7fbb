"""One contact among several that act on one another: its mode, its friction, and the linear problem of all of them.

See `coupled_contacts.py`, which says what that problem is.
"""

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.contacts.machine_on_contacts import LEAST, FurtherContact
from vibrocap.physics.friction.law import Law


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
