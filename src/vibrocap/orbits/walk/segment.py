"""The stretch of a branch between two neighbouring points: points, brackets of roots, changes of the mode sequence."""

import bisect
import dataclasses
import itertools
from collections.abc import Callable

import numpy as np

from vibrocap.orbits.walk.residual import BranchPoint, Residual, corrected, tangent

NARROW = 1e-11  # share of a segment to which a root is bracketed
CLOSEST = 1e-13  # the same in natural sizes and shares of the range: what rounding leaves
KINK = 1e-3  # share of a segment within which a kink may keep its points from being closed; farther apart they jump
MOST_CHANGES = 12  # within one step of a branch
SHORTEST = 1e-6  # share of a segment within which no further changes are looked for
PROBES = (0.08, 0.17, 0.26, 0.35, 0.43, 0.54, 0.63, 0.72, 0.81, 0.9, 0.97)  # shares of a step that is looked at closely
TOO_MANY = "the mode sequence changes more often than it can be located"
NOT_CLOSED = "the mode sequence changes, but orbits in between do not close"
JUMPS = "the mode sequence changes where the orbits jump"
LEAPS = 1e-3  # of the largest value at the ends of a search: one that stays above it does not pass zero


class Lost(Exception):
    """The function cannot be evaluated at a place."""


@dataclasses.dataclass(frozen=True)
class Bracket:
    """Two places between which a function changes its sign, and its values there."""

    left: float
    right: float
    value_left: float
    value_right: float
    scale: float  # largest value at the ends of the search

    @property
    def jumps(self) -> bool:
        """Whether the function jumps over zero instead of passing it."""
        return min(abs(self.value_left), abs(self.value_right)) > LEAPS * self.scale


def root(function: Callable[[float], float], left: float, right: float, width: float) -> Bracket:
    """Where a function changes its sign between two places, to half a width: bracketing with the ITP method.

    Interpolate, truncate, project (Oliveira and Takahashi 2020): as safe as bisection, as quick as the secant. It does
    not assume that the function is continuous; `Bracket.jumps` tells. Raises what the function raises.
    """
    low, high = function(left), function(right)
    scale, span = max(abs(low), abs(high)), right - left
    most = int(np.ceil(np.log2(span / (2.0 * width)))) + 1
    for trial in itertools.count():
        if right - left <= 2.0 * width or low == 0.0 or high == 0.0:
            break
        middle = 0.5 * (left + right)
        secant = (high * left - low * right) / (high - low)
        towards = np.sign(middle - secant)
        truncated = min(0.2 * (right - left) ** 2 / span, abs(middle - secant)) * towards + secant
        radius = max(width * 2.0 ** (most - trial) - 0.5 * (right - left), 0.0)
        place = truncated if abs(truncated - middle) <= radius else middle - towards * radius
        place = float(np.clip(place, left + 0.1 * width, right - 0.1 * width))
        if not left < place < right:
            break  # no number lies between
        value = function(place)
        if np.sign(value) == np.sign(low):
            left, low = place, value
        else:
            right, high = place, value
    return Bracket(left, right, low, high, scale)


def change(
    holds: Callable[[float], bool], left: float, right: float, width: float, kink: float = 0.0
) -> tuple[float, float]:
    """Two places no farther apart than a width: something holds at the first and not at the second (bisection).

    kink: width of the bracket below which a place that is lost ends the search; above, `Lost` is raised
    """
    while right - left > width and left < (middle := 0.5 * (left + right)) < right:
        try:
            left, right = (middle, right) if holds(middle) else (left, middle)
        except Lost:
            if right - left < kink:
                break
            raise
    return left, right


