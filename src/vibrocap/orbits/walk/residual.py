"""What vanishes along a branch: its value with its derivatives at a point, and Newton's way to where it does.

Newton's method stands here once for all that has to vanish: points of branches, orbits, special points. Within the ball
of convergence each step leaves less than half of the residual (Kantorovich: h_k/2 with h_k < 1). A step that leaves
more is outside of that ball or has met the rounding of the residual itself, whose level the residual knows. So it stops
where there is nothing left to gain, or where a step that no longer halves the residual has come to that level. On the
way into the ball a step is halved while it makes the residual larger, or, where that costs more than another guess, is
taken as it is a few times.
"""

import dataclasses
import functools
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.recorded.sticking import by_contact, first_turned
from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind, mode_change

if TYPE_CHECKING:
    from vibrocap.orbits.walk.segment import Segment
    from vibrocap.orbits.walk.special_points import Found

STALLED = 0.5  # share of the residual that a step within the ball of convergence leaves at most
ASTRAY = 4  # steps after which one that makes the residual larger is not on the way into the ball


class Levels(NamedTuple):
    """Residuals: `enough`, at which nothing is left to gain, and the largest that rounding can explain."""

    enough: float
    rounding: float


class Trial(Protocol):
    """A point that was tried: `residual` is infinite where nothing could be evaluated."""

    @property
    def x(self) -> np.ndarray: ...

    @property
    def residual(self) -> float: ...

    def step(self) -> np.ndarray | None:
        """Newton's step from here; None where nothing can be varied."""
        ...


Tried = TypeVar("Tried", bound=Trial)


def newton(
    attempt: Callable[[np.ndarray], Tried],
    x: np.ndarray,
    levels: Levels,
    most: int,
    *,
    stride: float = np.inf,
    halvings: int = 0,
) -> tuple[Tried, int]:
    """(the best point tried, steps taken) from x; it is a root where its residual is at most `levels.rounding`.

    most: steps; stride: longest, in the largest component; halvings: of a step that does not reduce the residual
    """
    best = trial = attempt(x)
    for steps in range(most):
        step = trial.step() if levels.enough < trial.residual < np.inf else None
        if step is None:
            return best, steps
        step = step * min(1.0, stride / max(float(np.max(np.abs(step))), 1e-300))
        following = attempt(trial.x + step)
        for _ in range(halvings if trial.residual > levels.rounding else 0):
            if following.residual < trial.residual:
                break
            step = 0.5 * step
            following = attempt(trial.x + step)
        if following.residual < best.residual:
            best = following
        stalls = not following.residual < STALLED * trial.residual
        astray = following.residual >= trial.residual and (halvings > 0 or steps + 1 >= ASTRAY)
        if astray or (stalls and best.residual <= levels.rounding):
            return best, steps + 1
        trial = following
    return best, most


CLOSE_TO_CIRCLE = 1e-8  # a multiplier whose size is this close to 1 is neither stable nor unstable


