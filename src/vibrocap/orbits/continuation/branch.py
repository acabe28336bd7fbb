"""A branch of steady motions over a parameter: labelled arrays, a table of special points, and why it ends."""

import dataclasses
import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.orbits.closing.autonomous_orbit import near_cycle
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.closing.shooting import named_states, shoot
from vibrocap.orbits.continuation.branch_end import BranchEnd
from vibrocap.orbits.continuation.branch_point import CLOSE_TO_CIRCLE, BranchPoint
from vibrocap.orbits.continuation.following import Followed
from vibrocap.orbits.continuation.special_points import Found, SpecialKind
from vibrocap.orbits.maps.closing_map import ClosingMap
from vibrocap.orbits.maps.itinerary import WordChange, word_change
from vibrocap.system import System

if TYPE_CHECKING:
    from vibrocap.orbits.continuation.branch_crossings import BranchCrossing

DISCONTINUOUS = (SpecialKind.WORD_CHANGE, SpecialKind.JUMP)


@dataclasses.dataclass(frozen=True, eq=False)
class SpecialPoint:
    """Something special on a branch, between two of its points.

    parameter, error: where, and how far off at most; before, after: words; change: what happens where they differ
    after_point: index of the last point of the branch before it; arclength: of the branch there
    unstable_before, unstable_after: number of multipliers not inside the unit circle
    passed: at a change of the word, over what the multipliers jump as they would pass it where the motion is smooth
    found: as the continuation left it, to follow what branches off
    """

    kind: SpecialKind
    parameter: float
    error: float
    state: dict[str, float]
    drift: float | None
    multipliers: np.ndarray
    arclength: float
    after_point: int
    word_before: str
    word_after: str
    unstable_before: int
    unstable_after: int
    change: WordChange | None
    passed: SpecialKind | None
    text: str
    found: Found = dataclasses.field(repr=False)

    @property
    def stability(self) -> str:
        """ "lost", "gained" or "kept", going along the branch."""
        if (self.unstable_before == 0) == (self.unstable_after == 0):
            return "kept"
        return "lost" if self.unstable_before == 0 else "gained"

    @property
    def discontinuous(self) -> bool:
        """Whether the multipliers jump there, so that a loss of stability is none of the smooth kinds."""
        return self.kind in DISCONTINUOUS and self.unstable_before != self.unstable_after


