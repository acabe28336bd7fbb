"""A measured table as least squares: its settled runs at any values of the unknowns, and the search for the best."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.design.calibration.table import MeasuredTable
from vibrocap.design.search.goal import measure_unit
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.design.search.variables import DesignSpace
from vibrocap.measures.ensemble import FINISHED, ensemble
from vibrocap.motion.trust import TRAVEL
from vibrocap.physics.system import System

STEP = 1e-4  # of the differences that give slopes, in shares of the ranges
FAILED_ROW = 1e3  # residual of a run without a value, in standard errors
BEGUN, FIRST_STEPS = 4, 15  # candidates that are refined; steps of each, before the best goes on
ROUNDS = 3  # of the search, each from twice as many points, while the misfit is improbable
UNLIKELY = 1e-3  # probability of a misfit, if errors were as given, below which it is improbable


class TableModel:
    """Predictions of a table by settled runs, at points of the unit cube of the unknowns.

    corrected: None, or (column, kind) of a column that one more coordinate corrects: a factor exp(c), an offset c in
    standard deviations of the column
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

    def with_corrected(self, column: str, kind: str) -> "TableModel":
        """The same with one more coordinate, that corrects a column."""
        return TableModel(self.system, self.table, self.space, self.runs, self.rows, (column, kind))

    def _correct(self, name: str, column: np.ndarray, size: np.ndarray) -> np.ndarray:
        """A column [..., rows] corrected by coordinates [points]."""
        if self.corrected is None or self.corrected[0] != name:
            return column
        if self.corrected[1] == "factor":
            return column * np.exp(size)[:, None]
        return column + (size * float(np.std(self.table.column(name))))[:, None]

    def predicted(self, points: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(predictions [points, measures, rows] in the table's units, whether each run finished [points, rows])."""
        many, unknowns = len(points), len(self.space.paths)
        size = points[:, unknowns] if self.corrected else np.zeros(many)
        over = {path: np.repeat(x, len(rows)) for path, x in self.space.values(points[:, :unknowns]).items()}
        for path, column in self.table.conditions.items():
            over[path] = self._correct(path, np.tile(column[rows], (many, 1)), size).ravel()
        try:
            found = ensemble(self.system, over, measures=self.table.measures, **self.runs)
        except ValueError:  # a part refuses a point
            if many == 1:
                return np.full((1, len(self.scales), len(rows)), np.nan), np.zeros((1, len(rows)), dtype=bool)
            each = [self.predicted(point[None], rows) for point in points]
            return np.concatenate([one[0] for one in each]), np.concatenate([one[1] for one in each])
        finished = (found["status"] == FINISHED).reshape(many, -1)
        values = [
            np.where(finished, scale * found[name].reshape(many, -1), 0.0 if name in TRAVEL else np.nan)
            for name, scale in zip(self.table.measures, self.scales, strict=True)
        ]
        return np.stack(values, axis=1), finished

    def residuals(self, points: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
        """[points, measures * rows] predicted less measured, in standard errors."""
        rows = self.rows if rows is None else rows
        values, _ = self.predicted(points, rows)
        unknowns = len(self.space.paths)
        size = points[:, unknowns] if self.corrected else np.zeros(len(points))
        measured = np.stack(
            [
                self._correct(name, np.tile(self.table.targets[name][rows], (len(points), 1)), size)
                for name in self.table.measures
            ],
            axis=1,
        )
        found = (values - measured) / self.errors[:, rows]
        found = np.where(np.isfinite(found), found, FAILED_ROW)
        if self.corrected and self.corrected[0] in self.table.measures and self.corrected[1] == "factor":
            k = self.table.measures.index(self.corrected[0])
            found[:, k] /= np.exp(size)[:, None]  # its errors are scaled with it
        return found.reshape(len(points), -1)

    def slopes(self, point: np.ndarray) -> np.ndarray:
        """[measures * rows, coordinates] of the residuals, by differences within the bounds."""
        many = len(point)
        steps = np.tile(point, (2 * many, 1))
        for i in range(many):
            low, high = (0.0, 1.0) if i < len(self.space.paths) else (-np.inf, np.inf)
            steps[2 * i, i] = max(point[i] - STEP, low)
            steps[2 * i + 1, i] = min(point[i] + STEP, high)
        found = self.residuals(steps)
        widths = [steps[2 * i + 1, i] - steps[2 * i, i] for i in range(many)]
        return np.stack([(found[2 * i + 1] - found[2 * i]) / widths[i] for i in range(many)], axis=1)


def searched(model: TableModel, starts: int, seed: int, report: Any) -> np.ndarray:
    """The best point of the unit cube, searched again from more points while errors as given make it improbable."""
    best = np.inf, np.zeros(model.coordinates)
    for k in range(ROUNDS):
        points = sample_points(model.coordinates, starts * 2**k, seed + k)
        costs = np.sum(soft(model.residuals(points)), axis=1)
        begun = [points[place] for place in np.argsort(costs, kind="stable")[: BEGUN * 2**k]]
        ends = [refined(model, point, "soft_l1", FIRST_STEPS)[1] for point in begun]
        near = min(ends, key=lambda end: float(np.sum(soft(model.residuals(end[None])))))
        best = min(best, refined(model, near), key=lambda found: found[0])
        if report:
            report((k + 1) / ROUNDS)
        if not (model.table.with_errors and improbable(model, best[0])):
            break
    return best[1]


def improbable(model: TableModel, squares: float) -> bool:
    """Whether a sum of squared residuals is larger than chance explains, if errors were as given."""
    from scipy.stats import chi2

    return bool(chi2.sf(squares, len(model.rows) * len(model.scales) - model.coordinates) < UNLIKELY)


def soft(residuals: np.ndarray) -> np.ndarray:
    """Half a square, and linear where far off, so that a few rows do not decide where to begin."""
    return np.sqrt(1.0 + residuals**2) - 1.0


def refined(model: TableModel, point: np.ndarray, loss: str = "linear", steps: int = 60) -> tuple[float, np.ndarray]:
    """(sum of squares, point) of the minimum near a point."""
    from scipy.optimize import least_squares

    unknowns = len(model.space.paths)
    low = np.concatenate([np.zeros(unknowns), np.full(model.coordinates - unknowns, -10.0)])
    high = np.concatenate([np.ones(unknowns), np.full(model.coordinates - unknowns, 10.0)])
    found = least_squares(
        lambda x: model.residuals(x[None])[0],
        np.clip(point, low + 1e-9, high - 1e-9),
        jac=model.slopes,  # type: ignore[arg-type]
        bounds=(low, high),
        loss=loss,
        max_nfev=steps,
        xtol=1e-9,
        ftol=1e-9,
    )
    return float(np.sum(model.residuals(found.x[None]) ** 2)), found.x
