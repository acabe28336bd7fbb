"""Where branches are born from others: at pitchforks and flips, left for a new branch or met by one that ends."""

from collections.abc import Iterator

import numpy as np

from vibrocap.orbits.branch_point import BranchPoint, corrected, null_tangent
from vibrocap.orbits.closing_map import Closure
from vibrocap.orbits.segment import Lost, Segment
from vibrocap.orbits.special_points import Found, SpecialKind, flip_test, special_points_between
from vibrocap.orbits.words import same_cycle, word_change

WIDEST = 0.05  # share of the parameter's range within which a birth is looked for
NARROWEST = 1e-4
BESIDE = (-1e-3, 1e-3, -1e-2, 1e-2)  # shares of the range at which a branch that leaves at an angle is looked for
OFF = tuple(10.0 ** np.arange(-4.0, -0.4, 0.5))  # distances from its parent there, in natural sizes
DIFFERENT = 1e-5  # mismatch under the parent's map from which on an orbit is another


def birth_between(closure: Closure, first: BranchPoint, last: BranchPoint) -> Found | None:
    """The pitchfork (or flip) of the coarser map where a branch turns back, being born there; None at a true fold.

    A branch of mirror twins meets that of symmetric orbits where the parameter has an extremum along it, since the
    twins are the same branch gone through the other way; a branch of twice the period meets its own shift by one
    period. At the meeting a multiplier of the coarser map is -1: there the place is found, since there nothing is singular.

    first, last: neighbouring points of the branch between which the parameter turns back
    """
    segment = _coarser_segment(closure, first, last)
    if segment is None or not flip_test(segment.points[0]) * flip_test(segment.points[-1]) < 0.0:
        return None
    try:
        bracket = segment.root(flip_test)
    except Lost:
        return None
    point = segment.point(bracket.left)
    if bracket.jumps or np.linalg.norm(point.x - first.x) > np.linalg.norm(last.x - first.x):
        return None
    error = abs(segment.parameter(bracket.right) - segment.parameter(bracket.left))
    return _seen_from(closure, first, point, SpecialKind.FLIP, error)


def birth_at_change(closure: Closure, last: BranchPoint, beyond: BranchPoint) -> Found:
    """The meeting of a branch with that of the coarser map where no multiplier passes -1: at a change of the word.

    There the multipliers of the coarser branch jump over -1, and the new branch leaves at an angle, not as a parabola.
    The place is that of the change on the coarser branch; else between the two points given.

    last: the last point that is not an orbit of the coarser map; beyond: the next one, which is
    """
    segment = _coarser_segment(closure, last, beyond)
    ends = () if segment is None else special_points_between(segment.closure, segment.points[0], segment.points[-1])
    for special in ends:
        if special.kind is SpecialKind.WORD_CHANGE:
            return _seen_from(closure, last, special.point, special.kind, special.error)
    error = abs(closure.parameter(beyond.x) - closure.parameter(last.x))
    return _seen_from(closure, last, last, SpecialKind.WORD_CHANGE, error)


def _coarser_segment(closure: Closure, first: BranchPoint, last: BranchPoint) -> Segment | None:
    """A stretch of the coarser branch about two points, the shortest with a multiplier -1 or a change of the word."""
    coarser = closure.coarser()
    if coarser is None:
        return None
    guess = 0.5 * (first.x + last.x)
    near = float(np.linalg.norm(last.x - first.x))
    across = np.zeros(len(guess))
    across[-1] = 1.0
    middle, _ = corrected(coarser, guess, across, float(guess[-1]), first.closing)
    if middle is None or np.linalg.norm(middle.x - guess) > max(near, NARROWEST):
        return None
    reach = NARROWEST
    while reach <= WIDEST:
        ends: list[BranchPoint] = []
        for side in (-reach, reach):
            found, _ = corrected(coarser, middle.x + side * across, across, middle.x[-1] + side, middle)
            if found is not None:
                ends.append(BranchPoint(found, null_tangent(found)))
        if len(ends) < 2:
            return None
        if flip_test(ends[0]) * flip_test(ends[1]) < 0.0 or not same_cycle(*(each.closing.word for each in ends)):
            return Segment(coarser, *ends)
        reach *= 4.0
    return None


def _seen_from(closure: Closure, last: BranchPoint, point: BranchPoint, kind: SpecialKind, error: float) -> Found:
    """The record of a birth at a point of the coarser branch, seen from the branch that ends there."""
    coarser = closure.coarser()
    smooth = SpecialKind.PITCHFORK if coarser is not None and coarser.half else SpecialKind.FLIP
    towards = point.x - last.x
    size = float(np.linalg.norm(towards))
    closing = closure.attempt(point.x, point.closing)
    return Found(
        smooth if kind is SpecialKind.FLIP else kind,
        1.0,
        BranchPoint(closing, towards / size if size > 0.0 else last.tangent),
        error,
        (last.unstable(), last.unstable()),
        (last.closing.word, closing.word),
        None if kind is SpecialKind.FLIP else word_change(last.closing.word, closing.word)[0],
        passed=None if kind is SpecialKind.FLIP else smooth,
        text="this branch is born here",
    )


def angled_births(parent: Closure, special: Found) -> Iterator[tuple[Closure, BranchPoint]]:
    """(map, point) of branches that leave at a change of the word, where the multipliers jump over -1.

    There is no eigenvector that shows the way, since the derivative jumps. Orbits are looked for on both sides of the
    change, off the parent's orbit along the eigenvector of its largest multiplier on its unstable side.
    """
    finer = parent.finer()
    assert special.beyond is not None
    unstable = max((special.point, special.beyond), key=lambda point: float(np.max(np.abs(point.own_multipliers))))
    values, vectors = np.linalg.eig(unstable.closing.jacobian)
    off = np.append(np.real(vectors[:, np.argmax(np.abs(values))]), 0.0)
    across = np.zeros(len(off))
    across[-1] = 1.0
    for beside in BESIDE:
        q = float(special.point.x[-1]) + beside
        if not 0.0 <= q <= 1.0:
            continue
        middle, _ = corrected(parent, special.point.x + beside * across, across, q, special.point.closing)
        if middle is None:
            continue
        for distance in OFF:
            found, _ = corrected(finer, middle.x + distance * off, across, q, middle)
            if found is None or parent.attempt(found.x, found).residual <= DIFFERENT:
                continue
            yield finer, BranchPoint(found, null_tangent(found))
            break


def born_point(closure: Closure, special: Found) -> tuple[Closure, BranchPoint]:
    """(map, first point) of the branch that leaves at a pitchfork or a flip, along the eigenvector of multiplier -1.

    That branch is symmetric about its birth: its tangent there has no part along the parameter.
    """
    assert special.direction is not None
    finer = closure.finer()
    direction = np.append(special.direction, 0.0)
    closing = finer.attempt(special.point.x, special.point.closing)
    return finer, BranchPoint(closing, direction / np.linalg.norm(direction))
