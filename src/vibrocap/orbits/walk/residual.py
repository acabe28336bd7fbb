"""What vanishes along a branch: its value at a point with its derivatives, and what a residual tells the walk."""

import dataclasses
import functools
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.recorded.sticking import by_contact, first_turned
from vibrocap.orbits.walk.itinerary import ModeChange, mode_change
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.newton import Levels

if TYPE_CHECKING:
    from vibrocap.orbits.walk.branch_point import BranchPoint
    from vibrocap.orbits.walk.segment import Segment
    from vibrocap.orbits.walk.special_points import Found

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
    """What is followed: implement `attempt`, `parameter`, `special_points` and `described`, and the walk does the rest.

    half: whether the map is S P_(T/2), whose multipliers are the roots of those of the orbit
    levels: of the mismatch, for Newton's method; growth: of the step where it takes no more than `quick` steps
    straight: cosine of the turn of the tangent over a step, at least
    """

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
        ...

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
