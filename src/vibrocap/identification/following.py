"""Following a minimum: least squares from a point nearby whose slopes are known, with few slopes of its own."""

import numpy as np

from vibrocap.identification.prediction import Prediction
from vibrocap.identification.search import Loss, Minimum, SearchStatus, finite

LONGEST = 1.0  # largest change of a coordinate in one step
DAMPING = 1e-6  # of the diagonal of J^T J at first
STUBBORN = 1e4  # damping at which a search gives up


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
        move, promised = _step(u, errors, slopes, loss, free, (low, high), damping)
        if promised <= stop * cost:
            if fresh:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
            slopes, fresh = prediction.slopes(u, errors, (held,)), True
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
            slopes, fresh = prediction.slopes(u, errors, (held,)), True
        else:
            damping = max(damping, 1e-4) * 10
            if damping > STUBBORN:
                return Minimum(u, cost, errors, slopes, used, SearchStatus.CONVERGED)
    return Minimum(u, cost, errors, slopes, used, SearchStatus.STOPPED)


def _step(
    u: np.ndarray,
    errors: np.ndarray,
    slopes: np.ndarray,
    loss: Loss,
    free: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    damping: float,
) -> tuple[np.ndarray, float]:
    """A step within the bounds and the decrease of the cost that it promises."""
    weights = loss.slope(errors)[:, None]
    weighted = slopes if loss.kind == "linear" else weights * slopes
    gradient = weighted.T @ errors
    low, high = bounds
    stuck = ((u <= low) & (gradient > 0)) | ((u >= high) & (gradient < 0))
    matrix = weighted.T @ slopes
    move = np.zeros_like(u)
    for _ in range(
        len(u)
    ):  # a coordinate that the step would take over its bound stays there, and the others step anew
        moving = free & ~stuck
        move = np.zeros_like(u)
        if not moving.any():
            return move, 0.0
        part = matrix[np.ix_(moving, moving)]
        diagonal = np.diag(part).copy()
        part = part + np.diag(damping * diagonal + 1e-12 * max(diagonal.max(), 1e-300))
        move[moving] = -np.linalg.solve(part, gradient[moving])
        move *= min(1.0, LONGEST / max(float(np.abs(move).max()), 1e-300))
        inside = np.clip(u + move, low, high) - u
        if np.allclose(inside, move, rtol=0, atol=1e-12):
            break
        over = inside != move
        if np.all(np.abs(inside[over]) > 1e-12):  # it may still go as far as the bound
            move = inside
            break
        stuck = stuck | (over & (np.abs(inside) <= 1e-12))
        move = inside
    return move, float(-(gradient @ move) - 0.5 * move @ matrix @ move)
