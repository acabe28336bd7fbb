"""Priors: what is known of parameters before a fit, as errors beside those of the samples.

A parameter p that a scale, a data sheet or another experiment tells as m +- d has the error w (p - m)/d. Its weight w
is what an error of one deviation is worth among errors that are correlated: w^2 = s^2 tau, with the unit s^2 and the
correlation time tau of `uncertainty`. Both follow from the fit itself, which therefore ends with some rounds.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion

MOST = 3.5  # standard deviations by which data and prior may differ; beyond, one of both is wrong
WEIGHTINGS, SETTLED = 5, 0.02  # of weights and fits at most, until the weights change by less than such a share
SAYS_MORE = 0.5  # share of what is known of a parameter, from which on its prior says more than the data


@dataclasses.dataclass(frozen=True)
class Prior:
    """A normal distribution of a parameter.

    weight: of an error of one deviation, 0 as long as it is not known; pull: by how many standard deviations of both
    what the data say alone is off.
    """

    name: str
    mean: float
    deviation: float
    weight: float = 0.0
    pull: float = 0.0


def checked_priors(known: Mapping[str, Any] | None, names: Sequence[str]) -> tuple[Prior, ...]:
    """Priors from {name: (mean, standard deviation)} of names that are searched, or ArgumentError."""
    priors = []
    for name, pair in (known or {}).items():
        if name not in names:
            raise ArgumentError("priors", f"{name!r} is not searched; {suggestion(name, names)}")
        try:
            mean, deviation = (float(number) for number in pair)
        except (TypeError, ValueError):
            mean = deviation = math.nan
        if not (math.isfinite(mean) and 0.0 < deviation < math.inf):
            raise ArgumentError("priors", f"{name} should be a mean and a standard deviation > 0, got {pair!r}")
        priors.append(Prior(name, mean, deviation))
    return tuple(priors)


def weighted(priors: Sequence[Prior], names: Sequence[str], unit: float, inflation: np.ndarray) -> tuple[Prior, ...]:
    """The same with the weights that s^2 and the correlation times [p] of the named parameters give them."""
    weights = np.sqrt(unit * inflation)
    return tuple(dataclasses.replace(prior, weight=float(weights[names.index(prior.name)])) for prior in priors)


def pulled(
    priors: Sequence[Prior], names: Sequence[str], values: np.ndarray, covariance: np.ndarray
) -> tuple[Prior, ...]:
    """The same, knowing what the data say alone: parameters [p] and their covariance."""
    places = [names.index(prior.name) for prior in priors]
    pairs = zip(priors, values[places], np.diag(covariance)[places], strict=True)
    pulls = [(prior, (value - prior.mean) / math.sqrt(prior.deviation**2 + own)) for prior, value, own in pairs]
    return tuple(dataclasses.replace(prior, pull=float(pull)) for prior, pull in pulls)


def settled(old: Sequence[Prior], new: Sequence[Prior]) -> bool:
    """Whether weights have changed by next to nothing."""
    return all(abs(a.weight - b.weight) <= SETTLED * b.weight for a, b in zip(old, new, strict=True))


def prior_errors(priors: Sequence[Prior], names: Sequence[str], values: np.ndarray) -> np.ndarray:
    """Errors [..., priors] of parameters [..., p]."""
    columns = [prior.weight / prior.deviation * (values[..., names.index(prior.name)] - prior.mean) for prior in priors]
    return np.stack(columns, axis=-1) if columns else np.empty((*values.shape[:-1], 0))


def prior_slopes(priors: Sequence[Prior], names: Sequence[str], slopes: np.ndarray) -> np.ndarray:
    """Derivatives [priors, p] of these errors; slopes [p, p]: of the parameters by the coordinates."""
    rows = [prior.weight / prior.deviation * slopes[names.index(prior.name)] for prior in priors]
    return np.array(rows).reshape(len(rows), slopes.shape[1])