@dataclasses.dataclass(frozen=True, eq=False)
class Branch:
    """Steady motions that go over into each other as a parameter changes, in order of the arclength.

    over, between: path and range of the parameter; response_period: of all its orbits, in drive periods; 0 for cycles
        of a system that nothing drives in time
    period: [points] length of a response
    parameter, drift, mean_velocity, arclength, stable, word: [points]; states: [points, states] at the section
    multipliers: [points, multipliers] modulo the drift, largest first; drift: NaN without a cyclic coordinate
    symmetric: whether its orbits are their own mirror images; None where the system has no such symmetry
    special_points: in order; ends: why it was not followed beyond its first and its last point
    start: index of the point it was followed from; -1 where no orbit closed there and the branch is empty
    """

    system: System
    over: str
    between: tuple[float, float]
    response_period: int
    symmetric: bool | None
    parameter: np.ndarray
    period: np.ndarray
    states: np.ndarray
    drift: np.ndarray
    mean_velocity: np.ndarray
    multipliers: np.ndarray
    stable: np.ndarray
    word: np.ndarray
    arclength: np.ndarray
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[BranchEnd, BranchEnd]
    start: int
    closing_map: ClosingMap = dataclasses.field(repr=False)

    def __len__(self) -> int:
        return len(self.parameter)

    def orbit(self, point: int) -> Orbit:
        """The orbit at a point of the branch, closed anew, with all that an `Orbit` tells."""
        return self.orbit_near(self.states[point], float(self.parameter[point]), float(self.period[point]))

    def orbits_at(self, value: float) -> list[Orbit]:
        """The orbits of the branch at a value of its parameter: one for each time that it passes there."""
        found = []
        for i in range(len(self) - 1):
            left, right = self.parameter[i : i + 2]
            if min(left, right) <= value < max(left, right) or (i == len(self) - 2 and value == right):
                share = (value - left) / (right - left)
                state = self.states[i] + share * (self.states[i + 1] - self.states[i])
                period = self.period[i] + share * (self.period[i + 1] - self.period[i])
                found.append(self.orbit_near(state, value, float(period)))
        return found

    def orbit_near(self, state: np.ndarray, value: float, period: float) -> Orbit:
        """The orbit closed from a state [states] at a value of the parameter; the period matters to cycles only."""
        map_ = self.closing_map
        system = self.system.with_parameters({self.over: value})
        if self.response_period == 0:
            return near_cycle(system, state, period, map_.tolerance)
        return shoot(
            system, named_states(system, state), self.response_period, half=map_.half, tolerance=map_.tolerance
        )

    def crossings(self, measure: str = "drift", value: float = 0.0) -> "tuple[BranchCrossing, ...]":
        """Where a measure passes a value along the branch, see `branch_crossings`."""
        from vibrocap.orbits.continuation.branch_crossings import branch_crossings

        return branch_crossings(self, measure, value)

    def kind(self, *kinds: SpecialKind) -> tuple[SpecialPoint, ...]:
        """The special points of some kinds."""
        return tuple(special for special in self.special_points if special.kind in kinds)

    @property
    def parts(self) -> tuple[tuple[int, int, bool], ...]:
        """(first point, last point, stable) of each stretch of the branch that is all stable or all unstable."""
        if not len(self):
            return ()
        cuts = np.flatnonzero(np.diff(self.stable.astype(int))) + 1
        edges = [0, *cuts.tolist(), len(self)]
        return tuple((first, last - 1, bool(self.stable[first])) for first, last in itertools.pairwise(edges))

    def table(self) -> list[dict[str, Any]]:
        """The special points as rows of a table."""
        return [
            {
                "kind": special.kind.value,
                self.over: special.parameter,
                "error": special.error,
                "drift": special.drift,
                "stability": special.stability,
                "word before": special.word_before,
                "word after": special.word_after,
                "remarks": _remarks(special),
            }
            for special in self.special_points
        ]

    def __str__(self) -> str:
        """The branch in words."""
        kind = {True: "symmetric ", False: "travelling ", None: ""}[self.symmetric]
        drifts = self.closing_map.map.cyclic >= 0
        kind = kind if drifts or self.symmetric is not False else "asymmetric "
        if not len(self):
            return f"No {kind}branch: {self.ends[0].advice}"
        what = f"orbits of {self.response_period} drive period(s)" if self.response_period else "cycles"
        lines = [
            f"Branch of {kind}{what} over {self.over}, {len(self)} points:",
            *(f"  {row['kind']:20s} {special.parameter:.10g} (error {special.error:.0e})  {row['remarks']}"
              for row, special in zip(self.table(), self.special_points, strict=True)),
            *(f"  {where} at {value:.10g}: {_ended(end)}"
              for where, value, end in zip(("begins", "ends"), self.parameter[[0, -1]], self.ends, strict=True)),
        ]  # fmt: skip
        return "\n".join(lines)


def _ended(end: BranchEnd) -> str:
    """Why a branch ends, with what to try where there is more to it."""
    return f"{end.value}. {end.advice}" if end.early or end is BranchEnd.ORBIT_CEASES else end.value


def _remarks(special: SpecialPoint) -> str:
    """What else is to be said of a special point."""
    said = [special.change.value if special.change else "", special.text]
    if special.kind is SpecialKind.UNLOCATED:
        said.append(special.kind.meaning)
    if special.word_before != special.word_after:
        said.append(f"{special.word_before} -> {special.word_after}")
    if special.passed is not None:
        said.append(f"multipliers jump as over a {special.passed.value}")
    if special.stability != "kept":
        said.append(f"stability {special.stability}")
    return "; ".join(each for each in said if each)


