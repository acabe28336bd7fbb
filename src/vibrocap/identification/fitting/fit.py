"""Fits of a friction law to records: the law is driven by the measured motion and answers with the measured force."""

import functools
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_one_of, is_positive, suggestion
from vibrocap.identification.fitting.simpler_fits import SimplerFits
from vibrocap.identification.fitting.solution import Settings, solution
from vibrocap.identification.problem.data_scales import data_scales
from vibrocap.identification.problem.parametrisation import Parametrisation, parametrisation, require_values
from vibrocap.identification.problem.prediction import DELAY, Prediction, nuisances
from vibrocap.identification.problem.samples import Samples, drafts, samples
from vibrocap.identification.problem.terms import checked_terms
from vibrocap.identification.result.fit_result import Fit
from vibrocap.identification.search.loss import Loss
from vibrocap.progress import Progress, reporting

DRAFT = 4000  # samples, in all, of a draft
STARTS = ("fitted", "relaxed")
WEIGHTS = ("power", "equal")


def fit(
    records: Any,
    law: Any,
    *,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    starts: int = 8,
    loss: str = "linear",
    loss_scale: float | None = None,
    weights: str = "power",
    terms: str | Sequence[str] = (),
    start: str = "fitted",
    intervals: str = "profile",
    held_out: Any = (),
    load: float | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = None,
) -> Fit:
    """Fit a friction law to measured records, all of them together.

    The law is driven by the measured velocity, and its parameters minimise the error of its force,

        sum over records and samples of loss[(R(law; v(t), N) + terms - F) / unit of the record].

    records: a `Record` or several. held_out: names of some of them, or further records: they are predicted, not fitted,
        from a relaxed contact.
    law: an instance (its values are the first start and the values of what is held), a class or a name (then the data
        suggest the start). free, fixed, bounds: see `parametrisation`; a static level is searched as a ratio, at least
        1, over the Coulomb level; whole exponents and conventions are held unless named in `free`.
    A law that contains others (`Law.special_cases`) starts from the best of each, too, and one with `bounds` from
    the best without them, so that neither ends in a worse minimum than those.
    starts: local searches, from points of a scrambled Sobol sequence (seed) around a start made from the data; they are
        drafted on thinned records and the best draft is polished on all samples.
    loss: linear, or soft_l1, huber, cauchy, arctan, which outliers pull less; loss_scale: error from which it bends,
        over the record's unit (by default one and a half robust deviations of a linear draft's errors).
    weights: "power": the unit of a record is the standard deviation of its force, so that each record counts the same
        per sample; "equal": one unit for all, right where the noise has the same size in newtons.
    terms: what the sensor measures beside friction, each a number that is searched, one for all records: "offset" (N),
        "mass" times acceleration, "spring" times displacement (with an offset for its middle), "damping" times velocity
        ("damping_forward" and "damping_back" of one direction), "drag" times v |v|, and where the contact turns
        "gravity" times sin(angle), "gravity_cosine" times cos(angle); "delay", the time (s) by which the force with all
        of them is late behind the motion.
    start: the contact's states at the first sample of each record: "fitted" (nobody measured them) or "relaxed" (zero).
    intervals: "profile" (likelihood profiles) or "covariance" (quicker; symmetric in the logarithm).
    load: normal force (N) of records without their own; without both, coefficients are forces in N.
    progress: True for a bar, or a function that is called with the share that is done.

    Returns a `Fit`; where all starts fail its status says so and its law is None. Same input, same numbers.
    Raises ValueError for input that makes no sense: unknown names (with the nearest), bounds reversed, nothing free,
    fewer samples than parameters, unusable records.
    """
    begin = clock.perf_counter()
    settings = Settings(starts, loss, loss_scale, intervals, seed)
    check_one_of("weights", weights, WEIGHTS)
    check_one_of("start", start, STARTS)
    fitted, unseen = split_records(records, held_out, load)
    scales = data_scales(fitted)
    chosen = parametrisation(law, scales, free, fixed, bounds)
    require_values(law, free, fixed)
    own_units, thinned = units(fitted, weights), tuple(drafts(fitted, DRAFT))

    asked: dict[str, Any] = {"terms": checked_terms(terms, (DELAY,), fitted), "start": start}

    def predicted(choice: Parametrisation, of: tuple[Samples, ...]) -> Prediction:
        extra = nuisances(choice.template, fitted, level=scales.level, **asked)
        return Prediction(choice.template, choice.space.with_more(extra), of, own_units, threads)

    def simpler(loss: Loss) -> list[np.ndarray]:
        draft = functools.partial(predicted, of=thinned)
        return SimplerFits(draft, scales, bounds or {}, settings.starts, loss, settings.seed).ends(chosen)

    prediction, draft = predicted(chosen, tuple(fitted)), predicted(chosen, thinned)
    options = {"method": "driven by the measured motion", "weights": weights, **asked, "load": load}
    own_bounds = {name: tuple(pair) for name, pair in (bounds or {}).items()}
    options |= {"fixed": dict(fixed or {}), "bounds": own_bounds}
    with reporting(progress, f"Fitting {chosen.template.name}") as report:
        return solution(prediction, draft, chosen, settings, unseen, options, begin, report, simpler)


def units(fitted: Sequence[Samples], weights: str) -> tuple[float, ...]:
    """Error that counts as 1, of each record."""
    if weights == "power":
        return tuple(each.deviation for each in fitted)
    return (float(np.std(np.concatenate([each.force for each in fitted]))),) * len(fitted)


def split_records(records: Any, held_out: Any, load: float | None) -> tuple[list[Samples], list[Samples]]:
    """Samples to fit and samples held out."""
    given = list(records) if isinstance(records, (list, tuple)) else [records]
    if not given:
        raise ArgumentError("records", "there is none")
    if load is not None and not is_positive(load):
        raise ArgumentError("load", f"should be a normal force > 0 in N, got {load!r}")
    all_samples = [samples(record, load) for record in given]
    names = [each.name for each in all_samples]
    if len(set(names)) < len(names):
        raise ArgumentError("records", f"should have different names, got {', '.join(names)}")
    turning = [each.name for each in all_samples if each.rotary]
    if turning and len(turning) < len(all_samples):
        raise ArgumentError("records", f"{', '.join(turning)} turn and the others slide; should be of one contact")
    unseen: list[Samples] = []
    for item in held_out if isinstance(held_out, (list, tuple)) else [held_out]:
        if isinstance(item, str):
            if item not in names:
                raise ArgumentError("held_out", f"no record is called {item!r}; {suggestion(item, names)}")
            unseen.append(all_samples[names.index(item)])
        else:
            unseen.append(samples(item, load))
    hidden = {each.name for each in unseen}
    fitted = [each for each in all_samples if each.name not in hidden]
    if not fitted:
        raise ArgumentError("held_out", "leaves no record to fit")
    return fitted, unseen
