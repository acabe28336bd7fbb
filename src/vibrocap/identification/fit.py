"""Fits of a friction law to records: the law is driven by the measured motion and answers with the measured force.

Or its steady curve is fitted, sample by sample, without the memory of the contact.
"""

import dataclasses
import functools
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_one_of, is_positive, suggestion
from vibrocap.identification.fit_result import Fit
from vibrocap.identification.inference.patterns import ripple
from vibrocap.identification.inference.residuals import record_errors
from vibrocap.identification.problem.coordinates import differing_parameters
from vibrocap.identification.problem.parametrisation import (
    Parametrisation,
    leading_levels,
    parametrisation,
    require_values,
)
from vibrocap.identification.problem.prediction import BESIDE, GAIN, Prediction, SteadyPrediction, nuisances
from vibrocap.identification.problem.priors import checked_priors
from vibrocap.identification.problem.samples import FEWEST_SAMPLES, Samples, data_scales, drafts, samples
from vibrocap.identification.problem.terms import RIPPLES, TERMS, checked_terms
from vibrocap.identification.search import Loss, finite, local_searches
from vibrocap.identification.solution import Settings, SimplerFits, solution
from vibrocap.progress import Progress, reporting
from vibrocap.records.record import Record, listed_records

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
    by_record: Sequence[str] = (),
    along: Mapping[str, str] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
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

    records: a `Record` or several. held_out: names of some of them, or further records: they are predicted, not fitted;
        their first tenth gives the contact's initial state and parameters `by_record`, the rest judges.
    law: an instance (its values are the first start and the values of what is held), a class or a name (then the data
        suggest the start). A law that contains others (`Law.special_cases`) starts from the best of each, too, and one
        with `bounds` from the best without them, so that neither ends in a worse minimum than those.
    free, fixed, bounds: see `parametrisation`; a static level is searched as a ratio, at least 1, over the Coulomb
        level; whole exponents and conventions are held unless named in `free`.
    starts: local searches, from random points (seed) around a start made from the data, drafted on thinned records; the
        best is polished on all samples.
    loss: linear, or soft_l1, huber, cauchy, arctan, which outliers pull less; loss_scale: error from which it bends,
        over the record's unit (by default one and a half robust deviations of a linear draft's errors).
    weights: "power": the unit of a record is the standard deviation of its force, so that each record counts the same
        per sample; "equal": one unit for all, right where the noise has the same size in newtons.
    terms: further forces on the sensor, each a fitted number, one for all records: "offset" (N), "mass" times
        acceleration, "spring" times displacement (with an offset for its middle), "damping" times velocity
        ("damping_forward" and "damping_back" of one direction), "drag" times v |v|, and where the contact turns
        "gravity" times sin(angle), "gravity_cosine" times cos(angle); "delay", the time (s) by which the force with all
        of them is late behind the motion; "ripple", a force periodic in position, and "friction_ripple", a factor of
        friction that is, whose wavelengths are searched; "adhesion", the load N_0 in mu (N + N_0) = mu N + F_0;
        "gain", the factor of the force sensor, by record (that of the first is 1) or with a prior.
    by_record: parameters and terms with a value in each record. along: {parameter or term: condition} of those that
        change in proportion to a number of the record, one of its `conditions` (a temperature, a time) or "load".
    priors: {name: (mean, standard deviation)} of parameters and terms.
    start: the contact's states at the first sample of each record: "fitted" (nobody measured them) or "relaxed" (zero).
    intervals: "profile" (likelihood profiles) or "covariance" (quicker; symmetric in the logarithm).
    load: normal force (N) of records without their own; without both, coefficients are forces in N.
    progress: True for a bar, or a function that is called with the share that is done.

    Returns a `Fit`; where all starts fail its status says so and its law is None. Raises ValueError for unknown names
    (with the nearest), bounds reversed, nothing free, fewer samples than parameters, unusable records.
    """
    begin = clock.perf_counter()
    settings = Settings(starts, loss, loss_scale, intervals, seed)
    check_one_of("weights", weights, WEIGHTS)
    check_one_of("start", start, STARTS)
    fitted, unseen = split_records(records, held_out, load)
    scales = data_scales(fitted)
    full = parametrisation(law, scales, free, fixed, bounds)
    require_values(law, free, fixed)
    own_units, thinned = units(fitted, weights), tuple(drafts(fitted, DRAFT))

    asked: dict[str, Any] = {"terms": checked_terms(terms, BESIDE, fitted), "start": start}
    along, priors, bounds = along or {}, priors or {}, bounds or {}
    if GAIN in asked["terms"] and GAIN not in by_record and GAIN not in priors:
        raise ArgumentError("terms", "gain is part of the law's levels: name it in by_record too, or give its prior")
    lengths: dict[str, float] = {}

    def predicted(choice: Parametrisation, of: tuple[Samples, ...]) -> Prediction:
        extra = nuisances(choice.template, fitted, level=scales.level, lengths=lengths, **asked)
        space = choice.space.with_more(extra)
        own, conditions = list(by_record), dict(along)
        if choice is not full:  # a simpler law has fewer parameters
            own = [name for name in own if name in space.names]
            conditions = {name: what for name, what in conditions.items() if name in space.names}
        differing, more = differing_parameters(space, space.begun(choice.start), fitted, own, conditions)
        space = space.with_more(more)
        if GAIN not in priors:  # the first record's is 1
            space = dataclasses.replace(space, coordinates=tuple(c for c in space.coordinates if c.name != GAIN))
        return Prediction(choice.template, space, of, own_units, threads, differing=differing)

    if ripples := [name for name in asked["terms"] if name in RIPPLES]:
        without = predicted(full, tuple(fitted)), predicted(full, thinned)
        lengths |= ripple_lengths(ripples, *without, full, settings)
    prediction, draft = predicted(full, tuple(fitted)), predicted(full, thinned)
    known = checked_priors(priors, prediction.space.names)
    prediction, draft = (dataclasses.replace(part, priors=known) for part in (prediction, draft))
    options = {"method": "driven by the measured motion", "weights": weights, **asked, "load": load}
    options |= {"by_record": list(by_record), "along": dict(along)}
    options["priors"] = {prior.name: (prior.mean, prior.deviation) for prior in known}
    options |= {"fixed": dict(fixed or {}), "bounds": {name: tuple(pair) for name, pair in bounds.items()}}
    simpler = SimplerFits(functools.partial(predicted, of=thinned), scales, bounds, starts, seed)
    with reporting(progress, f"Fitting {full.template.name}") as report:
        return solution(prediction, draft, full, settings, unseen, options, begin, report, simpler)


def ripple_lengths(
    names: Sequence[str], prediction: Prediction, draft: Prediction, full: Parametrisation, settings: Settings
) -> dict[str, float]:
    """Wavelengths at which the errors of a fit without ripples have most, by the ripple's name."""
    first = [draft.space.begun(full.start)]
    end, _ = local_searches(draft, first, starts=settings.starts, loss=Loss(settings.loss), seed=settings.seed)[0]
    errors = finite(prediction.errors(end.u))
    waves = {name: strongest_wave(name, prediction, errors) for name in names}
    if none := [name for name, length in waves.items() if not length > 0.0]:
        raise ArgumentError("terms", f"{none[0]} needs a path of several waves, sampled many times in each")
    return waves


