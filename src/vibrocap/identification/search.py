"""Search: the coordinates of least squares, from several starts, drafted on few samples and polished on all."""

import dataclasses
import enum
import warnings
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.identification.coordinates import STEP
from vibrocap.identification.prediction import Prediction

LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
FAILED_ERROR = 1e2  # error of every sample of a run that failed: far above any fit's, so that the search turns back
SCREENED = 8  # points looked at per start
SHORT, LONG, POLISH = 10, 40, 60  # evaluations of a first draft, of the best drafts and of the polish
CARRIED = 3  # drafts that are carried on
TIE = 1e-7
SCAN, REACH = 81, 8.0  # points of a scan and its reach, in coarse steps
STOP = 1e-8  # relative change of cost or coordinates at which a search has converged


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


@dataclasses.dataclass(frozen=True, eq=False)
class Start:
    """One start of a multi-start search: where it began, the draft's end and its cost per sample."""

    u: np.ndarray
    end: np.ndarray
    cost: float


@dataclasses.dataclass(frozen=True)
class Loss:
    """How errors count. linear: squares; the others grow slower beyond `scale`, so that outliers pull less.

    soft_l1, huber, cauchy, arctan: as in scipy.optimize.least_squares.
    """

    kind: str = "linear"
    scale: float = 1.0

    def cost(self, errors: np.ndarray) -> np.ndarray:
        """Half the sum of losses of errors [..., n]."""
        z = (errors / self.scale) ** 2
        if self.kind == "linear":
            rho = z
        elif self.kind == "soft_l1":
            rho = 2 * (np.sqrt(1 + z) - 1)
        elif self.kind == "huber":
            rho = np.where(z <= 1, z, 2 * np.sqrt(z) - 1)
        elif self.kind == "cauchy":
            rho = np.log1p(z)
        else:
            rho = np.arctan(z)
        return 0.5 * self.scale**2 * rho.sum(axis=-1)

    def slope(self, errors: np.ndarray) -> np.ndarray:
        """Derivative of the loss by z [n]: the weight that robust least squares gives to a sample."""
        z = (errors / self.scale) ** 2
        if self.kind == "linear":
            return np.ones_like(z)
        if self.kind == "soft_l1":
            return 1 / np.sqrt(1 + z)
        if self.kind == "huber":
            return np.where(z <= 1, 1.0, 1 / np.sqrt(np.maximum(z, 1)))
        return 1 / (1 + z) if self.kind == "cauchy" else 1 / (1 + z * z)


def minimum(
    prediction: Prediction,
    start: np.ndarray,
    loss: Loss | None = None,
    *,
    held: Sequence[int] = (),
    evaluations: int = POLISH,
    stop: float = STOP,
    scale: np.ndarray | None = None,
) -> Minimum:
    """Least squares from one start, within the bounds; coordinates numbered in `held` stay where they are.

    scale [p]: natural steps of the coordinates (trust region), 1 by default.
    """
    from scipy.optimize import least_squares

    loss = loss or Loss()
    searched = [j for j in range(len(start)) if j not in held]
    low, high = prediction.space.low, prediction.space.high
    start = np.clip(start, low, high)
    known: dict[bytes, np.ndarray] = {}

    def whole(part: np.ndarray) -> np.ndarray:
        u = start.copy()
        u[searched] = part
        return u

    def errors(part: np.ndarray) -> np.ndarray:
        u = whole(part)
        key = u.tobytes()
        if key not in known:
            known.clear()
            known[key] = finite(prediction.errors(u))
        return known[key]

    def slopes(part: np.ndarray) -> np.ndarray:
        found = prediction.slopes(whole(part), errors(part), held)
        return np.nan_to_num(found[:, searched], nan=0.0, posinf=0.0, neginf=0.0)

    # A coordinate without effect would leave the step undetermined: a tie that costs nothing keeps it where it is.
    def tied_errors(part: np.ndarray) -> np.ndarray:
        return np.concatenate([errors(part), TIE * (part - start[searched])])

    def tied_slopes(part: np.ndarray) -> np.ndarray:
        return np.concatenate([slopes(part), TIE * np.eye(len(searched))])

    if not searched:
        found = errors(np.empty(0))
        return Minimum(
            start, float(loss.cost(found)), found, np.zeros((len(found), len(start))), 1, SearchStatus.CONVERGED
        )
    room = 1e-10 * (high - low)[searched]
    result = least_squares(
        tied_errors,
        np.clip(start[searched], low[searched] + room, high[searched] - room),
        tied_slopes,  # type: ignore[arg-type]
        bounds=(low[searched], high[searched]),
        loss=loss.kind,
        f_scale=loss.scale,
        x_scale=1.0 if scale is None else scale[searched],
        ftol=stop,
        xtol=stop,
        gtol=1e-12,
        max_nfev=evaluations,
    )
    u = whole(result.x)
    found = errors(result.x)
    # SciPy scales the slopes by the loss; here they are wanted as they are.
    plain = np.zeros((len(found), len(start)))
    plain[:, searched] = slopes(result.x) if loss.kind != "linear" else result.jac[: len(found)]
    failed = bool(np.all(found == FAILED_ERROR))
    status = SearchStatus.FAILED if failed else SearchStatus.STOPPED if result.status == 0 else SearchStatus.CONVERGED
    return Minimum(u, float(loss.cost(found)), found, plain, int(result.nfev), status)


