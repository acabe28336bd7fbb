"""Posterior: samples of all that a fit leaves uncertain, jointly, with the bands of curves and motions that follow.

The density is exp(-cost/s^2) as in the profiles, with priors, flat in the coordinates of the search (logarithms of
positive parameters) within their bounds. Errors that are correlated count as their correlation times say: with tau_j of
coordinate j and T, the geometric mean of all,

    ln density(u) = -cost(u*)/(s^2 T),    u*_j = best_j + (u_j - best_j) sqrt(T/tau_j)

has the covariance of `uncertainty` where the fit is linear, and the shape of the cost elsewhere.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from vibrocap.arguments import ArgumentError, require, suggestion
from vibrocap.identification.inference.sampling import chain
from vibrocap.identification.problem.steady_prediction import steady_force
from vibrocap.identification.result.fit_result import Chapter, Problem, number
from vibrocap.identification.search.loss import finite
from vibrocap.progress import Progress, reporting
from vibrocap.results import Result

LARGE = 10_000  # samples from which thinned records are used
DRAWN = 200  # draws that a band is made of
ENDS = (0.025, 0.975)


class Source(Protocol):
    """What is sampled: the density of coordinates [m, p], and what follows from them."""

    names: tuple[str, ...]
    begin: np.ndarray
    spread: np.ndarray
    bounds: tuple[np.ndarray, np.ndarray]

    def density(self, table: np.ndarray) -> np.ndarray:
        """Logarithm [m] at coordinates [m, p]."""
        ...

    def values(self, table: np.ndarray) -> np.ndarray:
        """Parameters [m, p] at coordinates."""
        ...

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str) -> np.ndarray:
        """Steady friction [m, k] at velocities [k]; section: of the law in a case."""
        ...

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """(time [n], predictions [m, n], standard deviation of a measurement about them) of a record."""
        ...


@dataclasses.dataclass(frozen=True, eq=False)
class Band:
    """Over x [n]: the median, and from low to high 95 % of what the samples make."""

    x: np.ndarray
    low: np.ndarray
    middle: np.ndarray
    high: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Posterior(Result):
    """Samples of what a fit leaves uncertain.

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
        """Lower ends of the intervals."""
        return dict(zip(self.names, np.quantile(self.values, ENDS[0], axis=0).tolist(), strict=True))

    @property
    def high(self) -> Mapping[str, float]:
        """Upper ends of the intervals."""
        return dict(zip(self.names, np.quantile(self.values, ENDS[1], axis=0).tolist(), strict=True))

    def __getitem__(self, name: str) -> np.ndarray:
        """The samples of a parameter."""
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
        if not self.settled:
            facts["not settled"] = (
                "the chain is short of fifty correlation times; fix what the data leave open, or give it a prior"
            )
        return facts

    @property
    def chapter(self) -> Chapter:
        """Its intervals, in words."""
        return Chapter(f"of {len(self.values)} samples", ("95 %",), list(self.facts.items()))

    def friction_curve(self, velocity: Any, load: float = 1.0, law: str = "friction") -> Band:
        """Band of the steady friction at velocities [k], N; load: as in the fit; law: its section of a case."""
        speeds = np.asarray(velocity, float)
        return _band(speeds, self.source.curve(self._drawn, speeds, load, law))

    def prediction(self, record: str, seed: int = 0) -> Band:
        """Band over time of a new measurement of a record, fitted or held out."""
        time, made, deviation = self.source.record(record, self._drawn)
        noise = deviation * np.random.default_rng(seed).standard_normal(made.shape)
        return _band(time, made + noise)

    @property
    def _drawn(self) -> np.ndarray:
        return self.coordinates[:DRAWN]


def _band(x: np.ndarray, made: np.ndarray) -> Band:
    low, middle, high = np.nanquantile(made, [ENDS[0], 0.5, ENDS[1]], axis=0)
    return Band(x, low, middle, high)


class DrivenSource:
    """A law that is driven through its records."""

    def __init__(self, problem: Problem):
        thin = problem.prediction.size > LARGE
        self.base, self.full = problem.draft if thin else problem.prediction, problem.prediction
        self.loss, spread, space = problem.loss, problem.uncertainty, self.full.space
        self.names, self.begin, self.bounds = space.names, problem.best.u, (space.low, space.high)
        back = np.linalg.inv(space.slopes(self.begin))
        self.spread = back @ spread.covariance @ back.T
        self.unit = spread.unit * self.base.size / self.full.size
        self.time = float(np.exp(np.mean(np.log(spread.inflation))))
        self.near = np.sqrt(self.time / spread.inflation)

    def density(self, table: np.ndarray) -> np.ndarray:
        """Logarithm [m] at coordinates [m, p]."""
        errors = finite(self.base.error_table(self.begin + (table - self.begin) * self.near))
        return -np.asarray(self.loss.cost(errors)) / (self.unit * self.time)

    def values(self, table: np.ndarray) -> np.ndarray:
        """Parameters [m, p] at coordinates."""
        return self.full.space.values(table)

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str) -> np.ndarray:
        """Steady friction [m, k] at velocities [k]."""
        values = self.values(table)
        columns = {name: values[:, [self.names.index(name)]] for name in self.full.law_names}
        return steady_force(self.full.template, np.broadcast_to(velocity, (len(table), len(velocity))), load, columns)

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """(time [n], predictions [m, n], standard deviation of a measurement about them) of a record."""
        names = [record.name for record in self.full.records]
        if name not in names:
            raise ArgumentError("record", f"no record of the fit is called {name!r}; {suggestion(name, names)}")
        k = names.index(name)
        error = self.full.by_record(finite(self.full.errors(self.begin)))[k] * self.full.units[k]
        return self.full.records[k].time, self.full.forces(table, k), float(np.std(error[np.isfinite(error)]))


def posterior(fit: Any, *, samples: int = 1000, seed: int = 0, progress: Progress = None) -> Posterior:
    """Samples of what a `Fit` or a `MotionFit` leaves uncertain, with its priors.

    samples: at least as many are drawn, until the chain is fifty times as long as its correlations; progress: True for
    a bar, or a function that is called with the share done. Needs emcee (the extra `fit`). The same seed gives the
    same samples.
    """
    if getattr(fit, "problem", None) is None:
        raise ArgumentError("fit", "should be a fit of this session that found its parameters; fit again")
    require("posterior", "emcee")
    source: Source = DrivenSource(fit.problem) if isinstance(fit.problem, Problem) else fit.problem
    with reporting(progress, "Sampling") as report:
        sampled_chain = chain(source.density, source.begin, source.spread, source.bounds, samples, seed, report)
    values = source.values(sampled_chain.draws)
    name = getattr(fit, "law_name", "")
    if name:
        units = {each.name: each.unit for each in (*fit.parameters, *fit.nuisances)}
    else:
        units = {each.path: each.unit_of("value") for each in fit.parameters}
    return Posterior(
        source.names,
        tuple(units.get(each, "1") for each in source.names),
        values,
        name,
        sampled_chain.effective,
        sampled_chain.settled,
        sampled_chain.draws,
        source,
    )
