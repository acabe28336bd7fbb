"""Fits of the steady curve: force against velocity, sample by sample, without the memory of the contact."""

import functools
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.identification.fitting.fit import DRAFT, split_records, units
from vibrocap.identification.fitting.simpler_fits import SimplerFits
from vibrocap.identification.fitting.solution import Settings, solution
from vibrocap.identification.problem.data_scales import data_scales
from vibrocap.identification.problem.parametrisation import Parametrisation, leading_levels, parametrisation
from vibrocap.identification.problem.prediction import nuisances
from vibrocap.identification.problem.samples import FEWEST_SAMPLES, Samples
from vibrocap.identification.problem.steady_prediction import SteadyPrediction
from vibrocap.identification.problem.terms import checked_terms
from vibrocap.identification.result.fit_result import Fit
from vibrocap.progress import Progress, reporting


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
    if moving.sum() < FEWEST_SAMPLES:
        few = f"has {int(moving.sum())} samples faster than {least_speed:g} m/s"
        raise ArgumentError(f"record {record.name!r}", few)
    return record.kept(moving)
