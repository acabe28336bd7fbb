"""A point of a branch: a start that closes, the direction in which the branch continues, and Newton's way there."""

import dataclasses

import numpy as np

from vibrocap.orbits.closing.periodic_solution import CLOSE_TO_CIRCLE, FORGOTTEN
from vibrocap.orbits.maps.closing_map import Closing, Closure

POINT_CLOSED = 1e-12  # residual at which a point is accepted
ROUNDING = 3e-11  # the same where no step of Newton's method makes it smaller
MOST_STEPS = 10
LONGEST_STRIDE = 0.5  # of a step of Newton's method, over natural sizes


@dataclasses.dataclass(frozen=True, eq=False)
class BranchPoint:
    """A closed orbit on a branch: its closing and the unit tangent of the branch there."""

    closing: Closing
    tangent: np.ndarray

    @property
    def x(self) -> np.ndarray:
        """States over natural sizes, then the share of the parameter's range."""
        return self.closing.x

    @property
    def own_multipliers(self) -> np.ndarray:
        """Eigenvalues of the derivative of the map that was closed (of the half-period map, if that is followed)."""
        return np.linalg.eigvals(self.closing.jacobian).astype(complex)

    def multipliers(self, half: bool) -> np.ndarray:
        """Floquet multipliers of the orbit, largest first.

        The map over a period is the square of the half-period map, P_T = (S P_(T/2))^2, and so are its multipliers.
        """
        values = self.own_multipliers**2 if half else self.own_multipliers
        values = np.where(np.abs(values) <= FORGOTTEN, 0.0, values)
        return values[np.argsort(-np.abs(values), kind="stable")]

    def unstable(self) -> int:
        """Number of multipliers on or outside the unit circle."""
        return int(np.sum(np.abs(self.own_multipliers) >= 1.0 - CLOSE_TO_CIRCLE))


def corrected(
    closure: Closure, guess: np.ndarray, normal: np.ndarray, level: float, like: Closing | None = None
) -> tuple[Closing | None, int]:
    """(the closed point nearest to a guess in the plane normal . x = level, steps taken); None where there is none.

    Newton's method on the mismatch and the plane together. What sticks in the image sticks in the start.
    """
    x, last, best = guess, np.inf, None
    for steps in range(MOST_STEPS + 1):
        found = closure.attempt(x, like)
        gap = float(normal @ x - level)
        residual = max(found.residual, abs(gap))
        if residual <= POINT_CLOSED:
            return found, steps
        if not np.isfinite(residual):
            return None, steps
        if residual >= 0.5 * last and best is not None:
            if best[0] <= ROUNDING:
                return best[1], steps
            if steps >= 4 and residual >= last:
                return None, steps
        if best is None or residual < best[0]:
            best = (residual, found)
        last, like = residual, found
        matrix = np.vstack((found.derivative, normal))
        step = np.linalg.lstsq(matrix, -np.append(found.mismatch, gap), rcond=1e-14)[0]
        step *= min(1.0, LONGEST_STRIDE / max(float(np.max(np.abs(step))), 1e-300))
        x = x + step
        x[:-1][found.at_rest] = 0.0
    return (best[1] if best is not None and best[0] <= ROUNDING else None), MOST_STEPS


def tangent(closing: Closing, towards: np.ndarray) -> np.ndarray:
    """The unit tangent of a branch at a closed point, on the side of a vector that is nearly one."""
    matrix = np.vstack((closing.derivative, towards))
    wanted = np.zeros(len(towards))
    wanted[-1] = 1.0
    found = np.linalg.lstsq(matrix, wanted, rcond=1e-14)[0]
    size = float(np.linalg.norm(found))
    return found / size if size > 0.0 and np.isfinite(size) else towards / np.linalg.norm(towards)


def null_tangent(closing: Closing) -> np.ndarray:
    """The unit tangent of a branch of which no neighbour is known, towards larger parameters."""
    found = np.linalg.svd(closing.derivative)[2][-1]
    return found if found[-1] >= 0.0 else -found
