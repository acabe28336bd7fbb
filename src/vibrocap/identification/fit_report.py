"""The report of a finished search: parameters with intervals, errors by record, identifiability."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.fit_result import (
    SLIDING,
    TURNING,
    Fit,
    FittedParameter,
    MeasuredUnits,
    RecordResult,
    relative_rmse,
)
from vibrocap.identification.inference.identifiability import WIDE, Identifiability, Verdict, identifiability
from vibrocap.identification.inference.intervals import Interval, opened, reached_limits
from vibrocap.identification.inference.residuals import residual_report
from vibrocap.identification.inference.uncertainty import Problem, correlation_time, inverse
from vibrocap.identification.problem.coordinates import Coordinate, in_one_record
from vibrocap.identification.problem.parametrisation import unit_of
from vibrocap.identification.problem.prediction import Prediction, nuisances
from vibrocap.identification.problem.priors import SAYS_MORE
from vibrocap.identification.problem.samples import FEWEST_SAMPLES, Samples
from vibrocap.identification.problem.terms import TERMS
from vibrocap.identification.search import Minimum, SearchStatus, Start, descent
from vibrocap.physics.parameters import parameter_table

BEGIN = (0.1, 0.2, 0.4)  # shares of an unseen record that find what is of this record alone, until they do
SURE = 0.05  # of the noise: variance that what they leave open adds to the errors
EACH = 5  # samples for each parameter, the least with which intervals are given


def finished_fit(
    problem: Problem,
    best: Minimum,
    profiles: Mapping[str, Interval] | None,
    held_out: Sequence[Samples],
    starts: tuple[Start, ...],
    options: Mapping[str, Any],
    seconds: Callable[[], float],
) -> Fit:
    """The `Fit` at a minimum, with the intervals of a problem."""
    prediction, spread = problem.prediction, problem.uncertainty
    space = prediction.space
    values = space.named(best.u)
    columns = np.sqrt(np.diag(spread.covariance)), spread.threshold, spread.threshold / np.sqrt(spread.inflation)
    # quantiles for the standard errors, which carry the inflation already
    standard, thresholds, quantiles = (dict(zip(space.names, x.tolist(), strict=True)) for x in columns)
    intervals = {}
    for name, coordinate in zip(space.names, space.coordinates, strict=True):
        value, profile = values[name], (profiles or {}).get(name)
        interval = profile or _from_covariance(value, standard[name], quantiles[name], coordinate)
        ends = {"low": min(interval.low, value), "high": max(interval.high, value)}
        intervals[name] = dataclasses.replace(interval, **ends)
    limits = reached_limits(problem)
    intervals = opened(intervals, limits, problem)
    report = _identifiability(problem, values, intervals)
    counted, parameters_in_all = int(sum(np.sum(count) for count in prediction.counts)), len(space.names)
    if counted < EACH * parameters_in_all:
        sentence = (
            f"{counted} samples cannot carry {parameters_in_all} parameters, those of the measurement included: no "
            f"interval holds with fewer than {EACH} samples for each."
        )
        alone = dataclasses.replace(report, experiments={})
        report = _judged(alone, Verdict.TOO_FEW, [*report.verdicts], sentence, "more samples are needed")
        for name, interval in intervals.items():
            low = -math.inf if interval.low < 0 else 0.0
            intervals[name] = dataclasses.replace(interval, low=low, high=math.inf, low_open=True, high_open=True)
    fitted, unseen = [_result(prediction, best.u, k) for k in range(len(prediction.records))], []
    for record in held_out:
        hidden, u, begun = _begun(prediction.of([record], [record.deviation]), best.u, options.get("start", ""))
        unseen.append(_result(hidden, u, 0, True, begun))
    relative, absolute = relative_rmse([r.measured for r in fitted], [r.predicted for r in fitted])
    held_out_relative, _ = relative_rmse([r.measured for r in unseen], [r.predicted for r in unseen])
    residuals = residual_report(problem, limits, held_out_relative)
    beforehand = {prior.name for prior in prediction.priors if spread.known[space.names.index(prior.name)] > SAYS_MORE}
    determined = [name for name, verdict in report.verdicts.items() if verdict == Verdict.DETERMINED]
    report = _judged(report, Verdict.PRIOR, [name for name in determined if name in beforehand])
    if residuals.doubtful:
        doubted = [name for name in determined if name not in beforehand]
        subject = f"no interval of {', '.join(doubted)} holds, however narrow it is."
        sentence = f"The errors are no noise (see below): {subject}"
        report = _judged(report, Verdict.DOUBTED, doubted, sentence, "correct the fault that the errors show")
    law = prediction.law(best.u)
    loads = [np.asarray(record.load) for record in prediction.records]
    known_load = options.get("load") is not None or any(np.any(load != 1.0) for load in loads)
    units = TURNING if any(record.rotary for record in prediction.records) else SLIDING
    guessed = {name: unit for record in prediction.records for name, unit in record.guessed_units.items()}
    parameters, of_law = [], {info.name: (info.meaning, unit_of(info, known_load)) for info in parameter_table(law)}
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        unit = units.of_parameter(unit_of(info, known_load))
        if units is TURNING and known_load and info.dimension is not None and info.dimension.coefficient == 1:
            unit = "m"  # a torque over the normal force
        texts = (info.name, info.symbol, info.meaning, unit)
        if info.name in intervals:
            one, verdict = intervals[info.name], report.verdicts[info.name]
            error = math.inf if verdict == Verdict.NO_EFFECT else standard[info.name]
            curve = (one.curve, thresholds[info.name])
            parameters.append(FittedParameter(*texts, value, one.low, one.high, error, verdict, *curve))
        else:
            held = float(value)
            parameters.append(FittedParameter(*texts, held, held, held, 0.0, Verdict.HELD))
    of_measurement = []
    for coordinate in (coordinate for coordinate in space.coordinates if coordinate.nuisance):
        name = coordinate.name
        verdict = Verdict.DOUBTED if residuals.doubtful else Verdict.PRIOR if name in beforehand else None
        numbers = values[name], intervals[name], standard[name]
        of_measurement.append(_nuisance(coordinate, *numbers, units, verdict, of_law))
    return Fit(
        law=law,
        law_name=law.name,
        status=best.status,
        parameters=tuple(parameters),
        nuisances=tuple(of_measurement),
        records=(*fitted, *unseen),
        relative_rmse=relative,
        rmse=absolute,
        held_out_relative_rmse=held_out_relative,
        samples=sum(int(np.sum(prediction.tells(k))) for k in range(len(prediction.records))),
        effective_samples=spread.effective,
        cost=best.cost,
        unit=spread.unit,
        identifiability=report,
        starts=starts,
        seconds=seconds(),
        options={**options, "known_load": known_load, "rotary": units is TURNING, "guessed_units": guessed},
        problem=problem,
        limits=limits,
        residuals=residuals,
    )


def failed_fit(
    law_name: str, starts: tuple[Start, ...], samples: int, options: Mapping[str, Any], seconds: float
) -> Fit:
    """The `Fit` of which no start could be driven through the records."""
    numbers = ("relative_rmse", "rmse", "held_out_relative_rmse", "effective_samples", "cost", "unit")
    how: dict[str, Any] = {"starts": starts, "seconds": seconds, "options": dict(options), "identifiability": None}
    unknown = dict.fromkeys(numbers, math.nan) | dict.fromkeys(("parameters", "nuisances", "records"), ())
    return Fit(law=None, law_name=law_name, status=SearchStatus.FAILED, samples=samples, **unknown, **how)


def _judged(
    report: Identifiability, verdict: Verdict, names: Sequence[str], sentence: str = "", advice: str = ""
) -> Identifiability:
    """The report with another verdict on some parameters, with the reason and what would help."""
    if not names:
        return report
    return dataclasses.replace(
        report,
        verdicts={**report.verdicts, **dict.fromkeys(names, verdict)},
        sentences=(*filter(None, [sentence]), *report.sentences),
        experiments={**report.experiments, **(dict.fromkeys(names, advice) if advice else {})},
    )


def _result(prediction: Prediction, u: np.ndarray, which: int, hidden: bool = False, begun: int = 0) -> RecordResult:
    """What a fit makes of a record, judged from sample number `begun` on where the motion tells the force."""
    record, forces = prediction.records[which], prediction.forces(u, which)[0]
    judged = prediction.tells(which) & (np.arange(len(record)) >= begun)
    time, velocity, force, predicted = (x[judged] for x in (record.time, record.velocity, record.force, forces))
    relative, absolute = relative_rmse([force], [predicted])
    tau = correlation_time(predicted - force) if np.isfinite(absolute) else math.nan
    return RecordResult(record.name, hidden, time, velocity, force, predicted, absolute, relative, tau)


def _begun(prediction: Prediction, u: np.ndarray, start: str) -> tuple[Prediction, np.ndarray, int]:
    """(prediction of an unseen record, coordinates, samples that found what is of this record alone)."""
    space, (record,) = prediction.space, prediction.records
    more = list(nuisances(prediction.template, [record], terms=(), start=start, level=1.0))
    for parameter in prediction.differing:
        if not parameter.condition:  # it begins at the value in any other record
            at = next(k for k, c in enumerate(space.coordinates) if parameter.name in (c.name, c.base))
            coordinate = dataclasses.replace(space.coordinates[at], name=parameter.name)
            more.append(in_one_record(coordinate, record.name, float(u[at])))
    if not more:
        return prediction, u, 0
    whole = dataclasses.replace(prediction, space=space.with_more(tuple(more)), priors=())
    point, count = whole.space.begun(u), 0
    for share in BEGIN:
        count = max(round(share * len(record)), FEWEST_SAMPLES)
        first = whole.of([record.kept(slice(count))], whole.units)
        point = descent(first, point, stop=1e-8, held=range(len(u))).u
        slopes = np.nan_to_num(whole.slopes(point, held=range(len(u))))[:, len(u) :]
        base = inverse(slopes[:count].T @ slopes[:count])
        if np.mean(np.einsum("ni,ij,nj->n", slopes, base, slopes)) < SURE:
            break
    return whole, point, count


def _identifiability(problem: Problem, values: Mapping[str, float], all_of: Mapping[str, Interval]) -> Identifiability:
    """The report, from the slopes by the logarithms of the law's parameters."""
    prediction, best = problem.prediction, problem.best
    space, names = prediction.space, prediction.law_names
    to_parameters = np.linalg.inv(space.slopes(best.u))
    columns = [space.names.index(name) for name in names]
    amounts = []
    for coordinate in (space.coordinates[j] for j in columns):  # of an e-fold, or the least visible one at zero
        value, near_zero = values[coordinate.name], coordinate.form in ("foot", "linear")
        amounts.append(max(abs(value), coordinate.scale) if near_zero else value)
    weighted = np.sqrt(problem.loss.slope(best.errors))[:, None] * best.slopes
    slopes = weighted @ to_parameters[:, columns] * amounts
    others = [j for j in range(len(space.names)) if j not in columns]
    intervals = {name: all_of[name] for name in names}
    spread = (problem.uncertainty.unit, float(np.median(problem.uncertainty.inflation)))
    return identifiability(prediction.template, names, slopes, weighted[:, others], *spread, intervals)


