"""Branch switching: from a branch to one that bifurcates from it at a pitchfork or a flip, and where that one ends."""

from collections.abc import Iterator

import numpy as np

from vibrocap.orbits.walk.kinds import CORNERS, SpecialKind
from vibrocap.orbits.walk.residual import BranchPoint, Residual, closed_at, null_tangent
from vibrocap.orbits.walk.segment import Segment
from vibrocap.orbits.walk.special_points import Found, flip_test, special_points_between

WIDEST = 0.05  # share of the parameter's range within which a bifurcation is looked for
NARROWEST = 1e-4
TWIN = 3.0  # how far off, over the distance of two points about a bifurcation, the twin of one may be from the other
FAR_BIFURCATION = 30.0  # the same of the bifurcation, where the branch leaves at a sharp angle
BESIDE = (-1e-3, 1e-3, -1e-2, 1e-2)  # shares of the range at which a branch that leaves at an angle is looked for
OFFSETS = tuple(10.0 ** np.arange(-4.0, -0.4, 0.5))  # distances from its parent there, in natural sizes
TEXT = "this branch is born here"
DIFFERENT = 1e-5  # mismatch under the parent's map from which on an orbit is another


def parent_bifurcation(residual: Residual, first: BranchPoint, last: BranchPoint, slack: float = 0.0) -> Found | None:
    """Where a branch bifurcates from one of the coarser map, between two of its points; None where it is not.

    A branch of mirror-image solutions meets that of symmetric orbits where the parameter has an extremum along it,
    since the twins are the same branch gone through the other way; a branch of twice the period meets its own shift by
    one period. There a multiplier of the coarser map is -1 (a pitchfork or a flip), or they jump over -1 at a change of
    the mode sequence, and then the new branch leaves at an angle. The place is found on the coarser branch, where
    nothing is singular. Beyond it the branch is its own twin: the image of `last` under the coarser map is near
    `first`, which tells a bifurcation from a fold beside it.

    slack: how much farther than `last` from `first` all this may be
    """
    coarser = residual.coarser()
    if coarser is None:
        return None
    near = float(np.linalg.norm(last.x - first.x)) + slack
    twin = np.append(last.x[:-1] + coarser.attempt(last.x, last.closing).mismatch, last.x[-1])
    if not np.linalg.norm(first.closing.away(twin)) <= TWIN * near:
        return None
    segment = _coarser_segment(coarser, first, last, TWIN * near)
    if segment is None:
        return None
    for special in special_points_between(segment.residual, segment.points[0], segment.points[-1]):
        smooth = special.kind in (SpecialKind.PITCHFORK, SpecialKind.FLIP)
        near_enough = np.linalg.norm(special.point.x - first.x) <= FAR_BIFURCATION * near
        if (smooth or special.passed is not None) and near_enough:
            return _on_finer_branch(residual, first, special)
    return None


def unlocated_bifurcation(residual: Residual, last: BranchPoint, beyond: BranchPoint) -> Found:
    """A bifurcation between the last point that is no orbit of the coarser map and the next one, which is."""
    coarser = residual.coarser()
    kind = SpecialKind.PITCHFORK if coarser is not None and coarser.half else SpecialKind.FLIP
    return Found.between(residual, SpecialKind.UNLOCATED, last, beyond, share=1.0, passed=kind, text=TEXT)


def _coarser_segment(coarser: Residual, first: BranchPoint, last: BranchPoint, near: float) -> Segment | None:
    """A stretch of the coarser branch about two points, the shortest with a multiplier -1 or a change of modes."""
    guess = 0.5 * (first.x + last.x)
    across = np.eye(len(guess))[-1]
    middle = closed_at(coarser, guess, float(guess[-1]), first.closing)
    if middle is None or np.linalg.norm(middle.x - guess) > near:
        return None
    reach = NARROWEST
    while reach <= WIDEST:
        ends: list[BranchPoint] = []
        for side in (-reach, reach):
            point = closed_at(coarser, middle.x + side * across, middle.x[-1] + side, middle)
            if point is not None:
                ends.append(BranchPoint(point, null_tangent(point)))
        if len(ends) < 2:
            return None
        if flip_test(ends[0]) * flip_test(ends[1]) < 0.0 or not ends[0].closing.alike(ends[1].closing):
            return Segment(coarser, *ends)
        reach *= 4.0
    return None


def _on_finer_branch(residual: Residual, last: BranchPoint, special: Found) -> Found:
    """The record of a bifurcation on the coarser branch, seen from the branch that ends there."""
    towards = special.point.x - last.x
    size = float(np.linalg.norm(towards))
    tangent = towards / size if size > 0.0 else last.tangent
    point = BranchPoint(residual.attempt(special.point.x, special.point.closing), tangent)
    words, change, count = (last.closing.mode_sequence, point.closing.mode_sequence), None, last.closing.unstable()
    if special.kind in CORNERS:
        change = special.change if last.closing.alike(point.closing) else last.closing.change_to(point.closing)[1]
    return Found(special.kind, 1.0, point, special.error, (count, count), words, change, special.passed, text=TEXT)


def branches_at_corner(parent: Residual, special: Found) -> Iterator[tuple[Residual, BranchPoint]]:
    """(map, point) of branches that leave at a change of the mode sequence, where the multipliers jump over -1.

    There the derivative jumps, and no eigenvector shows the way. Orbits are looked for on both sides of the change, off
    the parent's orbit along the eigenvector of its largest multiplier on its unstable side.
    """
    finer = parent.finer()
    assert special.beyond is not None
    ends = (special.point, special.beyond)
    unstable = max(ends, key=lambda point: float(np.max(np.abs(point.closing.eigenvalues))))
    values, vectors = np.linalg.eig(unstable.closing.jacobian)
    off = np.append(np.real(vectors[:, np.argmax(np.abs(values))]), 0.0)
    across = np.eye(len(off))[-1]
    for beside in BESIDE:
        q = float(special.point.x[-1]) + beside
        if not 0.0 <= q <= 1.0:
            continue
        middle = closed_at(parent, special.point.x + beside * across, q, special.point.closing)
        if middle is None:
            continue
        for distance in OFFSETS:
            other = closed_at(finer, middle.x + distance * off, q, middle)
            if other is None or parent.attempt(other.x, other).residual <= DIFFERENT:
                continue
            yield finer, BranchPoint(other, null_tangent(other))
            break


def switched_point(residual: Residual, special: Found) -> tuple[Residual, BranchPoint]:
    """(map, first point) of the branch that leaves at a pitchfork or a flip, along the eigenvector of multiplier -1.

    That branch is symmetric about it: its tangent there has no part along the parameter.
    """
    assert special.direction is not None
    finer = residual.finer()
    direction = np.append(special.direction, 0.0)
    closing = finer.attempt(special.point.x, special.point.closing)
    return finer, BranchPoint(closing, direction / np.linalg.norm(direction))
