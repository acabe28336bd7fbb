"""Least squares within bounds, from many starts, by steps within a trusted distance.

The slopes of a fit have tens of thousands of rows and ten columns. A step needs J^T J and J^T e alone, one pass over
the rows. The square of J's condition number does no harm: what is lost below 1e-6 of the largest singular value belongs
to combinations of parameters that the data do not determine, and these stay where they are.

`scipy.optimize.least_squares` came to the same minima of the fits in `benchmarks/fitting.py` in 1.1 to 1.6 times the
time, the most for profiles, which start warm here (`warm_descent`).
"""

import dataclasses
import enum
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.problem.prediction import Prediction

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


LONGEST = 1.0  # trusted change of the coordinates at first: a factor of e
NO_MOVE = 1e-9  # change of the coordinates below which nothing moves
STOP = 1e-9  # share of the cost by which a step must be predicted to reduce it
COARSE_STOP = 1e-6  # the same for a cost that is not smooth in the small
WEAKEST = 1e-12  # of the largest eigenvalue of J^T J
HALVINGS = 40  # of the interval in which the damping of a step is sought


def descent(
    prediction: Prediction,
    start: np.ndarray,
    loss: Loss | None = None,
    *,
    evaluations: int = 60,
    stop: float = STOP,
    held: Sequence[int] = (),
) -> Minimum:
    """The minimum from a start anywhere: slopes are made anew after every step.

    Coordinates that are held stay. It ends when a step is predicted to reduce the cost by less than `stop` of it, moves
    nothing, or after so many evaluations.
    """
    loss = loss or Loss()
    bounds = prediction.space.low, prediction.space.high
    u = np.clip(start, *bounds)
    errors = finite(prediction.errors(u))
    cost, used, radius = float(loss.cost(errors)), 1, LONGEST
    slopes = sound_slopes(prediction, u, errors, held)
    free = ~np.isin(np.arange(len(u)), held)
    ended = False
    while used < evaluations and not ended:
        move, predicted_reduction = step(u, errors, slopes, loss, free, bounds, radius)
        length = float(np.linalg.norm(move))
        if ended := predicted_reduction <= stop * cost or length <= NO_MOVE:
            break
        tried = finite(prediction.errors(u + move))
        used += 1
        gained = cost - float(loss.cost(tried))
        radius = _new_radius(radius, length, gained / predicted_reduction)
        if gained > 0:
            # a step that reduced the cost as predicted and by next to nothing is the last
            ended = gained <= stop * cost and gained > 0.25 * predicted_reduction
            u, errors, cost = u + move, tried, cost - gained
            slopes = sound_slopes(prediction, u, errors, held)
    failed = bool(np.all(errors[: prediction.size] == FAILED_ERROR))
    status = SearchStatus.FAILED if failed else SearchStatus.CONVERGED if ended else SearchStatus.STOPPED
    return Minimum(u, float(loss.cost(errors)), errors, slopes, used, status)


def warm_descent(
    prediction: Prediction,
    start: np.ndarray,
    slopes: np.ndarray,
    loss: Loss,
    *,
    held: int,
    evaluations: int = 20,
    stop: float = 1e-6,
) -> Minimum:
    """The minimum over all coordinates but the one numbered `held` (-1: none is), from a start close to it.

    slopes [n, p]: at a neighbouring point; each step corrects them by what it saw (Broyden), and they are made anew
    where a step fails and once where the search would end. It ends when the predicted reduction is below `stop` of the
    cost. A profile asks for many such minima: this takes a small part of the work of a search that knows nothing.
    """
    bounds = prediction.space.low, prediction.space.high
    free = np.arange(len(start)) != held
    u, errors = start.copy(), finite(prediction.errors(start))
    cost, slopes = float(loss.cost(errors)), slopes.copy()
    fresh, radius, used = False, LONGEST, 1
    while used < evaluations:
        move, predicted_reduction = step(u, errors, slopes, loss, free, bounds, radius)
        length = float(np.linalg.norm(move))
        if predicted_reduction <= stop * cost or length <= NO_MOVE:
            if fresh:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
            slopes, fresh, radius = sound_slopes(prediction, u, errors, (held,)), True, LONGEST
            continue
        tried = finite(prediction.errors(u + move))
        used += 1
        gained = cost - float(loss.cost(tried))
        if gained > 0:
            slopes = slopes + np.outer(tried - errors - slopes @ move, move / (move @ move))
            settled = fresh and gained <= 0.3 * stop * cost
            u, errors, cost = u + move, tried, cost - gained
            radius = _new_radius(radius, length, gained / predicted_reduction)
            if settled:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
            fresh = fresh and gained <= stop * cost
        elif not fresh:
            slopes, fresh = sound_slopes(prediction, u, errors, (held,)), True
        else:
            radius = _new_radius(radius, length, gained / predicted_reduction)
    return Minimum(u, cost, errors, slopes, used, SearchStatus.STOPPED)


