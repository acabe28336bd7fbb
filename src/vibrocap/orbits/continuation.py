"""Following a branch of orbits by its arclength, past folds and through changes of the word, until it ends."""

import dataclasses
import enum

import numpy as np

from vibrocap.orbits.birth import birth_between, unlocated_birth
from vibrocap.orbits.branch_point import BranchPoint, corrected, null_tangent, tangent
from vibrocap.orbits.closing_map import Closing, Closure
from vibrocap.orbits.corner import around_corner
from vibrocap.orbits.special_points import Found, SpecialKind, special_points_between
from vibrocap.orbits.words import same_cycle

SMALLEST = 1e-10  # step below which a branch counts as ended
STRAIGHT = 0.9  # cosine of the turn of the tangent over a step
SHORT = 1e-4  # share of the largest step from which on a kink is taken for what it is
OFF = 0.3  # share of a step by which a point may be off the guess
SAME = 1e-7  # mismatch under the coarser map up to which an orbit is one of that map
SURE = 1e-4  # share of the largest step below which a step has not jumped to another branch
CORNER = 1e-2  # share of the largest step from which on a corner is looked for
CLOSE = 0.02  # share of the largest step below which a step is looked at closely
TORN = (SpecialKind.UNLOCATED, SpecialKind.JUMP)
QUICK = 3  # steps of Newton's method after which the next step may be longer


class BranchEnd(enum.Enum):
    """Why a branch was not followed further; `advice` says what to try."""

    PARAMETER_BOUND = "parameter bound"
    PITCHFORK = "pitchfork"
    FLIP = "flip"
    CLOSED = "closed"
    ORBIT_CEASES = "orbit ceases"
    NEWTON_FAILED = "Newton failed"
    TOO_MANY_POINTS = "too many points"
    NOT_FOLLOWED = "not followed"
    START_FAILED = "start failed"

    @property
    def advice(self) -> str:
        """What it means and what can be done."""
        return ADVICE[self]


ADVICE = {
    BranchEnd.PARAMETER_BOUND: "The end of the range asked for.",
    BranchEnd.PITCHFORK: "The orbit has become symmetric: the branch is born here from that of symmetric orbits, and "
    "beyond it its mirror twins come.",
    BranchEnd.FLIP: "The orbit has become one of half its period: the branch is born here, and beyond it the same "
    "orbits come again, a period later.",
    BranchEnd.CLOSED: "The branch has come back to its start.",
    BranchEnd.ORBIT_CEASES: "The word of the motion would change here, and no orbit of the new word continues this "
    "one: such orbits cease to exist. Simulate beyond it (`orbit(system, initial=...)`) to see what follows.",
    BranchEnd.NEWTON_FAILED: "No next point closes however small the step. Try another `tolerance`, or start from "
    "an orbit beyond this parameter.",
    BranchEnd.TOO_MANY_POINTS: "Raise `points`, or allow longer steps with `step`.",
    BranchEnd.NOT_FOLLOWED: "It was not asked to follow the branch this way.",
    BranchEnd.START_FAILED: "No orbit closes at the start. Give an `orbit`, or another `initial`.",
}


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
    points, special, ds = [here], [], (0.2 if born else 0.1) * step
    finer_than = closure.coarser()
    while True:
        if len(points) >= most:
            return Followed(points, special, BranchEnd.TOO_MANY_POINTS)
        if _at_bound(here):
            return Followed(points, special, BranchEnd.PARAMETER_BOUND)
        at_birth = born and len(points) == 1
        found, ds, between, end = _next_stretch(closure, finer_than, here, ds, step, at_birth)
        special += [(len(points) - 1, each) for each in between]
        if found is not None:
            points.append(found)
        if end is None and _closes(points, step):
            end = BranchEnd.CLOSED
        if end is not None or found is None:
            return Followed(points, special, end or BranchEnd.NEWTON_FAILED)
        here = found


