"""The walk along a branch by its arclength, past folds and through changes of the mode sequence, until it ends."""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.orbits.walk.branch_switching import parent_bifurcation, unlocated_bifurcation
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.residual import BranchPoint, Closing, Residual, closed_at, corrected, null_tangent, tangent
from vibrocap.orbits.walk.segment import TOO_MANY, Lost, Segment
from vibrocap.orbits.walk.special_points import (
    Found,
    SpecialPoint,
    reversed_record,
    special_point,
    special_points_between,
)

ON_COARSER_MAP = 1e-7  # mismatch under the coarser map up to which an orbit is one of that map
MEETING = 1e-4  # distance at which a branch that becomes one of the coarser map may be from its bifurcation
CROWDED = 0.03  # the same of a step whose changes of mode sequence are too many to be located one by one
UNTRUSTED = (SpecialKind.UNLOCATED, SpecialKind.JUMP)
SMALLEST = 1e-10  # step below which a branch counts as ended
STRAIGHT = 0.9  # cosine of the turn of the tangent between the first and the last point of a closed branch
SHORT = 1e-4  # share of the largest step below which it has not jumped to another branch, and a turn is a kink
OFF_GUESS = 0.3  # share of a step by which a point may be off the guess
CORNERED = 1e-2  # share of the largest step from which on a corner is looked for
BEYOND_CORNER = (3.0, 10.0, 1.0, 30.0)  # how far beyond it the other side is sought, over the distance tried
OFF_SIDE = 3.0  # how far off the guess it may be found, over the same
NO_DISTANCE = 1e-9  # distance from a corner below which nothing is told apart


@dataclasses.dataclass(frozen=True, eq=False)
class Followed:
    """One way along a branch: its points from the start on, what is special after each, and why it ended."""

    points: list[BranchPoint]
    special: list[tuple[int, Found]]  # (index of the point before it, what it is)
    end: BranchEnd


def started(residual: Residual, x: np.ndarray) -> BranchPoint | None:
    """The point of a branch at the parameter of x; None where nothing closes near it."""
    point = closed_at(residual, x, float(x[-1]))
    return None if point is None else BranchPoint(point, null_tangent(point))


