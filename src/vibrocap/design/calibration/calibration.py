"""calibrate(system, table, over=...): parameters of a case from a measured table of settled motions."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_whole
from vibrocap.case.case import Case, CaseError
from vibrocap.design.calibration.table import MeasuredTable, read_table
from vibrocap.design.calibration.table_model import (
    ColumnDoubt,
    TableModel,
    column_doubt,
    improbable,
    outlying,
    refused_rows,
    searched,
)
from vibrocap.design.search.problem import asked_case, measure_unit
from vibrocap.design.search.variables import design_space
from vibrocap.identification.inference.identifiability import Direction, Verdict, combinations, verdict_within
from vibrocap.identification.inference.uncertainty import inverse
from vibrocap.measures.of_measure import MeasuresInUnits
from vibrocap.motion.simulate import initial_state
from vibrocap.motion.trust import NOT_SETTLED
from vibrocap.physics.dimensions.conversion import NumberAtPath
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, Numbers
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.results import Result
from vibrocap.studies.plan.variation import refusal

LEVEL = 0.95
CLOSE = 1e-3  # in shares of the ranges, within which a parameter stands at its bound
HALVINGS = 30  # to where an interval ends at values that a part refuses
SINGULAR = 1e-12  # singular value of the slopes below which a combination does nothing


@dataclasses.dataclass(frozen=True)
class CalibratedParameter(Dimensional):
    """A parameter: value, 95 % interval [low, high], standard error, and whether the table determines it.

    path: that of `over`; of several paths the value is the factor that they share. Interval and error are NaN where
    rows of the table cannot be trusted.
    """

    path: str
    value: NumberAtPath
    low: NumberAtPath
    high: NumberAtPath
    standard_error: NumberAtPath
    verdict: Verdict

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high

    def __str__(self) -> str:
        within = "" if math.isnan(self.low) else f" [{self.low:.6g}, {self.high:.6g}]"
        return f"{self.value:.6g}{within}, {self.verdict.value}"


class Calibrated(Result):
    """A result with parameters of a case."""

    parameters: tuple[CalibratedParameter, ...]
    rows = "parameters"

    def __getitem__(self, path: str) -> CalibratedParameter:
        """A parameter by its path."""
        return next(parameter for parameter in self.parameters if parameter.path == path)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Calibration(Calibrated):
    """Parameters of a case from a measured table.

    system: with the parameters found; parameters: with their 95 % intervals and verdicts; correlation: [p, p] of them
    directions: combinations of parameters, best determined first, with the deviation of their logarithm
    predicted: [rows] by measure, in the units of the table; residuals: measured less predicted, in standard errors;
        NaN of rows that are not to be trusted
    misfit: mean square of the fitted residuals, over the degrees of freedom; about 1 where errors were given and the
        model holds; held_out_misfit: mean square of the rows that were held out, None where there are none
    rms: root mean square of the residuals by measure, in the units of the table
    held_out: rows, from 0, that the fit has not seen; doubt: the column that explains a misfit, None where none does
    not_trusted: rows, from 0, by the reason why the run at the optimum, or a step beside it, is not to be trusted
    """

    system: System
    parameters: tuple[CalibratedParameter, ...]
    correlation: Numbers
    directions: tuple[Direction, ...]
    measured: MeasuredTable
    predicted: dict[str, Numbers]
    residuals: dict[str, Numbers]
    misfit: Number
    held_out_misfit: Number | None
    rms: MeasuresInUnits
    held_out: tuple[int, ...]
    doubt: ColumnDoubt | None
    outliers: tuple[int, ...]
    not_trusted: dict[str, tuple[int, ...]]
    initial: ByName

    in_record = "parameters correlation directions misfit rms held_out_misfit doubt rows_outlying rows_not_trusted"

    @property
    def rows_outlying(self) -> list[int]:
        """Numbers of rows that stand out, from 1."""
        return [1 + row for row in self.outliers]

    @property
    def rows_not_trusted(self) -> dict[str, list[int]]:
        """Numbers of such rows, from 1, by the reason."""
        return {why: [1 + row for row in rows] for why, rows in self.not_trusted.items()}

    @property
    def heading(self) -> str:
        return f"calibration on {self.measured.rows} rows"

    @property
    def facts(self) -> dict[str, str]:
        facts = {parameter.path: str(parameter) for parameter in self.parameters}
        facts["misfit"] = f"{self.misfit:.4g}" + ("" if self.measured.with_errors else " (errors estimated from it)")
        facts |= {f"rms {name}": said(x, measure_unit(self.system, name)[0], 4) for name, x in self.rms.items()}
        pairs = [(abs(r), r, i, k) for (i, k), r in np.ndenumerate(self.correlation) if i < k]
        for _, r, i, k in sorted(pairs, reverse=True)[:1]:
            words = f"{r:.3g} of {self.parameters[i].path} and {self.parameters[k].path}"
            facts["correlation"] = words + (" (the largest)" if len(pairs) > 1 else "")
        if self.held_out_misfit is not None:
            facts["held out"] = f"{self.held_out_misfit:.4g}"
        for reason, rows in self.not_trusted.items():
            cure = "give more periods" if reason == NOT_SETTLED else "narrow the bounds"
            facts[reason] = f"row {', '.join(str(1 + k) for k in rows)}: {cure}, or hold such rows out"
        if self.doubt:
            facts["doubt"] = str(self.doubt)
        if rows := ", ".join(map(str, self.rows_outlying)):
            facts["outlier"] = f"row {rows}: hold it out, unless all others are wrong"
        return facts

    def case(self, periods: float = 40) -> Case:
        """A case with the parameters found."""
        return Case(self.system, self.initial, periods=periods)


@shows_progress("Calibrating")
def calibrate(
    system: System | Case,
    table: Any,
    over: Mapping[str, Any],
    *,
    held_out: Sequence[int] = (),
    initial: ByName | None = None,
    starts: int = 256,
    seed: int = 0,
    periods: int = 300,
    settle: float = 1e-7,
    tolerance: float = 1e-9,
    threads: int | None = None,
    progress: Progress = None,
) -> Calibration:
    """Parameters of machine, friction, drive and actuator from a measured table, with joint intervals.

    A laboratory has a table: mean speed over frequency and duty, with errors. Each row is a settled motion. The
    parameters minimise the sum of the squared residuals in standard errors, searched from Sobol points and by
    Gauss-Newton steps within the bounds (SciPy's trust region). Intervals are those of the linearised least squares,
    with Student's quantile; where errors were given and the misfit exceeds 1, they widen by its root. They end where a
    part refuses its values. Where the run of a row fails or has not settled, there are none; where the misfit is
    improbable or a column is doubted, so are the parameters.

    table: a CSV file, a pandas.DataFrame or a mapping of columns: paths of parameters ("drive.frequency", in SI where
        the case is) are the conditions, columns named by measures the readings, `MEASURE_error` their standard error;
        other units stand in the heading ("mean_velocity [mm/s]", "drive.period_ms") or in a line below it
    over: {path: (low, high)}: the unknowns with their bounds; {"path,path": "factor:low:high"}: a factor of the
        system's own values that several share
    held_out: numbers of rows, from 0, that the fit does not see and that judge it
    initial: the start of all runs; starts: points from which the search begins; seed: of them
    periods, settle, tolerance, threads: see `ensemble`

    Returns a `Calibration`. Raises CaseError with every complaint about system, table and over, before any work.
    """
    complaints = Complaints()
    case = asked_case(system, settle, complaints, driven=True, seed=(seed, 0))
    system = case.system
    measured = read_table(table, system, complaints)
    space = design_space(system, over, complaints)
    for path in space.require_numbers(complaints):
        if measured is not None and {*path.replace(" ", "").split(",")} & {*measured.conditions}:
            complaints.add(path, "is a column of the table; leave it out of `over`, or the column out of the table")
    with complaints.collected():
        check_whole("starts", starts, 1, 2**16)
    with complaints.collected():
        initial_state(system, case.initial if initial is None else initial)
    held = sorted({int(k) for k in held_out})
    if measured is not None:
        if any(not 0 <= k < measured.rows for k in held):
            complaints.add("held_out", f"names a row that is none of the {measured.rows} of the table")
        fitted = (measured.rows - len(held)) * len(measured.measures)
        if fitted <= len(space.paths):
            need = f"more than {len(space.paths)} measured values for so many parameters, got {fitted}"
            complaints.add("table", f"should hold {need}")
        if not complaints:
            complaints += refused_rows(system, measured, space)
    if complaints or measured is None:
        raise CaseError(complaints, "the calibration")
    fixed = dict(case.initial if initial is None else initial)
    runs = {"initial": fixed, "periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    rows = np.setdiff1d(np.arange(measured.rows), held)
    model = TableModel(system, measured, space, runs, rows)
    return _calibration(model, searched(model, starts, seed, told(progress)), held)


def _calibration(model: TableModel, shares: np.ndarray, held: list[int]) -> Calibration:
    """The result of a search."""
    space, table, unknowns = model.space, model.table, len(model.space.paths)
    values, trust = model.predicted(np.vstack([shares, *model.beside(shares)]), np.arange(table.rows))
    doubts = ([trust.doubt((point, row)) for point in range(len(values))] for row in range(table.rows))
    reasons = np.array([next(filter(None, doubt), "") for doubt in doubts])
    not_trusted = {str(why): tuple(np.flatnonzero(reasons == why).tolist()) for why in np.unique(reasons) if why}
    residuals = model.residuals(shares[None])[0]
    spare = len(residuals) - unknowns
    misfit = float(np.sum(residuals**2) / spare)
    slopes = model.slopes(shares)
    widen = max(misfit, 1.0) if table.with_errors else misfit
    covariance = widen * inverse(slopes.T @ slopes)
    fitted = {*reasons[model.rows].tolist()}
    verdict, doubt = None, None if NOT_SETTLED in fitted else column_doubt(model, shares, residuals)
    outliers = () if doubt or any(fitted) else outlying(model, residuals, slopes)
    if any(fitted):
        covariance, verdict = np.full_like(covariance, np.nan), Verdict.UNTRUSTED
    elif doubt or outliers or improbable(model, float(np.sum(residuals**2))):
        verdict = Verdict.DOUBTED
    parameters = [_parameter(model, k, shares, covariance, slopes, verdict) for k in range(unknowns)]
    own = np.array([parameter.value for parameter in parameters])
    per_fold = np.array([space.derivative(k, float(shares[k])) for k in range(unknowns)])
    logs = slopes * (np.where(own == 0.0, 1.0, own) / per_fold)
    deviation = np.sqrt(np.diag(covariance))
    known = {name: np.where(reasons == "", values[0, i], np.nan) for i, name in enumerate(table.measures)}
    left = {name: table.targets[name] - known[name] for name in table.measures}
    every = {name: left[name] / table.errors[name] for name in table.measures}
    squares = np.concatenate([every[name][held] ** 2 for name in table.measures])
    return Calibration(
        system=model.system.with_parameters(space.parameters(shares)),
        parameters=tuple(parameters),
        correlation=covariance / np.outer(deviation, deviation),
        directions=() if verdict is Verdict.UNTRUSTED else combinations(space.paths, logs, widen, SINGULAR),
        measured=table,
        predicted=known,
        residuals=every,
        misfit=misfit,
        held_out_misfit=_mean(squares) if len(held) else None,
        rms={name: math.sqrt(_mean(left[name][model.rows] ** 2)) for name in table.measures},
        held_out=tuple(held),
        doubt=doubt,
        outliers=outliers,
        not_trusted=not_trusted,
        initial=model.runs["initial"],
    )


def _mean(squares: np.ndarray) -> float:
    """Mean of the squares that are known, NaN where none is."""
    known = squares[~np.isnan(squares)]
    return float(np.mean(known)) if len(known) else math.nan


def _parameter(
    model: TableModel, k: int, shares: np.ndarray, covariance: np.ndarray, slopes: np.ndarray, doubted: Verdict | None
) -> CalibratedParameter:
    """A parameter with its interval and what the table says of it; doubted: what is said of all parameters."""
    from scipy.special import stdtrit

    space, path, share = model.space, model.space.paths[k], float(shares[k])
    deviation = float(np.sqrt(covariance[k, k]))
    error = deviation * space.derivative(k, share)
    value = float(space.design(shares)[path])
    if doubted is Verdict.UNTRUSTED:
        return CalibratedParameter(path, value, math.nan, math.nan, error, doubted)
    half = float(stdtrit(len(slopes) - len(shares), 0.5 + 0.5 * LEVEL))
    ends = [_end(model, shares, sign * half * covariance[:, k] / deviation, k) for sign in (-1.0, 1.0)]
    low, high = (float(space.design(end)[path]) for end, _ in ends)
    open_low, open_high = (cut or not 0.0 < end[k] < 1.0 for end, cut in ends)
    verdict = verdict_within(low, high, open_low or share < CLOSE, open_high or share > 1.0 - CLOSE)
    if np.sqrt(np.mean(slopes[:, k] ** 2)) < 1e-9:
        verdict = Verdict.NO_EFFECT
    elif doubted and not (open_low and open_high):
        verdict = doubted
    return CalibratedParameter(path, value, low, high, error, verdict)


def _end(model: TableModel, shares: np.ndarray, change: np.ndarray, k: int) -> tuple[np.ndarray, bool]:
    """(shares at an end of the interval of parameter k, whether a part refuses what lies beyond).

    change: to the point of the joint region where the parameter is extreme; the others go with it as they are
    correlated, or stay, where a part refuses that they do.
    """

    def point(part: float) -> np.ndarray:
        return np.clip(shares + part * change, 0.0, 1.0)

    def refused(part: float) -> bool:
        alone = shares.copy()
        alone[k] = point(part)[k]
        return all(refusal(model.system, model.space.parameters(point_tried)) for point_tried in (point(part), alone))

    if not refused(1.0):
        return point(1.0), False
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if refused(middle) else (middle, high)
    return point(low), True
