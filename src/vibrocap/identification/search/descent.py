"""Descent: least squares within bounds, by steps within a trusted distance, on matrices as small as the parameters.

The slopes of a fit have tens of thousands of rows and ten columns. A step needs J^T J and J^T e alone, one pass over
the rows. The square of J's condition number does no harm: what is lost below 1e-6 of the largest singular value belongs
to combinations of parameters that the data do not determine, and these stay where they are.

`scipy.optimize.least_squares` came to the same minima of the fits in `benchmarks/fitting.py` in 1.1 to 1.6 times the
time, the most for profiles, which start warm here (`warm_descent`).
"""

from collections.abc import Sequence

import numpy as np

from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.loss import FAILED_ERROR, Loss, Minimum, SearchStatus, finite

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
        if predicted_reduction <= stop * cost or length <= NO_MOVE:
            ended = True
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
