"""fit_motion(case, records, over=...): parameters of any machine and law from its motion under a measured force.

Output error: the case is simulated under the measured force, and what it does is compared with what was measured. So
mass, springs, dampers, gravity and friction are found together, and a motion under another force is predicted.
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_whole, shown, suggestion
from vibrocap.case.case import Case, CaseError
from vibrocap.design.calibration.calibration import Calibrated, CalibratedParameter
from vibrocap.design.calibration.motion_source import MotionSource, Unseen
from vibrocap.design.calibration.record_model import (
    RecordModel,
    courses,
    measured_column,
    searched,
    spread_of,
    turns,
    with_priors,
)
from vibrocap.design.search.variables import design_space
from vibrocap.identification.inference.identifiability import Verdict, verdict_within
from vibrocap.identification.inference.residuals import FAR
from vibrocap.identification.inference.uncertainty import Uncertainty, correlation_time, inverse
from vibrocap.identification.problem.priors import MOST, SAYS_MORE, checked_priors
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.numerics.api import available_threads
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, Numbers, WithUnit
from vibrocap.records.record import Record
from vibrocap.studies.plan.variation import refusal

HALVINGS = 6  # to where the squares object to a value of a parameter
LEAST = 1e-9  # share of a range: the first step from a value
FAINT = 1e-9  # change of every error per share, below which a parameter does nothing
BEGIN = 0.1  # share of a held-out record from which its start is found
SENSITIVE = 1e3  # growth of a change of the start from which on neighbouring parameters have minima of their own
CONSTANT = 1.0  # relative error from which on a prediction is no better than a constant


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class MotionFit(Calibrated):
    """Parameters of a case from motions under measured forces, and the motions that it predicts.

    system: with the parameters found, and the drive of the case; predict: the quantity compared, in `unit`
    parameters: with their 95 % intervals and verdicts; correlation: [p, p] of them
    held_out: names of the records that the fit has not seen; of such a record the first tenth finds its start alone,
        and what it says of errors is of the rest
    measured, predicted, band: [samples] by record; of a new measurement 95 % lie within predicted +- band
    rms: root mean square error by record; relative: over the standard deviation of what was measured, 1 for a constant
    noise_ratio: errors over the noise of the samples, which second differences tell
    growth: largest factor by which a change of the start grows in a record
    pulls: standard deviations by which data and priors disagree, by parameter, where that is no chance
    starts: initial states by record, of the case without units
    not_trusted: why the motion of a record is not to be trusted, by the record's name: it does not reach the end of the
        record, or is not certified. Nothing is said of its errors then, and of no parameter if it was fitted
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
    pulls: dict[str, Number]
    starts: dict[str, ByName]
    not_trusted: dict[str, str]
    converged: bool
    problem: MotionSource | None = dataclasses.field(default=None, repr=False)

    rows = "parameters"
    in_record = "predict parameters correlation records noise_ratio growth pulls not_trusted converged"

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
            unit = "" if self.unit == "1" else f" {self.unit}"
            worse = ", no better than a constant" if self.relative[name] >= CONSTANT else ""
            kept = "held out, " if name in self.held_out else ""
            facts[name] = f"{kept}rms {rms:.4g}{unit}, {self.relative[name]:.2%} of the motion{worse}"
            if name in self.not_trusted:
                facts[name] = f"{kept}the motion is not to be trusted: {self.not_trusted[name]}"
        for path, away in self.pulls.items():
            facts[f"prior {path}"] = f"differs from the data by {abs(away):.2g} standard deviations"
        if self.noise_ratio > FAR:
            times = f"errors are {self.noise_ratio:.3g} times the noise of the samples"
            facts["doubt"] = f"{times}: machine or law lack something"
        elif self.growth > SENSITIVE:
            facts["doubt"] = f"a change of the start grows {self.growth:.2g} times: fit shorter records"
        if not self.converged:
            facts["search"] = "not settled: give more starts or narrower bounds"
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
    priors: Mapping[str, tuple[float, float]] | None = None,
    initial: ByName | None = None,
    starts: int = 64,
    seed: int = 0,
    tolerance: float = 1e-9,
    threads: int | None = None,
    progress: Progress = None,
) -> MotionFit:
    """Parameters of machine, friction and actuator from measured motions under a measured force or torque.

    The case is simulated under the force of each record, straight lines between its samples, and the squared errors
    of what it predicts are minimised: from Sobol points over the first eighth of the records, then over longer ones
    (SciPy's trust region). Parameters are common to all records; each has a start of its own, which is found too.
    Errors that follow from a wrong model are correlated, and intervals widen with their correlation time.

    system: in SI where the records are; its drive is replaced, and the start of a case is not taken; it may be any
        machine, a `[mechanism]` of one's own too
    records: force (torque) of the drive, and the motion: `vc.read_records`
    over: {path: (low, high)}: the unknowns with their bounds, as in `calibrate`; "drive.amplitude" is a factor of the
        measured force
    predict: a state: a length or an angle is compared with the records' displacement, a velocity with theirs
    held_out: names of records that the fit does not see and that judge it
    priors: {path: (mean, standard deviation)} of the unknowns
    initial: states at the start of every record that are known; the machine's others are found
    starts: points from which the search begins; seed: of them

    Returns a `MotionFit`. Raises CaseError with every complaint about system, records and over, before any work.
    """
    complaints = Complaints()
    case = system if isinstance(system, Case) else Case(system)
    records = [records] if isinstance(records, Record) else list(records)
    hidden = (held_out,) if isinstance(held_out, str) else tuple(held_out)
    _check_records(case.system, records, predict, hidden, complaints)
    for name, count in (("starts", starts), ("seed", seed)):
        with complaints.collected():
            check_whole(name, count, 1 if name == "starts" else 0, 2**16)
    with complaints.collected():
        check_run(periods=1.0, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    known = dict(initial or {})
    with complaints.collected():
        initial_state(case.system, known)
    if complaints:
        raise CaseError(complaints, "the fit")
    every = {course.name: course for course in courses(case.system, records, predict, known)}
    fitted = [course for name, course in every.items() if name not in hidden]
    space = design_space(fitted[0].system, over, complaints)
    space.require_numbers(complaints)
    with complaints.collected():
        known_before = checked_priors(priors, space.paths)
    if complaints:
        raise CaseError(complaints, "the fit")
    threads = threads or available_threads()
    model = RecordModel(predict, space, fitted, tolerance, threads)
    point, converged = searched(model, starts, seed, told(progress))
    point = with_priors(model, point, known_before)
    others = [RecordModel(predict, space, [every[name]], tolerance, threads) for name in hidden]
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
    for name in hidden:
        if name not in names:
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
    space, many = model.space, len(model.space.paths)
    counts = model.counts(1.0)
    errors = model.errors(point, counts)
    slopes = model.slopes(point, counts)
    spread = spread_of(model, point, errors, slopes)
    deviation = math.sqrt(float(np.sum(errors**2)) / max(len(errors) - model.coordinates, 1))
    growth = model.growth(slopes)
    pulls = {prior.name: prior.pull for prior in model.priors if abs(prior.pull) > MOST}
    reasons = {course.name: model.distrust(k, point) for k, course in enumerate(model.courses)}
    doubted = bool(pulls) or growth > SENSITIVE or float(np.linalg.norm(errors)) > FAR * model.noise
    doubt = Verdict.UNTRUSTED if any(reasons.values()) else Verdict.DOUBTED if doubted else None
    shares = point[:many]
    own = spread.covariance[:many, :many] if doubt is not Verdict.UNTRUSTED else np.full((many, many), np.nan)
    parameters = [_parameter(model, k, point, slopes, spread, doubt) for k in range(many)]
    deviations = np.sqrt(np.diag(own))
    motion_fit = MotionFit(
        system=system.with_parameters(
            {path: value for path, value in space.parameters(shares).items() if not path.startswith("drive.")}
        ),
        predict=model.predict,
        unit=system.result_units.unit(model.predict),
        parameters=tuple(parameters),
        correlation=own / np.outer(deviations, deviations),
        held_out=tuple(other.courses[0].name for other in others),
        **{name: {} for name in ("time", "measured", "predicted", "band", "rms", "relative", "starts")},
        noise_ratio=float(np.linalg.norm(errors)) / max(model.noise, 1e-300),
        growth=growth,
        pulls=pulls,
        not_trusted={name: why for name, why in reasons.items() if why},
        converged=converged,
        problem=None if doubt is Verdict.UNTRUSTED else MotionSource(model, point, spread, deviation),
    )
    for k in range(len(model.courses)):
        rows = slice(sum(counts[:k]), sum(counts[: k + 1]))
        _add(motion_fit, model, k, point, errors[rows], _band(slopes[rows], spread.covariance, deviation))
    for other in others:
        _predict(motion_fit, other, shares, own, deviation)
    return motion_fit


def _parameter(
    model: RecordModel, k: int, point: np.ndarray, slopes: np.ndarray, spread: Uncertainty, doubt: Verdict | None
) -> CalibratedParameter:
    """A parameter with what its records say of it: the interval in which the squares are as likely as at the point.

    It is sought where the others follow the parameter as they are correlated, and where they stay:
    where a level of friction decides whether a contact sticks, slopes tell nothing of what lies beyond.
    """
    space, path = model.space, model.space.paths[k]
    variable: Any = space.variables[k]
    value = float(variable.at(point[k]))
    if doubt is Verdict.UNTRUSTED:
        return CalibratedParameter(path, value, math.nan, math.nan, math.nan, doubt)
    limit = model.squares(point, model.counts(1.0)) + spread.unit * spread.threshold[k] ** 2
    error = math.sqrt(spread.covariance[k, k])
    alone = np.eye(len(point))[k]
    acting = np.any(np.abs(np.concatenate([slopes, model.known_slopes(point)])) > FAINT, axis=0)
    joint = np.where(acting, spread.covariance[:, k] / spread.covariance[k, k], alone)
    half = error * float(spread.threshold[k] / math.sqrt(spread.inflation[k])) if acting[k] else 0.0
    reached = []
    for sign in (-1.0, 1.0):
        linear = float(np.clip(point[k] + sign * half, 0.0, 1.0))
        many = len(space.paths)
        refused = refusal(model.system, space.parameters(np.where(alone[:many], linear, point[:many])))
        ends = [point[k] + sign * _reach(model, k, point, sign * along, error, limit) for along in (alone, joint)]
        reached.append(sorted([*ends, *([] if refused else [linear])])[0 if sign < 0.0 else -1])
    low, high = reached
    ends = float(variable.at(low)), float(variable.at(high))
    of_prior = spread.known[k] > SAYS_MORE and any(prior.name == path for prior in model.priors)
    whole = doubt or (Verdict.PRIOR if of_prior else None)
    verdict = verdict_within(*ends, low <= 0.0, high >= 1.0, whole) if acting[k] else Verdict.NO_EFFECT
    error *= space.derivative(k, float(point[k]))
    return CalibratedParameter(path, value, *ends, error, verdict)


def _reach(model: RecordModel, k: int, point: np.ndarray, along: np.ndarray, begin: float, limit: float) -> float:
    """How far parameter k may go along a direction, in shares of its range, before the squares exceed a limit."""
    counts, (low, high) = model.counts(1.0), model.bounds
    room = (1.0 - point[k]) if along[k] > 0.0 else point[k]

    def allowed(change: float) -> bool:
        return model.squares(np.clip(point + change * along, low, high), counts) <= limit

    inside, step = 0.0, min(max(begin, LEAST), room)
    while allowed(step):
        if step >= room:
            return room
        inside, step = step, min(2.0 * step, room)
    outside = step
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if allowed(middle) else (inside, middle)
    return outside


def _band(slopes: np.ndarray, covariance: np.ndarray, deviation: float) -> np.ndarray:
    """Half width [n] of the 95 % band of new measurements, in sizes."""
    return 1.96 * np.sqrt(np.einsum("ni,ij,nj->n", slopes, covariance, slopes) + deviation**2)


def _add(fit: MotionFit, model: RecordModel, k: int, point: np.ndarray, errors: np.ndarray, band: np.ndarray) -> None:
    """A record in the result; errors, band: [its last samples] in sizes, by which it is judged."""
    course, units = model.courses[k], fit.system.result_units
    name, judged = course.name, slice(len(course.instants) - len(errors), None)
    trusted = 1.0 if name not in fit.not_trusted else math.nan
    fit.time[name] = course.instants[judged] * units.factor("time")
    fit.measured[name] = course.measured[judged]
    fit.predicted[name] = model.predicted(k, point, len(course.instants))[judged]
    fit.band[name] = band * course.size * trusted
    fit.rms[name] = float(np.sqrt(np.mean(errors**2))) * course.size * trusted
    fit.relative[name] = fit.rms[name] / float(np.std(course.measured[judged]))
    fit.starts[name] = model.start(k, point)


def _predict(fit: MotionFit, model: RecordModel, shares: np.ndarray, covariance: np.ndarray, deviation: float) -> None:
    """A held-out record: its start from its first tenth at the parameters found, and the prediction of the rest.

    What is uncertain of the start follows from the noise of that tenth, and with the parameters: ds/dp = -(Js^T Js)^-1
    Js^T Jp there.
    """
    many, (place,) = len(shares), model.places
    begun, (whole,) = model.counts(BEGIN), model.counts(1.0)
    point = np.concatenate((shares, np.zeros(len(place))))
    if len(place):
        point = model.refined(point, begun, 30, place).x
    errors, slopes = model.errors(point, (whole,)), model.slopes(point, (whole,))
    first = slopes[: begun[0]]
    base = inverse(first[:, place].T @ first[:, place])
    follows = -base @ first[:, place].T @ first[:, :many]
    total = slopes[:, :many] + slopes[:, place] @ follows
    own = base * deviation**2 * correlation_time(errors[: begun[0]])
    if fit.problem:
        fit.problem.unseen[model.courses[0].name] = Unseen(model, point, follows, own, begun[0])
    joint = np.zeros((len(point), len(point)))
    joint[:many, :many] = covariance
    joint[np.ix_(place, place)] = own
    band = _band(np.hstack((total, slopes[:, place])), joint, deviation)
    if why := model.distrust(0, point):
        fit.not_trusted[model.courses[0].name] = why
    _add(fit, model, 0, point, errors[begun[0] :], band[begun[0] :])
