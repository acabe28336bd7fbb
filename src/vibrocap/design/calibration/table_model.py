"""A measured table as least squares: its settled runs at any values of the unknowns, the search for the best, and the
column whose factor, sign or offset is wrong.
"""

import dataclasses
import itertools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint
from vibrocap.design.calibration.table import MeasuredTable
from vibrocap.design.search.problem import measure_unit
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.design.search.variables import DesignSpace
from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.status import Status
from vibrocap.motion.trust import TRAVEL, Trust
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import refusal

STEP = 1e-4  # of the differences that give slopes, in shares of the ranges
FAILED_ROW = 1e3, 10.0  # residual of a run without a value, at least: in standard errors, in largest measured values
REFUSED = list(Status).index(Status.NOT_FINITE)  # status of the runs at a point that a part refuses
REFUSALS = 64  # points of the unknowns at which a part has to refuse a row
BEGUN, FIRST_STEPS = 4, 15  # candidates that are refined; steps of each, before the best goes on
ROUNDS = 3  # of the search at most, each from twice as many points, until chance explains the misfit or two agree
AGREE = 0.01  # mean squares by which rounds that end in the same minimum may differ: a tenth of a standard error
UNLIKELY = 1e-3  # probability of a misfit, if errors are as known, below which it is improbable
KINDS = ("factor", "reversal", "offset")  # of a correction of a column


class TableModel:
    """Predictions of a table by settled runs, at points of the unit cube of the unknowns.

    corrected: None, or (column, kind) of a column that one more coordinate c corrects: a factor exp(c), a reversal
    -exp(c), an offset of c standard deviations of the column
    """

    def __init__(
        self,
        system: System,
        table: MeasuredTable,
        space: DesignSpace,
        runs: Mapping[str, Any],
        rows: np.ndarray,
        corrected: tuple[str, str] | None = None,
    ):
        self.system, self.table, self.space, self.runs, self.rows = system, table, space, dict(runs), rows
        self.corrected = corrected
        self.scales = [measure_unit(system, name)[1] for name in table.measures]
        self.errors = np.stack([table.errors[name] for name in table.measures])

    @property
    def coordinates(self) -> int:
        return len(self.space.paths) + (self.corrected is not None)

    def _correct(self, name: str, column: np.ndarray, size: np.ndarray) -> np.ndarray:
        """A column [..., rows] corrected by coordinates [points]."""
        if self.corrected is None or self.corrected[0] != name:
            return column
        amount = self.correction(size)[:, None]
        return column + amount if self.corrected[1] == "offset" else column * amount

    def correction(self, size: Any) -> Any:
        """The amount of the correction at its coordinate: a factor of either sign, or an offset in its unit."""
        assert self.corrected is not None
        name, kind = self.corrected
        if kind == "offset":
            return size * float(np.std(self.table.column(name)))
        return np.exp(size) * (-1.0 if kind == "reversal" else 1.0)

    def predicted(self, points: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, Trust]:
        """(predictions [points, measures, rows] in the table's units, their trust [points, rows]).

        Rows of the same conditions are one run.
        """
        many, unknowns = len(points), len(self.space.paths)
        size = points[:, unknowns] if self.corrected else np.zeros(many)
        own, group = np.unique(self.table.alike[rows], return_inverse=True)
        over = {path: np.repeat(x, len(own)) for path, x in self.space.values(points[:, :unknowns]).items()}
        for path, column in self.table.conditions.items():
            over[path] = self._correct(path, np.tile(column[own], (many, 1)), size).ravel()
        try:
            runs = ensemble(self.system, over, measures=self.table.measures, **self.runs)
        except ValueError:  # a part refuses a point
            if many == 1:
                refused = Trust(np.full((1, len(rows)), REFUSED), np.zeros((1, len(rows)), dtype=bool))
                return np.full((1, len(self.scales), len(rows)), np.nan), refused
            values, trusts = zip(*(self.predicted(point[None], rows) for point in points), strict=True)
            status, settled = zip(*((trust.status, trust.settled) for trust in trusts), strict=True)
            return np.concatenate(values), Trust(np.concatenate(status), np.concatenate(settled))
        by_row = {name: runs[name].reshape(many, -1)[:, group] for name in ("status", "settled", *self.table.measures)}
        trust, values = Trust(by_row["status"], by_row["settled"]), []
        for name, scale in zip(self.table.measures, self.scales, strict=True):
            values.append(np.where(trust.finished, scale * by_row[name], 0.0 if name in TRAVEL else np.nan))
        return np.stack(values, axis=1), trust

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """[points, measures * rows] predicted less measured, in standard errors, of the fitted rows."""
        values, _ = self.predicted(points, self.rows)
        many, unknowns = len(points), len(self.space.paths)
        size = points[:, unknowns] if self.corrected else np.zeros(many)
        targets = {name: np.tile(self.table.targets[name][self.rows], (many, 1)) for name in self.table.measures}
        measured = np.stack([self._correct(name, column, size) for name, column in targets.items()], axis=1)
        residuals = (values - measured) / self.errors[:, self.rows]
        worst = FAILED_ROW[1] * np.max(np.abs(measured), axis=2, keepdims=True) / self.errors[:, self.rows]
        residuals = np.where(np.isfinite(residuals), residuals, np.maximum(worst, FAILED_ROW[0]))
        if self.corrected and self.corrected[0] in self.table.measures and self.corrected[1] != "offset":
            k = self.table.measures.index(self.corrected[0])
            residuals[:, k] /= np.exp(size)[:, None]  # its errors are scaled with it
        return residuals.reshape(many, -1)

    def slopes(self, point: np.ndarray) -> np.ndarray:
        """[measures * rows, coordinates] of the residuals, by differences within the bounds."""
        below, above = self.beside(point)
        residuals = self.residuals(np.concatenate((below, above)))
        widths = np.diag(above - below)
        return (residuals[len(point) :] - residuals[: len(point)]).T / np.where(widths > 0.0, widths, np.inf)

    def beside(self, point: np.ndarray) -> np.ndarray:
        """[2, coordinates, coordinates] the points a step below and above a point along each coordinate."""
        unbounded = np.arange(len(point)) >= len(self.space.paths)
        bounds = np.where(unbounded, -np.inf, 0.0), np.where(unbounded, np.inf, 1.0)
        pairs = [beside(point, i, STEP, bounds, self._refuses) for i in range(len(point))]
        return np.stack(pairs, axis=1)

    def _refuses(self, point: np.ndarray) -> bool:
        return bool(refusal(self.system, self.space.parameters(point[: len(self.space.paths)])))


