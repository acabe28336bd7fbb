"""Following a branch of orbits by its arclength, past folds and through changes of the word, until it ends."""

import dataclasses

import numpy as np

from vibrocap.orbits.continuation.branch_end import BranchEnd
from vibrocap.orbits.continuation.branch_point import BranchPoint, corrected, null_tangent
from vibrocap.orbits.continuation.branch_step import SMALLEST, STRAIGHT, next_point
from vibrocap.orbits.continuation.branch_switching import birth_between, unlocated_birth
from vibrocap.orbits.continuation.special_points import Found, SpecialKind, special_points_between
from vibrocap.orbits.continuation.word_cuts import TOO_MANY
from vibrocap.orbits.maps.closing_map import Closure

SAME = 1e-7  # mismatch under the coarser map up to which an orbit is one of that map
MEETING = 1e-4  # distance at which a branch that becomes one of the coarser map may be from its birth
SURE = 1e-4  # share of the largest step below which a step has not jumped to another branch
CROWDED = 0.03  # the same of a step whose changes of word are too many to be located one by one
TORN = (SpecialKind.UNLOCATED, SpecialKind.JUMP)


@dataclasses.dataclass(frozen=True, eq=False)
class Followed:
    """One way along a branch: its points from the start on, what is special after each, and why it ended."""

    points: list[BranchPoint]
    special: list[tuple[int, Found]]  # (index of the point before it, what it is)
    end: BranchEnd


def started(closure: Closure, x: np.ndarray) -> BranchPoint | None:
    """The point of a branch at the parameter of x; None where nothing closes near it."""
    across = np.zeros(len(x))
    across[-1] = 1.0
    found, _ = corrected(closure, x, across, float(x[-1]))
    return None if found is None else BranchPoint(found, null_tangent(found))


def followed(
    closure: Closure, start: BranchPoint, towards: float, most: int, step: float, born: bool = False
) -> Followed:
    """Follow a branch from a point, first towards larger (+1) or smaller (-1) parameters along its tangent.

        predict   x' = x + ds t          correct   F(x) = 0,  n . (x - x') = 0   with the tangent n = t

    Steps grow while Newton's method needs few of its own and the tangent hardly turns. Where the word changes the
    tangent turns at once: a step that has become very short is taken in spite of it. A corner at which it turns far
    is passed by looking along the other side's tangent.

    most: points; step: longest, in natural sizes of the states and shares of the parameter's range
    born: the start is where this branch is born from another, as in `special_points_between`
    """
    here = dataclasses.replace(start, tangent=towards * start.tangent)
    walk = _Walk(closure, closure.coarser(), step, (0.2 if born else 0.1) * step)
    points, special = [here], []
    while True:
        if len(points) >= most:
            return Followed(points, special, BranchEnd.TOO_MANY_POINTS)
        if _at_bound(here):
            return Followed(points, special, BranchEnd.PARAMETER_BOUND)
        found, between, end = walk.stretch(here, born and len(points) == 1)
        special += [(len(points) - 1, each) for each in between]
        if found is not None:
            points.append(found)
        if end is None and _closes(points):
            end = BranchEnd.CLOSED
        if end is not None or found is None:
            return Followed(points, special, end or BranchEnd.NEWTON_FAILED)
        here = found


@dataclasses.dataclass
class _Walk:
    """A branch that is being followed.

    ds: length of the next step; watched: arclength for which the word is looked at closely, since it changed there more
    often than a longer step could locate
    """

    closure: Closure
    coarser: Closure | None
    longest: float
    ds: float
    watched: float = 0.0

    def stretch(self, here: BranchPoint, at_birth: bool) -> tuple[BranchPoint | None, list[Found], BranchEnd | None]:
        """(next point, special points before it, why the branch ends there).

        A step after which the orbit is one of the coarser map, or that has orbits between its ends which do not close,
        has jumped to another branch: it is made shorter. If it cannot be short enough, the branches do meet there.
        """
        met_at: BranchPoint | None = None
        while True:
            found, following, why = next_point(self.closure, here, self.ds, self.longest)
            if found is None:
                if met_at is not None:
                    return self._ended(here, met_at)
                special = birth_between(self.closure, here, here, MEETING)
                return (None, [], why) if special is None else (special.point, [special], _end_at(special))
            way = float(np.linalg.norm(found.x - here.x))
            least = min(way, self.ds)
            if here.tangent[-1] * found.tangent[-1] < 0.0 and not at_birth:
                met = birth_between(self.closure, here, found)
                if met is not None:
                    smooth = met.passed is None
                    before = special_points_between(self.closure, here, met.point, met=True) if smooth else []
                    return met.point, [*before, met], _end_at(met)
            sure = way <= SURE * self.longest
            if at_birth and not sure and (found.x[-1] - here.x[-1]) * found.tangent[-1] < 0.0:
                self.ds = 0.3 * least  # it has turned back already: the fold shall lie after the first step
                continue
            if self.coarser is not None and self.coarser.attempt(found.x, found.closing).residual <= SAME:
                met_at, self.ds = found, 0.3 * least
                if self.ds < SMALLEST:
                    return self._ended(here, met_at)
                continue
            closely = self.watched > 0.0
            between = special_points_between(self.closure, here, found, born=at_birth, closely=closely)
            crowded = way <= CROWDED * self.longest
            if any(each.kind in TORN and not (crowded if each.text == TOO_MANY else sure) for each in between):
                if any(each.text == TOO_MANY for each in between):
                    self.watched = max(self.watched, way)
                self.ds = 0.2 * least
                continue
            self.watched = max(self.watched - way, 0.0)
            self.ds = min(self.ds, following) if self.watched > 0.0 else following
            return found, between, None

    def _ended(self, here: BranchPoint, beyond: BranchPoint) -> tuple[BranchPoint, list[Found], BranchEnd]:
        """The end at the branch from which this one is born."""
        special = birth_between(self.closure, here, beyond, MEETING) or unlocated_birth(self.closure, here, beyond)
        return special.point, [special], _end_at(special)


def _end_at(special: Found) -> BranchEnd:
    """How a branch ends at a birth."""
    return BranchEnd.PITCHFORK if SpecialKind.PITCHFORK in (special.kind, special.passed) else BranchEnd.FLIP


def _at_bound(point: BranchPoint) -> bool:
    """Whether the branch leaves the range of the parameter from here."""
    q, onward = float(point.x[-1]), float(point.tangent[-1])
    return (q >= 1.0 - 1e-12 and onward > 0.0) or (q <= 1e-12 and onward < 0.0)


def _closes(points: list[BranchPoint]) -> bool:
    """Whether the last step has come back to the first point."""
    if len(points) < 10:
        return False
    first, before, last = points[0], points[-2], points[-1]
    way = last.x - before.x
    share = float(np.clip((first.x - before.x) @ way / max(float(way @ way), 1e-300), 0.0, 1.0))
    off = np.linalg.norm(before.x + share * way - first.x)
    return bool(off <= 0.05 * np.linalg.norm(way) and first.tangent @ last.tangent > STRAIGHT)