def empty_branch(closure: ClosingMap, between: tuple[float, float]) -> Branch:
    """The record of a branch of which not even the first orbit closed."""
    names = len(closure.system.state_names)
    none, nowhere = np.empty(0), (BranchEnd.START_FAILED, BranchEnd.START_FAILED)
    multipliers = np.empty((0, len(closure.unknowns)), dtype=complex)
    return Branch(
        closure.system, closure.path, between, closure.response_period, closure.symmetric, none, none,
        np.empty((0, names)), none, none, multipliers, np.empty(0, dtype=bool), np.empty(0, dtype=str),
        none, (), nowhere, -1, closure,
    )  # fmt: skip


def joined(closure: ClosingMap, back: Followed | None, onward: Followed | None) -> Branch:
    """The record of a branch from the ways followed from one start, against and along its order."""
    before = [] if back is None else back.points[:0:-1]
    start = (onward or back).points[0]  # type: ignore[union-attr]
    points = [*before, start, *([] if onward is None else onward.points[1:])]
    x = np.stack([point.x for point in points])
    ways = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1)))
    special = []
    if back is not None:
        special = [
            _special(closure, _reversed(each), len(before) - 1 - i, points, ways) for i, each in back.special[::-1]
        ]
    if onward is not None:
        special += [_special(closure, each, len(before) + i, points, ways) for i, each in onward.special]
    multipliers = np.stack([point.multipliers(closure.half) for point in points])
    periods = np.array([closure.period(point.x) for point in points])
    drift = np.array([closure.drift(point.closing) for point in points])
    ends = tuple(BranchEnd.NOT_FOLLOWED if way is None else way.end for way in (back, onward))
    if onward is not None and onward.end is BranchEnd.CLOSED:
        ends = (BranchEnd.CLOSED, BranchEnd.CLOSED)
    return Branch(
        system=closure.system,
        over=closure.path,
        between=closure.between,
        response_period=closure.response_period,
        symmetric=closure.symmetric,
        parameter=np.array([closure.parameter(point.x) for point in points]),
        period=periods,
        states=np.stack([closure.state(point.x, point.closing) for point in points]),
        drift=drift,
        mean_velocity=drift / periods,
        multipliers=multipliers,
        stable=np.all(np.abs(multipliers) < 1.0 - CLOSE_TO_CIRCLE, axis=1),
        word=np.array([point.closing.word for point in points]),
        arclength=ways,
        special_points=tuple(special),
        ends=(ends[0], ends[1]),
        start=len(before),
        closing_map=closure,
    )


def _reversed(found: Found) -> Found:
    """What is special, seen by one who comes along the branch the other way."""
    words, text = found.words[::-1], found.text
    if found.change is not None and found.words[0] != found.words[1] and not text.startswith("this branch"):
        text = word_change(*words)[1]
    return dataclasses.replace(found, words=words, unstable=found.unstable[::-1], text=text)


def _special(
    closure: ClosingMap, found: Found, after: int, points: list[BranchPoint], ways: np.ndarray
) -> SpecialPoint:
    """The public record of what is special after a point of a branch."""
    point = found.point
    drift = closure.drift(point.closing)
    return SpecialPoint(
        kind=found.kind,
        parameter=closure.parameter(point.x),
        error=found.error,
        state=named_states(closure.system, closure.state(point.x, point.closing)),
        drift=None if np.isnan(drift) else drift,
        multipliers=point.multipliers(closure.half),
        arclength=float(ways[after] + np.linalg.norm(point.x - points[after].x)),
        after_point=after,
        word_before=found.words[0],
        word_after=found.words[1],
        unstable_before=found.unstable[0],
        unstable_after=found.unstable[1],
        change=found.change,
        passed=found.passed,
        text=found.text,
        found=found,
    )