def sound_slopes(prediction: Prediction, u: np.ndarray, errors: np.ndarray, held: Sequence[int] = ()) -> np.ndarray:
    """Slopes [n, p], zero where a difference could not be made."""
    return np.nan_to_num(prediction.slopes(u, errors, held), nan=0.0, posinf=0.0, neginf=0.0)


def _new_radius(radius: float, length: float, ratio: float) -> float:
    """The trusted distance after a step of a length that reduced the cost by such a share of the prediction."""
    if ratio < 0.25:
        return 0.25 * length
    return max(radius, 2.0 * length) if ratio > 0.75 else radius


def step(
    u: np.ndarray,
    errors: np.ndarray,
    slopes: np.ndarray,
    loss: Loss,
    free: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    radius: float,
) -> tuple[np.ndarray, float]:
    """A step within the bounds and the predicted reduction of the cost, 0 where there is none to be had.

    It minimises |e + J move|^2, weighted by the loss, over moves no longer than the radius. Coordinates that it would
    take over a bound go that far and stay, and the others are solved for anew; where that reduces nothing, a shorter
    step does.
    """
    weighted = slopes if loss.kind == "linear" else loss.slope(errors)[:, None] * slopes
    gradient, matrix = weighted.T @ errors, weighted.T @ slopes
    low, high = bounds[0] - u, bounds[1] - u
    may_move = free & ~(((low >= 0) & (gradient > 0)) | ((high <= 0) & (gradient < 0)))
    while radius > NO_MOVE:
        move, moving = np.zeros_like(u), may_move.copy()
        while moving.any():
            pull = gradient[moving] + matrix[np.ix_(moving, ~moving)] @ move[~moving]
            move[moving] = _damped_solution(matrix[np.ix_(moving, moving)], -pull, radius)
            over = moving & ((move < low) | (move > high))
            move = np.clip(move, low, high)
            moving &= ~over
            if not over.any():
                break
        predicted_reduction = float(-(gradient @ move) - 0.5 * move @ matrix @ move)
        if predicted_reduction > 0 or not move.any():
            return move, max(predicted_reduction, 0.0)
        radius *= 0.25
    return np.zeros_like(u), 0.0


def _damped_solution(matrix: np.ndarray, pull: np.ndarray, radius: float) -> np.ndarray:
    """x of (matrix + damping) x = pull with the least damping >= 0 for which x is no longer than the radius."""
    values, vectors = np.linalg.eigh(matrix)
    values = np.maximum(values, WEAKEST * max(float(values[-1]), 1e-300))
    along = vectors.T @ pull
    if np.linalg.norm(along / values) <= radius:
        return vectors @ (along / values)
    low, high = float(values[0]), float(values[-1] + np.linalg.norm(along) / radius)  # of damping + least eigenvalue
    for _ in range(HALVINGS):  # by factors: the damping may be anything between the weakest and the strongest direction
        middle = float(np.sqrt(low * high))
        longer = np.linalg.norm(along / (values + (middle - values[0]))) > radius
        low, high = (middle, high) if longer else (low, middle)
    return vectors @ (along / (values + (high - values[0])))


SCREENED = 32  # points looked at per start
SHORT, LONG, POLISH = 10, 40, 60  # evaluations of a first draft, of the best drafts and of the polish
CARRIED = 3  # drafts that are carried on
SCAN, SCAN_REACH, LOOKS = 41, 8.0, 5  # points of a scan, its reach in coarse steps, scans at most
SAME_COST = 1e-4  # relative difference of the costs of drafts that came to the same end
DAMPED, FARTHEST = 1e-9, 100.0  # of J^T J; of another coordinate's change along a valley


@dataclasses.dataclass(frozen=True, eq=False)
class Start:
    """One start of a multi-start search: where it began, the draft's end and its cost per sample."""

    u: np.ndarray
    end: np.ndarray
    cost: float

    in_record = "cost"