def strongest_wave(name: str, prediction: Prediction, errors: np.ndarray) -> float:
    """Wavelength of a ripple that errors have most of; 0 where the path is too short for any."""
    records = record_errors(prediction, errors)
    counted = np.concatenate([record.error[record.counts] for record in records])
    return ripple(records, counted, [TERMS[f"{name}_sine"].of_friction])[0]


def units(fitted: Sequence[Samples], weights: str) -> tuple[float, ...]:
    """Error that counts as 1, of each record."""
    if weights == "power":
        return tuple(record.deviation for record in fitted)
    return (float(np.std(np.concatenate([record.force for record in fitted]))),) * len(fitted)


def split_records(records: Any, held_out: Any, load: float | None) -> tuple[list[Samples], list[Samples]]:
    """Samples to fit and samples held out."""
    records = listed_records(records, Samples)
    if not records:
        raise ArgumentError("records", "there is none")
    if load is not None and not is_positive(load):
        raise ArgumentError("load", f"should be a normal force > 0 in N, got {load!r}")
    all_samples = [samples(record, load) for record in records]
    names = [sample.name for sample in all_samples]
    if len(set(names)) < len(names):
        raise ArgumentError("records", f"should have different names, got {', '.join(names)}")
    turning = [sample.name for sample in all_samples if sample.rotary]
    if turning and len(turning) < len(all_samples):
        raise ArgumentError("records", f"{', '.join(turning)} turn and the others slide; should be of one contact")
    unseen: list[Samples] = []
    for item in held_out if isinstance(held_out, (list, tuple)) else [held_out]:
        if item not in names and not isinstance(item, (Record, Samples)):
            raise ArgumentError("held_out", f"no record is called {item!r}; {suggestion(item, names)}")
        unseen.append(all_samples[names.index(item)] if isinstance(item, str) else samples(item, load))
    hidden = {record.name for record in unseen}
    fitted = [sample for sample in all_samples if sample.name not in hidden]
    if not fitted:
        raise ArgumentError("held_out", "leaves no record to fit")
    return fitted, unseen


