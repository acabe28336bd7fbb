"""The solution of a fit: starts, search, intervals and report for any prediction.

A law that contains another can be no worse than that, but a search of more parameters can end in a worse minimum. So it
also starts from the best of what it contains, and of the same law without bounds of one's own.
"""

import dataclasses
import time as clock
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_one_of, check_whole, is_positive
from vibrocap.identification.fit_report import failed_fit, finished_fit
from vibrocap.identification.fit_result import Fit
from vibrocap.identification.inference.intervals import INTERVALS, with_intervals
from vibrocap.identification.inference.uncertainty import Problem, spread_of
from vibrocap.identification.problem.coordinates import Space
from vibrocap.identification.problem.parametrisation import Parametrisation, law_class, parametrisation
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.problem.priors import WEIGHTINGS, pulled, settled, weighted
from vibrocap.identification.problem.samples import DataScales, Samples
from vibrocap.identification.search import (
    COARSE_STOP,
    LOSSES,
    Loss,
    Minimum,
    SearchStatus,
    descent,
    local_searches,
    robust_scale,
    search,
)
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics.parameters import parameter_table


@dataclasses.dataclass(frozen=True)
class SimplerFits:
    """The fits of the laws that a law contains, on thinned records; `best` of a choice is that of its own drafts.

    draft: what belongs to a choice of parameters, nuisances included; scales: of the data; bounds: those of one's own
    """

    draft: Callable[[Parametrisation], Prediction]
    scales: DataScales
    bounds: Mapping[str, tuple[float, float]]
    starts: int
    seed: int

    def ends(self, choice: Parametrisation, loss: Loss) -> list[np.ndarray]:
        """Coordinates, nuisances included, of the best drafts of the simpler fits of a choice."""
        space, ends = self.draft(choice).space, []
        if self.bounds:
            free = self._choice(choice.template, choice.space.names)
            ends.append(dataclasses.replace(self, bounds={}).best(free, loss))
        for name, values in type(choice.template).special_cases.items():
            simpler = self._special_case(choice, name, values)
            best = None if simpler is None else self.best(simpler, loss)
            if best is not None:
                ends.append({**best, **{k: best.get(v, 1.0) if isinstance(v, str) else v for k, v in values.items()}})
        middle = space.named(space.begun(choice.start))
        known = [{k: v for k, v in end.items() if k in middle} for end in ends if end is not None]
        return [space.of({**middle, **end}) for end in known]

    def best(self, choice: Parametrisation, loss: Loss) -> dict[str, float] | None:
        """Values by name of the best draft of a choice, its own simpler fits among the starts."""
        prediction = self.draft(choice)
        first, also = [prediction.space.begun(choice.start)], self.ends(choice, loss)
        end, _ = local_searches(prediction, first, also, starts=self.starts, loss=loss, seed=self.seed)[0]
        return None if end.status == SearchStatus.FAILED else prediction.space.named(end.u)

    def _choice(self, template: Any, free: Sequence[str], bounds: Any = None) -> Parametrisation:
        """The choice of a law's free parameters; the others are held at the template's values."""
        values = {info.name: getattr(template, info.name) for info in parameter_table(template)}
        held = {name: value for name, value in values.items() if name not in free and isinstance(value, float)}
        return parametrisation(type(template), self.scales, free, held, bounds)

    def _special_case(
        self, choice: Parametrisation, name: str, values: Mapping[str, float | str]
    ) -> Parametrisation | None:
        """The choice of a simpler law; None where what is held does not allow it."""
        template, free = choice.template, choice.space.names
        for own, value in values.items():
            wanted = getattr(template, value) if isinstance(value, str) else value
            if own not in free and getattr(template, own) != wanted:
                return None
        cls = law_class(name)
        infos = parameter_table(cls)
        shared = [info.name for info in infos if info.name in free]
        if not shared:
            return None
        inner = cls(**{info.name: getattr(template, info.name) for info in infos if hasattr(template, info.name)})
        return self._choice(inner, shared, {k: pair for k, pair in self.bounds.items() if k in shared})


BESIDE = 2  # samples on either side of a closing that are left out
REMAINING = 0.5  # share of the samples that must remain
JOINT = "engaged"


@dataclasses.dataclass(frozen=True)
class Settings:
    """How a fit searches; see `fit.fit`. Raises ValueError for settings that make no sense."""

    starts: int
    loss: str
    loss_scale: float | None
    intervals: str
    seed: int

    def __post_init__(self):
        check_whole("starts", self.starts, 1)
        check_whole("seed", self.seed, 0)
        if self.loss_scale is not None and not is_positive(self.loss_scale):
            raise ArgumentError("loss_scale", f"should be > 0, got {self.loss_scale!r}")
        check_one_of("loss", self.loss, LOSSES)
        check_one_of("intervals", self.intervals, INTERVALS)


