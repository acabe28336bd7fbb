"""Posterior: samples of all that a fit leaves uncertain, jointly, with the bands of curves and motions that follow."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, require, suggestion
from vibrocap.identification.experiments.bootstrap import ENDS, LARGE
from vibrocap.identification.inference.sampling import Source, chain
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.steady_prediction import steady_force
from vibrocap.identification.result.fit_result import Chapter, number
from vibrocap.identification.search.loss import finite
from vibrocap.progress import Progress, reporting
from vibrocap.results import Result

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
