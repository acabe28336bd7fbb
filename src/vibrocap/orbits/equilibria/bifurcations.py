"""Folds and Hopf points of equilibria: each the root of an equation of its own, with exact second derivatives.

With J = df/dy and q the parameter:

    fold            f = 0,   J a = 0,                       l . a = 1                       unknowns y, q, a
    Hopf            f = 0,   J v = i omega v,               l . v = 1       (complex)       y, q, v, omega
    mode coupling   f = 0,   J v = i omega v,  (J - i omega) w = v,  l . v = 1,  l . w = 0  y, q, v, w, omega

(Moore and Spence 1980 and Griewank and Reddien 1983 of the first two.) The last is where two frequencies of a system
without damping meet: it has more equations than unknowns, which agree, and is solved by least squares.
"""

import dataclasses
import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.orbits.equilibria.steady_states import ROUNDINGS, balanced
from vibrocap.orbits.walk.residual import Levels, newton

if TYPE_CHECKING:
    from vibrocap.orbits.equilibria.equilibrium_branch import Sliding

MOST_STEPS = 40
LEVELS = Levels(0.0, 1e-9)  # of the length of a step
NUDGE = 1e-4  # of the natural size of a state or its own unit, where that is less, for a third derivative
CANCELLED = 1e-8  # of the terms of a coefficient, below which what is left of them has no sign


@dataclasses.dataclass(frozen=True, eq=False)
class Located:
    """A root: the point x, the error of the parameter by rounding, omega (0: a fold) and v or a, over natural sizes."""

    x: np.ndarray
    error: float
    frequency: float
    vector: np.ndarray


def fold(mode: "Sliding", x: np.ndarray) -> Located | None:
    """The fold near a point; None where Newton's method leads to none."""
    n = mode.count
    vector = np.linalg.svd(mode.jacobian(x))[2][-1]
    constant = vector.copy()

    def system(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        at, a = u[: n + 1], u[n + 1 :]
        derivative, curvature = mode.derivative(at), mode.curvature(at)
        jacobian = derivative[:, :n]
        matrix = np.zeros((2 * n + 1, 2 * n + 1))
        matrix[:n, : n + 1] = derivative
        matrix[n : 2 * n, : n + 1] = np.einsum("jkx,k->jx", curvature, a)
        matrix[n : 2 * n, n + 1 :] = jacobian
        matrix[2 * n, n + 1 :] = constant
        values = np.concatenate((mode.rates(at), jacobian @ a, [constant @ a - 1.0]))
        noise = np.concatenate((_noise(mode, derivative, at), np.abs(jacobian) @ np.abs(a), [1.0]))
        return values, matrix, noise

    located = _root(system, np.concatenate((x, vector)), n)
    if located is None:
        return None
    u, error = located
    return Located(u[: n + 1], error * mode.width, 0.0, u[n + 1 :])


def hopf(mode: "Sliding", x: np.ndarray, guess: complex, coupled: bool = False) -> Located | None:
    """The Hopf point near a point with the eigenvalue `guess`; coupled: where two frequencies meet.

    None where Newton's method leads to none, or to a pair of real eigenvalues.
    """
    n = mode.count
    values, vectors = np.linalg.eig(mode.jacobian(x))
    vector = vectors[:, np.argmin(np.abs(values - guess))]
    constant = vector.conj() / np.linalg.norm(vector) ** 2
    frequency = float(guess.imag)
    start = [x, [frequency], np.real(vector), np.imag(vector)]
    if coupled:
        unit = mode.jacobian(x) - 1j * frequency * np.eye(n)
        second = np.linalg.lstsq(np.vstack((unit, constant)), np.append(vector, 0.0), rcond=1e-6)[0]
        start += [np.real(second), np.imag(second)]

    re, im, re_2, im_2 = (slice(n + 2 + i * n, n + 2 + (i + 1) * n) for i in range(4))  # of v, and of w

    def system(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        at, omega, v = u[: n + 1], u[n + 1], u[re] + 1j * u[im]
        derivative, curvature = mode.derivative(at), mode.curvature(at)
        jacobian = derivative[:, :n]
        unit, size = jacobian - 1j * omega * np.eye(n), np.abs(jacobian) + abs(omega) * np.eye(n)

        def rows(*blocks: tuple[Any, np.ndarray]) -> np.ndarray:
            """Rows of the derivative, of which these blocks are not zero."""
            matrix = np.zeros((len(blocks[0][1]), len(u)), dtype=complex)
            for place, block in blocks:
                matrix[:, place] = block
            return matrix

        def eigen(v: np.ndarray, *blocks: tuple[Any, np.ndarray]) -> np.ndarray:
            """Rows of J v - i omega v."""
            return rows((slice(n + 1), np.einsum("jkx,k->jx", curvature, v)), (n + 1, -1j * v), *blocks)

        normal = constant[None]
        matrix = [rows((slice(n + 1), derivative)), eigen(v, (re, unit), (im, 1j * unit))]
        matrix.append(rows((re, normal), (im, 1j * normal)))
        values = [mode.rates(at).astype(complex), unit @ v, [constant @ v - 1.0]]
        noise = [_noise(mode, derivative, at), size @ np.abs(v), [1.0]]
        if coupled:
            w, one = u[re_2] + 1j * u[im_2], np.eye(n)
            matrix.append(eigen(w, (re, -one), (im, -1j * one), (re_2, unit), (im_2, 1j * unit)))
            matrix.append(rows((re_2, normal), (im_2, 1j * normal)))
            values += [unit @ w - v, [constant @ w]]
            noise += [size @ np.abs(w) + np.abs(v), [1.0]]
        # Rates are real: their imaginary rows are nothing.
        complex_values, complex_rows, noises = np.concatenate(values), np.vstack(matrix), np.concatenate(noise)
        real_values, real_rows = (np.concatenate((np.real(x), np.imag(x)[n:])) for x in (complex_values, complex_rows))
        return real_values, real_rows, np.concatenate((noises, noises[n:]))

    located = _root(system, np.concatenate(start), n)
    if located is None or not abs(located[0][n + 1]) > 1e-8 * frequency:
        return None
    u, error = located
    vector = u[re] + 1j * u[im] if u[n + 1] > 0.0 else u[re] - 1j * u[im]
    return Located(u[: n + 1], error * mode.width, abs(float(u[n + 1])), vector)


def _noise(mode: "Sliding", derivative: np.ndarray, x: np.ndarray) -> np.ndarray:
    """What inputs that are rounded in their last digit change the rates by."""
    share = abs(mode.between[0]) / mode.width + abs(x[-1])
    return np.abs(derivative) @ np.append(np.abs(x[:-1]), share)


@dataclasses.dataclass(frozen=True, eq=False)
class _Extended:
    """Unknowns of an extended system that were tried, with its values and its derivative.

    The residual is the length of Newton's own step, over the largest unknown: it measures a distance, whatever the
    units of equations.
    """

    x: np.ndarray
    values: np.ndarray
    matrix: np.ndarray
    noise: np.ndarray

    @functools.cached_property
    def inverse(self) -> np.ndarray:
        """Of the derivative, from rows and columns of one size."""
        rows = np.linalg.norm(self.matrix, axis=1)
        rows = np.where(rows > 0.0, rows, 1.0)
        columns = np.linalg.norm(self.matrix / rows[:, None], axis=0)
        columns = np.where(columns > 0.0, columns, 1.0)
        return np.linalg.pinv(self.matrix / rows[:, None] / columns, rcond=1e-15) / columns[:, None] / rows

    def step(self) -> np.ndarray:
        return -self.inverse @ self.values

    @property
    def residual(self) -> float:
        if not (np.all(np.isfinite(self.values)) and np.all(np.isfinite(self.matrix))):
            return np.inf
        return float(np.max(np.abs(self.step()))) / (1.0 + float(np.max(np.abs(self.x))))


def _root(
    system: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]], u: np.ndarray, place: int
) -> tuple[np.ndarray, float] | None:
    """(root, error of its component `place` by rounding); None where Newton's method does not arrive."""
    solution, _ = newton(lambda at: _Extended(at, *system(at)), u, LEVELS, MOST_STEPS)
    if not solution.residual <= LEVELS.rounding:
        return None
    eps, step = float(np.finfo(float).eps), solution.step()
    error = ROUNDINGS * eps * float(np.abs(solution.inverse[place]) @ solution.noise) + 2.0 * abs(float(step[place]))
    return solution.x + step, error