def search(
    prediction: Prediction,
    draft: Prediction,
    first: Sequence[np.ndarray],
    also: Sequence[np.ndarray] = (),
    *,
    starts: int,
    loss: Loss,
    seed: int,
    report: Callable[[float], Any],
) -> tuple[Minimum, tuple[Start, ...]]:
    """The best minimum from several starts: `first` and the best of random points around the last of them.

    Drafts run on `draft` (the same law and coordinates, fewer samples); the best is polished on `prediction`. So are
    those that began at `also`, the ends of simpler fits, unless they came to the same: what such a fit reaches is never
    missed.
    """
    ends = local_searches(draft, first, also, starts=starts, loss=loss, seed=seed, report=report)
    stop = COARSE_STOP if any(coordinate.jumps for coordinate in prediction.space.coordinates) else STOP
    best, least = None, ends[0][0].cost
    for i, (end, begin) in enumerate(ends):
        if i == 0 or (any(begin is start for start in also) and end.cost > (1 + SAME_COST) * least):
            tried = _scanned(prediction, descent(prediction, end.u, loss, evaluations=POLISH, stop=stop), loss)
            best = tried if best is None or tried.cost < best.cost else best
            report(0.75)
    assert best is not None
    report(0.8)
    return best, tuple(Start(u, end.u, end.cost / draft.size) for end, u in ends)


def local_searches(
    draft: Prediction,
    first: Sequence[np.ndarray],
    also: Sequence[np.ndarray] = (),
    *,
    starts: int,
    loss: Loss,
    seed: int,
    report: Callable[[float], Any] = lambda _: None,
) -> list[tuple[Minimum, np.ndarray]]:
    """Ends and begins of the local searches on thinned records, the best first; those from `also` come on top."""
    first = list(first)[:starts]
    begins = [np.clip(u, draft.space.low, draft.space.high) for u in first]
    if starts > len(begins):
        begins += _promising(draft, first[-1], starts - len(begins), loss, seed)
    begins += also
    report(0.05)
    minima: list[tuple[Minimum, np.ndarray]] = []
    for i, u in enumerate(begins):
        minima.append((descent(draft, u, loss, evaluations=SHORT, stop=1e-4), u))
        report(0.05 + 0.5 * (i + 1) / len(begins))
    minima.sort(key=lambda pair: pair[0].cost)
    for i, (end, u) in enumerate(minima):
        if i < CARRIED or any(u is start for start in also):
            minima[i] = (_scanned(draft, descent(draft, end.u, loss, evaluations=LONG, stop=1e-6), loss), u)
        report(0.55 + 0.15 * (i + 1) / len(minima))
    minima.sort(key=lambda pair: pair[0].cost)
    return minima


def _scanned(prediction: Prediction, best: Minimum, loss: Loss) -> Minimum:
    """The minimum, after looks along coordinates in which the force is not smooth: there a descent ends too soon.

    The others stay, or follow as the slopes say that they should; a lower point starts a new descent.
    """
    for j, coordinate in enumerate(prediction.space.coordinates):
        for _ in range(LOOKS if coordinate.jumps else 0):
            moves = coordinate.step * np.linspace(-SCAN_REACH, SCAN_REACH, SCAN)[:, None]
            table = np.concatenate([best.u + moves * line for line in (np.eye(len(best.u))[j], _valley(best, j))])
            table = np.clip(table, prediction.space.low, prediction.space.high)
            costs = loss.cost(finite(prediction.error_table(table)))
            lowest, again = table[int(np.argmin(costs))], best
            if costs.min() < best.cost:
                again = descent(prediction, lowest, loss, evaluations=POLISH, stop=COARSE_STOP)
            if not again.cost < best.cost:
                break
            best = again
    return best


def _valley(best: Minimum, j: int) -> np.ndarray:
    """How all coordinates change along the valley of the cost when coordinate j changes by 1, at most as much each."""
    line = np.linalg.solve(best.slopes.T @ best.slopes + DAMPED * np.eye(len(best.u)), np.eye(len(best.u))[j])
    return line / line[j] if line[j] > 0 and np.abs(line).max() <= line[j] * FARTHEST else np.eye(len(best.u))[j]


def _promising(draft: Prediction, centre: np.ndarray, count: int, loss: Loss, seed: int) -> list[np.ndarray]:
    """The best `count` of many points around a centre, not too near to each other."""
    spread = np.array([coordinate.spread for coordinate in draft.space.coordinates])
    normal = np.random.default_rng(seed).normal(size=(max(64, SCREENED * count), len(centre)))
    table = np.clip(centre + spread * normal, draft.space.low, draft.space.high)
    costs = loss.cost(finite(draft.error_table(table)))
    order = np.argsort(costs, kind="stable")
    kept: list[int] = []
    for least in (1.0, 0.0):  # first those that are apart, then any
        for i in order:
            apart = all(np.linalg.norm(normal[i] - normal[j]) > least for j in kept)
            if len(kept) < count and i not in kept and apart:
                kept.append(int(i))
    return [table[i] for i in kept]
