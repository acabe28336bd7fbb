"""Special points of a branch: where it folds, where others branch off, where stability or the mode sequence changes."""

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.orbits.walk.kinds import CORNERS, ModeChange, SpecialKind
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE, BranchPoint, Residual
from vibrocap.orbits.walk.segment import Bracket, Lost, Segment, mode_changes
from vibrocap.physics.dimensions.conversion import Parameter
from vibrocap.quantities.declared import AngularFrequency, Length, Number, Numbers, States
from vibrocap.results import Result

SEEN = 1e-8  # share of the parameter's range within which the integrator sees that a velocity or a force grazes a limit
DECIDED = 1e-10  # the same of a force that passes its limit: modes are decided to 1e-11 of the forces
FOLDED = 1e-3  # distance from 1 of the multiplier that makes a turn of the parameter a fold
NOISE = 1e-9  # error of a multiplier, of which the error of a located point is made up
DEGENERATE = 1e-8  # first Lyapunov coefficient over omega that is zero up to rounding


@dataclasses.dataclass(frozen=True, eq=False)
class Found:
    """A special point between two points of a branch, before it is written down.

    share: of the way between them; error: of the parameter; direction: in which another branch leaves, or None
    point, beyond: the orbit there; at a change of the mode sequence the last before it and the first after it
    passed: what the multipliers jump over at a change of the mode sequence as they would pass it where all is smooth
    unstable: number of multipliers not inside the unit circle before and after; text: more about it
    place: the parameter, where the point is only near it
    frequency, vector: of the eigenvalues on the imaginary axis at a point of equilibria; 0: they are real
    """

    kind: SpecialKind
    share: float
    point: BranchPoint
    error: float
    unstable: tuple[int, int]
    words: tuple[str, str]
    change: ModeChange | None = None
    passed: SpecialKind | None = None
    direction: np.ndarray | None = None
    beyond: BranchPoint | None = None
    text: str = ""
    place: float | None = None
    frequency: float = 0.0
    vector: np.ndarray | None = None

    @classmethod
    def between(
        cls, residual: Residual, kind: SpecialKind, before: BranchPoint, after: BranchPoint, **others: Any
    ) -> "Found":
        """Something between two points, by default at the first; error: that of the parameter by their distance."""
        error = abs(residual.parameter(after.x) - residual.parameter(before.x))
        counts = before.closing.unstable(), after.closing.unstable()
        words = before.closing.mode_sequence, after.closing.mode_sequence
        return cls(kind, **({"point": before, "error": error, "unstable": counts, "words": words} | others))

    @classmethod
    def at_end(
        cls, kind: SpecialKind, share: float, point: BranchPoint, error: float, text: str, place: float, **others: Any
    ) -> "Found":
        """Something near a point, at an end of a branch."""
        count, word = point.closing.unstable(), point.closing.mode_sequence
        return cls(kind, share, point, error, (count, count), (word, word), text=text, place=place, **others)


def flip_test(point: BranchPoint) -> float:
    """Vanishes with a multiplier -1."""
    return float(np.real(np.prod(point.closing.eigenvalues + 1.0)))


def circle_test(point: BranchPoint) -> float:
    """Vanishes where the product of two multipliers is 1: a pair on the circle (or a neutral saddle)."""
    values = point.closing.eigenvalues
    return float(np.real(np.prod([a * b - 1.0 for a, b in itertools.combinations(values, 2)])))


def fold_test(point: BranchPoint) -> float:
    """How fast the parameter grows along the branch."""
    return float(point.tangent[-1])


def branch_test(point: BranchPoint) -> float:
    """Vanishes where another branch crosses: the derivative with the tangent below it is singular."""
    return float(np.linalg.det(np.vstack((point.closing.derivative, point.tangent))))