def refused_rows(system: System, table: MeasuredTable, space: DesignSpace) -> list[str]:
    """What a part refuses of the conditions of a row, whatever the unknowns are; of each quantity the first row."""
    points = [np.full(len(space.paths), 0.5), *sample_points(len(space.paths), REFUSALS, 0)]
    complaints: dict[str, Complaint] = {}
    for row in map(int, np.unique(table.alike)):
        conditions = {path: float(column[row]) for path, column in table.conditions.items()}
        refusals = (refusal(system, space.parameters(point) | conditions) for point in points)
        refused = list(itertools.takewhile(bool, refusals))
        texts = refused[0] if len(refused) == len(points) else ()
        for old in (text for text in texts if isinstance(text, Complaint)):
            complaints.setdefault(old.field, Complaint(old.field, f"{old.text} in row {row + 1}"))
    return list(complaints.values())


def beside(
    point: np.ndarray, i: int, step: float, bounds: tuple[np.ndarray, np.ndarray], refuses: Callable[..., bool]
) -> tuple[np.ndarray, np.ndarray]:
    """The points a step below and above a point along a coordinate, or the point where a bound or a part is nearer."""
    pair = []
    for sign in (-1.0, 1.0):
        moved = point.copy()
        moved[i] = np.clip(point[i] + sign * step, bounds[0][i], bounds[1][i])
        pair.append(point if refuses(moved) else moved)
    return pair[0], pair[1]


