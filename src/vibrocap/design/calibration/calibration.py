"""calibrate(system, table, over=...): parameters of a case from a measured table of settled motions.

A laboratory has a table: mean speed over frequency and duty, with errors. Each row is a settled motion whose conditions
are known and whose measures were read; what is unknown of machine, friction and drive follows by least squares.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_whole, shown
from vibrocap.case.case import Case, CaseError
from vibrocap.case.sections import is_kind
from vibrocap.design.calibration.table import MeasuredTable, read_table
from vibrocap.design.calibration.table_model import FIRST_STEPS, TableModel, improbable, refined, searched, soft
from vibrocap.design.search.goal import asked_case
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.design.search.variables import DesignSpace, design_space
from vibrocap.identification.inference.identifiability import WIDE, Direction, Verdict
from vibrocap.identification.inference.uncertainty import inverse
from vibrocap.motion.simulate import initial_state
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, Numbers
from vibrocap.results import Result

SUSPECT = (
    1e-4  # probability, over all columns, below which chance is no explanation of what a factor or offset explains
)
GAIN = 0.3  # least share of the misfit that a wrong column has to explain
STARTS, LARGEST = 128, 0.6  # points from which a correction is looked for, and its largest size there
REFINED = 2  # of them that are refined at first, and corrections that are refined to the end


@dataclasses.dataclass(frozen=True)
class ColumnDoubt:
    """What would explain a misfit: a column that is off by a factor or an offset, and by how much.

    kind: "factor" or "offset"; size: by which the column would have to be corrected; probability: that chance explains
        as much; gain: share of the misfit that it explains
    """

    column: str
    kind: str
    size: float
    probability: float
    gain: float

    def __str__(self) -> str:
        how = f"multiplied by {self.size:.3g}" if self.kind == "factor" else f"shifted by {self.size:.3g}"
        return f"{self.column} {how} would explain {100.0 * self.gain:.0f} % of the misfit"


def column_doubt(model: TableModel, shares: np.ndarray, residuals: np.ndarray) -> ColumnDoubt | None:
    """The column that a factor or an offset makes fit, if chance does not explain the gain (F test, Bonferroni)."""
    from scipy.stats import f as f_distribution

    before, spare = float(np.sum(residuals**2)), len(residuals) - len(shares) - 1
    if spare < 1 or (model.table.with_errors and not improbable(model, before)):
        return None
    names = [*model.table.conditions, *model.table.measures]
    begun = [_begun(model.with_corrected(name, kind), shares) for name in names for kind in ("factor", "offset")]
    tried: list[ColumnDoubt] = []
    for _, other, near in sorted(begun, key=lambda each: each[0])[:REFINED]:
        after, point = refined(other, near)
        assert other.corrected is not None
        name, kind = other.corrected
        ratio = (before - after) / (after / spare)
        chance = float(f_distribution.sf(max(ratio, 0.0), 1, spare)) * len(begun)
        size = float(np.exp(point[-1])) if kind == "factor" else float(point[-1] * np.std(model.table.column(name)))
        tried.append(ColumnDoubt(name, kind, size, min(chance, 1.0), 1.0 - after / before))
    best = max(tried, key=lambda each: each.gain)
    return best if best.probability < SUSPECT and best.gain > GAIN else None


def _begun(model: TableModel, shares: np.ndarray) -> tuple[float, TableModel, np.ndarray]:
    """(cost, model, point) of a correction after its first steps: a wrong column may have led the search far away."""
    points = sample_points(model.coordinates, STARTS, 0)
    points[:, -1] = LARGEST * (2.0 * points[:, -1] - 1.0)
    points = np.concatenate([points, [np.append(shares, size) for size in (0.0, 0.5 * LARGEST, -0.5 * LARGEST)]])
    order = np.argsort(np.sum(soft(model.residuals(points)), axis=1), kind="stable")
    ends = [refined(model, points[k], "soft_l1", FIRST_STEPS)[1] for k in order[:REFINED]]
    costs = [float(np.sum(soft(model.residuals(end[None])))) for end in ends]
    best = int(np.argmin(costs))
    return costs[best], model, ends[best]


LEVEL = 0.95
CLOSE = 1e-3  # in shares of the ranges, within which a parameter stands at its bound


@dataclasses.dataclass(frozen=True)
class CalibratedParameter:
    """A parameter: value, 95 % interval [low, high], standard error, and whether the table determines it."""

    path: str
    value: Number
    low: Number
    high: Number
    standard_error: Number
    verdict: Verdict

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Calibration(Result):
    """Parameters of a case from a measured table.

    system: with the parameters found; parameters: with their 95 % intervals and verdicts; correlation: [p, p] of them
    directions: combinations of parameters, best determined first, with the deviation of their logarithm
    predicted: [rows] by measure, in the units of the table; residuals: measured less predicted, in standard errors
    misfit: mean square of the fitted residuals, over the degrees of freedom; about 1 where errors were given and the
        model holds; held_out_misfit: of the rows that were held out, None where there are none
    doubt: the column that explains a misfit, None where none does; failed: rows whose run failed at the optimum
    """

    system: System
    parameters: tuple[CalibratedParameter, ...]
    correlation: Numbers
    directions: tuple[Direction, ...]
    table: MeasuredTable
    predicted: dict[str, Numbers]
    residuals: dict[str, Numbers]
    misfit: Number
    held_out_misfit: Number | None
    doubt: ColumnDoubt | None
    failed: tuple[int, ...]
    initial: ByName

    @property
    def heading(self) -> str:
        return f"calibration on {self.table.rows} rows"

    @property
    def facts(self) -> dict[str, str]:
        found = {
            each.path: f"{each.value:.6g} [{each.low:.6g}, {each.high:.6g}], {each.verdict.value}"
            for each in self.parameters
        }
        found["misfit"] = f"{self.misfit:.4g}" + ("" if self.table.with_errors else " (errors estimated from it)")
        if self.held_out_misfit is not None:
            found["held out"] = f"{self.held_out_misfit:.4g}"
        if self.failed:
            found["failed rows"] = ", ".join(str(1 + k) for k in self.failed)
        if self.doubt:
            found["doubt"] = str(self.doubt)
        return found

    def __getitem__(self, path: str) -> CalibratedParameter:
        """A parameter by its path."""
        return next(each for each in self.parameters if each.path == path)

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

    Each row is a settled motion. The parameters minimise the sum of the squared residuals in standard errors, searched
    from Sobol points and by Gauss-Newton steps within the bounds (SciPy's trust region). Intervals are those of the
    linearised least squares, with Student's quantile; where errors were given and the misfit exceeds 1, they widen by
    its root.

    table: a CSV file, a pandas.DataFrame or a mapping of columns: paths of parameters ("drive.frequency", in SI where
        the case is) say the conditions, names of measures what was read, `MEASURE_error` its standard error
    over: {path: (low, high)}: what is unknown, and within which bounds
    held_out: numbers of rows, from 0, that the fit does not see and that judge it
    initial: the start of all runs; starts: points from which the search begins; seed: of them
    periods, settle, tolerance, threads: see `ensemble`

    Returns a `Calibration`. Raises CaseError with every complaint about system, table and over, before any work.
    """
    complaints = Complaints()
    case = asked_case(system, settle, complaints, seed=(seed, 0))
    system = case.system
    measured = read_table(table, system, complaints)
    space = design_space(system, over, complaints)
    for path in space.paths:
        if is_kind(path) or path not in [space.paths[i] for i in space.continuous]:
            complaints.add(path, "should be a number with its bounds, such as 0.1:0.5")
        elif measured is not None and path in measured.conditions:
            complaints.add(path, "is a column of the table; leave it out of `over`, or the column out of the table")
    with complaints.collected():
        check_whole("starts", starts, 1, 2**16)
    with complaints.collected():
        initial_state(system, case.initial if initial is None else initial)
    held = sorted({int(k) for k in held_out})
    if measured is not None:
        if any(not 0 <= k < measured.rows for k in held):
            complaints.add(
                "held_out", f"should be numbers of rows from 0 to {measured.rows - 1}, got {shown(held_out)}"
            )
        fitted = (measured.rows - len(held)) * len(measured.measures)
        if fitted <= len(space.paths):
            need = f"more than {len(space.paths)} measured values for so many parameters, got {fitted}"
            complaints.add("table", f"should hold {need}")
    if complaints or measured is None:
        raise CaseError(complaints, "the calibration")
    fixed = dict(case.initial if initial is None else initial)
    runs = {"initial": fixed, "periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    rows = np.setdiff1d(np.arange(measured.rows), held)
    model = TableModel(system, measured, space, runs, rows)
    shares = searched(model, starts, seed, told(progress))
    return _calibration(model, shares, np.array(held, dtype=int), fixed)


def _calibration(model: TableModel, shares: np.ndarray, held: np.ndarray, initial: Mapping[str, float]) -> Calibration:
    """The result of a search."""
    space, table, unknowns = model.space, model.table, len(model.space.paths)
    residuals = model.residuals(shares[None])[0]
    spare = len(residuals) - unknowns
    misfit = float(np.sum(residuals**2) / spare)
    slopes = model.slopes(shares)
    widen = max(misfit, 1.0) if table.with_errors else misfit
    covariance = widen * inverse(slopes.T @ slopes)
    parameters = [_parameter(space, k, shares, covariance, slopes, spare) for k in range(unknowns)]
    values = np.array([each.value for each in parameters])
    per_fold = np.array([space.derivative(k, float(shares[k])) for k in range(unknowns)])
    logs = slopes * (np.where(values == 0.0, 1.0, values) / per_fold)
    deviation = np.sqrt(np.diag(covariance))
    predicted, finished = model.predicted(shares[None], np.arange(table.rows))
    own = {name: predicted[0, i] for i, name in enumerate(table.measures)}
    every = {name: (table.targets[name] - own[name]) / table.errors[name] for name in table.measures}
    held_misfit = None
    if len(held):
        held_misfit = float(np.mean(model.residuals(shares[None], held) ** 2))
    return Calibration(
        system=model.system.with_parameters({each.path: each.value for each in parameters}),
        parameters=tuple(parameters),
        correlation=covariance / np.outer(deviation, deviation),
        directions=_directions(space.paths, logs, widen),
        table=table,
        predicted=own,
        residuals=every,
        misfit=misfit,
        held_out_misfit=held_misfit,
        doubt=column_doubt(model, shares, residuals),
        failed=tuple(int(k) for k in np.flatnonzero(~finished[0])),
        initial=dict(initial),
    )


def _parameter(
    space: DesignSpace, k: int, shares: np.ndarray, covariance: np.ndarray, slopes: np.ndarray, spare: int
) -> CalibratedParameter:
    """A parameter with its interval and what the table says of it."""
    from scipy.special import stdtrit

    path, share = space.paths[k], float(shares[k])

    def value(x: float) -> float:
        return float(space.values(np.where(np.arange(len(shares)) == k, np.clip(x, 0.0, 1.0), shares)[None])[path][0])

    deviation = float(np.sqrt(covariance[k, k]))
    half = float(stdtrit(spare, 0.5 + 0.5 * LEVEL)) * deviation
    low, high = value(share - half), value(share + half)
    open_low, open_high = share - half <= 0.0, share + half >= 1.0
    if np.sqrt(np.mean(slopes[:, k] ** 2)) < 1e-9:
        verdict = Verdict.NO_EFFECT
    elif open_low and open_high:
        verdict = Verdict.UNDETERMINED
    elif open_low or share < CLOSE:
        verdict = Verdict.BOUNDED_ABOVE
    elif open_high or share > 1.0 - CLOSE:
        verdict = Verdict.BOUNDED_BELOW
    else:
        verdict = Verdict.WIDE if low > 0.0 and high > WIDE * low else Verdict.DETERMINED
    return CalibratedParameter(path, value(share), low, high, deviation * space.derivative(k, share), verdict)


def _directions(paths: Sequence[str], logs: np.ndarray, unit: float) -> tuple[Direction, ...]:
    """Combinations of parameters, the best determined first; logs: slopes by the logarithms."""
    _, singular, right = np.linalg.svd(logs, full_matrices=False)
    found = []
    for value, row in zip(singular, right, strict=True):
        signed = row * np.sign(row[np.argmax(np.abs(row))])
        deviation = math.sqrt(unit) / float(value) if value > 1e-12 else math.inf
        found.append(Direction(dict(zip(paths, signed.tolist(), strict=True)), deviation))
    return tuple(found)
