"""One mode of the contacts in steady sliding, as a residual that can be followed over a parameter."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import Expression
from vibrocap.orbits.equilibria.search import STANDS
from vibrocap.orbits.equilibria.steady_equations import SteadyEquations
from vibrocap.orbits.walk.brackets import Lost
from vibrocap.orbits.walk.branch_point import BranchPoint
from vibrocap.orbits.walk.ends import BranchEnd
from vibrocap.orbits.walk.newton import Levels
from vibrocap.orbits.walk.residual import Closing, Residual
from vibrocap.orbits.walk.segment import Segment

BENT = 0.1  # of an eigenvalue, by which it may leave the straight line amid a step
UNRESOLVED = 1e-12  # of the largest eigenvalue, below which another is rounding beside it
GUARDED = 1e-9  # value of a guard down to which its branch of the equations holds
ON_AXIS = 1e-9  # real part over the eigenvalue that is zero up to rounding


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyClosing(Closing):
    """A state tried as an equilibrium of a mode; jacobian: of the rates, whose eigenvalues decide the stability."""

    mode: "Mode" = dataclasses.field(kw_only=True)
    rows: np.ndarray = dataclasses.field(kw_only=True)

    @property
    def derivative(self) -> np.ndarray:
        return np.column_stack((self.jacobian, self.slope)) / self.rows[:, None]

    @functools.cached_property
    def eigenvalues(self) -> np.ndarray:
        return super().eigenvalues

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
class Mode(Residual):
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
        """Of the range."""
        return self.between[1] - self.between[0]

    def parameter(self, x: np.ndarray) -> float:
        """The value of the parameter."""
        return float(self.between[0] + x[-1] * self.width)

    def state(self, x: np.ndarray) -> np.ndarray:
        """The unknowns themselves."""
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

    def longest(self, x: np.ndarray, step: float) -> float:
        """A share of the range, and of the size of the states."""
        return step * (1.0 + float(np.max(np.abs(x))))

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