def first_lyapunov_coefficient(mode: "Sliding", x: np.ndarray, omega: float, vector: np.ndarray) -> float:
    """Of a Hopf point (Kuznetsov 2004, eq. 5.39), of an eigenvector of length 1 over natural sizes.

    Negative: a stable cycle is born on the side of unstable sliding (supercritical); positive: an unstable one on the
    side of stable sliding (subcritical); 0 where its terms cancel up to their errors. Second derivatives are exact,
    third ones a difference of those.
    """
    n = mode.count
    jacobian, bilinear = mode.jacobian(x), mode.curvature(x)[:, :, :n]
    units = balanced(jacobian, np.ones(n))[2]
    q = vector / np.linalg.norm(vector)
    values, vectors = np.linalg.eig(jacobian.T)
    p = vectors[:, np.argmin(np.abs(values + 1j * omega))]
    p = p / np.conj(np.vdot(p, q))

    def b(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.einsum("jkl,k,l->j", bilinear, u, v)

    def c(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        nudge, total = NUDGE / float(np.max(units) * np.max(np.abs(w) / units)), np.zeros(n, dtype=complex)
        for unit, part in ((1.0, np.real(w)), (1j, np.imag(w))):
            along = np.append(part * nudge, 0.0)
            slope = (mode.curvature(x + along) - mode.curvature(x - along))[:, :, :n] / (2.0 * nudge)
            total += unit * np.einsum("jkl,k,l->j", slope, u, v)
        return total

    def solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
        even, rows, columns = balanced(matrix, np.ones(n))
        return columns * np.linalg.lstsq(even, right / rows, rcond=1e-13)[0]

    third = c(q, q, q.conj())
    mean = solution(jacobian, b(q, q.conj()))
    double = solution(2j * omega * np.eye(n) - jacobian, b(q, q))
    terms = np.array([third, -2.0 * b(q, mean), b(q.conj(), double)])
    value = float(np.real(np.vdot(p, np.sum(terms, axis=0))))
    return value / (2.0 * omega) if abs(value) > CANCELLED * float(np.sum(np.abs(p) * np.abs(terms))) else 0.0