@dataclasses.dataclass(frozen=True, eq=False)
class Closing:
    """What a residual makes of a point x = (unknowns over their natural sizes, share q of the parameter's range).

    mismatch: [m] what shall vanish: of a map, image less start; jacobian: [m, m] of the image by the start; slope: [m]
        of the mismatch by q
    at_rest: [m] whether the unknown is exactly zero: the velocity of a contact that sticks
    mode_sequence: of the contacts along a motion; turns: length of a whole turn along each unknown, infinite where it
        does not turn; None: none of them does
    """

    x: np.ndarray
    mismatch: np.ndarray
    jacobian: np.ndarray
    slope: np.ndarray
    at_rest: np.ndarray
    finished: bool
    mode_sequence: str = ""
    turns: np.ndarray | None = dataclasses.field(default=None, kw_only=True)

    def alike(self, other: "Closing") -> bool:
        """Whether the same happens in both, so that all is smooth between them."""
        return self.itinerary == other.itinerary

    @property
    def itinerary(self) -> Hashable:
        """What happens along the motion, as far as it can change along a branch."""
        return tuple(map(first_turned, by_contact(self.mode_sequence)))

    def change_to(self, other: "Closing") -> tuple[SpecialKind, ModeChange | None, str]:
        """(kind, change of modes, in words): how the itinerary changes from here to another point."""
        return SpecialKind.MODE_CHANGE, *mode_change(self.mode_sequence, other.mode_sequence)

    @functools.cached_property
    def boundary(self) -> BranchEnd | None:
        """The end of the branch that lies before this point, where the equations do not hold any more; None within."""
        return None

    @functools.cached_property
    def eigenvalues(self) -> np.ndarray:
        """That decide the stability: of a map, its own multipliers."""
        return np.linalg.eigvals(self.jacobian).astype(complex)

    def unstable(self) -> int:
        """Number of eigenvalues that are not inside of the stable region: of a map, on or outside the unit circle."""
        return int(np.sum(np.abs(self.eigenvalues) >= 1.0 - CLOSE_TO_CIRCLE))

    def away(self, x: np.ndarray) -> np.ndarray:
        """Points [..., m + 1] less this one, modulo whole turns."""
        gained = x - self.x
        if self.turns is None:
            return gained
        turning = np.isfinite(self.turns)
        gained[..., turning] -= self.turns[turning] * np.round(gained[..., turning] / self.turns[turning])
        return gained

    @functools.cached_property
    def size(self) -> float:
        """Largest unknown that does not turn, over its natural size; at least 1."""
        unknowns = self.x[:-1] if self.turns is None else self.x[:-1][np.isinf(self.turns[:-1])]
        return float(np.max(np.abs(unknowns), initial=1.0))

    @property
    def residual(self) -> float:
        """Largest mismatch; infinite where the point could not be evaluated."""
        largest = float(np.max(np.abs(self.mismatch)))
        return largest if self.finished and np.isfinite(largest) else np.inf

    @property
    def derivative(self) -> np.ndarray:
        """Of the mismatch by x, [m, m + 1]."""
        return np.column_stack((self.jacobian - np.eye(len(self.mismatch)), self.slope))


class Residual(Protocol):
    """What is followed: implement `attempt`, `special_points` and `described`, and the walk does the rest.

    between: range of the parameter
    half: whether the map is S P_(T/2), whose multipliers are the roots of those of the orbit
    levels: of the mismatch, for Newton's method; growth: of the step where it takes no more than `quick` steps
    straight: cosine of the turn of the tangent over a step, at least
    """

    between: tuple[float, float]
    half: bool = False
    levels: Levels = Levels(1e-12, 3e-11)
    quick: int = 3
    growth: float = 1.5
    straight: float = 0.9

    def attempt(self, x: np.ndarray, like: Any = None) -> Closing:
        """The closing of a point; `like`: of a neighbour, whose switched states are taken over."""
        ...

    def parameter(self, x: np.ndarray) -> float:
        """The parameter's value at a point."""
        return float(self.between[0] + x[-1] * self.width)

    @property
    def width(self) -> float:
        """Of the parameter's range."""
        return self.between[1] - self.between[0]

    def share(self, parameter: float) -> float:
        """Where a value of the parameter is in its range."""
        return (parameter - self.between[0]) / self.width

    def special_points(self, segment: "Segment", left: float, right: float, at_parent: bool) -> "list[Found]":
        """Special points of a smooth stretch of a segment; at_parent: it begins or ends at another branch."""
        ...

    def described(self, record: "Found") -> dict[str, Any]:
        """What else the record of a special point says: its state by name, and what belongs to it."""
        ...

    def resolved(self, here: "BranchPoint", new: "BranchPoint") -> bool:
        """Whether a step is short enough to see what happens on the way."""
        return True

    def differ(self, one: Closing, other: Closing) -> bool:
        """Whether something else happens at two points of which one does not close."""
        return not one.alike(other)

    def ending(self, points: "list[BranchPoint]", end: BranchEnd) -> "tuple[BranchEnd, Found | None]":
        """The name of an end at which the walk sees only that nothing closes, and the special point there."""
        return end, None

    def coarser(self) -> "Residual | None":
        """The map of which this one is the square: its fixed points are where a branch of this one bifurcates."""
        return None

    def finer(self) -> "Residual":
        """The square of this map: what bifurcates at a multiplier -1 of this one closes under it."""
        raise ArgumentError("special", "should be a point of driven orbits: nothing is followed from this one")


