"""fit_motion(case, records, over=...): parameters of any machine and law from its motion under a measured force."""

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_whole, shown, suggestion
from vibrocap.case.case import Case, CaseError
from vibrocap.design.calibration.calibration import Calibrated, CalibratedParameter
from vibrocap.design.calibration.course import courses, measured_column, turns, unknowns
from vibrocap.design.calibration.motion_search import (
    SENSITIVE,
    in_segments,
    parameter_within,
    searched,
    sensitive_segments,
    with_priors,
)
from vibrocap.design.calibration.record_model import MotionSource, RecordModel, Unseen
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.identification.inference.residuals import FAR
from vibrocap.identification.inference.uncertainty import correlation_time, inverse
from vibrocap.identification.problem.priors import MOST, checked_priors
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.numerics.api import available_threads
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, Numbers, WithUnit
from vibrocap.quantities.dimensional import said
from vibrocap.records.record import Record, listed_records

BEGIN = 0.1  # share of a held-out record from which its start is found
OPEN = 0.1  # gap between segments over the noise of the samples, or what runs are exact to, from which they do not join
CONSTANT = 1.0  # relative error from which on a prediction is no better than a constant


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class MotionFit(Calibrated):
    """Parameters of a case from motions under measured forces, and the motions that it predicts.

    system: with the parameters found, and the drive of the case; predict: the quantity compared, in `unit`
    parameters: with their 95 % intervals and verdicts; correlation: [p, p] of them
    held_out: names of the records that the fit has not seen; the first tenth of one finds its start alone, and what the
        result says of errors is of the rest
    measured, predicted, band: [samples] by record; of a new measurement 95 % lie within predicted +- band
    rms: root mean square error by record; relative: over the standard deviation of the measurement, 1 for a constant
    noise_ratio: errors over the noise of the samples, from second differences
    growth: largest factor by which a change of the start grows in a record; segments: of each record, each with a
        start of its own that the one before meets
    pulls: standard deviations by which data and priors disagree, by parameter, where that is no chance
    starts: initial states by record, of the case without units
    not_trusted: why the motion of a record is not to be trusted, by its name. Nothing is said of its errors then,
        and of no parameter if it was fitted
    converged: whether the search has settled; problem: what `posterior` samples, None where motions are not trusted
    """

    system: System
    predict: str
    unit: str
    parameters: tuple[CalibratedParameter, ...]
    correlation: Numbers
    held_out: tuple[str, ...]
    time: dict[str, Numbers]
    measured: dict[str, Numbers]
    predicted: dict[str, Numbers]
    band: dict[str, Numbers]
    rms: dict[str, Number]
    relative: dict[str, Number]
    noise_ratio: Number
    growth: Number
    segments: int
    pulls: dict[str, Number]
    starts: dict[str, ByName]
    not_trusted: dict[str, str]
    converged: bool
    problem: MotionSource | None = dataclasses.field(default=None, repr=False)

    rows = "parameters"
    in_record = "predict parameters correlation records noise_ratio growth segments pulls not_trusted converged"

    @property
    def records(self) -> dict[str, dict[str, Any]]:
        """What is left of each record by name: its rms, relative too, and whether it was held out."""
        records = {}
        for name, x in self.rms.items():
            rms = x if self.unit == "1" else WithUnit(x, self.unit)
            records[name] = {"rms": rms, "relative": self.relative[name], "held_out": name in self.held_out}
        return records

    @property
    def heading(self) -> str:
        return f"{self.predict} of {', '.join(self.measured)}"

    @property
    def facts(self) -> dict[str, str]:
        facts = {parameter.path: str(parameter) for parameter in self.parameters}
        for name, rms in self.rms.items():
            worse = ", no better than a constant" if self.relative[name] >= CONSTANT else ""
            told = f"rms {said(rms, self.unit, 4)}, {self.relative[name]:.2%} of the motion{worse}"
            if name in self.not_trusted:
                told = f"the motion is not to be trusted: {self.not_trusted[name]}"
            facts[name] = f"held out, {told}" if name in self.held_out else told
        for path, away in self.pulls.items():
            facts[f"prior {path}"] = f"differs from the data by {abs(away):.2g} standard deviations"
        if self.noise_ratio > FAR:
            times = f"errors are {self.noise_ratio:.3g} times the noise of the samples"
            facts["doubt"] = f"{times}: machine or law lack something"
        grows = f"a change of the start grows {self.growth:.2g} times"
        if self.segments > 1:
            facts["search"] = f"{self.segments} segments a record, as {grows}"
        elif self.growth > SENSITIVE:
            facts["doubt"] = f"{grows}: fit in segments or shorter records"
        if not self.converged:
            facts["not settled"] = "give more starts or narrower bounds"
        return facts

    def case(self, periods: float = 40) -> Case:
        """The case with the parameters found, and its own drive."""
        return Case(self.system, periods=periods)


