"""Bootstrap: how parameters scatter when the fit sees the records, or stretches of them, in other numbers."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.result.fit_result import Chapter, Fit, number
from vibrocap.identification.search.descent import warm_descent
from vibrocap.identification.search.loss import Minimum
from vibrocap.progress import Progress, reporting
from vibrocap.results import Result

FEWEST_RECORDS = 4
BLOCKS = 20  # stretches that a single record is cut into
LARGE = 10_000  # samples from which thinned records are fitted, and sampled
ENDS = (0.025, 0.975)  # of an interval


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Bootstrap(Result):
    """Parameters of repeated fits to records (or stretches) drawn with replacement.

    names [p]; values [replicates, p]; over: "records" or "blocks"; low, high: percentile intervals (95 %) by name;
    failed: replicates that did not settle, which are left out.
    """

    names: tuple[str, ...]
    values: np.ndarray
    over: str
    low: Mapping[str, float]
    high: Mapping[str, float]
    failed: int

    in_record = "over values low high failed"

    @property
    def chapter(self) -> Chapter:
        """Its intervals, in words."""
        rows = [(name, f"{number(self.low[name], 4)} to {number(self.high[name], 4)}") for name in self.names]
        title = f"in {len(self.values)} refits of {self.over}"
        return Chapter(title, ("95 % of the values",), rows)


def bootstrap(
    fit: Fit, *, replicates: int = 200, over: str | None = None, seed: int = 0, progress: Progress = None
) -> Bootstrap:
    """Bootstrap the parameters of a finished fit, each replicate searched from the fit's own minimum.

    over: "records" draws whole records, which asks for at least four; "blocks" draws stretches of each record (20 of
    them, so that stretches are longer than the errors' correlation where that is below a twentieth of the record).
    The law is driven through whole records in either case; drawn is how often a sample counts.
    None: records where there are four.
    progress: True for a bar, or a function that is called with the share done
    What it tells beyond the profiles: whether records want different parameters, with no model of their errors.
    """
    if fit.problem is None or not fit.ok:
        raise ArgumentError(
            "fit", "should be a fit of this session that found a law; fit again after reading one from a file"
        )
    check_whole("replicates", replicates, 10)
    problem = fit.problem
    count = len(problem.prediction.records)
    over = over or ("records" if count >= FEWEST_RECORDS else "blocks")
    if over not in ("records", "blocks"):
        raise ArgumentError("over", f"should be 'records' or 'blocks', got {over!r}")
    if over == "records" and count < 2:
        raise ArgumentError("over", "'records' needs several records; there is one, use 'blocks'")
    base = problem.draft if problem.prediction.size > LARGE else problem.prediction
    rng = np.random.default_rng(seed)
    begin = _refit(base, problem.best.u, problem)
    columns = [base.space.names.index(name) for name in base.law_names]
    refits = []
    with reporting(progress, "Refitting") as report:
        for done in range(replicates):
            minimum = _refit(_drawn(base, over, rng), begin.u, problem)
            if np.isfinite(minimum.cost):
                refits.append(base.space.values(minimum.u)[columns])
            if report is not None:
                report((done + 1) / replicates)
    values = np.array(refits)
    low, high = (dict(zip(base.law_names, end, strict=True)) for end in np.quantile(values, ENDS, axis=0).tolist())
    return Bootstrap(base.law_names, values, over, low, high, replicates - len(refits))


def _drawn(prediction: Prediction, over: str, rng: np.random.Generator) -> Prediction:
    """The same records, in which a sample that was drawn k times counts k times: its unit is infinite for none."""

    def counts(number: int) -> np.ndarray:
        return np.bincount(rng.integers(0, number, number), minlength=number)

    records = prediction.records
    if over == "records":
        drawn = list(counts(len(records)))
    else:
        drawn = [counts(BLOCKS)[np.arange(len(record)) * BLOCKS // len(record)] for record in records]
    with np.errstate(divide="ignore"):
        return prediction.of(
            records, [unit / np.sqrt(count) for unit, count in zip(prediction.units, drawn, strict=True)]
        )


def _refit(prediction: Prediction, start: np.ndarray, problem: Problem) -> Minimum:
    """The minimum of all coordinates near a start."""
    slopes = prediction.slopes(start)
    return warm_descent(prediction, start, slopes, problem.loss, held=-1, evaluations=40, stop=1e-6)
