"""Descent: least squares within bounds, by Levenberg-Marquardt steps on matrices as small as the number of parameters.

The slopes of a fit have tens of thousands of rows and ten columns. A step needs J^T J and J^T e alone, which takes a
pass over the rows; a decomposition of J itself takes fifty times as long where the linear algebra's threads have to
wait for a processor. The square of J's condition number does no harm: the columns are scaled, and what is lost below
1e-6 of the scale belongs to combinations of parameters that the data do not determine.
"""

import numpy as np

from vibrocap.identification.minimum import FAILED_ERROR, Loss, Minimum, SearchStatus, finite
from vibrocap.identification.prediction import Prediction

LONGEST = 1.0  # largest change of a coordinate in one step
DAMPING = 1e-6  # of the diagonal of J^T J, at least
STUBBORN = 1e6  # damping at which a search gives up: its steps are lost in the differences
STILL = 1e-9  # change of every coordinate below which a search has ended
STOP = 1e-9  # share of the cost that a step must promise
FIRST = 1e-3  # damping of a descent from afar


def descent(
    prediction: Prediction,
    start: np.ndarray,
    loss: Loss | None = None,
    *,
    evaluations: int = 60,
    stop: float = STOP,
) -> Minimum:
    """The minimum from a start anywhere: slopes are made anew after every step (Nielsen 1999 for the damping).

    It ends when a step promises less than `stop` of the cost, moves no coordinate, or after so many evaluations.
    """
    loss = loss or Loss()
    bounds = prediction.space.low, prediction.space.high
    u = np.clip(start, *bounds)
    errors = finite(prediction.errors(u))
    cost, used, damping, growth = float(loss.cost(errors)), 1, FIRST, 2.0
    slopes = sound_slopes(prediction, u, errors)
    free = np.ones(len(u), bool)
    ended = False
    while used < evaluations and not ended:
        move, promised = step(u, errors, slopes, loss, free, bounds, damping)
        if promised <= stop * cost or np.abs(move).max() <= STILL:
            ended = True
            break
        tried = finite(prediction.errors(u + move))
        used += 1
        tried_cost = float(loss.cost(tried))
        if tried_cost < cost:
            gain = (cost - tried_cost) / promised
            # a step that kept its promise and gained next to nothing is the last
            ended = gain > 0.25 and cost - tried_cost <= stop * cost
            u, errors, cost = u + move, tried, tried_cost
            slopes = sound_slopes(prediction, u, errors)
            damping, growth = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), DAMPING), 2.0
        else:
            damping, growth = damping * growth, 2.0 * growth
            ended = damping > STUBBORN
    failed = bool(np.all(errors == FAILED_ERROR))
    status = SearchStatus.FAILED if failed else SearchStatus.CONVERGED if ended else SearchStatus.STOPPED
    return Minimum(u, cost, errors, slopes, used, status)


def followed(
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

    Levenberg-Marquardt steps within the bounds. slopes [n, p]: at a neighbouring point; each step corrects them by what
    it saw (Broyden), and they are made anew where a step fails and once where the search would end. It ends when the
    model promises less than `stop` of the cost. A profile asks for many such minima: this takes a small part of the
    work of a search that knows nothing.
    """
    low, high = prediction.space.low, prediction.space.high
    free = np.arange(len(start)) != held
    u, errors = start.copy(), finite(prediction.errors(start))
    cost, slopes = float(loss.cost(errors)), slopes.copy()
    fresh, damping, used = False, DAMPING, 1
    while used < evaluations:
        move, promised = step(u, errors, slopes, loss, free, (low, high), damping)
        if promised <= stop * cost:
            if fresh:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
            slopes, fresh = sound_slopes(prediction, u, errors, (held,)), True
            continue
        tried = finite(prediction.errors(u + move))
        used += 1
        tried_cost = float(loss.cost(tried))
        if tried_cost < cost:
            slopes = slopes + np.outer(tried - errors - slopes @ move, move / (move @ move))
            settled = fresh and cost - tried_cost <= 0.3 * stop * cost
            u, errors, cost, damping = u + move, tried, tried_cost, max(damping / 10, DAMPING)
            if settled:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
            fresh = fresh and cost - tried_cost <= stop * cost
        elif not fresh:
            slopes, fresh = sound_slopes(prediction, u, errors, (held,)), True
        else:
            damping = max(damping, 1e-4) * 10
            if damping > STUBBORN:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
    return Minimum(u, cost, errors, slopes, used, SearchStatus.STOPPED)


def sound_slopes(prediction: Prediction, u: np.ndarray, errors: np.ndarray, held: tuple[int, ...] = ()) -> np.ndarray:
    """Slopes [n, p], zero where a difference could not be made."""
    return np.nan_to_num(prediction.slopes(u, errors, held), nan=0.0, posinf=0.0, neginf=0.0)


def step(
    u: np.ndarray,
    errors: np.ndarray,
    slopes: np.ndarray,
    loss: Loss,
    free: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    damping: float,
) -> tuple[np.ndarray, float]:
    """A step within the bounds and the decrease of the cost that it promises.

    It solves (J^T W J + damping diag) move = -J^T W e, W the weights of the loss. Coordinates that it would take over
    a bound, or further than LONGEST, go that far and stay, and the others are solved for anew.
    """
    weighted = slopes if loss.kind == "linear" else loss.slope(errors)[:, None] * slopes
    gradient, matrix = weighted.T @ errors, weighted.T @ slopes
    low, high = np.maximum(bounds[0] - u, -LONGEST), np.minimum(bounds[1] - u, LONGEST)
    diagonal = np.diag(matrix)
    damped = matrix + np.diag(damping * diagonal + 1e-12 * max(diagonal.max(), 1e-300))
    move = np.zeros_like(u)
    moving = free & ~(((low >= 0) & (gradient > 0)) | ((high <= 0) & (gradient < 0)))
    while moving.any():
        pull = gradient[moving] + damped[np.ix_(moving, ~moving)] @ move[~moving]
        move[moving] = -np.linalg.solve(damped[np.ix_(moving, moving)], pull)
        over = moving & ((move < low) | (move > high))
        move = np.clip(move, low, high)
        if not over.any():
            break
        moving &= ~over
    return move, float(-(gradient @ move) - 0.5 * move @ matrix @ move)
