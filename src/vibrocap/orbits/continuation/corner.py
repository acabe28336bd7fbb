"""Corners: where a branch changes its direction at once, since the derivative of its map jumps with the word."""

import numpy as np

from vibrocap.orbits.continuation.branch_point import BranchPoint, corrected, null_tangent, tangent
from vibrocap.orbits.maps.closing_map import Closing, Closure
from vibrocap.orbits.maps.itinerary import same_cycle

REACHES = (3.0, 10.0, 1.0, 30.0)  # how far beyond the corner its other side is looked for, over the distance tried
OFF = 3.0  # how far off the guess it may be found, over the same
LEVEL = 1e-9  # distance from a corner below which nothing is told apart


def around_corner(closure: Closure, here: BranchPoint, beyond: Closing, distance: float) -> BranchPoint | None:
    """A point of the branch on the other side of a corner that is nearer than a distance; None where there is none.

    A little beyond the corner along the old tangent the map is that of the new word, and the null vector of its
    derivative is the new tangent. Orbits of the new word exist to one side of the corner only, which tells the sign,
    and the branch may turn by more than a right angle (then no plane across the old tangent meets it).

    beyond: the closing at `distance` along the old tangent, whose word is another
    The point is as far from the corner as `here` is: the straight way between the two is then across the corner.
    """
    if not beyond.finished:
        return None
    along = null_tangent(beyond)
    for reach in REACHES:
        for sign in (1.0, -1.0):
            guess = here.x + reach * distance * sign * along
            found, _ = corrected(closure, guess, along, float(along @ guess), beyond)
            if found is None or same_cycle(found.word, here.closing.word) or not 0.0 <= found.x[-1] <= 1.0:
                continue
            if np.linalg.norm(found.x - guess) <= OFF * distance:
                return _level(closure, here, BranchPoint(found, tangent(found, sign * along)))
    return None


def _level(closure: Closure, here: BranchPoint, other: BranchPoint) -> BranchPoint:
    """A point of the other side that is as far from the corner as `here` is, where it can be had."""
    sides = np.column_stack((here.tangent, other.tangent))
    share = np.linalg.lstsq(sides, other.x - here.x, rcond=1e-12)[0]
    if share[0] < LEVEL:
        return other
    guess = here.x + share[0] * (here.tangent + other.tangent)
    found, _ = corrected(closure, guess, other.tangent, float(other.tangent @ guess), other.closing)
    if found is None or same_cycle(found.word, here.closing.word) or np.linalg.norm(found.x - guess) > share[0]:
        return other
    return BranchPoint(found, tangent(found, other.tangent))
