"""Wrong columns of a measured table: a factor or an offset that explains what chance does not."""

import dataclasses

import numpy as np

from vibrocap.design.calibration.table_model import FIRST_STEPS, TableModel, improbable, refined, soft
from vibrocap.design.search.uncertainty import sample_points

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