FORGOTTEN = 1e-13  # size of a multiplier below which, with a law that sticks, it is zero
MOST_STEPS = 10
LONGEST_STRIDE = 0.5  # of a step of Newton's method, over natural sizes and the size of the states


@dataclasses.dataclass(frozen=True, eq=False)
class BranchPoint:
    """A point that closes, and the unit tangent of the branch there; closing: the `Closing` of its residual."""

    closing: Any
    tangent: np.ndarray

    @property
    def x(self) -> np.ndarray:
        """Unknowns over natural sizes, then the share of the parameter's range."""
        return self.closing.x

    def longest(self, step: float) -> float:
        """The longest step from here: a share of the range and of the size of the states."""
        states, parameter = self.tangent[:-1] / self.closing.size, self.tangent[-1]
        return step / float(np.hypot(np.linalg.norm(states), parameter))

    def multipliers(self, half: bool) -> np.ndarray:
        """Floquet multipliers of the orbit, largest first.

        The map over a period is the square of the half-period map, P_T = (S P_(T/2))^2, and so are its multipliers.
        """
        values = self.closing.eigenvalues**2 if half else self.closing.eigenvalues
        values = np.where(np.abs(values) <= FORGOTTEN, 0.0, values)
        return values[np.argsort(-np.abs(values), kind="stable")]


@dataclasses.dataclass(frozen=True, eq=False)
class _OnPlane:
    """A closing tried in the plane normal . x = level: what shall vanish is its mismatch and the distance from it."""

    closing: Closing
    normal: np.ndarray
    gap: float

    @property
    def x(self) -> np.ndarray:
        return self.closing.x

    @property
    def residual(self) -> float:
        return max(self.closing.residual, abs(self.gap))

    def step(self) -> np.ndarray:
        matrix = np.vstack((self.closing.derivative, self.normal))
        return np.linalg.lstsq(matrix, -np.append(self.closing.mismatch, self.gap), rcond=1e-14)[0]


def corrected(
    residual: Residual, guess: np.ndarray, normal: np.ndarray, level: float, like: Closing | None = None
) -> tuple[Any, int]:
    """(the closed point nearest to a guess in the plane normal . x = level, steps taken); None where there is none.

    Newton's method on the mismatch and the plane together. What sticks in the image sticks in the start.
    """
    last = like

    def attempt(x: np.ndarray) -> _OnPlane:
        nonlocal last
        if last is not like:
            x[:-1][last.at_rest] = 0.0  # type: ignore[union-attr]
        last = residual.attempt(x, last)
        return _OnPlane(last, normal, float(normal @ last.x - level))

    stride = LONGEST_STRIDE * (1.0 if like is None else like.size)
    best, steps = newton(attempt, guess, residual.levels, MOST_STEPS, stride=stride)
    return (best.closing if best.residual <= residual.levels.rounding else None), steps


def closed_at(residual: Residual, guess: np.ndarray, level: float, like: Closing | None = None) -> Any:
    """The closed point nearest to a guess at a share of the parameter's range; None where there is none."""
    return corrected(residual, guess, np.eye(len(guess))[-1], level, like)[0]


def tangent(closing: Closing, towards: np.ndarray) -> np.ndarray:
    """The unit tangent of a branch at a closed point, on the side of a vector that is nearly one."""
    matrix = np.vstack((closing.derivative, towards))
    wanted = np.zeros(len(towards))
    wanted[-1] = 1.0
    solution = np.linalg.lstsq(matrix, wanted, rcond=1e-14)[0]
    size = float(np.linalg.norm(solution))
    return solution / size if size > 0.0 and np.isfinite(size) else towards / np.linalg.norm(towards)


def null_tangent(closing: Closing) -> np.ndarray:
    """The unit tangent of a branch of which no neighbour is known, towards larger parameters."""
    null_vector = np.linalg.svd(closing.derivative)[2][-1]
    return null_vector if null_vector[-1] >= 0.0 else -null_vector
