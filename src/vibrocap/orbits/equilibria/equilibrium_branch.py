"""A branch of equilibria over a parameter: steady sliding in one mode, its folds, its Hopf points, and why it ends."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.numerics.expressions.graph import Expression
from vibrocap.orbits.equilibria.bifurcations import Located, first_lyapunov_coefficient, fold, hopf
from vibrocap.orbits.equilibria.equilibrium import Equilibrium, RestSet, equilibrium, sorted_eigenvalues, stable
from vibrocap.orbits.equilibria.steady_states import GUARDED, STANDS, SteadyEquations, SteadyState, steady_states
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.orbits.parameter_range import checked_range, system_at
from vibrocap.orbits.walk.branch_record import BranchRecord
from vibrocap.orbits.walk.following import Walked, followed, started, walked
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.residual import BranchPoint, Closing, Levels, Residual
from vibrocap.orbits.walk.segment import Lost, Segment
from vibrocap.orbits.walk.special_points import Found, SpecialPoint
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path, value_in_words
from vibrocap.physics.system import System
from vibrocap.quantities.declared import AngularFrequencies, Numbers, Over, Speeds, StateColumns

BENT = 0.1  # of an eigenvalue, by which it may leave the straight line amid a step
UNRESOLVED = 1e-12  # of the largest eigenvalue, below which another is rounding beside it
NEAR = 2.0  # steps of the branch within which a located point must lie
ON_AXIS = 1e-9  # real part over the eigenvalue that is zero up to rounding


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyClosing(Closing):
    """A state tried as an equilibrium of a mode; jacobian: of the rates, whose eigenvalues decide the stability."""

    mode: "Sliding" = dataclasses.field(kw_only=True)
    rows: np.ndarray = dataclasses.field(kw_only=True)

    @property
    def derivative(self) -> np.ndarray:
        return np.column_stack((self.jacobian, self.slope)) / self.rows[:, None]

    def unstable(self) -> int:
        """How many real parts are positive."""
        return int(np.sum(np.real(self.eigenvalues) > ON_AXIS * np.abs(self.eigenvalues)))

    @functools.cached_property
    def boundary(self) -> BranchEnd | None:
        """By speeds of sliding, guards of the branches and bounds of the equations: positive within a mode."""
        mode, recording = self.mode, self.mode.problem.recording
        velocities = mode.values(mode.problem.velocities, self.x)
        sizes = mode.problem.sizes
        for side, velocity, contact in zip(mode.sides, velocities, recording.contacts, strict=True):
            if contact.kind != "smooth" and not side * velocity / sizes[contact.state] > STANDS:
                return BranchEnd.REST
        if not np.all(mode.values(recording.switches, self.x) > -GUARDED):
            return BranchEnd.OTHER_BRANCH
        return None if np.all(mode.values(recording.bounds, self.x) > 0.0) else BranchEnd.NO_LOAD


def matched(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Eigenvalues in the order of a neighbour's to which they are nearest."""
    from scipy.optimize import linear_sum_assignment  # only here: it takes long to load

    sizes = np.maximum(np.abs(values)[None], np.abs(like)[:, None])
    away = np.abs(values[None] - like[:, None]) / np.where(sizes > 0.0, sizes, 1.0)
    return values[linear_sum_assignment(away)[1]]


