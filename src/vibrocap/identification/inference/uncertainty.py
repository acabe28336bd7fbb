"""Uncertainty of least squares whose errors are correlated: covariance, effective samples and the unit of deviance."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search import Loss, Minimum

WINDOW = 5.0  # correlation times over which correlations are summed (Sokal 1997)
LEVEL = 0.95
FAINT = 1e-9  # length of a column of slopes that are rounding
FEWEST = 2.0  # degrees of freedom that an interval has at least


@dataclasses.dataclass(frozen=True, eq=False)
class Uncertainty:
    """How far a cost may rise, and parameters may be off, by chance.

    Neighbouring errors are correlated. With the correlation time tau = 1 + 2 sum_k rho_k of the contributions
    psi_i = (J^T J)^-1 J_i e_i of the samples to a parameter's estimate, its variance is tau times that of independent
    errors. (A mean error that pushes no parameter does not count; records that want different values of a parameter
    do.) Where few samples determine a parameter, their own errors are fitted away; so tau is also taken as for
    stationary errors, 1 + 2 sum_k rho_k(e) c_k, with the correlations c of the leverage J (J^T J)^-1, and the larger
    counts. Errors that are larger in some samples than in others count where they have leverage (the covariance is the
    sandwich of White 1980): both factors together are the inflation.

    unit: s^2 = sum psi^2/(n - p) / mean psi', the cost by which -2 log(likelihood) changes by 2 for independent errors
        (psi: derivative of the loss; for squares s^2 = sum e^2/(n - p)).
    inflation [p]: variance of each parameter over that for independent errors of one size, tau times the unevenness of
        the errors; n over it is the number of samples that count for it.
    threshold [p]: t such that the interval of a parameter (95 %) ends where 2 (cost - least cost) = s^2 t^2; the
        quantile of Student's t for n/tau - p degrees of freedom, times sqrt(tau).
    covariance [p, p]: of the parameters, with the inflation; huge along what the data do not determine.
    effective: sum of the records' n/tau, with the correlation time of each record's errors.
    known [p]: share of what is known of each parameter that the priors contribute, 0 to 1.
    """

    unit: float
    inflation: np.ndarray
    threshold: np.ndarray
    covariance: np.ndarray
    effective: float
    known: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """What a fit minimised: the prediction on all samples and on few, the loss, the minimum and its uncertainty.

    Of a law whose force jumps, without the samples beside jumps (see `solution.away_from_jumps`): its minimum is a
    little off the fit's.
    """

    prediction: Prediction
    draft: Prediction
    loss: Loss
    best: Minimum
    uncertainty: Uncertainty

    def at(self, best: Minimum) -> "Problem":
        """The same at another minimum."""
        return dataclasses.replace(self, best=best, uncertainty=spread_of(self.prediction, best, self.loss))


def spread_of(prediction: Prediction, best: Minimum, loss: Loss) -> Uncertainty:
    """The uncertainty at a minimum of a prediction."""
    counts = prediction.counts
    errors = [error[count] for error, count in zip(prediction.by_record(best.errors), counts, strict=True)]
    slopes, known = np.split(best.slopes, [prediction.size])
    return uncertainty(errors, slopes[np.concatenate(counts)], known, prediction.space.slopes(best.u), loss)


def uncertainty(
    errors: Sequence[np.ndarray], slopes: np.ndarray, priors: np.ndarray, to_parameters: np.ndarray, loss: Loss
) -> Uncertainty:
    """The uncertainty at a minimum.

    errors: [n] per record; slopes [n, p]: their derivatives by the coordinates, all records in a row; priors [q, p]:
    slopes of the errors that priors add; to_parameters [m, p]: derivatives of the parameters by the coordinates.
    """
    from scipy.special import stdtrit

    n, p = slopes.shape
    psi, bend = loss.influence(np.concatenate(errors))
    unit = float(np.sum(psi**2) / max(n - p, 1) / bend)
    base = inverse(slopes.T @ slopes + priors.T @ priors)
    known = np.zeros(len(to_parameters))
    if len(priors):  # the samples make this share of the variance of each estimate, the priors the rest
        gain = to_parameters @ base
        own = np.einsum("pi,ij,pj->p", gain, slopes.T @ slopes, gain) / np.sum(gain * to_parameters, axis=1)
        known = 1.0 - np.clip(own, 0.0, 1.0)
    leverage = slopes @ (base @ to_parameters.T)
    influence = (slopes * psi[:, None]) @ (base @ to_parameters.T)
    inflation, cuts = _unevenness(influence, leverage, unit), np.cumsum([len(error) for error in errors])[:-1]
    for j in range(len(to_parameters)):
        own, stationary = (np.split(matrix[:, j], cuts) for matrix in (influence, leverage))
        inflation[j] *= max(_inflation(own), _inflation(errors, stationary))
    spare = np.maximum(n / inflation - p, FEWEST) / np.maximum(1.0 - known, FAINT)
    root = np.sqrt(inflation)
    covariance = unit / bend * (to_parameters @ base @ to_parameters.T) * np.outer(root, root)
    threshold = stdtrit(spare, 0.5 + 0.5 * LEVEL) * root
    effective = sum(len(error) / correlation_time(error) for error in errors)
    return Uncertainty(unit, inflation, threshold, covariance, effective, known)


def _unevenness(influence: np.ndarray, leverage: np.ndarray, unit: float) -> np.ndarray:
    """Variance of each estimate [p] over that for errors of one size: above 1 where they are large where they matter.

        sum (J (J^T J)^-1 e)_i^2 / (s^2 sum (J (J^T J)^-1)_i^2)            White 1980

    The ratio is itself uncertain, by sqrt(2/m) where m samples have the leverage; below 1 it counts only as far as it
    is sure to two of these.
    """
    squares = np.sum(leverage**2, axis=0)
    known = squares > 0
    ratio, number = np.ones(len(squares)), np.full(len(squares), np.inf)
    ratio[known] = np.sum(influence**2, axis=0)[known] / (unit * squares[known])
    number[known] = squares[known] ** 2 / np.sum(leverage**4, axis=0)[known]
    return np.where(ratio > 1.0, ratio, np.minimum(ratio * np.exp(2.0 * np.sqrt(2.0 / number)), 1.0))


def correlation_time(errors: np.ndarray) -> float:
    """Integrated correlation time of errors in samples, at least 1."""
    return _inflation([errors])


def _inflation(series: Sequence[np.ndarray], leverage: Sequence[np.ndarray] | None = None) -> float:
    """tau of several stretches of one quantity of mean zero, at least 1 and at most half the longest stretch.

    leverage: weights of the samples in a sum whose variance is asked for; the quantity's correlations then count as
    often as the weights have them. The sum of the correlations ends at the first lag that is WINDOW times the time
    found until there; beyond, it would gather noise.
    """
    longest = max(len(piece) for piece in series)
    correlation = _correlation(series, longest)
    if not correlation[0] > 0:
        return 1.0
    correlation = correlation / correlation[0]
    if leverage is not None:
        weights = _correlation(leverage, longest)
        correlation = correlation * weights / max(weights[0], 1e-300)
    times = 2.0 * np.cumsum(correlation) - 1.0
    enough = np.flatnonzero(np.arange(longest) >= WINDOW * times)
    return float(min(max(times[enough[0] if len(enough) else longest - 1], 1.0), longest / 2))


def _correlation(series: Sequence[np.ndarray], longest: int) -> np.ndarray:
    """Sums of products at each lag [longest]."""
    correlation = np.zeros(longest)
    for piece in series:
        power = np.abs(np.fft.rfft(piece, 2 * len(piece))) ** 2
        correlation[: len(piece)] += np.fft.irfft(power)[: len(piece)]
    return correlation


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a matrix J^T J; directions that it does not determine get a huge variance instead of an error.

    J: changes of errors that are themselves of the order of 1, so that a column shorter than FAINT says nothing.
    """
    scale = np.maximum(np.sqrt(np.diag(matrix)), FAINT)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    values = np.maximum(values, 1e-14)
    return (vectors / values) @ vectors.T / np.outer(scale, scale)
