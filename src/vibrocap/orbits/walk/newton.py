"""Newton's method, once, for all that has to vanish: points of branches, orbits, special points.

Within the ball of convergence each step leaves less than half of the residual (Kantorovich: h_k/2 with h_k < 1). A step
that leaves more is outside of that ball or has met the rounding of the residual itself, and the residual knows the
level of its rounding. So it stops where there is nothing left to gain, or where a step that no longer halves the
residual has come to that level. On the way into the ball a step is halved while it makes the residual larger, or, where
that costs more than another guess, is taken as it is a few times.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

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