TESTS: dict[SpecialKind, Callable[[BranchPoint], float]] = {
    SpecialKind.FOLD: fold_test,
    SpecialKind.FLIP: flip_test,
    SpecialKind.NEIMARK_SACKER: circle_test,
    SpecialKind.BRANCH_POINT: branch_test,
}


def special_points_between(
    residual: Residual,
    first: BranchPoint,
    last: BranchPoint,
    from_parent: bool = False,
    to_parent: bool = False,
    closely: bool = False,
) -> list[Found]:
    """Special points between two neighbouring points of a branch, in order.

    The segment is cut where the modes change; between the cuts all is smooth, and multipliers that pass 1, -1 or the
    circle are found by the sign of functions that vanish there. What changes sign or stability over a cut does so by a
    jump. Two of a kind between the same two points are not seen.

    from_parent, to_parent: the first or the last point is where it bifurcates from another, which has the multiplier 1
    """
    segment = Segment(residual, first, last)
    cuts, complaint = mode_changes(segment, closely)
    edges = [0.0, *itertools.chain.from_iterable(cuts), 1.0]
    special_points = [_change(segment, left, right) for left, right in cuts]
    if complaint:
        special_points.append(_record(segment, SpecialKind.UNLOCATED, 0.0, 1.0, text=complaint))
    for i in range(0, len(edges), 2):
        left, right = edges[i : i + 2]
        if segment.point(left).closing.alike(segment.point(right).closing):
            at_parent = (from_parent and left == 0.0) or (to_parent and right == 1.0)
            special_points += residual.special_points(segment, left, right, at_parent)
    return sorted(special_points, key=lambda special_point: special_point.share)


def special_points_of_maps(segment: Segment, left: float, right: float, at_parent: bool) -> list[Found]:
    """Of a map, by functions of its multipliers that change their sign, for `Residual.special_points`."""
    before, after = segment.point(left), segment.point(right)
    special_points: list[Found] = []
    for kind, test in TESTS.items():
        if at_parent and kind in (SpecialKind.FOLD, SpecialKind.BRANCH_POINT):
            continue
        if not test(before) * test(after) < 0.0:
            continue
        try:
            bracket = segment.root(test, left, right)
        except Lost:
            bracket = None
        if bracket is None or segment.discontinuous(bracket.left, bracket.right):
            text = f"{kind.value} test changes sign" + ("" if bracket is None else " where the orbits jump")
            special_points.append(_record(segment, SpecialKind.UNLOCATED, left, right, text=text))
            continue
        special = _located(segment, kind, bracket, (before, after))
        folds = kind is SpecialKind.BRANCH_POINT  # a fold is no branch point too
        if special and not (folds and any(abs(special.share - other.share) < 1e-4 for other in special_points)):
            special_points.append(special)
    return special_points


def _record(segment: Segment, kind: SpecialKind, left: float, right: float, **others: Any) -> Found:
    """The record of something between two shares that were visited."""
    points = segment.point(left), segment.point(right)
    return Found.between(segment.residual, kind, *points, **({"share": left} | others))