class Segment:
    """Points of a branch between two of its points, by their share (0 to 1) of the straight way from one to the other.

    Every point is closed in the plane across that way, from a guess on the straight line between its nearest neighbours
    that are known already, so that a search closes in at little cost and a kink in between does no harm.
    """

    def __init__(self, residual: Residual, first: BranchPoint, last: BranchPoint):
        self.residual = residual
        self.way = last.x - first.x
        self.length = float(np.linalg.norm(self.way))
        self.normal = self.way / self.length
        self.start = float(self.normal @ first.x)
        self.narrow = max(NARROW, CLOSEST / self.length)
        self.shares, self.points = [0.0, 1.0], [first, last]

    def point(self, share: float) -> BranchPoint:
        """The closed point at a share of the way. Raises `Lost`."""
        place = bisect.bisect_left(self.shares, share)
        if place < len(self.shares) and self.shares[place] == share:
            return self.points[place]
        left, right = self.shares[place - 1], self.shares[place]
        before, after = self.points[place - 1], self.points[place]
        level = self.start + share * self.length
        between = before.x + (share - left) / (right - left) * (after.x - before.x)
        for near, guess in ((before, between), (before, None), (after, None)):
            if guess is None:  # along the neighbour's own tangent: on its own side of a kink
                onward = float(near.tangent @ self.normal)
                guess = near.x + (level - self.normal @ near.x) / (onward or 1.0) * near.tangent
            corrected_point, _ = corrected(self.residual, guess, self.normal, level, near.closing)
            if corrected_point is not None and np.linalg.norm(corrected_point.x - between) <= self.length:
                point = BranchPoint(corrected_point, tangent(corrected_point, self.normal))
                self.shares.insert(place, share)
                self.points.insert(place, point)
                return point
        raise Lost(f"no closed point at {share:.6g} of a segment")

    def parameter(self, share: float) -> float:
        """The parameter at a share that was visited."""
        return self.residual.parameter(self.points[self.shares.index(share)].x)

    def discontinuous(self, left: float, right: float) -> bool:
        """Whether the orbits at two shares that were visited, as near as can be, differ: they are on two branches."""
        one, other = (self.points[self.shares.index(share)].x for share in (left, right))
        return bool(np.linalg.norm(other - one) > KINK * self.length + 1e3 * CLOSEST)

    def root(self, function: Callable[[BranchPoint], float], left: float = 0.0, right: float = 1.0) -> Bracket:
        """Where a function changes its sign between two shares, see `root`."""
        width = min(self.narrow, 0.25) * (right - left)
        return root(lambda share: function(self.point(share)), left, right, width)

    def change(self, same: Callable[[BranchPoint], bool], left: float, right: float) -> tuple[float, float]:
        """Two shares as near as rounding allows: at the first `same` holds, at the second it does not (bisection)."""
        return change(lambda share: same(self.point(share)), left, right, self.narrow, KINK)


def mode_changes(segment: Segment, closely: bool = False) -> tuple[list[tuple[float, float]], str]:
    """(changes as pairs of shares as near as can be, why there may be others: empty if all were located).

    A change is bracketed by bisection. Bisection sees one where there are three: the middle of each stretch that it
    leaves is looked at too, and if its mode sequence is another, the search continues there.

    closely: look between points of the same mode sequence too, since there were too many changes here for a longer step
    """
    changes: list[tuple[float, float]] = []
    try:
        marks = (0.0, *(PROBES if closely else ()), 1.0)
        complaint = next(filter(None, (_cut(segment, *pair, changes) for pair in itertools.pairwise(marks))), "")
    except Lost:
        complaint = NOT_CLOSED
    return sorted(changes), complaint


def _cut(segment: Segment, left: float, right: float, changes: list[tuple[float, float]]) -> str:
    """Bracket the changes between two shares whose words differ; returns why it was given up."""
    here, there = (segment.point(share).closing.itinerary for share in (left, right))
    if here == there:
        return ""
    if len(changes) >= MOST_CHANGES:
        return TOO_MANY
    before, after = segment.change(lambda point: point.closing.itinerary == here, left, right)
    if segment.discontinuous(before, after):
        return JUMPS
    changes.append((before, after))
    for first, last in ((left, before), (after, right)):
        middle = 0.5 * (first + last) if last - first > SHORTEST else first
        for begin, end in ((first, middle), (middle, last)):
            if begin < end and (complaint := _cut(segment, begin, end, changes)):
                return complaint
    return ""
