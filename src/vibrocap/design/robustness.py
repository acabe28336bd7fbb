"""robustness(system, uncertain=...): how sure a measure is where friction, machine or ground are not known exactly."""

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from vibrocap.arguments import Complaint, Complaints, check_whole
from vibrocap.case.case import Case, CaseError
from vibrocap.design.search.problem import asked_case, goal_of, measure_unit
from vibrocap.design.search.uncertainty import TAIL, sample_points, sampled, uncertain_quantities
from vibrocap.design.search.variables import made_through, refusal_among, through_complaints
from vibrocap.measures.ensemble import ensemble, residues
from vibrocap.measures.measure import Measure
from vibrocap.measures.standard import standard_measures, undefined_measures
from vibrocap.motion.simulate import initial_state
from vibrocap.motion.trust import NOT_SETTLED, Trust
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress
from vibrocap.quantities.declared import ByName, Number, NumberInUnit, Numbers, NumbersInUnit
from vibrocap.results import Result

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RESAMPLES = 999  # of the bootstrap of Sobol indices


class SobolIndex(NamedTuple):
    """A share of the variance, with its 95 % interval."""

    share: Number
    low: Number
    high: Number


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Robustness(Result):
    """What becomes of a measure where some quantities are uncertain.

    nominal: of the system itself, NaN where its run is not to be trusted; of a measure of travel all values are along
        the nominal direction, where there is one
    nominal_doubt: why the nominal run has no value or no direction: a status, "not settled" or "no travel"; else empty
    values: [samples] of the measure; `failed_as` for failed runs, NaN for unsettled ones; parameters: [samples] by path
    tail_mean: the mean of the worst tenth, the conditional value at risk (Rockafellar and Uryasev 2000); as mean,
        deviation, quantiles and worst over the samples that have a value
    failed: share of the samples whose run failed, by status; not_settled: share of those that had not settled;
    wrong_way: share that travels against the nominal direction by more than its residue (`motion.trust`), or None
    failed_as: value of a failed run in the numbers above: 0 of travel, else NaN, which they exclude
    first_order, total: Sobol indices by quantity, the share of the variance that it alone explains, and that would
        vanish if all others were known (Saltelli 2010), each with a 95 % interval (value, low, high); None where any
        run is not to be trusted, or nothing varies by more than its residue
    """

    measure: str
    unit: str
    nominal: NumberInUnit
    nominal_doubt: str
    parameters: dict[str, Numbers]
    values: NumbersInUnit
    failed: dict[str, Number]
    not_settled: Number
    wrong_way: Number | None
    failed_as: Number
    worst_is_least: bool
    first_order: dict[str, SobolIndex] | None
    total: dict[str, SobolIndex] | None

    in_record = (
        "measure nominal nominal_doubt mean deviation worst tail_mean quantiles wrong_way failed not_settled "
        "first_order total"
    )

    def _of_values(self, statistic: Callable[[np.ndarray], Any], least: int = 1) -> float:
        """A statistic of the samples that have a value, NaN where these are fewer than `least`."""
        finite = self.values[~np.isnan(self.values)]
        with np.errstate(invalid="ignore"):  # some may be infinite, as the cost of no travel is
            return float(statistic(finite)) if len(finite) >= least else float("nan")

    @property
    def mean(self) -> NumberInUnit:
        return self._of_values(np.mean)

    @property
    def deviation(self) -> NumberInUnit:
        return self._of_values(lambda x: np.std(x, ddof=1), 2)

    @property
    def quantiles(self) -> dict[Number, NumberInUnit]:
        """Values that the share of samples given by each key stays below."""
        how: Any = {"method": "higher" if np.any(np.isinf(self.values)) else "linear"}
        return {share: self._of_values(lambda x, share=share: np.quantile(x, share, **how)) for share in QUANTILES}

    @property
    def worst(self) -> NumberInUnit:
        return self._of_values(np.min if self.worst_is_least else np.max)

    @property
    def tail_mean(self) -> NumberInUnit:
        order = 1 if self.worst_is_least else -1
        return self._of_values(lambda x: np.mean(np.sort(x)[::order][: int(np.ceil(TAIL * len(x)))]))

    @property
    def most_influential(self) -> str | None:
        """The quantity to know better: that with the largest total index; None where there are none."""
        return max(self.total, key=lambda name: self.total[name][0]) if self.total else None  # type: ignore[index]

    @property
    def heading(self) -> str:
        return f"robustness of {self.measure}"

    @property
    def facts(self) -> dict[str, str]:
        unit = "" if self.unit == "1" else f" {self.unit}"
        low, *_, high = self.quantiles.values()
        facts = {
            "nominal": f"{self.nominal:.8g}{unit}" + (f" ({self.nominal_doubt})" if self.nominal_doubt else ""),
            "mean": f"{self.mean:.6g}{unit}, deviation {self.deviation:.3g}{unit}",
            "90 % within": f"{low:.6g} to {high:.6g}{unit}",
            "worst": f"{self.worst:.6g}{unit}, mean of the worst tenth {self.tail_mean:.6g}{unit}",
        }
        if self.wrong_way is not None:
            facts["wrong way"] = f"{100.0 * self.wrong_way:.3g} % of {len(self.values)} samples"
        if self.failed:
            facts["failed"] = ", ".join(f"{100.0 * share:.3g} % {status}" for status, share in self.failed.items())
        if self.not_settled:
            facts["not settled"] = f"{100.0 * self.not_settled:.3g} %"
        if self.total and (name := self.most_influential):
            facts["to know better"] = f"{name} (total index {self.total[name][0]:.3g})"
        return facts

    def table(self) -> list[dict[str, Any]]:
        """A row for each sample: the uncertain quantities and the measure."""
        columns = self.parameters | {self.measure: self.values}
        return [dict(zip(columns, row, strict=True)) for row in np.transpose(list(columns.values())).tolist()]