def steady_fit(
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
    intervals: str = "profile",
    held_out: Any = (),
    least_speed: float = 0.0,
    load: float | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Fit:
    """Fit the steady curve R(v) of a law to samples of force and velocity.

    For measurements at constant speeds, and for set-valued laws, which have nothing else. Samples at rest tell nothing
    of the curve and are left out, as are those slower than `least_speed` (m/s): near a reversal the contact is elastic.
    Parameters that the steady curve does not show (stiffness, bristle damping) are held at the law's own values, which
    nobody measured, and `options["not_shown"]` names them; `free` may not.
    The other arguments, the result and the errors are those of `fit.fit`.
    """
    begin = clock.perf_counter()
    settings = Settings(starts, loss, loss_scale, intervals, seed)
    if not (np.isfinite(least_speed) and least_speed >= 0):
        raise ArgumentError("least_speed", f"should be a speed >= 0 in m/s, got {least_speed!r}")
    parts = split_records(records, held_out, load)
    fitted, unseen = ([_moving(record, least_speed) for record in part] for part in parts)
    scales = data_scales(fitted)
    full = parametrisation(law, scales, free, fixed, bounds)
    prediction = SteadyPrediction(full.template, full.space, tuple(fitted), units(fitted, weights))
    slopes = prediction.slopes(full.start)
    shown = [name for name, column in zip(full.space.names, slopes.T, strict=True) if np.abs(column).max() > 1e-9]
    if free is not None and len(shown) < len(full.space.names):
        hidden = next(name for name in full.space.names if name not in shown)
        raise ArgumentError("free", f"{hidden} does not change the steady curve; fit the driven law for it")
    if not shown:
        raise ArgumentError("law", f"no parameter of {full.template.name} changes the steady curve at these speeds")
    # a static level that is not shown must not be held below the Coulomb level that is searched: it goes along
    leaders = leading_levels(full.template)
    searched = [name for name in full.space.names if name in shown or leaders.get(name) in shown]
    hidden = [name for name in full.space.names if name not in searched]
    if hidden:
        kept = {name: pair for name, pair in (bounds or {}).items() if name in searched}
        full = parametrisation(law, scales, searched, fixed, kept)
    own_units, asked = units(fitted, weights), checked_terms(terms, (), fitted)

    def predicted(choice: Parametrisation, of: tuple[Samples, ...]) -> SteadyPrediction:
        extra = nuisances(choice.template, fitted, terms=asked, start="relaxed", level=scales.level)
        return SteadyPrediction(choice.template, choice.space.with_more(extra), of, own_units)

    prediction = predicted(full, tuple(fitted))
    every = max(1, prediction.size // DRAFT)
    thinned = tuple(record.kept(slice(None, None, every)) for record in fitted)

    options = {"method": "steady curve", "weights": weights, "terms": asked, "least_speed": least_speed}
    options |= {"load": load, "fixed": dict(fixed or {}), "not_shown": hidden}
    draft = predicted(full, thinned)
    simpler = SimplerFits(functools.partial(predicted, of=thinned), scales, bounds or {}, starts, seed)
    with reporting(progress, f"Fitting {full.template.name}") as report:
        return solution(prediction, draft, full, settings, unseen, options, begin, report, simpler)


def _moving(record: Samples, least_speed: float) -> Samples:
    """The samples that move."""
    moving = np.abs(record.velocity) > least_speed
    if (count := int(moving.sum())) < FEWEST_SAMPLES:
        raise ArgumentError(f"record {record.name!r}", f"has {count} samples faster than {least_speed:g} m/s")
    return record.kept(moving)
