"""The solution of a fit: search, intervals and report for any prediction."""

import dataclasses
import time as clock
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_one_of, check_whole, is_positive
from vibrocap.identification.fitting.simpler_fits import SimplerFits
from vibrocap.identification.inference.profile import INTERVALS, with_intervals
from vibrocap.identification.inference.uncertainty import Problem, spread_of
from vibrocap.identification.problem.coordinates import Space
from vibrocap.identification.problem.parametrisation import Parametrisation
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.problem.priors import WEIGHTINGS, pulled, settled, weighted
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.result.fit_report import failed_fit, finished_fit
from vibrocap.identification.result.fit_result import Fit
from vibrocap.identification.search.descent import COARSE_STOP, descent
from vibrocap.identification.search.loss import LOSSES, Loss, Minimum, SearchStatus, robust_scale
from vibrocap.identification.search.multistart import search
from vibrocap.laboratory.driven import driven_force

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
    if prediction.size <= len(space.coordinates):
        few = f"have {prediction.size} samples for {len(space.coordinates)} free parameters"
        raise ArgumentError("records", f"{few}; more samples are needed")
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
    spread = spread_of(prediction, best, rule)

    def with_own(part: Prediction) -> Prediction:
        unit = spread.unit * (part.size / prediction.size)
        known = weighted(prediction.priors, prediction.space.names, unit, spread.inflation)
        return dataclasses.replace(part, priors=known)

    return with_own(prediction), with_own(draft)


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
    wrong side costs more than all the noise. The cost then has cliffs, on which a descent and a profile get stuck, and
    slopes and covariance mean nothing. So these samples take part in the search, which needs to know where the joint
    closes, and are left out of the last descent and of the intervals: what remains tells of the gap by the contact's
    deflection after it has closed, which is smooth. Intervals are then wider than they would have to be.

    Samples count where they did; they stay if fewer than half would remain (a joint that closes all the time).
    """
    law = prediction.law(u)
    if JOINT not in law.internal:
        return prediction
    units: list[Any] = []
    left = total = 0
    for i, (record, unit) in enumerate(zip(prediction.records, prediction.units, strict=True)):
        states = {"load": record.load, "internal": prediction.start(u, i)}
        driven = driven_force(law, record.time, record.velocity, **states)
        closed = driven.internal[:, law.internal.index(JOINT)]
        beside = np.zeros(len(record), bool)
        for at in np.flatnonzero(closed[1:] != closed[:-1]) + 1:
            beside[max(at - BESIDE, 0) : at + BESIDE] = True
        units.append(np.where(beside, np.inf, unit))
        left, total = left + int(np.sum(~beside)), total + len(record)
    return prediction.of(prediction.records, units) if left >= REMAINING * total else prediction