def _next_stretch(
    closure: Closure, coarser: Closure | None, here: BranchPoint, ds: float, longest: float, at_birth: bool
) -> tuple[BranchPoint | None, float, list[Found], BranchEnd | None]:
    """(next point, length of the step after it, special points before it, why the branch ends there).

    A step after which the orbit is one of the coarser map, or that has orbits between its ends which do not close, has
    jumped to another branch: it is made shorter. If it cannot be short enough, the branches do meet there.
    """
    met_at: BranchPoint | None = None
    while True:
        found, following, why = _next_point(closure, here, ds, longest)
        if found is None:
            if met_at is not None:
                return _ended(closure, here, met_at)
            return None, ds, [], why
        if here.tangent[-1] * found.tangent[-1] < 0.0 and not at_birth:
            met = birth_between(closure, here, found)
            if met is not None:
                before = special_points_between(closure, here, met.point, met=True) if met.passed is None else []
                return met.point, ds, [*before, met], _birth(met)
        way = float(np.linalg.norm(found.x - here.x))
        if at_birth and (found.x[-1] - here.x[-1]) * found.tangent[-1] < 0.0 and way > SURE * longest:
            ds = 0.3 * min(way, ds)  # it has turned back already: the fold shall lie after the first step
            continue
        if coarser is not None and coarser.attempt(found.x, found.closing).residual <= SAME:
            met_at, ds = found, 0.3 * min(way, ds)
            if ds < SMALLEST:
                return _ended(closure, here, met_at)
            continue
        between = special_points_between(closure, here, found, born=at_birth, closely=way < CLOSE * longest)
        if way > SURE * longest and any(each.kind in TORN for each in between):
            ds = 0.2 * min(way, ds)
            continue
        return found, following, between, None


def _ended(
    closure: Closure, here: BranchPoint, beyond: BranchPoint
) -> tuple[BranchPoint, float, list[Found], BranchEnd]:
    """The end of a branch at the one it is born from, as `_next_stretch` gives it."""
    special = birth_between(closure, here, beyond) or unlocated_birth(closure, here, beyond)
    return special.point, 0.0, [special], _birth(special)


def _birth(special: Found) -> BranchEnd:
    """How a branch ends at a birth."""
    return BranchEnd.PITCHFORK if SpecialKind.PITCHFORK in (special.kind, special.passed) else BranchEnd.FLIP


def _at_bound(point: BranchPoint) -> bool:
    """Whether the branch leaves the range of the parameter from here."""
    q, onward = float(point.x[-1]), float(point.tangent[-1])
    return (q >= 1.0 - 1e-12 and onward > 0.0) or (q <= 1e-12 and onward < 0.0)


def _next_point(
    closure: Closure, here: BranchPoint, ds: float, longest: float
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
            normal = np.zeros(len(guess))
            normal[-1] = 1.0
        found, steps = corrected(closure, guess, normal, float(normal @ guess), here.closing)
        if found is not None and -1e-12 <= found.x[-1] <= 1.0 + 1e-12:
            towards = found.x - here.x
            new = BranchPoint(found, tangent(found, towards / np.linalg.norm(towards)))
            short = ds <= SHORT * longest
            straight = float(new.tangent @ here.tangent) >= STRAIGHT or short
            near = float(np.linalg.norm(found.x - guess)) <= (1.0 if short else OFF) * length
            if straight and near and towards @ here.tangent > 0.0:
                longer = 1.5 * ds if steps <= QUICK else ds
                return new, (ds if bounded else min(longer, longest)), BranchEnd.PARAMETER_BOUND
        trial = closure.attempt(here.x + ds * here.tangent, here.closing)
        if ds <= CORNER * longest and not same_cycle(trial.word, here.closing.word):
            turned = around_corner(closure, here, trial, ds)
            if turned is not None:
                return turned, float(np.linalg.norm(turned.x - here.x)), BranchEnd.PARAMETER_BOUND
        ds *= 0.4
    changed = trial is not None and not same_cycle(trial.word, here.closing.word)
    return None, ds, BranchEnd.ORBIT_CEASES if changed else BranchEnd.NEWTON_FAILED


def _closes(points: list[BranchPoint], step: float) -> bool:
    """Whether the last step has come back to the first point."""
    if len(points) < 10:
        return False
    first, before, last = points[0], points[-2], points[-1]
    way = last.x - before.x
    share = float(np.clip((first.x - before.x) @ way / max(float(way @ way), 1e-300), 0.0, 1.0))
    off = np.linalg.norm(before.x + share * way - first.x)
    return bool(off <= 0.05 * np.linalg.norm(way) and first.tangent @ last.tangent > STRAIGHT)