def searched(model: TableModel, starts: int, seed: int, report: Any) -> np.ndarray:
    """The best point of the unit cube, searched again from more points until it is no chance that it is the best.

    It is not where chance explains its misfit, or where two rounds, from points of their own, end with it.
    """
    best = np.inf, np.zeros(model.coordinates)
    for k in range(ROUNDS):
        points = sample_points(model.coordinates, starts * 2**k, seed + k)
        costs = np.sum(soft(model.residuals(points)), axis=1)
        begun = [points[place] for place in np.argsort(costs, kind="stable")[: BEGUN * 2**k]]
        ends = [refined(model, point, "soft_l1", FIRST_STEPS)[1] for point in begun]
        near = min(ends, key=lambda end: float(np.sum(soft(model.residuals(end[None])))))
        end = refined(model, near)
        again = abs(end[0] - best[0]) <= AGREE * end[0] / len(model.rows)
        best = min(best, end, key=lambda minimum: minimum[0])
        if report:
            report((k + 1) / ROUNDS)
        if again or (chance(model, best[0]) or 0.0) >= UNLIKELY:
            break
    return best[1]


def chance(model: TableModel, squares: float) -> float | None:
    """Probability of so large a sum of squares where the model holds; None where nothing says how large errors are.

    Errors are given (chi^2), or repeated rows show them: then what the model leaves beside their scatter is compared
    with it (F, the test of lack of fit).
    """
    from scipy.stats import chi2, f

    spare = len(model.rows) * len(model.scales) - model.coordinates
    if model.table.with_errors:
        return float(chi2.sf(squares, spare))
    scatter, freedom = model.table.scatter(model.rows)
    if scatter == 0.0 or spare <= freedom:
        return None
    return float(f.sf((squares - scatter) / (spare - freedom) / (scatter / freedom), spare - freedom, freedom))


def improbable(model: TableModel, squares: float) -> bool:
    """Whether a sum of squared residuals is larger than chance explains, or no less than that of constants."""
    known = chance(model, squares)
    if known is not None:
        return known < UNLIKELY
    measured = [(model.table.targets[name] / model.table.errors[name])[model.rows] for name in model.table.measures]
    return squares >= sum(float(np.sum((value - np.mean(value)) ** 2)) for value in measured)


def outlying(model: TableModel, residuals: np.ndarray, slopes: np.ndarray) -> tuple[int, ...]:
    """Numbers of fitted rows that are farther from what the others say than chance explains (Bonferroni).

        t = r (n/((1 - h) (s - r^2/(1 - h))))^(1/2)        externally studentised residual, Cook and Weisberg 1982

    r, h: residual and its leverage; s: sum of all r^2; n: spare values without it. A thousandth of the column's own
    deviation stands out of nothing.
    """
    from scipy.special import stdtr

    base, sizes, _ = np.linalg.svd(slopes, full_matrices=False)
    free = np.maximum(1.0 - np.sum(base[:, sizes > 1e-9 * sizes[0]] ** 2, axis=1), 1e-9)
    spare = len(residuals) - slopes.shape[1] - 1
    others = np.maximum(np.sum(residuals**2) - residuals**2 / free, 1e-300)
    chances = 2.0 * stdtr(max(spare, 1), -np.abs(residuals) * np.sqrt(spare / (free * others)))
    least = [1e-3 * np.std(model.table.targets[name]) / model.table.errors[name] for name in model.table.measures]
    far = np.abs(residuals) > np.concatenate([column[model.rows] for column in least])
    places = np.flatnonzero(far & (chances * len(residuals) < UNLIKELY)) % len(model.rows)
    return tuple(np.unique(model.rows[places]).tolist())


def soft(residuals: np.ndarray) -> np.ndarray:
    """Half a square, and linear where far off: few rows, or a motion that soon goes wrong, do not decide the start."""
    return np.sqrt(1.0 + residuals**2) - 1.0


