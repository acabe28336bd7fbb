"""The report of a finished search: parameters with intervals, errors by record, identifiability."""

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.inference.identifiability import WIDE, Identifiability, Verdict, identifiability
from vibrocap.identification.inference.limits import opened, reached_limits
from vibrocap.identification.inference.profile import Interval
from vibrocap.identification.inference.residuals import residual_report
from vibrocap.identification.inference.uncertainty import correlation_time, inverse
from vibrocap.identification.problem.coordinates import Coordinate
from vibrocap.identification.problem.differing import in_one_record
from vibrocap.identification.problem.parameter_roles import unit_of
from vibrocap.identification.problem.prediction import START, Prediction, nuisances
from vibrocap.identification.problem.priors import MOST, SAYS_MORE
from vibrocap.identification.problem.samples import FEWEST_SAMPLES, Samples
from vibrocap.identification.problem.terms import RIPPLES, TERMS, length_name
from vibrocap.identification.result.fit_result import (
    SLIDING,
    TURNING,
    Fit,
    FittedParameter,
    MeasuredUnits,
    Problem,
    RecordResult,
    relative_rmse,
)
from vibrocap.identification.search.descent import descent
from vibrocap.identification.search.loss import Minimum, SearchStatus
from vibrocap.identification.search.multistart import Start
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
    standard = dict(zip(space.names, np.sqrt(np.diag(spread.covariance)).tolist(), strict=True))
    thresholds = dict(zip(space.names, spread.threshold.tolist(), strict=True))
    # quantiles for the standard errors, which carry the inflation already
    inflation = dict(zip(space.names, np.sqrt(spread.inflation).tolist(), strict=True))
    intervals = {
        name: (profiles or {}).get(name)
        or _from_covariance(values[name], standard[name], thresholds[name] / inflation[name], coordinate)
        for name, coordinate in zip(space.names, space.coordinates, strict=True)
    }
    intervals = {
        name: dataclasses.replace(interval, low=min(interval.low, values[name]), high=max(interval.high, values[name]))
        for name, interval in intervals.items()
    }
    limits = reached_limits(prediction, problem.best, problem.loss, spread)
    intervals = opened(intervals, limits, prediction, problem.best)
    report = _identifiability(problem, values, intervals)
    counted, parameters_in_all = int(sum(np.sum(count) for count in prediction.counts)), len(space.names)
    if counted < EACH * parameters_in_all:
        report = _too_few(report, counted, parameters_in_all)
        for name, interval in intervals.items():
            low = -math.inf if interval.low < 0 else 0.0
            intervals[name] = dataclasses.replace(interval, low=low, high=math.inf, low_open=True, high_open=True)
    results = _results(prediction, best, held_out, options.get("start", ""))
    fitted = [result for result in results if not result.held_out]
    unseen = [result for result in results if result.held_out]
    relative, absolute = relative_rmse([r.measured for r in fitted], [r.predicted for r in fitted])
    held_out_relative, _ = relative_rmse([r.measured for r in unseen], [r.predicted for r in unseen])
    residuals = residual_report(prediction, problem.best, spread, problem.loss, limits).with_held_out(held_out_relative)
    residuals = residuals.with_pulls({prior.name: prior.pull for prior in prediction.priors if abs(prior.pull) > MOST})
    beforehand = {prior.name for prior in prediction.priors if spread.known[space.names.index(prior.name)] > SAYS_MORE}
    report = _beforehand(report, beforehand)
    if residuals.doubtful:
        report = _doubted(report)
    law = prediction.law(best.u)
    loads = [np.asarray(record.load) for record in prediction.records]
    known_load = options.get("load") is not None or any(np.any(load != 1.0) for load in loads)
    units = TURNING if any(record.rotary for record in prediction.records) else SLIDING
    guessed = {name: unit for record in prediction.records for name, unit in record.guessed_units.items()}
    parameters = []
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
            parameters.append(FittedParameter(*texts, float(value), float(value), float(value), 0.0, Verdict.HELD))
    return Fit(
        law=law,
        law_name=law.name,
        status=best.status,
        parameters=tuple(parameters),
        nuisances=tuple(
            _nuisance(
                coordinate,
                values[coordinate.name],
                intervals[coordinate.name],
                standard[coordinate.name],
                units,
                Verdict.DOUBTED if residuals.doubtful else Verdict.PRIOR if coordinate.name in beforehand else None,
                {info.name: (info.meaning, unit_of(info, known_load)) for info in parameter_table(law)},
            )
            for coordinate in space.coordinates
            if coordinate.nuisance
        ),
        records=tuple(results),
        relative_rmse=relative,
        rmse=absolute,
        held_out_relative_rmse=held_out_relative,
        samples=prediction.size,
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
    return Fit(
        law=None,
        law_name=law_name,
        status=SearchStatus.FAILED,
        parameters=(),
        nuisances=(),
        records=(),
        **dict.fromkeys(numbers, math.nan),
        samples=samples,
        identifiability=None,
        starts=starts,
        seconds=seconds,
        options=dict(options),
    )


def _too_few(report: Identifiability, samples: int, parameters: int) -> Identifiability:
    """The report where the samples cannot carry the parameters: nothing is determined."""
    sentence = (
        f"{samples} samples cannot carry {parameters} parameters, those of the measurement included: no interval holds "
        f"with fewer than {EACH} samples for each."
    )
    verdicts = dict.fromkeys(report.verdicts, Verdict.TOO_FEW)
    experiments = dict.fromkeys(report.verdicts, "more samples are needed")
    sentences = (sentence, *report.sentences)
    return dataclasses.replace(report, verdicts=verdicts, sentences=sentences, experiments=experiments)


def _beforehand(report: Identifiability, known: Collection[str]) -> Identifiability:
    """The report where priors say more of some parameters than the data: these determine none of them."""
    verdicts = {k: Verdict.PRIOR if k in known and v == Verdict.DETERMINED else v for k, v in report.verdicts.items()}
    return dataclasses.replace(report, verdicts=verdicts)


def _doubted(report: Identifiability) -> Identifiability:
    """The report where the errors show a fault of the data or of the law: nothing is called determined."""
    verdicts = {
        name: Verdict.DOUBTED if verdict == Verdict.DETERMINED else verdict for name, verdict in report.verdicts.items()
    }
    first = {name: "put right what the errors show" for name, verdict in verdicts.items() if verdict == Verdict.DOUBTED}
    named = ", ".join(first)
    sentence = f"The errors are no noise (see below): no interval of {named} holds, however narrow it is."
    sentences = (sentence, *report.sentences) if first else report.sentences
    return dataclasses.replace(
        report, verdicts=verdicts, sentences=sentences, experiments={**report.experiments, **first}
    )


def _results(prediction: Prediction, best: Minimum, held_out: Sequence[Samples], start: str) -> list[RecordResult]:
    results = [_result(prediction, best.u, k, False, 0) for k in range(len(prediction.records))]
    for record in held_out:
        unseen, u, begun = _begun(prediction.of([record], [record.deviation]), best.u, start)
        results.append(_result(unseen, u, 0, True, begun))
    return results


def _result(prediction: Prediction, u: np.ndarray, which: int, hidden: bool, begun: int) -> RecordResult:
    """What a fit makes of a record, judged from sample number `begun` on."""
    record, predicted = prediction.records[which], prediction.forces(u, which)[0]
    columns = [each[begun:] for each in (record.time, record.velocity, record.force, predicted)]
    relative, absolute = relative_rmse([columns[2]], [columns[3]])
    tau = correlation_time(columns[3] - columns[2]) if np.isfinite(absolute) else math.nan
    time, velocity, force, made = columns
    return RecordResult(record.name, hidden, time, velocity, force, made, absolute, relative, tau)


def _begun(prediction: Prediction, u: np.ndarray, start: str) -> tuple[Prediction, np.ndarray, int]:
    """(prediction of an unseen record, coordinates, samples that found what is of this record alone)."""
    space, (record,) = prediction.space, prediction.records
    more = list(nuisances(prediction.template, [record], terms=(), start=start, level=1.0))
    for parameter in prediction.differing:
        if not parameter.condition:  # it begins at the value in any other record
            values = [
                (c, float(x)) for c, x in zip(space.coordinates, u, strict=True) if parameter.name in (c.name, c.base)
            ]
            coordinate, begin = values[0]
            more.append(in_one_record(dataclasses.replace(coordinate, name=parameter.name), record.name, begin))
    if not more:
        return prediction, u, 0
    whole = dataclasses.replace(prediction, space=space.with_more(tuple(more)), priors=())
    point, count = whole.space.begun(u), 0
    for share in BEGIN:
        count = max(round(share * len(record)), FEWEST_SAMPLES)
        first = whole.of([record.between(0, count)], whole.units)
        point = descent(first, point, stop=1e-8, held=range(len(u))).u
        slopes = np.nan_to_num(whole.slopes(point, held=range(len(u))))[:, len(u) :]
        base = inverse(slopes[:count].T @ slopes[:count])
        if np.mean(np.einsum("ni,ij,nj->n", slopes, base, slopes)) < SURE:
            break
    return whole, point, count


def _identifiability(problem: Problem, values: Mapping[str, float], found: Mapping[str, Interval]) -> Identifiability:
    """The report, from the slopes by the logarithms of the law's parameters."""
    prediction, best = problem.prediction, problem.best
    space, names = prediction.space, prediction.law_names
    to_parameters = np.linalg.inv(space.slopes(best.u))
    columns = [space.names.index(name) for name in names]
    amounts = [_amount(space.coordinates[j], values[space.names[j]]) for j in columns]
    weighted = np.sqrt(problem.loss.slope(best.errors))[:, None] * best.slopes
    slopes = weighted @ to_parameters[:, columns] * amounts
    others = [j for j in range(len(space.names)) if j not in columns]
    intervals = {name: found[name] for name in names}
    spread = (problem.uncertainty.unit, float(np.median(problem.uncertainty.inflation)))
    return identifiability(prediction.template, names, slopes, weighted[:, others], *spread, intervals)


def _amount(coordinate: Any, value: float) -> float:
    """What counts as one e-fold of a parameter: itself, or the smallest visible amount of one that is zero."""
    return max(abs(value), coordinate.scale) if coordinate.form in ("foot", "linear") else value


def _from_covariance(value: float, error: float, threshold: float, coordinate: Coordinate) -> Interval:
    """Interval from the covariance: symmetric in the logarithm, or in the parameter where it may be zero."""
    reach = threshold * error
    if coordinate.form == "linear":
        low, high = value - reach, value + reach
        low_open, high_open = low <= coordinate.low, high >= coordinate.high
        return Interval(-math.inf if low_open else low, math.inf if high_open else high, low_open, high_open)
    if coordinate.form == "foot":
        low, high = value - reach, value + reach
        return Interval(max(low, 0.0), high if high < coordinate.high else math.inf, low <= 0, high >= coordinate.high)
    factor = math.exp(min(reach / value, 700.0))
    low, high = value / factor, value * factor
    # a factor of the square of WIDE is beyond what a straight line says of a logarithm: the profile knows
    low_open, high_open = low <= coordinate.low or factor > WIDE**2, high >= coordinate.high or factor > WIDE**2
    return Interval(0.0 if low_open else low, math.inf if high_open else high, low_open, high_open)


OTHERS = {
    "delay": ("time by which the force is late behind the motion", "s"),
    "gain": ("factor of the force sensor", "1"),
    "adhesion": ("load that the contact has of itself", "N"),
    "machine_stiffness": ("stiffness of what pulls the contact", "N/m"),
    "drift": ("change of the force with the load point's displacement", "N/m"),
    **{length_name(ripple): ("wavelength", "m") for ripple in RIPPLES},
    START: ("state of the contact at the first sample, over its natural size", "1"),
}


def _texts(coordinate: Coordinate, law: Mapping[str, tuple[str, str]]) -> tuple[str, str]:
    """Meaning and unit of a parameter of the measurement; law: those of the law's parameters."""
    terms = {name: (term.meaning, term.unit) for name, term in TERMS.items()}
    base = START if coordinate.state else coordinate.base or coordinate.name
    text, unit = {**law, **terms, **OTHERS}[base]
    if coordinate.condition:
        return f"{text}, change with {coordinate.condition}", f"{unit} per {coordinate.condition}"
    return (f"{text}, in {coordinate.record}" if coordinate.record and not coordinate.state else text), unit


def _nuisance(
    coordinate: Coordinate,
    value: float,
    interval: Interval,
    error: float,
    units: MeasuredUnits,
    verdict_of_all: Verdict | None,
    law: Mapping[str, tuple[str, str]],
) -> FittedParameter:
    """A parameter of the measurement; a state cannot leave its range, so that an open end is the end of the range."""
    name = coordinate.name
    text, unit = _texts(coordinate, law)
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