def _from_covariance(value: float, error: float, threshold: float, coordinate: Coordinate) -> Interval:
    """Interval from the covariance: symmetric in the logarithm, or in the parameter where it may be zero."""
    reach, far = threshold * error, False
    if coordinate.form in ("linear", "foot"):
        low, high = value - reach, value + reach
    else:
        factor = math.exp(min(reach / value, 700.0))
        low, high = value / factor, value * factor
        far = factor > WIDE**2  # beyond what a straight line says of a logarithm: the profile knows
    end = 0.0 if coordinate.form == "foot" else coordinate.low
    low_open, high_open = low <= end or far, high >= coordinate.high or far
    return Interval(coordinate.least if low_open else low, math.inf if high_open else high, low_open, high_open)


def _nuisance(
    coordinate: Coordinate,
    value: float,
    interval: Interval,
    error: float,
    units: MeasuredUnits,
    verdict_of_all: Verdict | None,
    law: Mapping[str, tuple[str, str]],
) -> FittedParameter:
    """A parameter of the measurement; a state cannot leave its range, so that an open end is the end of the range.

    law: meaning and unit of the law's parameters
    """
    name = coordinate.name
    text, unit = law.get(coordinate.base, (coordinate.meaning, coordinate.unit))
    if coordinate.condition:
        text, unit = f"{text}, change with {coordinate.condition}", f"{unit} per {coordinate.condition}"
    elif coordinate.record and not coordinate.state:
        text = f"{text}, in {coordinate.record}"
    low, high = interval.low, interval.high
    if coordinate.state:
        low, high = max(low, coordinate.low), min(high, coordinate.high)
    determined = interval.closed or (coordinate.state and not (interval.low_open and interval.high_open))
    verdict = Verdict.DETERMINED if determined else Verdict.UNDETERMINED
    if name in TERMS and not TERMS[name].signed and interval.low_open and not interval.high_open:
        verdict = Verdict.BOUNDED_ABOVE
    if verdict_of_all and verdict == Verdict.DETERMINED:
        verdict = verdict_of_all
    return FittedParameter(name, "", text, units.of_parameter(unit), value, low, high, error, verdict)
