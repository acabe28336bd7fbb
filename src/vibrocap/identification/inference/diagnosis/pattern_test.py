"""The test whether errors hold a pattern: least squares beside what the fit can absorb, for coloured, uneven noise.

Errors are correlated in time and larger in some samples than in others. So error and columns are whitened by an
autoregressive model of what the pattern leaves (Cochrane and Orcutt 1949), of the order that Schwarz's criterion
chooses, and the pattern's coefficients b are compared with their covariance, once for errors of one size and once for
any (White 1980, with the leverage of MacKinnon and White 1985). The less sure of both counts:

    W = b^T V^-1 b,  F-distributed with k and n/tau - k degrees of freedom over k, where there is no pattern

with the correlation time tau of what the pattern leaves. The variance of the errors is taken over as many degrees of
freedom, too: that is safe rather than sharp in coloured noise, whose model is learnt from few independent samples.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

ORDER = 30  # largest of the autoregressive model
KEPT = 1e-8  # of a column's square that others must leave for it to be a column of its own


@dataclasses.dataclass(frozen=True, eq=False)
class Pattern:
    """Columns [n, k] that a cause would add to the force; tries: how many such patterns were looked through for it.

    sparse: they are large in a few samples only, too few for their errors to tell how large errors are there.
    waves: whether the last three are a sine, a cosine and a constant.
    """

    columns: np.ndarray
    tries: float = 1.0
    sparse: bool = False
    waves: bool = False


def basis_of(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns [n, r] of the same span; none for what is rounding."""
    size = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns[:, size > 0] / size[size > 0]
    if not columns.shape[1]:
        return columns
    values, vectors = np.linalg.eigh(columns.T @ columns)
    kept = values > KEPT * len(values)
    basis = columns @ (vectors[:, kept] / np.sqrt(values[kept]))
    return basis


def without(values: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Values [n] or [n, k] less their projection."""
    return values - basis @ (basis.T @ values) if basis.shape[1] else values


def explained(error: np.ndarray, basis: np.ndarray, pattern: Pattern) -> tuple[float, np.ndarray]:
    """(share of an error's squares that a pattern explains, what it leaves); the error has no part in the basis."""
    left = without(pattern.columns, basis)
    small = np.sum(left**2, axis=0) <= KEPT * np.sum(pattern.columns**2, axis=0)
    own = basis_of(left[:, ~small])
    rest = without(error, own)
    return 1.0 - float(rest @ rest) / max(float(error @ error), 1e-300), rest


def probability(
    error: np.ndarray, absorbed: np.ndarray, pattern: Pattern, rest: np.ndarray, cuts: Sequence[int]
) -> float:
    """Probability with which noise alone would show as much of a pattern; times the tries, at most 1.

    absorbed [n, p]: columns that the fit adapts; rest [n]: what the pattern leaves; cuts: where records begin.
    """
    from scipy.special import fdtrc

    model, time = autoregression(np.split(rest, cuts))
    white = [filtered(column, model, cuts) for column in (error[:, None], absorbed, pattern.columns)]
    basis = basis_of(white[1])
    left = without(white[2], basis)
    keep = np.sum(left**2, axis=0) > KEPT * np.sum(white[2] ** 2, axis=0)
    own = basis_of(left[:, keep])
    n, k = own.shape
    free = n / time - k - basis.shape[1]
    if k == 0 or free < 5:
        return 1.0
    target = without(white[0][:, 0], basis)
    coefficients = own.T @ target
    remaining = target - own @ coefficients
    leverage = np.minimum(np.sum(own**2, axis=1), 0.9)
    uneven = own * (remaining / (1 - leverage))[:, None]
    one_size = float(coefficients @ coefficients) / max(float(remaining @ remaining) / free, 1e-300)
    if pattern.sparse:
        return min(float(fdtrc(k, free, one_size / k)) * pattern.tries, 1.0)
    any_size = float(coefficients @ np.linalg.lstsq(uneven.T @ uneven, coefficients, rcond=None)[0])
    return min(float(fdtrc(k, free, min(one_size, any_size) / k)) * pattern.tries, 1.0)


def autoregression(series: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """(coefficients a_1.. of e_i = a_1 e_i-1 + ... (Levinson and Durbin), its correlation time in samples, at least 1).

    The order is that with the least criterion; tau = s^2 / (1 - sum a)^2 with the share s^2 that the model leaves.
    """
    n = sum(len(piece) for piece in series)
    most = min(ORDER, n // 20)
    sums = np.array(
        [sum(float(piece[k:] @ piece[: max(len(piece) - k, 0)]) for piece in series) for k in range(most + 1)]
    )
    if not sums[0] > 0:
        return np.empty(0), 1.0
    a, left, best, least, time = np.empty(0), 1.0, np.empty(0), 0.0, 1.0
    rho = sums / sums[0]
    for order in range(1, most + 1):
        reflection = (rho[order] - float(a @ rho[order - 1 : 0 : -1])) / left
        a = np.append(a - reflection * a[::-1], reflection)
        left *= 1 - reflection**2
        if not left > 1e-12:
            break
        criterion = n * np.log(left) + np.log(n) * order
        if criterion < least:
            best, least = a, criterion
            time = left / max(1 - float(np.sum(a)), 1e-6) ** 2
    return best, max(time, 1.0)


def filtered(columns: np.ndarray, model: np.ndarray, cuts: Sequence[int]) -> np.ndarray:
    """Columns [n, k] less what the model says of each sample, record by record."""
    if not len(model) or not columns.shape[1]:
        return columns
    less, pieces = np.concatenate(([1.0], -model)), []
    for piece in np.split(columns, cuts):
        left = np.transpose([np.convolve(column, less)[: len(piece)] for column in piece.T])
        pieces.append(left[min(len(model), len(piece) // 2) :])
    return np.concatenate(pieces)