def finite(errors: np.ndarray) -> np.ndarray:
    """Errors in which a run that failed counts as very far off."""
    return np.where(np.isfinite(errors), errors, FAILED_ERROR)


def search(
    prediction: Prediction,
    draft: Prediction,
    first: Sequence[np.ndarray],
    *,
    starts: int,
    loss: Loss,
    seed: int,
    progress: Callable[[float], None] | None = None,
) -> tuple[Minimum, tuple[Start, ...]]:
    """The best minimum from several starts: `first` and the best of a scrambled Sobol sequence around the last of them.

    Drafts run on `draft` (the same law and coordinates, fewer samples); the best is polished on `prediction`.
    """
    said = progress or (lambda _: None)
    first = list(first)[-starts:] if starts < len(first) else first
    begins = [np.clip(u, prediction.space.low, prediction.space.high) for u in first]
    if starts > len(begins):
        begins += _promising(draft, first[-1], starts - len(begins), loss, seed)
    said(0.05)
    drafts: list[tuple[Minimum, np.ndarray]] = []
    for i, u in enumerate(begins):
        drafts.append((minimum(draft, u, loss, evaluations=SHORT, stop=1e-4), u))
        said(0.05 + 0.5 * (i + 1) / len(begins))
    drafts.sort(key=lambda each: each[0].cost)
    for i in range(min(CARRIED, len(drafts))):
        u = drafts[i][0].u
        drafts[i] = (minimum(draft, u, loss, evaluations=LONG, stop=1e-6), drafts[i][1])
        said(0.55 + 0.15 * (i + 1) / CARRIED)
    drafts.sort(key=lambda each: each[0].cost)
    best = _scanned(prediction, minimum(prediction, drafts[0][0].u, loss, evaluations=POLISH), loss)
    said(0.8)
    return best, tuple(Start(u, end.u, end.cost / draft.size) for end, u in drafts)


def _scanned(prediction: Prediction, best: Minimum, loss: Loss) -> Minimum:
    """The minimum, after a look along coordinates in which the force is not smooth: there a descent ends too soon."""
    for j, coordinate in enumerate(prediction.space.coordinates):
        if coordinate.step <= STEP:
            continue
        table = np.tile(best.u, (SCAN, 1))
        table[:, j] = np.clip(
            best.u[j] + coordinate.step * np.linspace(-REACH, REACH, SCAN),
            prediction.space.low[j],
            prediction.space.high[j],
        )
        costs = loss.cost(finite(prediction.error_table(table)))
        i = int(np.argmin(costs))
        if costs[i] < best.cost:
            again = minimum(prediction, table[i], loss, evaluations=POLISH)
            best = again if again.cost < best.cost else best
    return best


def _promising(draft: Prediction, centre: np.ndarray, count: int, loss: Loss, seed: int) -> list[np.ndarray]:
    """The best `count` of many points around a centre, not too near to each other."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    spread = np.array([each.spread for each in draft.space.coordinates])
    with warnings.catch_warnings():  # a number that is no power of two balances the sequence less well, no more
        warnings.simplefilter("ignore")
        points = qmc.Sobol(len(centre), rng=seed).random(max(64, SCREENED * count))
    normal = ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    table = np.clip(centre + spread * normal, draft.space.low, draft.space.high)
    costs = loss.cost(finite(draft.error_table(table)))
    order = np.argsort(costs, kind="stable")
    chosen: list[int] = []
    for least in (1.0, 0.0):  # first those that are apart, then any
        for i in order:
            apart = all(np.linalg.norm(normal[i] - normal[j]) > least for j in chosen)
            if len(chosen) < count and i not in chosen and apart:
                chosen.append(int(i))
    return [table[i] for i in chosen]


def robust_scale(errors: np.ndarray) -> float:
    """Scale of a robust loss: one and a half robust standard deviations of the errors."""
    return float(max(1.5 * np.median(np.abs(errors)) / 0.6745, 1e-9))
