"""Optimal stability polynomials by linear programming: where the numbers of `stabilised.py` come from.

Of R(z) = sum over k <= order of a_k z^k/k!, with a_k = 1 but for the last three k, the largest reach is sought with
|R| <= 0.9 on the real interval from -reach to -3/2, and |R| <= 1 nearer to zero and on a narrow wedge around the
interval (Ketcheson and Ahmadia 2012, Communications in Applied Mathematics and Computational Science 7(2)).
"""

import math

import numpy as np
from scipy.optimize import linprog

DAMPED = 3
LARGEST = 0.9
OPENING = 0.1  # of the wedge: imaginary over real part, up to a quarter of the reach
DIRECTIONS = 16


def interval(reach: float, points: int = 160) -> np.ndarray:
    """Points from -reach to 0, denser towards the ends."""
    x = -reach * (1.0 - np.cos(np.linspace(0.0, np.pi, points))) / 2.0
    return x[x < -1e-6]


def wedge(reach: float, points: int = 160) -> np.ndarray:
    """Points of the interval, and above it at half the opening and at all of it."""
    x = interval(reach, points)
    return np.concatenate([x + 1j * share * OPENING * np.minimum(-x, 0.25 * reach) for share in (0.0, 0.5, 1.0)])


def allowed(z: np.ndarray) -> np.ndarray:
    """Largest |R| allowed at each point."""
    far = np.maximum(np.abs(np.exp(z)), LARGEST) + 0.02 * (z.imag > 0.0)
    return np.where(np.abs(z) < 1.5, 1.0, np.where(np.abs(z) < 2.5, far, LARGEST))


def terms(z: np.ndarray, order: int) -> np.ndarray:
    """z^k/k! for the damped k, one column each."""
    return np.stack([z**k / math.factorial(k) for k in range(order - DAMPED + 1, order + 1)], axis=1)


def undamped(z: np.ndarray, order: int) -> np.ndarray:
    """Sum of the terms that are left as they are."""
    return sum(z**k / math.factorial(k) for k in range(order - DAMPED + 1))


def damping(order: int, reach: float) -> np.ndarray | None:
    """Factors of the last three terms, or None if none keep R within what is allowed."""
    z = wedge(reach)
    columns, rows, bounds = terms(z, order), [], []
    sizes = np.abs(columns).max(axis=0)
    for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        turn = np.exp(-1j * angle)
        rows.append((columns / sizes * turn).real)
        bounds.append(allowed(z) - (undamped(z, order) * turn).real)
    found = linprog(np.zeros(DAMPED), A_ub=np.vstack(rows), b_ub=np.concatenate(bounds), bounds=[(None, None)] * DAMPED)
    return found.x / sizes if found.status == 0 else None


def longest_reach(order: int) -> float:
    """The largest reach, by halving."""
    low, high = 1.0, 60.0
    for _ in range(14):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if damping(order, middle) is not None else (low, middle)
    return low


def smallest_filter(order: int, reach: float, first: float) -> tuple[np.ndarray, float]:
    """(factors of D, largest |D|) on the interval, with the first factor given and |D| as small as can be."""
    columns = terms(interval(reach), order)
    sizes = np.abs(columns).max(axis=0)
    scaled, leading = columns / sizes, first * columns[:, 0]
    one = np.ones((len(scaled), 1))
    found = linprog(
        [0.0] * (DAMPED - 1) + [1.0],
        A_ub=np.vstack([np.hstack([scaled[:, 1:], -one]), np.hstack([-scaled[:, 1:], -one])]),
        b_ub=np.concatenate([-leading, leading]),
        bounds=[(None, None)] * DAMPED,
    )
    return np.array([first, *(found.x[:-1] / sizes[1:])]), found.x[-1]
