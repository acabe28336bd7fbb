"""Intervals of all parameters of a fit: profiles, on thinned samples where these say the same with less work."""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.identification.inference.profile import BetterFound, Interval, profile_intervals
from vibrocap.identification.inference.uncertainty import Uncertainty, inverse, uncertainty
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.descent import descent
from vibrocap.identification.search.loss import Loss, Minimum

INTERVALS = ("profile", "covariance")
WORTH = 3  # times fewer samples from which a draft is used
SAME = 0.25  # logarithm of the ratio of standard errors up to which a draft says the same
AGAIN = 4  # how often a better fit that a profile comes upon is taken up

Profiles = dict[str, Interval]


def with_intervals(
    prediction: Prediction,
    draft: Prediction,
    best: Minimum,
    rule: Loss,
    intervals: str,
    progress: Callable[[float], None] | None = None,
) -> tuple[Minimum, Uncertainty, Profiles | None]:
    """The minimum, its uncertainty and the profiles of the law's parameters (None where they were not asked for).

    A lower minimum that a profile comes upon takes the place of the first, and the profiles begin again.
    """
    spread = spread_of(prediction, best, rule)
    for _ in range(AGAIN if intervals == "profile" else 0):
        try:
            quick = _draft_profiles(prediction, draft, best, spread, rule, progress)
            found = quick or profile_intervals(prediction, best, spread, rule, prediction.law_names, progress)
            return best, spread, found
        except BetterFound as better:
            best = descent(prediction, prediction.space.of(better.values), rule, evaluations=100, stop=1e-10)
            spread = spread_of(prediction, best, rule)
    return best, spread, None


def spread_of(prediction: Prediction, best: Minimum, rule: Loss) -> Uncertainty:
    """The uncertainty at a minimum of a prediction."""
    counts = prediction.counts
    errors = np.split(best.errors, np.cumsum([len(each) for each in prediction.records])[:-1])
    errors = [each[count] for each, count in zip(errors, counts, strict=True)]
    return uncertainty(errors, best.slopes[np.concatenate(counts)], prediction.space.slopes(best.u), rule)


def _draft_profiles(
    prediction: Prediction,
    draft: Prediction,
    best: Minimum,
    spread: Uncertainty,
    rule: Loss,
    progress: Callable[[float], None] | None,
) -> Profiles | None:
    """Profiles on thinned samples; None where these do not say the same as all.

    The cost's rise per sample is the same on both as long as the change of the force is seen by the thinned samples as
    well. So they serve where the standard errors that follow from the slopes agree within SAME, and the minimum is off
    by no more than half of a standard error. The intervals are moved to the minimum on all samples.
    """
    if prediction.size < WORTH * draft.size:
        return None
    low = descent(draft, best.u, rule, evaluations=60, stop=1e-8)
    share = draft.size / prediction.size
    space, law = prediction.space, [prediction.space.names.index(name) for name in prediction.law_names]
    full, thin = _errors(prediction, best), _errors(draft, low) * np.sqrt(share)
    values, thin_values = space.values(best.u), space.values(low.u)
    error = np.sqrt(np.diag(spread.covariance))
    alike = (np.abs(np.log(thin / full)) < SAME) & (np.abs(thin_values - values) < 0.5 * error)
    unseen = (error > values) & (np.sqrt(spread.inflation * spread.unit) * thin > thin_values)
    if not (alike | unseen)[law].all():
        return None
    scaled = dataclasses.replace(spread, unit=spread.unit * share)
    found = profile_intervals(draft, low, scaled, rule, prediction.law_names, progress)
    for name, j in zip(prediction.law_names, law, strict=True):
        if alike[j] and thin_values[j] > 0 and values[j] > 0:
            found[name] = found[name].times(values[j] / thin_values[j])
    return found


def _errors(prediction: Prediction, best: Minimum) -> np.ndarray:
    """Standard errors of the parameters, for errors of size 1 that are independent."""
    to_parameters = prediction.space.slopes(best.u)
    return np.sqrt(np.diag(to_parameters @ inverse(best.slopes.T @ best.slopes) @ to_parameters.T))
