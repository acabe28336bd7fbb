"""Values of the polynomials that pieces are, at many times.

Where as many points are asked for in every piece, one piece after the other, its coefficients are fetched once.
"""

import numpy as np

from vibrocap.numerics.api import PieceSeries


def polynomial_values(coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Polynomials of pieces at times s [n] since the start of the pieces `index` [n]: [states, n]."""
    rows, local = _by_piece(coefficients, index, s)
    value = np.empty((rows.shape[1], *local.shape))
    value[:] = rows[-1]
    for row in rows[-2::-1]:
        value *= local
        value += row
    return value.reshape(rows.shape[1], len(index))


def polynomial_slopes(coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Slopes of the same polynomials: [states, n]."""
    rows, local = _by_piece(coefficients, index, s)
    slope = np.zeros((rows.shape[1], *local.shape))
    for k in range(len(rows) - 1, 0, -1):
        slope *= local
        slope += k * rows[k]
    return slope.reshape(rows.shape[1], len(index))


def _by_piece(
    coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(coefficients [order + 1, states, pieces, 1], times [pieces, points])."""
    points = _points_per_piece(index)
    chosen = coefficients[index[::points]]
    return np.ascontiguousarray(chosen.transpose(2, 1, 0))[..., None], s.reshape(-1, points)


def _points_per_piece(index: np.ndarray) -> int:
    """How many points follow one another in each piece; 1 where that differs."""
    if len(index) < 2:
        return 1
    other = np.flatnonzero(index != index[0])
    points = int(other[0]) if len(other) else len(index)
    if len(index) % points or np.any(index.reshape(-1, points) != index[::points, None]):
        return 1
    return points