@dataclasses.dataclass(frozen=True, eq=False)
class Sliding(Residual):
    """A problem in one mode of the contacts with the parameter among the unknowns, over natural sizes.

        z = y/d,  q the share of the parameter's range:     f = F/d,  J = d^-1 (dF/dy) d,  with the same eigenvalues

    x = (z, q) is [unknowns + 1]. The mismatch is f over the lengths of the rows of its derivative by x: a distance.
    """

    problem: SteadyEquations
    sides: np.ndarray
    switched: np.ndarray
    between: tuple[float, float]

    levels = Levels(1e-15, 1e-11)
    quick = 4
    growth = 2.0
    straight = 0.95

    @property
    def count(self) -> int:
        return len(self.problem.unknowns)

    def state(self, x: np.ndarray) -> np.ndarray:
        return x[:-1] * self.problem.scales

    def point(self, y: np.ndarray, parameter: float) -> np.ndarray:
        """x of unknowns and a value of the parameter."""
        return np.append(y / self.problem.scales, self.share(parameter))

    def values(self, expressions: Sequence[Expression], x: np.ndarray) -> np.ndarray:
        row = self.problem.row.copy()
        row[self.problem.index] = self.parameter(x)
        return self.problem.values(expressions, self.state(x), self.sides, self.switched, row)

    def rates(self, x: np.ndarray) -> np.ndarray:
        """f, [unknowns]."""
        return self.values(self.problem.rates, x) / self.problem.scales

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """J, [unknowns, unknowns]."""
        d = self.problem.scales
        return self.values(self.problem._jacobian, x).reshape(self.count, -1) * d / d[:, None]

    def derivative(self, x: np.ndarray) -> np.ndarray:
        """Of f by x, [unknowns, unknowns + 1]."""
        slope = self.values(self.problem._parameter_slopes[: self.count], x) * self.width / self.problem.scales
        return np.column_stack((self.jacobian(x), slope))

    def curvature(self, x: np.ndarray) -> np.ndarray:
        """Of J by x, [unknowns, unknowns, unknowns + 1]."""
        n, d = self.count, self.problem.scales
        by_states = self.values(self.problem._curvatures, x).reshape(n, n, n) * d
        by_parameter = self.values(self.problem._parameter_slopes[n:], x).reshape(n, n, 1) * self.width
        return np.concatenate((by_states, by_parameter), axis=2) * d[None, :, None] / d[:, None, None]

    def attempt(self, x: np.ndarray, like: Any = None) -> SteadyClosing:
        rates, derivative = self.rates(x), self.derivative(x)
        finished = bool(np.all(np.isfinite(rates)) and np.all(np.isfinite(derivative)))
        rows = np.linalg.norm(derivative, axis=1) if finished else np.ones(len(rates))
        rows = np.where(rows > 0.0, rows, 1.0)
        return SteadyClosing(
            x=x,
            mismatch=rates / rows,
            jacobian=derivative[:, :-1],
            slope=derivative[:, -1],
            at_rest=np.zeros(len(rates), dtype=bool),
            finished=finished,
            mode=self,
            rows=rows,
        )

    def resolved(self, here: BranchPoint, new: BranchPoint) -> bool:
        """Whether eigenvalues amid the step are nearly the means of its ends: none passes the imaginary axis unseen."""
        try:
            amid = Segment(self, here, new).point(0.5)
        except Lost:
            return False
        first = here.closing.eigenvalues
        middle, last = (matched(point.closing.eigenvalues, first) for point in (amid, new))
        size = np.max(np.abs([first, middle, last]), axis=0)
        floor = UNRESOLVED * float(np.max(size, initial=0.0))
        return not np.any(np.abs(middle - 0.5 * (first + last)) > BENT * size + floor)

    def special_points(self, segment: Segment, left: float, right: float, at_parent: bool) -> list[Found]:
        first, last = segment.point(left), segment.point(right)
        counts = first.closing.unstable(), last.closing.unstable()
        old, new = first.closing.eigenvalues, matched(last.closing.eigenvalues, first.closing.eigenvalues)
        neutral = [np.abs(np.real(values)) <= ON_AXIS * np.abs(values) for values in (old, new)]
        turns = first.tangent[-1] * last.tangent[-1] < 0.0
        special_points: list[Found] = []
        for k in range(len(old)):
            sided = old[k].real * new[k].real < 0.0 and not (neutral[0][k] or neutral[1][k])
            left_axis = neutral[0][k] != neutral[1][k] and (new[k] if neutral[0][k] else old[k]).real > 0.0
            if not (sided or left_axis) or (old[k].imag < 0.0 or new[k].imag < 0.0):
                continue
            share = float(abs(old[k].real) / (abs(old[k].real) + abs(new[k].real))) if sided else 0.5
            try:
                near = segment.point(left + share * (right - left))
            except Lost:
                near = first
            kind, located = SpecialKind.UNLOCATED, None
            if abs(old[k].imag) > 0.0 and abs(new[k].imag) > 0.0:
                guess = complex(0.0, float((1.0 - share) * old[k].imag + share * new[k].imag))
                kind = SpecialKind.MODE_COUPLING if left_axis else SpecialKind.HOPF
                located = hopf(self, near.x, guess, coupled=left_axis)
            elif turns:
                kind, located = SpecialKind.FOLD, fold(self, near.x)
            elif old[k].imag == new[k].imag == 0.0:
                kind, located = SpecialKind.BRANCH_POINT, self._branch_point(segment, k)
            if located is None or np.linalg.norm(located.x - near.x) > NEAR * segment.length:
                width = abs(self.parameter(last.x) - self.parameter(first.x))
                kind, located = SpecialKind.UNLOCATED, Located(near.x, width, 0.0, np.zeros(self.count))
            if not any(known.kind is kind and self._same(known, located) for known in special_points):
                at = segment.normal @ (located.x - segment.points[0].x) / segment.length
                point = BranchPoint(self.attempt(located.x), first.tangent)
                numbers: dict[str, Any] = {"frequency": located.frequency, "vector": located.vector}
                special_points.append(Found(kind, float(at), point, located.error, counts, ("", ""), **numbers))
        return special_points

    def _same(self, known: Found, located: Located) -> bool:
        """Whether a special point is one that is known, of the conjugate eigenvalue."""
        parameter, frequency = self.parameter(located.x), located.frequency
        near = abs(self.parameter(known.point.x) - parameter) <= known.error + 1e-9 * abs(parameter)
        return near and abs(known.frequency - frequency) <= 1e-6 * frequency

    def _branch_point(self, segment: Segment, k: int) -> Located | None:
        """Where a real eigenvalue passes zero without a turn of the branch, by a bracketed root along it."""
        first, last = segment.points[0], segment.points[-1]

        def smallest(point: BranchPoint) -> float:
            return float(matched(point.closing.eigenvalues, first.closing.eigenvalues)[k].real)

        ends = smallest(first), smallest(last)
        if not ends[0] * ends[1] < 0.0:
            return None
        try:
            bracket = segment.root(smallest)
        except Lost:
            return None
        point = segment.point(bracket.left)
        jacobian, span = point.closing.jacobian, abs(self.parameter(last.x) - self.parameter(first.x))
        values, vectors = np.linalg.eig(jacobian)
        at = int(np.argmin(np.abs(values)))
        # Rounding moves an eigenvalue by its condition times that of the matrix; one that is double there much farther.
        left = np.linalg.inv(vectors)[at] if np.linalg.cond(vectors) < 1e14 else np.full(len(values), np.inf)
        condition = float(np.linalg.norm(left) * np.linalg.norm(vectors[:, at]))
        noise = 16.0 * float(np.finfo(float).eps) * condition * float(np.linalg.norm(jacobian))
        width = (bracket.right - bracket.left) * span
        error = noise * span / abs(ends[1] - ends[0]) + width + 1e-15 * abs(self.parameter(point.x))
        return Located(point.x, error, 0.0, np.real(vectors[:, at]))

    def described(self, record: Found) -> dict[str, Any]:
        problem, x = self.problem, record.point.x
        state, vector = self.switched.copy(), np.zeros(len(self.switched), dtype=complex)
        state[problem.unknowns] = self.state(x)
        assert record.vector is not None
        vector[problem.unknowns] = record.vector * problem.scales
        length = float(np.linalg.norm(vector))
        hopf_point = record.kind is SpecialKind.HOPF
        return {
            "state": {name: value + 0.0 for name, value in named_states(problem.system, state).items()},
            "frequency": record.frequency or None,
            "lyapunov": first_lyapunov_coefficient(self, x, record.frequency, record.vector) if hopf_point else None,
            "vector": vector / length if length > 0.0 else vector,
        }