@shows_progress("Sampling the uncertain quantities")
def robustness(
    system: System | Case,
    uncertain: Mapping[Any, Any],
    measure: str | Measure = "mean_velocity",
    *,
    through: Callable[..., Mapping[str, Any]] | None = None,
    initial: ByName | None = None,
    samples: int = 256,
    seed: int = 0,
    periods: int = 300,
    settle: float = 1e-6,
    tolerance: float = 1e-8,
    threads: int | None = None,
    progress: Progress = None,
) -> Robustness:
    """The distribution of a measure of the settled motion under uncertain quantities.

    uncertain: {path: distribution}, in SI where the system is: "LOW:HIGH" or (low, high) for uniform,
        "normal:MEAN:DEVIATION", "lognormal:MEDIAN:SIGMA" (sigma of the logarithm), or a frozen distribution of
        scipy.stats. With "factor:" before it, the distribution is that of a factor of the system's own value, which
        several paths may share: {"friction.coulomb_coefficient,friction.static_coefficient": "factor:0.8:1.2"}.
        {"friction": fit}, or "fit:fit.json", takes the joint uncertainty that a fit of the law leaves, about its values
    through: None, or a function of quantities of one's own: `uncertain` then names its arguments, it is called with an
        array [n] of each and returns arrays by path: `through=lambda mu: {"machine.mass_ratio": 1.0 / mu - 1.0}`
    measure: one that is a number; initial: the start of all runs, by default that of the case
    samples: a power of two; samples x (quantities + 2) runs give the Sobol indices, 2 x samples of them the
        distribution
    seed: the same one gives the same samples; periods, settle, tolerance, threads: see `ensemble`

    A run that lifts off or fails otherwise counts as no travel of a measure of travel; one that has not settled within
    `periods` has no value. Raises CaseError with every complaint about system, uncertain and measure, before any work.
    """
    complaints = Complaints()
    case = asked_case(system, settle, complaints, seed=(seed, 0))
    system = case.system
    goal, measures = goal_of(system, measure, None, (), complaints, ("measure", "sense"))
    lacking = measure == goal.measure not in standard_measures(system) or goal.measure in undefined_measures(system)
    if lacking and not complaints:
        complaints.add("measure", f"{goal.measure}: no motion of this system has it")
    quantities = uncertain_quantities(system, uncertain, complaints, own=through is not None)
    with complaints.collected():
        check_whole("samples", samples, 8, 2**20)
        if samples & (samples - 1):
            complaints.add("samples", f"should be a power of two, got {samples}")
    with complaints.collected():
        initial_state(system, case.initial if initial is None else initial)
    if complaints:
        raise CaseError(complaints, "the question")
    many = len(quantities)
    first, second = np.split(sample_points(2 * many, samples, seed), 2, axis=1)
    mixed = [np.where(np.arange(many) == i, second, first) for i in range(many)]
    over = drawn = sampled(quantities, np.concatenate([first, second, *mixed]))
    if through is not None:
        made = functools.partial(made_through, through, drawn, (2 + many) * samples)
        if wrong := through_complaints(system, drawn, made):
            raise CaseError(wrong, "the question")
        over = made()
    over = {path: np.append(column, system.parameter(path)) for path, column in over.items()}  # the nominal run, last
    until: dict[str, Any] = {"periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    begun = dict(case.initial if initial is None else initial)
    try:
        runs = ensemble(system, over, measures=measures, initial=begun, **until)
    except ValueError:  # before any work
        if refused := refusal_among(system, over):
            raise CaseError([Complaint("uncertain", text) for text in refused], "the question") from None
        raise
    unit, scale = measure_unit(system, measures[0])
    values = scale * runs[goal.measure].astype(float)
    trust = Trust.of_runs(runs, scale * residues(system, over, goal.measure, settle))
    directions = trust.direction(values)
    nominal_doubt = trust.doubt(-1) or ("no travel" if goal.travels and directions[-1] == 0.0 else "")
    directed = goal.travels and not nominal_doubt
    if directed and directions[-1] < 0.0:
        values, directions = -values, -directions
    failed_as = 0.0 if goal.travels else float("nan")
    shown = np.where(trust.finished, trust.known(values), failed_as)
    counted = slice(0, 2 * samples)
    indices = _sobol_indices(values[:-1], samples, quantities, seed) if trust[:-1].differ(values[:-1]) else (None, None)
    doubts = trust[counted].doubts
    return Robustness(
        measure=goal.measure,
        unit=unit,
        nominal=float(trust.known(values)[-1]),
        nominal_doubt=nominal_doubt,
        parameters={name: column[counted] for name, column in drawn.items()},
        values=shown[counted],
        not_settled=doubts.pop(NOT_SETTLED, 0.0),
        failed=doubts,
        wrong_way=float(np.mean(directions[counted] < 0.0)) if directed else None,
        failed_as=failed_as,
        worst_is_least=goal.maximise,
        first_order=indices[0],
        total=indices[1],
    )


def _sobol_indices(values: np.ndarray, samples: int, quantities: Any, seed: int) -> tuple[Any, Any]:
    """(first-order, total) Sobol indices with intervals, by quantity, of finite values.

        S = <b (ab - a)>/s^2,   T = <(a - ab)^2>/(2 s^2)        Saltelli et al. 2010, table 2 (b) and (f)

    a, b: values of two samples of all quantities; ab: of the first with one quantity of the second; s^2: variance of
    both. The intervals are those of a bootstrap of the samples (percentiles).
    """
    if len(quantities) == 1:  # all variance is its own
        whole = {quantities[0].name: SobolIndex(1.0, 1.0, 1.0)}
        return whole, whole
    first, second, *mixed = values.reshape(-1, samples) - np.mean(values[: 2 * samples])

    def indices(members: np.ndarray) -> np.ndarray:
        a, b, ab = first[members], second[members], np.stack(mixed)[:, members]
        return np.array([np.mean(b * (ab - a), axis=-1), 0.5 * np.mean((a - ab) ** 2, axis=-1)]) / np.var([a, b])

    generator = np.random.default_rng(seed)
    drawn = [indices(generator.integers(samples, size=samples)) for _ in range(RESAMPLES)]
    ends = np.quantile(drawn, (0.025, 0.975), axis=0)
    rows = np.stack([indices(np.arange(samples)), *ends], axis=-1).tolist()
    return tuple(
        {quantity.name: SobolIndex(*row) for quantity, row in zip(quantities, table, strict=True)} for table in rows
    )  # type: ignore[return-value]