def _located(
    segment: Segment, kind: SpecialKind, bracket: Bracket, ends: tuple[BranchPoint, BranchPoint]
) -> Found | None:
    """The record of a root of a test between two points; None for a neutral saddle, which is nothing special."""
    share = bracket.left if abs(bracket.value_left) <= abs(bracket.value_right) else bracket.right
    point, counts = segment.point(share), _counts(segment, bracket.left, bracket.right)
    record = _record(segment, kind, bracket.left, bracket.right, share=share, point=point, unstable=counts)
    if bracket.jumps:
        return dataclasses.replace(record, kind=SpecialKind.JUMP, text=f"over that of a {kind.value}")
    values, vectors = np.linalg.eig(point.closing.jacobian)
    if kind is SpecialKind.FOLD:  # over one, a multiplier passes 1
        one, other = (np.real(np.prod(end.closing.eigenvalues - 1.0)) for end in ends)
        if np.min(np.abs(values - 1.0), initial=np.inf) > FOLDED or not one * other < 0.0:
            return dataclasses.replace(record, kind=SpecialKind.JUMP, text="the parameter turns without a fold")
    if kind is SpecialKind.NEIMARK_SACKER:
        pairs = itertools.combinations(range(len(values)), 2)
        one, other = min(pairs, key=lambda pair: abs(values[pair[0]] * values[pair[1]] - 1.0))
        if abs(values[one].imag) < 1e-6 or abs(values[one] - values[other].conj()) > 1e-6:
            return None
    direction = None
    if kind is SpecialKind.FLIP:
        direction = np.real(vectors[:, np.argmin(np.abs(values + 1.0))])
        if segment.residual.half:
            kind = SpecialKind.PITCHFORK
    elif kind is SpecialKind.BRANCH_POINT:
        direction = np.real(vectors[:, np.argmin(np.abs(values - 1.0))])
    # the errors of multipliers over the slope of the test; at a fold the parameter moves by what does not close
    noise = NOISE * abs(segment.parameter(1.0) - segment.parameter(0.0)) / max(bracket.scale, 1e-300)
    if kind is SpecialKind.FOLD:
        derivative = point.closing.derivative
        moved = np.linalg.svd(derivative[:, :-1])[0][:, -1] @ derivative[:, -1]
        noise += segment.residual.levels.rounding * _range(segment) / max(abs(float(moved)), 1e-300)
    return dataclasses.replace(record, kind=kind, error=record.error + noise, direction=direction)


def _counts(segment: Segment, left: float, right: float) -> tuple[int, int]:
    """Unstable multipliers at the visited points a little before and after, where they are told from the circle."""

    def on_circle(k: int) -> bool:
        return bool(np.any(np.abs(np.abs(segment.points[k].closing.eigenvalues) - 1.0) <= CLOSE_TO_CIRCLE))

    i, j = segment.shares.index(left), segment.shares.index(right)
    clear = 1e-5
    while i > 0 and (segment.shares[i] > left - clear or on_circle(i)):
        i -= 1
    while j < len(segment.shares) - 1 and (segment.shares[j] < right + clear or on_circle(j)):
        j += 1
    return segment.points[i].closing.unstable(), segment.points[j].closing.unstable()


def _change(segment: Segment, left: float, right: float) -> Found:
    """The record of a change of the mode sequence, or of the number of impacts, between two shares."""
    before, after = segment.point(left), segment.point(right)
    kind, change, text = before.closing.change_to(after.closing)
    passed = None
    for smooth, test in TESTS.items():
        if smooth is not SpecialKind.BRANCH_POINT and test(before) * test(after) < 0.0:
            passed = SpecialKind.PITCHFORK if smooth is SpecialKind.FLIP and segment.residual.half else smooth
            break
    record = _record(segment, kind, left, right, change=change, passed=passed, beyond=after, text=text)
    grazes = change in (ModeChange.GRAZING, ModeChange.SPLITTING) or "impacts" in text
    return dataclasses.replace(record, error=record.error + (SEEN if grazes else DECIDED) * _range(segment))


