"""Column doubts: a column of a measured table whose factor, sign or offset is wrong."""

import dataclasses

import numpy as np

from vibrocap.design.calibration.table_model import FIRST_STEPS, KINDS, UNLIKELY, TableModel, chance, refined, soft
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.motion.trust import TRAVEL
from vibrocap.studies.plan.variation import refusal

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
    begun = [_begun(model.with_corrected(name, kind), shares) for name, kind in corrections]
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