LONGEST = 0.02  # step, as a share of the range and of the size of the states


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class EquilibriumBranch(BranchRecord):
    """Equilibria that go over into each other as a parameter changes, in order along the branch.

    over, between: path and range of the parameter; sides: of each contact, the same all along
    parameter: [points]; states: [points, states]; travel: [points] rate of the cyclic coordinate, NaN without one
    eigenvalues: [points, eigenvalues] largest real part first; unstable: [points] how many have positive real parts
    stable: [points]; ends: why it ends at its first and its last point
    """

    system: System
    over: Path
    between: tuple[Parameter, Parameter]
    sides: tuple[int, ...]
    parameter: Annotated[Parameters, Over("point", name="over")]
    states: Annotated[StateColumns, Over("point")]
    travel: Annotated[Speeds, Over("point", words="rate of the cyclic coordinate")]
    eigenvalues: Annotated[AngularFrequencies, Over("point", "eigenvalue", words="eigenvalue")]
    unstable: Annotated[Numbers, Over("point", words="how many eigenvalues have positive real parts")]
    stable: Annotated[Numbers, Over("point", words="no eigenvalue has a positive real part")]
    special_points: Annotated[tuple[SpecialPoint, ...], Over("special")]
    ends: tuple[BranchEnd, BranchEnd]
    mode: Sliding = dataclasses.field(compare=False)

    in_record = "over between parameter states travel eigenvalues stable special_points ends advice"

    @property
    def heading(self) -> str:
        return f"branch of steady sliding over {self.over}"

    @property
    def facts(self) -> dict[str, str]:
        special = ", ".join(f"{point.kind.value} at {point.said('parameter')}" for point in self.special_points)
        return super().facts | ({"special points": special} if special else {})

    @property
    def largest_real_part(self) -> Annotated[AngularFrequencies, Over("point", words="largest real part")]:
        """Of the eigenvalues at each point."""
        return np.real(self.eigenvalues)[:, 0]

    @property
    def hopf_points(self) -> tuple[SpecialPoint, ...]:
        return self.kind(SpecialKind.HOPF)

    def equilibrium(self, point: int) -> Equilibrium:
        system = system_at(self.system, self.over, float(self.parameter[point]))
        problem = SteadyEquations(system, self.over)
        y = self.states[point][problem.unknowns]
        n, sides = len(problem.unknowns), self.mode.sides
        state = SteadyState(y, sides, np.zeros(len(sides), dtype=bool), self.mode.switched, np.zeros((n, 0)))
        return equilibrium(problem, RestSet(state, y, y))