def refined(model: TableModel, point: np.ndarray, loss: str = "linear", steps: int = 60) -> tuple[float, np.ndarray]:
    """(sum of squares, point) of the minimum near a point."""
    from scipy.optimize import least_squares

    own = np.arange(model.coordinates) < len(model.space.paths)
    low, high = np.where(own, 0.0, -10.0), np.where(own, 1.0, 10.0)
    begun, how = np.clip(point, low + 1e-9, high - 1e-9), {"jac": model.slopes, "bounds": (low, high)}
    until: dict[str, Any] = {"max_nfev": steps, "xtol": 1e-9, "ftol": 1e-9}
    minimum = least_squares(lambda x: model.residuals(x[None])[0], begun, loss=loss, **how, **until)
    return float(np.sum(model.residuals(minimum.x[None]) ** 2)), minimum.x


SUSPECT = 1e-4  # probability, over all columns, below which chance does not explain what a correction explains
GAIN = 0.3  # least share of the misfit that a wrong column has to explain
STARTS, LARGEST = 128, 0.6  # points from which a correction is looked for, and its largest size there
UNITS = np.log([2.0 * np.pi, 60.0, 180.0 / np.pi, 10.0, 100.0, 1000.0])  # factors of units that are confused: Hz, rad/s
REFINED = 2  # of them that are refined at first, and corrections that are refined to the end


@dataclasses.dataclass(frozen=True)
class ColumnDoubt:
    """What would explain a misfit: a column that is off by a factor or an offset, and by how much.

    kind: "factor" or "offset"; size: by which the column would have to be corrected, a factor below 0 where its axis
        points the other way; probability: that chance explains as much; gain: share of the misfit that it explains
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
    known = chance(model, before)
    if spare < 1 or (known is not None and known >= UNLIKELY):
        return None
    names = [*model.table.conditions, *model.table.measures]
    corrections = [(name, kind) for name in names for kind in KINDS if kind != "reversal" or _reversible(model, name)]
    same = model.system, model.table, model.space, model.runs, model.rows
    begun = [_begun(TableModel(*same, corrected), shares) for corrected in corrections]
    tried: list[ColumnDoubt] = []
    for _, other, near in sorted(begun, key=lambda pair: pair[0])[:REFINED]:
        after, point = refined(other, near)
        assert other.corrected is not None
        name, kind = other.corrected
        ratio = (before - after) / (after / spare)
        probability = float(f_distribution.sf(max(ratio, 0.0), 1, spare)) * len(begun)
        if np.all(other.predicted(point[None], model.rows)[1].ok):
            kind, size = "offset" if kind == "offset" else "factor", float(other.correction(point[-1]))
            tried.append(ColumnDoubt(name, kind, size, min(probability, 1.0), 1.0 - after / before))
    best = max(tried, key=lambda doubt: doubt.gain, default=None)
    return best if best and best.probability < SUSPECT and best.gain > GAIN else None


def _reversible(model: TableModel, name: str) -> bool:
    """Whether a column may have the wrong sign: what travels, and parameters that may be negative."""
    if name not in model.table.conditions:
        return name in TRAVEL
    return not refusal(model.system, {name: -float(np.max(np.abs(model.table.column(name))))})


def _begun(model: TableModel, shares: np.ndarray) -> tuple[float, TableModel, np.ndarray]:
    """(cost, model, point) of a correction after its first steps: a wrong column may have led the search far away."""
    points = sample_points(model.coordinates, STARTS, 0)
    points[:, -1] = LARGEST * (2.0 * points[:, -1] - 1.0)
    if model.corrected and model.corrected[0] in model.table.conditions and model.corrected[1] == "factor":
        units = np.resize(np.append(UNITS, -UNITS), 2 * STARTS)  # too far for slopes to lead there
        points = np.concatenate([points, np.column_stack([sample_points(len(shares), len(units), 0), units])])
    points = np.concatenate([points, [np.append(shares, size) for size in (0.0, 0.5 * LARGEST, -0.5 * LARGEST)]])
    order = np.argsort(np.sum(soft(model.residuals(points)), axis=1), kind="stable")
    ends = [refined(model, points[k], "soft_l1", FIRST_STEPS)[1] for k in order[:REFINED]]
    costs = [float(np.sum(soft(model.residuals(end[None])))) for end in ends]
    best = int(np.argmin(costs))
    return costs[best], model, ends[best]
