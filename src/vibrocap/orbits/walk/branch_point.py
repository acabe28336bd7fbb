"""A point of a branch: what closes there, the direction in which the branch continues, and Newton's way to it."""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.orbits.walk.newton import newton
from vibrocap.orbits.walk.residual import Closing, Residual

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
