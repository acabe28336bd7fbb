"""Samples of the parameters of a fit: draws from their posterior by an ensemble of walkers, and refits (bootstrap).

The density is exp(-cost/s^2) as in the profiles, with priors, flat in the coordinates of the search (logarithms of
positive parameters) within their bounds. Errors that are correlated count as their correlation times say: with tau_j of
coordinate j and T, the geometric mean of all,

    ln density(u) = -cost(u*)/(s^2 T),    u*_j = best_j + (u_j - best_j) sqrt(T/tau_j)

has the covariance of `uncertainty` where the fit is linear, and the shape of the cost elsewhere.

Walkers move by differences of others (ter Braak 2006), at times by a whole one, from mode to mode. Near a normal
density this takes a third of the steps of stretches; the program is emcee (Foreman-Mackey et al. 2013). Its snooker
moves are left out: they draw towards the mean, and deviations come out small.
"""

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, require, suggestion
from vibrocap.identification.fit_result import Chapter, Fit, number
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.prediction import Prediction, steady_force
from vibrocap.identification.search import finite, warm_descent
from vibrocap.progress import Progress, reporting
from vibrocap.results import Result

WALKERS, LEAST = 3, 24  # walkers a coordinate, and in all
ENOUGH = 50  # correlation times, after which the length of a chain is known (Foreman-Mackey et al. 2013)
BURNT, BLOCK, LONGEST = 5, 100, 4000  # correlation times left out at first; steps between looks, and in all


class Source:
    """What is sampled: the cost of coordinates about its minimum, and what follows from them.

    names: of the parameters; begin [p], spread [p, p]: the minimum and the covariance of the coordinates; bounds: of
    these; unit, inflation [p]: s^2 and the correlation times of `uncertainty`.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        begin: np.ndarray,
        spread: np.ndarray,
        bounds: tuple[np.ndarray, np.ndarray],
        unit: float,
        inflation: np.ndarray,
    ):
        self.names, self.begin, self.spread, self.bounds = names, begin, spread, bounds
        self.time = float(np.exp(np.mean(np.log(inflation))))
        self.unit, self.near = unit, np.sqrt(self.time / inflation)

    def cost(self, table: np.ndarray) -> np.ndarray:
        """[m] at coordinates [m, p]."""
        raise NotImplementedError

    def values(self, table: np.ndarray) -> np.ndarray:
        """Parameters [m, p] at coordinates."""
        raise NotImplementedError

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str) -> np.ndarray:
        """Steady friction [m, k] at velocities [k]; section: of the law in a case."""
        raise NotImplementedError

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """(time [n], predictions [m, n], standard deviation of a measurement about them) of a record."""
        raise NotImplementedError

    def density(self, table: np.ndarray) -> np.ndarray:
        """Logarithm [m] at coordinates [m, p] within the bounds; -inf elsewhere."""
        good = np.all((table >= self.bounds[0]) & (table <= self.bounds[1]), axis=1)
        densities = np.full(len(table), -np.inf)
        if good.any():
            near = self.begin + (table[good] - self.begin) * self.near
            densities[good] = -self.cost(near) / (self.unit * self.time)
        return np.where(np.isnan(densities), -np.inf, densities)


def chain(
    source: Source, samples: int, seed: int, report: Callable[[float], None] | None = None
) -> tuple[np.ndarray, float, bool]:
    """(draws [n, p] of coordinates, independent ones among them, whether it was long enough); reproducible by the seed.

    Needs emcee (the extra `fit`).
    """
    emcee: Any = importlib.import_module("emcee")
    check_whole("samples", samples, 100)
    random, begin, (low, high) = np.random.default_rng(seed), source.begin, source.bounds
    walkers = max(2 * (WALKERS * len(begin) // 2), LEAST)
    deviation = np.sqrt(np.diag(source.spread))
    ball = normal_draws(source.spread / np.outer(deviation, deviation), random.standard_normal((walkers, len(begin))))
    ball = begin + np.minimum(deviation, high - low) * ball  # what the data leave open fills its bounds
    room = 1e-3 * (high - low)
    state = emcee.State(
        np.clip(ball, low + room * random.random(ball.shape), high - room * random.random(ball.shape)),
        random_state=np.random.RandomState(seed).get_state(),
    )

    moves = [(emcee.moves.DEMove(), 0.9), (emcee.moves.DEMove(gamma0=1.0), 0.1)]
    sampler = emcee.EnsembleSampler(walkers, len(begin), source.density, moves=moves, vectorize=True)
    settled, steps, time = False, 0, float(BLOCK)
    while steps < LONGEST and not settled:
        state = sampler.run_mcmc(state, BLOCK, skip_initial_state_check=steps > 0)
        steps += BLOCK
        time = float(np.max(sampler.get_autocorr_time(tol=0)))
        kept = walkers * (steps - BURNT * time) / time
        settled = steps > ENOUGH * time and kept >= samples
        if report:
            report(min(steps / (ENOUGH * time), kept / samples, 1.0))
    draws = sampler.get_chain(discard=min(int(BURNT * time), steps // 2), flat=True)
    even = np.linspace(0, len(draws) - 1, min(samples, len(draws))).astype(int)
    effective = min(walkers * (steps - BURNT * time) / time, len(even))
    return random.permutation(draws[even]), max(float(effective), 0.0), settled


def normal_draws(covariance: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Independent normal numbers [m, p] as numbers of a covariance [p, p]."""
    values, vectors = np.linalg.eigh(covariance)
    return normal @ (vectors * np.sqrt(np.maximum(values, 0.0))).T


