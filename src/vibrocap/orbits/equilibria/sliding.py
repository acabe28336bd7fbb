"""Steady sliding as a branch: the special points of a mode, each the root of an equation of its own."""

from typing import Any

import numpy as np

from vibrocap.orbits.equilibria.bifurcations import Located, first_lyapunov_coefficient, fold, hopf
from vibrocap.orbits.equilibria.mode import ON_AXIS, Mode, matched
from vibrocap.orbits.walk.brackets import Lost
from vibrocap.orbits.walk.branch_point import BranchPoint
from vibrocap.orbits.walk.segment import Segment
from vibrocap.orbits.walk.special_kind import SpecialKind
from vibrocap.orbits.walk.special_points import Found

NEAR = 2.0  # steps of the branch within which a located point must lie


class Sliding(Mode):
    """A mode with its special points: eigenvalues that pass the imaginary axis."""

    def special_points(self, segment: Segment, left: float, right: float, at_parent: bool) -> list[Found]:
        first, last = segment.point(left), segment.point(right)
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
            if not any(
                special_point.kind is kind and self._same(special_point, located) for special_point in special_points
            ):
                at = segment.normal @ (located.x - segment.points[0].x) / segment.length
                point, counts = BranchPoint(self.attempt(located.x), first.tangent), (first.unstable(), last.unstable())
                numbers = {"frequency": located.frequency, "vector": located.vector}
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

    def described(self, found: Found) -> dict[str, Any]:
        """State, and of a Hopf point its frequency, its first Lyapunov coefficient and its eigenvector."""
        problem, x = self.problem, found.point.x
        state, vector = self.switched.copy(), np.zeros(len(self.switched), dtype=complex)
        state[problem.unknowns] = self.state(x)
        assert found.vector is not None
        vector[problem.unknowns] = found.vector * problem.scales
        length = float(np.linalg.norm(vector))
        lyapunov = None
        if found.kind is SpecialKind.HOPF:
            lyapunov = first_lyapunov_coefficient(self, x, found.frequency, found.vector)
        return {
            "state": {name: float(value) + 0.0 for name, value in zip(problem.system.state_names, state, strict=True)},
            "frequency": found.frequency or None,
            "lyapunov": lyapunov,
            "vector": vector / length if length > 0.0 else vector,
        }