def _range(segment: Segment) -> float:
    low, high = (segment.residual.parameter(np.array([share])) for share in (0.0, 1.0))
    return abs(high - low)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint(Result):
    """Something special on a branch, between two of its points.

    parameter, error: where, and how far off at most
    after_point: index of the last point of the branch before it; arclength: of the branch there
    unstable_before, unstable_after: number of multipliers not inside the unit circle, or of positive real parts
    found: as the walk left it, to follow what branches off

    Of orbits: drift, multipliers; modes_before, modes_after: their mode sequences; change: what happens where these
    differ; passed: at such a change, what the multipliers jump over as they would pass it where all is smooth
    Of equilibria: frequency: angular frequency at a Hopf point; lyapunov: its first Lyapunov coefficient, below zero
    where a stable cycle is born (supercritical), above where an unstable one is; vector: [states] the eigenvector over
    its length, complex: the shape of that cycle
    """

    kind: SpecialKind
    parameter: Parameter
    error: Parameter
    state: States
    arclength: Number
    after_point: int
    unstable_before: int
    unstable_after: int
    found: Found = dataclasses.field(repr=False, compare=False)
    drift: Length | None = None
    multipliers: Numbers | None = None
    modes_before: str = ""
    modes_after: str = ""
    change: ModeChange | None = None
    passed: SpecialKind | None = None
    text: str = ""
    frequency: AngularFrequency | None = None
    lyapunov: Number | None = None
    vector: Numbers | None = None

    @property
    def in_record(self) -> str:  # type: ignore[override]
        """What belongs to it: of orbits their travel and their modes, of equilibria the frequency and the state."""
        of_orbits, of_equilibria = "drift stability modes_before modes_after", "frequency criticality state stability"
        own = of_equilibria if self.multipliers is None else of_orbits
        return f"kind parameter error arclength {own} remarks"

    @property
    def criticality(self) -> str:
        """ "supercritical", "subcritical", or "degenerate" where the coefficient vanishes; "" where there is none."""
        if self.lyapunov is None or self.frequency is None:
            return ""
        if abs(self.lyapunov) <= DEGENERATE * self.frequency:
            return "degenerate"
        return "supercritical" if self.lyapunov < 0.0 else "subcritical"

    @property
    def heading(self) -> str:
        return f"{self.kind.value} at {self.said('parameter', 12)} (error {self.error:.0e})"

    @property
    def facts(self) -> dict[str, str]:
        return {"meaning": self.kind.meaning, "remarks": self.remarks}

    @property
    def stability(self) -> str:
        """ "lost", "gained" or "kept", going along the branch."""
        if (self.unstable_before == 0) == (self.unstable_after == 0):
            return "kept"
        return "lost" if self.unstable_before == 0 else "gained"

    @property
    def discontinuous(self) -> bool:
        """Whether the multipliers jump there, so that a loss of stability is none of the smooth kinds."""
        return self.kind in (*CORNERS, SpecialKind.JUMP) and self.unstable_before != self.unstable_after

    @property
    def remarks(self) -> str:
        remarks = [] if self.frequency is None else [f"omega {self.said('frequency')}", self.criticality]
        remarks += [self.change.value if self.change else "", self.text]
        if self.kind is SpecialKind.UNLOCATED:
            remarks.append(self.kind.meaning)
        if self.modes_before != self.modes_after:
            remarks.append(f"{self.modes_before} -> {self.modes_after}")
        if self.passed is not None:
            remarks.append(f"multipliers jump as over a {self.passed.value}")
        if self.stability != "kept":
            remarks.append(f"stability {self.stability}")
        return "; ".join(remark for remark in remarks if remark)


def reversed_record(record: Found) -> Found:
    """What is special, seen by one who comes along the branch the other way."""
    words, text = record.words[::-1], record.text
    if record.beyond is not None and not text.startswith("this branch"):
        text = record.beyond.closing.change_to(record.point.closing)[2]
    return dataclasses.replace(record, words=words, unstable=record.unstable[::-1], text=text)


def special_point(
    residual: Residual, record: Found, after: int, points: list[BranchPoint], ways: np.ndarray
) -> SpecialPoint:
    return SpecialPoint(
        parameter=residual.parameter(record.point.x) if record.place is None else record.place,
        arclength=float(ways[after] + np.linalg.norm(record.point.x - points[after].x)),
        after_point=after,
        modes_before=record.words[0],
        modes_after=record.words[1],
        unstable_before=record.unstable[0],
        unstable_after=record.unstable[1],
        found=record,
        **{name: getattr(record, name) for name in ("kind", "error", "change", "passed", "text")},
        **residual.described(record),
    )
