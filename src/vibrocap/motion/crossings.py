"""Instants at which a quantity of a motion passes a value: the roots of its polynomial on every piece.

On a piece a state is a polynomial and an observable is analytic, so that both are their interpolants at Chebyshev
points, to rounding; a piece on which the highest coefficients have not fallen to rounding is halved. The roots of an
interpolant are the eigenvalues of its colleague matrix (Good 1961; Trefethen, Approximation Theory and Approximation
Practice, ch. 18). Between roots the sign is that of the middle: a value that is only touched is no crossing.

Values of the polynomials that pieces are, at many times.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev

from vibrocap.arguments import ArgumentError
from vibrocap.numerics.api import PieceSeries

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory

DEGREE = 24
NEGLIGIBLE = 64 * np.finfo(float).eps  # of the largest coefficient: what rounding leaves of the highest ones
HALVINGS = 8  # of pieces at most: an observable with a kink inside a piece has no series to resolve
POINTS = chebyshev.chebpts1(DEGREE + 1)  # on (-1, 1): no border of a piece, where an observable may jump
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(POINTS, DEGREE))


def crossings(
    motion: "Trajectory", name: str, value: float, direction: int | None = None, modulo: float | None = None
) -> np.ndarray:
    """Times at which a quantity of a motion passes a value, see `Trajectory.crossings`."""
    if name not in motion.names:
        raise KeyError(f"{name!r} is not known of this motion; it has {', '.join(motion.names)}")
    if direction not in (None, 1, -1):
        raise ArgumentError("direction", f"should be 1 (upwards), -1 (downwards) or None (both), not {direction!r}")
    if not np.isfinite(value):
        raise ArgumentError("value", f"should be a finite number, got {value!r}")
    if modulo is not None and not (np.isfinite(modulo) and modulo > 0.0):
        raise ArgumentError("modulo", f"should be a positive number or None, got {modulo!r}")
    times, signs, values = _stretches(motion, name, float(value), modulo)
    other = signs != 0.0  # while the quantity keeps the value it is on no side of it
    times, signs, values = times[other], signs[other], values[other]
    passes = np.flatnonzero((signs[1:] != signs[:-1]) & (values[1:] == values[:-1])) + 1
    return times[passes if direction is None else passes[signs[passes] == direction]]


def _stretches(
    motion: "Trajectory", name: str, value: float, modulo: float | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(starts, signs of the quantity less a value, that value) of stretches of time without a change of sign, in order.

    Modulo something the value is that which the middle of a piece is nearest to.
    """
    index = np.arange(len(motion.piece_start))
    begin, length = np.zeros(len(index)), motion.piece_length
    starts: list[np.ndarray] = [np.empty(0)]
    signs: list[np.ndarray] = [np.empty(0)]
    values: list[np.ndarray] = [np.empty(0)]
    for halving in range(HALVINGS + 1):
        if not len(index):
            break
        s = begin[:, None] + 0.5 * length[:, None] * (1.0 + POINTS)
        quantity = motion.piece_values(name, index, s)
        coefficients = quantity @ TO_COEFFICIENTS.T
        away = coefficients[:, 0] - value
        target = value + (0.0 * away if modulo is None else modulo * np.round(away / modulo))
        noise = NEGLIGIBLE * np.maximum(np.abs(coefficients).max(axis=1), np.abs(target))
        coefficients[:, 0] -= target
        later = np.abs(coefficients[:, 1:])
        resolved = later[:, -2:].max(axis=1) <= noise
        if modulo is not None:
            resolved &= later.sum(axis=1) <= 0.25 * modulo  # no other value is near
        resolved |= halving == HALVINGS
        apart = np.abs(coefficients[:, 0]) > np.where(resolved, 1.0, 2.0) * later.sum(axis=1)  # no root
        starts.append(motion.piece_start[index[apart]] + begin[apart])
        signs.append(np.where(np.abs(coefficients[apart, 0]) > noise[apart], np.sign(coefficients[apart, 0]), 0.0))
        values.append(target[apart])
        for i in np.flatnonzero(resolved & ~apart):
            borders = np.concatenate(([-1.0], _roots(coefficients[i], noise[i]), [1.0]))
            starts.append(motion.piece_start[index[i]] + begin[i] + 0.5 * length[i] * (1.0 + borders[:-1]))
            between = chebyshev.chebval(0.5 * (borders[1:] + borders[:-1]), coefficients[i])
            signs.append(np.where(np.abs(between) > noise[i], np.sign(between), 0.0))
            values.append(np.full(len(between), target[i]))
        left = ~(resolved | apart)
        index, begin, length = index[left], begin[left], 0.5 * length[left]
        index, begin, length = np.tile(index, 2), np.concatenate((begin, begin + length)), np.tile(length, 2)
    times = np.concatenate(starts)
    order = np.argsort(times, kind="stable")
    return times[order], np.concatenate(signs)[order], np.concatenate(values)[order]


def _roots(coefficients: np.ndarray, noise: float) -> np.ndarray:
    """Real roots in (-1, 1), in order; a pair that rounding has parted from the real line stands at its middle."""
    trimmed = chebyshev.chebtrim(coefficients, noise)
    roots = chebyshev.chebroots(trimmed)
    real = roots.real[np.abs(roots.imag) < np.sqrt(NEGLIGIBLE)]
    return np.sort(real[np.abs(real) < 1.0])


def polynomial_values(coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Polynomials of pieces at times s since the start of the pieces `index` [n]: [states, *s.shape].

    s: [n], or [n, points] of as many times in each piece
    """
    rows = _by_power(coefficients, index, s)
    value = np.empty((rows.shape[1], *s.shape))
    value[:] = rows[-1]
    for row in rows[-2::-1]:
        value *= s
        value += row
    return value


def polynomial_slopes(coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Slopes of the same polynomials."""
    rows = _by_power(coefficients, index, s)
    slope = np.zeros((rows.shape[1], *s.shape))
    for k in range(len(rows) - 1, 0, -1):
        slope *= s
        slope += k * rows[k]
    return slope


def _by_power(coefficients: PieceSeries | np.ndarray, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Coefficients [order + 1, states, n] of the pieces, or [order + 1, states, n, 1] where s has two axes."""
    rows = np.ascontiguousarray(coefficients[index].transpose(2, 1, 0))
    return rows.reshape(*rows.shape, *[1] * (s.ndim - 1))
