"""Steady sliding in one mode of the contacts, as a residual with the special points of its branches."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import Expression
from vibrocap.orbits.equilibria.bifurcations import Located, first_lyapunov_coefficient, fold, hopf
from vibrocap.orbits.equilibria.search import GUARDED, STANDS
from vibrocap.orbits.equilibria.steady_equations import SteadyEquations
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.orbits.walk.branch_point import BranchPoint
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.newton import Levels
from vibrocap.orbits.walk.residual import Closing, Residual
from vibrocap.orbits.walk.segment import Lost, Segment
from vibrocap.orbits.walk.special_points import Found

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
        """Of the unknowns without the parameter."""
        return len(self.problem.unknowns)

    @property
    def width(self) -> float:
        return self.between[1] - self.between[0]

    def parameter(self, x: np.ndarray) -> float:
        return float(self.between[0] + x[-1] * self.width)

    def state(self, x: np.ndarray) -> np.ndarray:
        return x[:-1] * self.problem.scales

    def point(self, y: np.ndarray, parameter: float) -> np.ndarray:
        """x of unknowns and a value of the parameter."""
        return np.append(y / self.problem.scales, (parameter - self.between[0]) / self.width)

    def values(self, expressions: Sequence[Expression], x: np.ndarray) -> np.ndarray:
        """Values [expressions] of recorded expressions at a point."""
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
        """Whether every eigenvalue amid the step is nearly the mean of those at its ends.

        So none of them passes the imaginary axis unseen.
        """
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
        """State, and of a Hopf point its frequency, its first Lyapunov coefficient and its eigenvector."""
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