@shows_progress("Fitting the motion")
def fit_motion(
    system: System | Case,
    records: Record | Iterable[Record],
    over: Mapping[str, Any],
    *,
    predict: str = "position",
    held_out: str | Iterable[str] = (),
    terms: Sequence[str] = (),
    by_record: Sequence[str] = (),
    along: Mapping[str, str] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    segments: int | None = None,
    initial: ByName | None = None,
    starts: int = 64,
    seed: int = 0,
    tolerance: float = 1e-9,
    threads: int | None = None,
    progress: Progress = None,
) -> MotionFit:
    """Parameters of machine, friction and actuator from measured motions under a measured force or torque.

    The case is simulated under the force of each record (output error), cubic between its samples or, where jumps or
    noise make that better, straight. So mass, springs, dampers, gravity and friction are found together, and a motion
    under another force is predicted. The squared errors are minimised from Sobol points over the first eighth of the
    records, then over longer ones (SciPy's trust region). Each record has a start of its own, which is found too. Where
    changes of it grow along the measured motion, records are divided into segments with starts of their own, which have
    to join (multiple shooting; Bock 1981). Intervals widen with the correlation time of the errors.

    system: in SI where the records are; its drive is replaced, and the start of a case is not taken; it may be any
        machine, a `[mechanism]` of one's own too
    records: force (torque) of the drive, and the motion: `vc.read_records`
    over: {path: (low, high)}: the unknowns with their bounds, as in `calibrate`; "drive.amplitude" is a factor of the
        measured force
    predict: a state: a length or an angle is compared with the records' displacement, a velocity with theirs
    held_out: names of records that the fit does not see and that judge it
    terms: what the sensor of the force adds, as in `fit`: "offset", "delay" of the force behind the motion (s), and
        "gain" by record (that of the first is 1)
    by_record: unknowns and terms with a value in each record, p[record]; a held-out record finds its own in its first
        tenth. along: {unknown or term: condition} of what changes in proportion to a number of the record, one of its
        `conditions` or "load", by p.condition
    priors: {path: (mean, standard deviation)} of the unknowns
    segments: of each record; None: as many as the growth of changes asks for
    initial: states at the start of every record that are known; the machine's others are found
    starts: points from which the search begins; seed: of them

    Returns a `MotionFit`. Raises CaseError with every complaint about system, records and over, before any work.
    """
    complaints = Complaints()
    case = system if isinstance(system, Case) else Case(system)
    records = listed_records(records)
    hidden = tuple(held_out) if isinstance(held_out, Iterable) and not isinstance(held_out, str) else (held_out,)
    _check_records(case.system, records, predict, hidden, complaints)
    for name, count in (("starts", starts), ("seed", seed), ("segments", 1 if segments is None else segments)):
        with complaints.collected():
            check_whole(name, count, 0 if name == "seed" else 1, 2**16)
    with complaints.collected():
        check_run(periods=1.0, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    known = dict(initial or {})
    with complaints.collected():
        initial_state(case.system, known)
    if complaints:
        raise CaseError(complaints, "the fit")
    every = {course.name: course for course in courses(case.system, records, predict, known)}
    fitted = [course for name, course in every.items() if name not in hidden]
    searches = unknowns(case.system, fitted, over, terms, by_record, along or {}, complaints)
    if complaints:
        raise CaseError(complaints, "the fit")
    threads = threads or available_threads()
    model = RecordModel(predict, searches, fitted, tolerance, threads)
    with complaints.collected():
        known_before = checked_priors(priors, model.names)
    if segments is not None and segments > 1 and case.system.switched:
        complaints.add("segments", f"should be 1: {case.system.switched[0]} has no start that can be searched")
    if segments and 2 * segments > min(len(course.measured) for course in fitted):
        complaints.add("segments", "should be fewer: each has two samples at least")
    if complaints:
        raise CaseError(complaints, "the fit")
    segments = sensitive_segments(model, seed) if segments is None else segments
    model = in_segments(model, segments) if segments > 1 else model
    point, converged = searched(model, starts, seed, told(progress))
    point = with_priors(model, point, known_before)
    others = [RecordModel(predict, searches, [every[name]], tolerance, threads) for name in hidden]
    return _found(case.system, model, others, point, converged)


def _check_records(
    system: System, records: Sequence[Record], predict: str, hidden: Sequence[str], complaints: Complaints
) -> None:
    """What is wrong with the records, and with what is asked of them."""
    names = [record.name for record in records]
    if system.controller is not None:
        complaints.add("controller", "should be left out: the measured force drives the machine")
    if not records:
        complaints.add("records", "should be at least one")
    twice = {name for name in names if names.count(name) > 1}
    complaints += [f"records: {shown(name)} is the name of several; give each its own" for name in sorted(twice)]
    for name in (name for name in hidden if name not in names):
        complaints.add("held_out", f"there is no record {name!r}; {suggestion(name, names)}")
    if records and not {*names} - {*hidden}:
        complaints.add("held_out", "should leave at least one record to fit")
    if predict not in system.state_names:
        complaints.add("predict", f"there is no state {predict!r}; {suggestion(predict, system.state_names)}")
        return
    column = measured_column(system, predict)
    if column is None:
        complaints.add("predict", f"{predict} is no length, angle or velocity, so no record holds it")
        return
    for record in records:
        if record.rotary != turns(system, predict):
            own, other = ("turns", "does not turn")[:: 1 if record.rotary else -1]
            complaints.add("predict", f"{predict} {other}, but the contact of record {record.name!r} {own}")
        if getattr(record, column) is None:
            complaints.add("predict", f"{predict} is compared with {column}, which record {record.name!r} has not")


def _found(
    system: System, model: RecordModel, others: Sequence[RecordModel], point: np.ndarray, converged: bool
) -> MotionFit:
    """The result of a search."""
    many, counts = model.many, model.counts(1.0)
    total = sum(counts)
    residuals, slopes = model.residuals(point, counts), model.slopes(point, counts)
    errors, joined = residuals[:total], model.gap_rows(counts)[-1].stop
    spread = model.spread(residuals, slopes)
    starts = sum(not course.follows and len(course.free) for course in model.courses)
    deviation = math.sqrt(float(np.sum(errors**2)) / max(total - many - starts, 1))
    growth = model.growth(slopes, counts)
    pulls = {prior.name: prior.pull for prior in model.priors if abs(prior.pull) > MOST}
    reasons = {name: model.distrust(name, point) for name in model.records}
    gap = float(np.max(np.abs(residuals[total:joined]), initial=0.0)) / model.weight
    if gap > max(OPEN * model.noise / math.sqrt(total), math.sqrt(model.tolerance)):
        reasons = {name: why or f"its segments do not join: {gap:.1e} of a state" for name, why in reasons.items()}
    sensitive = growth > SENSITIVE and not model.divided
    doubted = bool(pulls) or sensitive or float(np.linalg.norm(errors)) > FAR * model.noise
    doubt = Verdict.UNTRUSTED if any(reasons.values()) else Verdict.DOUBTED if doubted else None
    own = spread.covariance[:many, :many] if doubt is not Verdict.UNTRUSTED else np.full((many, many), np.nan)
    within = [parameter_within(model, k, point, slopes, spread, doubt) for k in range(many)]
    deviations = np.sqrt(np.diag(own))
    values, _ = model.parameters(0, point)
    sampled = doubt is not Verdict.UNTRUSTED and not model.divided
    motion_fit = MotionFit(
        system=system.with_parameters({path: value for path, value in values.items() if not path.startswith("drive.")}),
        predict=model.predict,
        unit=system.result_units.unit(model.predict),
        parameters=tuple(parameter for parameter, _ in within),
        correlation=own / np.outer(deviations, deviations),
        held_out=tuple(other.courses[0].name for other in others),
        **{name: {} for name in ("time", "measured", "predicted", "band", "rms", "relative", "starts")},
        noise_ratio=float(np.linalg.norm(errors)) / max(model.noise, 1e-300),
        growth=growth,
        segments=len(model.courses) // len(model.records),
        pulls=pulls,
        not_trusted={name: why for name, why in reasons.items() if why},
        converged=converged,
        problem=MotionSource(model, point, spread, deviation) if sampled else None,
    )
    cuts = np.cumsum(counts)[:-1]
    of_courses = np.split(np.stack((errors, _band(slopes[:total], spread.covariance, deviation))), cuts, axis=1)
    for name in model.records:
        of_record, bands = np.concatenate([of_courses[k] for k in model.pieces(name)], axis=1)
        _add(motion_fit, model, name, point, of_record, bands)
    for other in others:
        _predict(motion_fit, model, other, point, spread.covariance, deviation, [ends for _, ends in within])
    return motion_fit


def _band(slopes: np.ndarray, covariance: np.ndarray, deviation: float) -> np.ndarray:
    """Half width [n] of the 95 % band of new measurements, in sizes."""
    return 1.96 * np.sqrt(np.einsum("ni,ij,nj->n", slopes, covariance, slopes) + deviation**2)


def _add(
    fit: MotionFit, model: RecordModel, name: str, point: np.ndarray, errors: np.ndarray, band: np.ndarray
) -> None:
    """A record in the result; errors, band: [its last samples] in sizes, by which it is judged."""
    places = model.pieces(name)
    courses_of, course = [model.courses[k] for k in places], model.courses[places[0]]
    motions = [model.predicted(k, point, len(course.measured)) for k, course in zip(places, courses_of, strict=True)]
    trusted = course.size * (1.0 if name not in fit.not_trusted else math.nan)
    judged = slice(len(course.time) - len(errors), None)
    fit.time[name] = course.time[judged] * fit.system.result_units.factor("time")
    fit.measured[name] = np.concatenate([course.measured for course in courses_of])[judged]
    fit.predicted[name] = np.concatenate(motions)[judged]
    fit.band[name] = band * trusted
    fit.rms[name] = float(np.sqrt(np.mean(errors**2))) * trusted
    fit.relative[name] = fit.rms[name] / float(np.std(fit.measured[name]))
    fit.starts[name] = model.start(places[0], point)


def _predict(
    fit: MotionFit,
    model: RecordModel,
    other: RecordModel,
    fitted: np.ndarray,
    covariance: np.ndarray,
    deviation: float,
    likely: Sequence[Sequence[np.ndarray]],
) -> None:
    """A held-out record: what is its own from its first tenth at the parameters found, and the prediction of the rest.

    What is uncertain of its own follows from the noise of that tenth, and with the parameters: ds/dp = -(Js^T Js)^-1
    Js^T Jp there. A parameter goes no farther than its interval, and the band is wider by what slopes do not tell of
    points as likely as that found, at the ends of the intervals: whether a contact sticks there.
    """
    many, (place,) = model.shared, other.places
    begun, (whole,) = other.counts(BEGIN), other.counts(1.0)
    point = np.concatenate((fitted[:many], np.zeros(len(place))))
    if other.many > many:
        point[many : other.many] = fitted[model.many - other.many + many : model.many]  # as in the last fitted record

    def begin(point: np.ndarray) -> np.ndarray:
        return other.refined(point, begun, 30, place).x if len(place) else point

    point = begin(point)
    errors, slopes = other.residuals(point, (whole,)), other.slopes(point, (whole,))
    first = slopes[: begun[0]]
    base = inverse(first[:, place].T @ first[:, place])
    follows = -base @ first[:, place].T @ first[:, :many]
    total = slopes[:, :many] + slopes[:, place] @ follows
    own = base * deviation**2 * correlation_time(errors[: begun[0]])
    if fit.problem:
        fit.problem.unseen[other.courses[0].name] = Unseen(other, point, follows, own, begun[0])
    joint = np.zeros((len(point), len(point)))
    reach = np.array([max((abs(end[k] - fitted[k]) for end in likely[k]), default=0.0) for k in range(many)])
    within = np.minimum(1.0, reach / (1.96 * np.sqrt(np.diag(covariance)[:many])))
    joint[:many, :many] = covariance[:many, :many] * np.outer(within, within)
    joint[np.ix_(place, place)] = own
    band = _band(np.hstack((total, slopes[:, place])), joint, deviation) ** 2
    for ends in likely:
        beyond = np.zeros(whole)
        for end in (end[:many] for end in ends):
            moved = begin(np.concatenate((end, point[many:])))
            far = np.abs(other.residuals(moved, (whole,)) - errors) - np.abs(total @ (end - fitted[:many]))
            beyond = np.maximum(beyond, far)
        band += beyond**2
    name = other.courses[0].name
    if why := other.distrust(name, point):
        fit.not_trusted[name] = why
    _add(fit, other, name, point, errors[begun[0] :], np.sqrt(band[begun[0] :]))
