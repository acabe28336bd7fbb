"""What a search minimises and finds: how errors count, and the end of one descent."""

import dataclasses
import enum

import numpy as np

# kind: rho(z), rho'(z), d(psi)/d(error), of the squared error over the scale z and psi = error rho'(z)
LOSSES = {
    "linear": (lambda z: z, np.ones_like, np.ones_like),
    "soft_l1": (lambda z: 2 * (np.sqrt(1 + z) - 1), lambda z: 1 / np.sqrt(1 + z), lambda z: (1 + z) ** -1.5),
    "huber": (
        lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1),
        lambda z: np.where(z <= 1, 1.0, 1 / np.sqrt(np.maximum(z, 1))),
        lambda z: (z <= 1).astype(float),
    ),
    "cauchy": (np.log1p, lambda z: 1 / (1 + z), lambda z: (1 - z) / (1 + z) ** 2),
    "arctan": (np.arctan, lambda z: 1 / (1 + z * z), lambda z: (1 - 3 * z * z) / (1 + z * z) ** 2),
}
LEAST_BEND = 0.05  # mean of the last of these: where most samples are outliers, a squared loss has no curvature
FAILED_ERROR = 1e2  # error of every sample of a run that failed: far above any fit's, so that the search turns back


class SearchStatus(enum.StrEnum):
    """How a search ended."""

    CONVERGED = "converged"
    STOPPED = "stopped at the largest number of evaluations: not settled; ask for more starts or fix a parameter"
    FAILED = "no start could be driven through the records: look at the bounds, the units and the sampling"


@dataclasses.dataclass(frozen=True, eq=False)
class Minimum:
    """End of one search: coordinates, cost (half the sum of losses), errors and slopes there, evaluations, status."""

    u: np.ndarray
    cost: float
    errors: np.ndarray
    slopes: np.ndarray
    evaluations: int
    status: SearchStatus


@dataclasses.dataclass(frozen=True)
class Loss:
    """How errors count. linear: squares; the others grow slower beyond `scale`, so that outliers pull less.

    soft_l1, huber, cauchy, arctan: as in scipy.optimize.least_squares.
    """

    kind: str = "linear"
    scale: float = 1.0

    def cost(self, errors: np.ndarray) -> np.ndarray:
        """Half the sum of losses of errors [..., n]."""
        return 0.5 * self.scale**2 * LOSSES[self.kind][0]((errors / self.scale) ** 2).sum(axis=-1)

    def slope(self, errors: np.ndarray) -> np.ndarray:
        """Derivative of the loss by z [n]: the weight that robust least squares gives to a sample."""
        return LOSSES[self.kind][1]((errors / self.scale) ** 2)

    def influence(self, errors: np.ndarray) -> tuple[np.ndarray, float]:
        """(psi [n], the derivative of the loss by the error, and the mean of its own derivative)."""
        bend = LOSSES[self.kind][2]((errors / self.scale) ** 2)
        return errors * self.slope(errors), max(float(np.mean(bend)), LEAST_BEND)


def finite(errors: np.ndarray) -> np.ndarray:
    """Errors in which a run that failed counts as very far off."""
    return np.where(np.isfinite(errors), errors, FAILED_ERROR)


def robust_scale(errors: np.ndarray) -> float:
    """Scale of a robust loss: one and a half robust standard deviations of the errors."""
    return float(max(1.5 * np.median(np.abs(errors)) / 0.6745, 1e-9))