DRAWN = 200  # draws that a band is made of


@dataclasses.dataclass(frozen=True, eq=False)
class Band:
    """Over x [n]: the median, and from low to high 95 % of the samples."""

    x: np.ndarray
    low: np.ndarray
    middle: np.ndarray
    high: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Posterior(Result):
    """Samples of the parameters of a fit.

    names, units [p]; values [samples, p], in these units; law_name: of the fitted law, "" of a fitted case, whose
    names are paths. low, high: 95 % intervals by name; effective: independent samples among them; settled: whether the
    chain was fifty times as long as its correlations. `robustness` takes it as it is: {"friction": posterior}.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    law_name: str
    effective: float
    settled: bool
    coordinates: np.ndarray = dataclasses.field(repr=False)
    source: Source = dataclasses.field(repr=False)

    in_record = "names units values law_name low high effective settled"

    @property
    def low(self) -> Mapping[str, float]:
        return dict(zip(self.names, np.quantile(self.values, ENDS[0], axis=0).tolist(), strict=True))

    @property
    def high(self) -> Mapping[str, float]:
        return dict(zip(self.names, np.quantile(self.values, ENDS[1], axis=0).tolist(), strict=True))

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.names:
            raise KeyError(f"{name!r}; {suggestion(name, self.names)}")
        return self.values[:, self.names.index(name)]

    @property
    def heading(self) -> str:
        return f"{len(self.values)} samples of {len(self.names)} parameters"

    @property
    def facts(self) -> dict[str, str]:
        low, high = self.low, self.high
        facts = {name: f"{number(low[name], 4)} to {number(high[name], 4)}" for name in self.names}
        short = "the chain is shorter than fifty correlation times; fix open parameters, or give them a prior"
        return facts | ({} if self.settled else {"not settled": short})

    @property
    def chapter(self) -> Chapter:
        """Its intervals, in words."""
        return Chapter(f"of {len(self.values)} samples", ("95 %",), list(self.facts.items()))

    def friction_curve(self, velocity: Any, load: float = 1.0, law: str = "friction") -> Band:
        """Band of the steady friction at velocities [k], N; load: as in the fit; law: its section of a case."""
        speeds = np.asarray(velocity, float)
        return _band(speeds, self.source.curve(self.coordinates[:DRAWN], speeds, load, law))

    def prediction(self, record: str, seed: int = 0) -> Band:
        """Band over time of a new measurement of a record, fitted or held out."""
        time, forces, deviation = self.source.record(record, self.coordinates[:DRAWN])
        noise = deviation * np.random.default_rng(seed).standard_normal(forces.shape)
        return _band(time, forces + noise)


def _band(x: np.ndarray, samples: np.ndarray) -> Band:
    low, middle, high = np.nanquantile(samples, [ENDS[0], 0.5, ENDS[1]], axis=0, method="median_unbiased")
    return Band(x, low, middle, high)


class DrivenSource(Source):
    """A law that is driven through its records."""

    def __init__(self, problem: Problem):
        self.full, self.loss, spread = problem.prediction, problem.loss, problem.uncertainty
        self.base = problem.draft if self.full.size > LARGE else self.full
        space, unit = self.full.space, spread.unit * self.base.size / self.full.size
        back, bounds = np.linalg.inv(space.slopes(problem.best.u)), (space.low, space.high)
        own = back @ spread.covariance @ back.T
        super().__init__(space.names, problem.best.u, own, bounds, unit, spread.inflation)

    def cost(self, table: np.ndarray) -> np.ndarray:
        return self.loss.cost(finite(self.base.error_table(table)))

    def values(self, table: np.ndarray) -> np.ndarray:
        return self.full.space.values(table)

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str) -> np.ndarray:
        values = self.values(table)
        columns = {name: values[:, [self.names.index(name)]] for name in self.full.law_names}
        return steady_force(self.full.template, np.broadcast_to(velocity, (len(table), len(velocity))), load, columns)

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        names = [record.name for record in self.full.records]
        if name not in names:
            raise ArgumentError("record", f"no record of the fit is called {name!r}; {suggestion(name, names)}")
        k = names.index(name)
        record, told, counts = self.full.records[k], self.full.tells(k), self.full.counts[k]
        errors = finite(self.full.forces(self.begin, k)[0] - record.force)
        return record.time[told], self.full.forces(table, k)[:, told], float(np.std(errors[counts]))


def posterior(fit: Any, *, samples: int = 1000, seed: int = 0, progress: Progress = None) -> Posterior:
    """Samples of the parameters of a `Fit` or a `MotionFit`, with its priors.

    samples: at least as many are drawn, until the chain is fifty times as long as its correlations; progress: True for
    a bar, or a function that is called with the share done. Needs emcee (the extra `fit`). The same seed gives the
    same samples.
    """
    if getattr(fit, "segments", 1) > 1:
        raise ArgumentError("fit", "in segments is not sampled: fit records that are short enough for one")
    if getattr(fit, "problem", None) is None:
        raise ArgumentError("fit", "should be a fit of this session that found its parameters; fit again")
    require("posterior", "emcee")
    source: Source = DrivenSource(fit.problem) if isinstance(fit.problem, Problem) else fit.problem
    with reporting(progress, "Sampling") as report:
        draws, effective, settled = chain(source, samples, seed, report)
    law = getattr(fit, "law_name", "")
    if law:
        known = {parameter.name: parameter.unit for parameter in (*fit.parameters, *fit.nuisances)}
    else:
        known = {parameter.path: parameter.unit_of("value") for parameter in fit.parameters}
    units = tuple(known.get(name, "1") for name in source.names)
    return Posterior(source.names, units, source.values(draws), law, effective, settled, draws, source)


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
    problem: Problem | None = getattr(fit, "problem", None)
    if problem is None or not fit.ok:
        advice = "fit again after reading one from a file"
        raise ArgumentError("fit", f"should be a fit of this session that found a law; {advice}")
    check_whole("replicates", replicates, 10)
    count = len(problem.prediction.records)
    over = over or ("records" if count >= FEWEST_RECORDS else "blocks")
    if over not in ("records", "blocks"):
        raise ArgumentError("over", f"should be 'records' or 'blocks', got {over!r}")
    if over == "records" and count < 2:
        raise ArgumentError("over", "'records' needs several records; there is one, use 'blocks'")
    base = problem.draft if problem.prediction.size > LARGE else problem.prediction
    rng, how = np.random.default_rng(seed), {"held": -1, "evaluations": 40, "stop": 1e-6}
    begin = warm_descent(base, problem.best.u, base.slopes(problem.best.u), problem.loss, **how).u
    columns = [base.space.names.index(name) for name in base.law_names]
    refits = []
    with reporting(progress, "Refitting") as report:
        for done in range(replicates):
            drawn = _drawn(base, over, rng)
            minimum = warm_descent(drawn, begin, drawn.slopes(begin), problem.loss, **how)
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
        units = [unit / np.sqrt(count) for unit, count in zip(prediction.units, drawn, strict=True)]
    return prediction.of(records, units)