def followed(
    residual: Residual,
    start: BranchPoint,
    towards: float,
    most: int,
    step: float,
    from_parent: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Followed:
    """Follow a branch from a point, first towards larger (+1) or smaller (-1) parameters along its tangent.

        predict   x' = x + ds t          correct   F(x) = 0,  n . (x - x') = 0   with the tangent n = t

    Steps grow while Newton's method needs few of its own and the tangent hardly turns. Where the modes change the
    tangent turns at once: a step that has become very short is taken in spite of it, and a corner at which it turns far
    is passed by looking along the other side's tangent.

    most: points; step: longest, see `BranchPoint.longest`
    from_parent: the start is where this branch bifurcates from another, as in `special_points_between`
    progress: called after each point with the share of the way to the end of the range, which may shrink again
    """
    here = dataclasses.replace(start, tangent=towards * start.tangent)
    walk = _Walk(residual, residual.coarser(), step, (0.2 if from_parent else 0.1) * step)
    points, special = [here], []
    while True:
        if len(points) >= most:
            return Followed(points, special, BranchEnd.TOO_MANY_POINTS)
        q, grows = float(here.x[-1]), float(here.tangent[-1])
        if (q >= 1.0 - 1e-12 and grows > 0.0) or (q <= 1e-12 and grows < 0.0):  # it leaves the range from here
            return Followed(points, special, BranchEnd.PARAMETER_BOUND)
        point, between, end = walk.stretch(here, from_parent and len(points) == 1)
        special += [(len(points) - 1, special_point) for special_point in between]
        if point is not None:
            points.append(point)
            if progress is not None:
                first, now = float(start.x[-1]), float(point.x[-1])
                left = (1.0 - first) if now > first else first  # of the range, towards where the branch has gone
                progress(min(abs(now - first) / left, 1.0) if left > 0.0 else 1.0)
        if end is None and _closes(points):
            end = BranchEnd.CLOSED
        if end in (BranchEnd.NEWTON_FAILED, BranchEnd.ORBIT_CEASES):
            end, ending = residual.ending(points, end)
            special += [] if ending is None else [(len(points) - 1, ending)]
        if end is not None or point is None:
            return Followed(points, special, end or BranchEnd.NEWTON_FAILED)
        here = point


@dataclasses.dataclass
class _Walk:
    """A branch that is being followed.

    ds: length of the next step; watched: arclength for which the mode sequence is looked at closely, since it changed
    there more often than a longer step could locate
    """

    residual: Residual
    coarser: Residual | None
    step: float
    ds: float
    watched: float = 0.0

    def stretch(self, here: BranchPoint, from_parent: bool) -> tuple[BranchPoint | None, list[Found], BranchEnd | None]:
        """(next point, special points before it, why the branch ends there).

        A step after which the orbit is one of the coarser map, or that has orbits between its ends which do not close,
        has jumped to another branch: it is made shorter. If it cannot be short enough, the branches do meet there.
        """
        met_at: BranchPoint | None = None
        longest = here.longest(self.step)
        while True:
            point, following, why = _next_point(self.residual, here, self.ds, longest)
            if point is None:
                if met_at is not None:
                    return self._ended(here, met_at)
                special = parent_bifurcation(self.residual, here, here, MEETING)
                return (None, [], why) if special is None else (special.point, [special], end_at(special))
            if point.closing.boundary is not None:
                last, end = _within(self.residual, here, point)
                if last is here:
                    return None, [], end
                return last, special_points_between(self.residual, here, last), end
            length = float(np.linalg.norm(point.x - here.x))
            least = min(length, self.ds)
            turns = here.tangent[-1] * point.tangent[-1] < 0.0 and not from_parent
            if turns and (met := parent_bifurcation(self.residual, here, point)) is not None:
                smooth = met.passed is None
                before = special_points_between(self.residual, here, met.point, to_parent=True) if smooth else []
                return met.point, [*before, met], end_at(met)
            sure = length <= SHORT * longest
            if from_parent and not sure and (point.x[-1] - here.x[-1]) * point.tangent[-1] < 0.0:
                self.ds = 0.3 * least  # it has turned back already: the fold shall lie after the first step
                continue
            if self.coarser is not None and self.coarser.attempt(point.x, point.closing).residual <= ON_COARSER_MAP:
                met_at, self.ds = point, 0.3 * least
                if self.ds < SMALLEST:
                    return self._ended(here, met_at)
                continue
            closely, crowded = self.watched > 0.0, length <= CROWDED * longest
            between = special_points_between(self.residual, here, point, from_parent=from_parent, closely=closely)
            untrusted = [special for special in between if special.kind in UNTRUSTED]
            if not all(crowded if special.text == TOO_MANY else sure for special in untrusted):
                if any(special.text == TOO_MANY for special in between):
                    self.watched = max(self.watched, length)
                self.ds = 0.2 * least
                continue
            following = min(following, point.longest(self.step))
            self.watched = max(self.watched - length, 0.0)
            self.ds = min(self.ds, following) if self.watched > 0.0 else following
            return point, between, None

    def _ended(self, here: BranchPoint, beyond: BranchPoint) -> tuple[BranchPoint, list[Found], BranchEnd]:
        ends = self.residual, here, beyond
        special = parent_bifurcation(*ends, MEETING) or unlocated_bifurcation(*ends)
        return special.point, [special], end_at(special)


def end_at(special: Found | SpecialPoint) -> BranchEnd:
    return BranchEnd.PITCHFORK if SpecialKind.PITCHFORK in (special.kind, special.passed) else BranchEnd.FLIP


def _closes(points: list[BranchPoint]) -> bool:
    """Whether the last step has come back to the first point, modulo whole turns."""
    if len(points) < 10:
        return False
    first, before, last = points[0], points[-2], points[-1]
    step = last.x - before.x
    back = before.closing.away(first.x)
    share = float(np.clip(back @ step / max(float(step @ step), 1e-300), 0.0, 1.0))
    off = np.linalg.norm(share * step - back)
    return bool(off <= 0.05 * np.linalg.norm(step) and first.tangent @ last.tangent > STRAIGHT)


def _within(residual: Residual, here: BranchPoint, beyond: BranchPoint) -> tuple[BranchPoint, BranchEnd]:
    """(the last point before the boundary of the equations that lies before another, the end there)."""
    segment = Segment(residual, here, beyond)
    try:
        left, right = segment.change(lambda point: point.closing.boundary is None, 0.0, 1.0)
    except Lost:
        left, right = 0.0, 1.0
    end = segment.point(right).closing.boundary
    assert end is not None
    return segment.point(left), end


def _next_point(
    residual: Residual, here: BranchPoint, ds: float, longest: float
) -> tuple[BranchPoint | None, float, BranchEnd]:
    """(next point, length of the step after it, why there is none)."""
    trial: Closing | None = None
    while ds >= SMALLEST:
        normal, length = here.tangent, ds
        guess = here.x + length * here.tangent
        bounded = not 0.0 <= guess[-1] <= 1.0
        if bounded:
            bound = float(guess[-1] > 1.0)
            length = (bound - here.x[-1]) / here.tangent[-1]
            guess = here.x + length * here.tangent
            guess[-1] = bound
            normal = np.eye(len(guess))[-1]
        point, steps = corrected(residual, guess, normal, float(normal @ guess), here.closing)
        if point is not None and -1e-12 <= point.x[-1] <= 1.0 + 1e-12:
            towards = point.x - here.x
            new = BranchPoint(point, tangent(point, towards / np.linalg.norm(towards)))
            short = ds <= SHORT * longest
            straight = float(new.tangent @ here.tangent) >= residual.straight or short
            near = float(np.linalg.norm(point.x - guess)) <= (1.0 if short else OFF_GUESS) * length
            resolved = short or residual.resolved(here, new)
            if straight and near and resolved and towards @ here.tangent > 0.0:
                longer = residual.growth * ds if steps <= residual.quick else ds
                return new, (ds if bounded else longer), BranchEnd.PARAMETER_BOUND
        trial = residual.attempt(here.x + ds * here.tangent, here.closing)
        if ds <= CORNERED * longest and not trial.alike(here.closing):
            turned = _around_corner(residual, here, trial, ds)
            if turned is not None:
                return turned, float(np.linalg.norm(turned.x - here.x)), BranchEnd.PARAMETER_BOUND
        ds *= 0.4
    if trial is None:
        return None, ds, BranchEnd.NEWTON_FAILED
    ceases = BranchEnd.ORBIT_CEASES if residual.differ(here.closing, trial) else BranchEnd.NEWTON_FAILED
    return None, ds, trial.boundary or ceases


def _around_corner(residual: Residual, here: BranchPoint, beyond: Closing, distance: float) -> BranchPoint | None:
    """A point of the branch on the other side of a corner that is nearer than a distance; None where there is none.

    A little beyond the corner along the old tangent the map is that of the new modes, and the null vector of its
    derivative is the new tangent. Orbits of the new modes exist to one side of the corner only, which tells the sign,
    and the branch may turn by more than a right angle (then no plane across the old tangent meets it). The point is as
    far from the corner as `here` is: the straight way between the two is then across the corner.

    beyond: the closing at `distance` along the old tangent, whose mode sequence is another
    """
    if not beyond.finished:
        return None
    along = null_tangent(beyond)
    for reach in BEYOND_CORNER:
        for sign in (1.0, -1.0):
            guess = here.x + reach * distance * sign * along
            point, _ = corrected(residual, guess, along, float(along @ guess), beyond)
            if point is None or point.alike(here.closing) or not 0.0 <= point.x[-1] <= 1.0:
                continue
            if np.linalg.norm(point.x - guess) <= OFF_SIDE * distance:
                return _level(residual, here, BranchPoint(point, tangent(point, sign * along)))
    return None


def _level(residual: Residual, here: BranchPoint, other: BranchPoint) -> BranchPoint:
    """A point of the other side that is as far from the corner as `here` is, where it can be had."""
    sides = np.column_stack((here.tangent, other.tangent))
    share = np.linalg.lstsq(sides, other.x - here.x, rcond=1e-12)[0]
    if share[0] < NO_DISTANCE:
        return other
    guess = here.x + share[0] * (here.tangent + other.tangent)
    point, _ = corrected(residual, guess, other.tangent, float(other.tangent @ guess), other.closing)
    if point is None or point.alike(here.closing) or np.linalg.norm(point.x - guess) > share[0]:
        return other
    return BranchPoint(point, tangent(point, other.tangent))


@dataclasses.dataclass(frozen=True, eq=False)
class Walked:
    """A branch from both ways along it, in order: its points, their arclengths, special points, ends, and the start."""

    points: list[BranchPoint]
    ways: np.ndarray
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[BranchEnd, BranchEnd]
    start: int


def walked(residual: Residual, back: Followed | None, onward: Followed | None) -> Walked:
    """The branch from the ways followed from one start, against and along its order."""
    before = [] if back is None else back.points[:0:-1]
    start = (onward or back).points[0]  # type: ignore[union-attr]
    points = [*before, start, *([] if onward is None else onward.points[1:])]
    ways = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(np.stack([point.x for point in points]), axis=0), axis=1)))
    placed = [(len(before) - 1 - i, reversed_record(record)) for i, record in (back.special[::-1] if back else ())]
    placed += [(len(before) + i, record) for i, record in (onward.special if onward else ())]
    special = tuple(special_point(residual, record, after, points, ways) for after, record in placed)
    ends = tuple(BranchEnd.NOT_FOLLOWED if part is None else part.end for part in (back, onward))
    if onward is not None and onward.end is BranchEnd.CLOSED:
        ends = (BranchEnd.CLOSED, BranchEnd.CLOSED)
    return Walked(points, ways, special, (ends[0], ends[1]), len(before))