def solution(
    prediction: Prediction,
    draft: Prediction,
    choice: Parametrisation,
    settings: Settings,
    unseen: Sequence[Samples],
    options: Mapping[str, Any],
    begin: float,
    report: Callable[[float], Any] | None,
    simpler: SimplerFits | None = None,
) -> Fit:
    """The fit of a prediction, whose first coordinates are those of the choice.

    draft: the same for few samples; unseen: held-out samples; options: for the result; begin: perf_counter at start.
    simpler: the fits from which further starts come.
    """
    report = report or (lambda _: None)
    space = prediction.space
    if prediction.size <= (unknowns := len(space.coordinates)):
        few = f"have {prediction.size} samples for {unknowns} free parameters; more samples are needed"
        raise ArgumentError("records", few)
    # the last one is the centre of the other starts
    first = [space.begun(u) for u in (choice.own_start, choice.start) if u is not None]
    rule = Loss(settings.loss, settings.loss_scale or 1.0)
    if settings.loss != "linear" and settings.loss_scale is None:
        linear = descent(draft, first[-1], Loss(), evaluations=12, stop=1e-4)
        rule = Loss(settings.loss, robust_scale(linear.errors[: draft.size][np.concatenate(draft.counts)]))
    all_options = {**options, **dataclasses.asdict(settings)}
    all_options["loss_scale"] = rule.scale if settings.loss != "linear" else None
    further = simpler.ends(choice, rule) if simpler is not None else []
    how: dict[str, Any] = {"starts": settings.starts, "seed": settings.seed, "loss": rule, "report": report}
    best, ended = search(prediction, draft, first, further, **how)
    if best.status == SearchStatus.FAILED:
        seconds = clock.perf_counter() - begin
        return failed_fit(prediction.template.name, ended, prediction.size, all_options, seconds)
    if prediction.priors:
        alone = prediction.space.values(best.u), spread_of(prediction, best, rule).covariance
        known = pulled(prediction.priors, prediction.space.names, *alone)
        prediction = dataclasses.replace(prediction, priors=known)
        prediction, draft = with_weights(prediction, draft, best, rule)
        best, ended = search(prediction, draft, first, [*further, best.u], **how)
        for _ in range(WEIGHTINGS):
            before = prediction.priors
            prediction, draft = with_weights(prediction, draft, best, rule)
            best = descent(prediction, best.u, rule)
            if settled(before, prediction.priors):
                break
    ordered = elements_in_order(prediction.space, best.u)
    if ordered is not None:
        best = descent(prediction, ordered, rule, stop=1e-8)
    smooth = away_from_jumps(prediction, best.u)
    jumps = smooth is not prediction
    thin = away_from_jumps(draft, best.u) if jumps else draft
    low = descent(smooth, best.u, rule, stop=COARSE_STOP) if jumps else best
    problem, intervals = Problem(smooth, thin, rule, low, spread_of(smooth, low, rule)), None
    if settings.intervals == "profile":
        problem, intervals = with_intervals(problem, lambda done: report(0.8 + 0.2 * done))
    report(1.0)
    end = best if jumps else problem.best  # a profile may have come upon a lower minimum
    return finished_fit(problem, end, intervals, unseen, ended, all_options, lambda: clock.perf_counter() - begin)


def with_weights(prediction: Prediction, draft: Prediction, best: Minimum, rule: Loss) -> tuple[Prediction, Prediction]:
    """A prediction and its draft, whose priors have the weights that the errors of a minimum give them."""
    spread, names = spread_of(prediction, best, rule), prediction.space.names
    units = (spread.unit * (part.size / prediction.size) for part in (prediction, draft))
    own, thin = (weighted(prediction.priors, names, unit, spread.inflation) for unit in units)
    return dataclasses.replace(prediction, priors=own), dataclasses.replace(draft, priors=thin)


def elements_in_order(space: Space, u: np.ndarray) -> np.ndarray | None:
    """Coordinates at which elements in parallel stand in the order in which they give way; None where they do.

    Elements of a Maxwell-slip law may change places without changing the force: stiffness_i with share_i, of which the
    last share is what the others leave. Without an order a fit would name them by chance.
    """
    values = space.named(u)
    stiffness = sorted(name for name in values if name.startswith("stiffness_"))
    shares = sorted(name for name in values if name.startswith("share_"))
    if len(stiffness) < 2 or len(shares) != len(stiffness) - 1:
        return None
    parts = [values[name] for name in shares]
    elements = list(zip([values[name] for name in stiffness], [*parts, 1.0 - sum(parts)], strict=True))
    order = sorted(elements, key=lambda element: element[1] / element[0])
    if order == elements:
        return None
    values |= dict(zip(stiffness, (k for k, _ in order), strict=True))
    values |= dict(zip(shares, (share for _, share in order[:-1]), strict=True))
    return space.of(values)


def away_from_jumps(prediction: Prediction, u: np.ndarray) -> Prediction:
    """The prediction in which samples beside a jump do not count; itself where the law has none.

    Whether such a sample lies before or after the jump hangs on a parameter by steps, not smoothly: one sample on the
    wrong side costs more than all the noise. The cost then has cliffs, on which descents and profiles get stuck. So
    these samples take part in the search, which needs to know where the joint closes, and not in the last descent and
    the intervals: the contact's deflection after the joint has closed tells of the gap smoothly. Intervals are then
    wider than they would have to be. The samples stay if fewer than half would remain.
    """
    law = prediction.law(u)
    if JOINT not in law.internal:
        return prediction
    units: list[Any] = []
    left = 0
    for i, (record, unit) in enumerate(zip(prediction.records, prediction.units, strict=True)):
        states = {"load": record.load, "internal": prediction.start(u, i)}
        driven = driven_force(law, record.time, record.velocity, **states)
        closed = driven.internal[:, law.internal.index(JOINT)]
        beside = np.zeros(len(record), bool)
        for at in np.flatnonzero(closed[1:] != closed[:-1]) + 1:
            beside[max(at - BESIDE, 0) : at + BESIDE] = True
        units.append(np.where(beside, np.inf, unit))
        left += int(np.sum(~beside))
    return prediction.of(prediction.records, units) if left >= REMAINING * prediction.size else prediction