def equilibrium_branch(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    *,
    start: Equilibrium | None = None,
    points: int = 2000,
) -> EquilibriumBranch:
    """The branch of steady sliding through one state of it, over a range of a parameter.

    Followed by its arclength, past folds and as an unstable branch. Folds and Hopf points are roots of equations of
    their own (`bifurcations.py`); `error` bounds the effect of rounding, so the exact place lies within it.

    over: path of the parameter, such as "machine.belt_speed"; between: its least and largest value
    start: a state of steady sliding of the system; by default the only one at the system's own parameters (where these
        are out of the range, at its nearer end)
    points: most points in each direction

    Raises ArgumentError for a system that is driven in time, one without steady sliding at the start, one with several
    of which none is given, and a start that is none of the system.
    """
    low, high = checked_range(system, over, between)
    check_whole("points", points, 10)
    if start is not None:
        if not isinstance(start, Equilibrium) or start.kind != "steady sliding" or start.dimension:
            raise ArgumentError("start", "should be a state of steady sliding, one of `equilibria(system).sliding`")
        if start.system.with_parameters({over: system.parameter(over)}) != system:
            raise ArgumentError("start", f"should be of the system, at any {over}: another parameter differs")
        system = start.system
    value = min(max(float(system.parameter(over)), low), high)
    if start is not None and value != float(system.parameter(over)):
        least, most = (value_in_words(over, number, system) for number in (low, high))
        raise ArgumentError("start", f"should have its {over} within {least} to {most}")
    problem = SteadyEquations(system_at(system, over, value), over)
    state = _start(problem, start)
    mode = Sliding(problem, state.sides, state.switched, (low, high))
    begun = started(mode, mode.point(state.y, value))
    if begun is None:
        why = f"should slide steadily at {_place(problem)}, but Newton's method leaves the state"
        raise ArgumentError("system", why)
    onward, back = followed(mode, begun, 1.0, points, LONGEST), None
    if onward.end is not BranchEnd.CLOSED:
        back = followed(mode, begun, -1.0, points, LONGEST)
    return _joined(mode, walked(mode, back, onward))


def _start(problem: SteadyEquations, start: Equilibrium | None) -> SteadyState:
    moving = [state for state in steady_states(problem) if not state.rests.any() and not state.dimension]
    value = _place(problem)
    if start is not None:
        y = np.array([start.state[name] for name in problem.system.state_names])[problem.unknowns]
        limit = 1e-6 * (1.0 + np.max(np.abs(y)))
        for steady in moving:
            if np.max(np.abs(steady.y - y) / problem.scales) <= limit:
                return steady
        raise ArgumentError("start", f"should be an equilibrium of the system at {value}, but none is there")
    if not moving:
        raise ArgumentError("system", f"should slide steadily at {value}, but no such state was found")
    if len(moving) > 1:
        raise ArgumentError("start", f"should be given: at {value} there are {len(moving)} states of steady sliding")
    return moving[0]


def _place(problem: SteadyEquations) -> str:
    """The value of the parameter, in words."""
    path = str(problem.path)
    return f"{path} = {value_in_words(path, problem.system.parameter(path), problem.system)}"


def _joined(mode: Sliding, walk: Walked) -> EquilibriumBranch:
    problem, points = mode.problem, walk.points
    states = np.tile(mode.switched, (len(points), 1))
    states[:, problem.unknowns] = np.stack([mode.state(point.x) for point in points])
    cyclic = problem.recording.cyclic_state
    rate = [problem.recording.rates[cyclic]] if cyclic >= 0 else []
    travel = np.array([(*mode.values(rate, point.x), np.nan)[0] for point in points])
    jacobians = [point.closing.jacobian for point in points]
    return EquilibriumBranch(
        system=problem.system,
        over=str(problem.path),
        between=mode.between,
        sides=tuple(int(side) for side in mode.sides),
        parameter=np.array([mode.parameter(point.x) for point in points]),
        states=states + 0.0,
        travel=travel,
        eigenvalues=np.stack([sorted_eigenvalues(jacobian) for jacobian in jacobians]),
        unstable=np.array([point.closing.unstable() for point in points]),
        stable=np.array([stable(jacobian) is True for jacobian in jacobians]),
        special_points=walk.special_points,
        ends=walk.ends,
        mode=mode,
    )
