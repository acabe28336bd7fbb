"""Populations of designs: each design run from several starts, all of them as one ensemble."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.case.sections import is_kind
from vibrocap.design.search.goal import FAILED, INFEASIBLE, UNSETTLED, names
from vibrocap.design.search.problem import Problem
from vibrocap.measures.ensemble import FINISHED, INITIAL, ensemble
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import refusal, varied

REFUSED = -2  # status of a design that a part refuses, so that it was not run


@dataclasses.dataclass(frozen=True)
class Population:
    """Designs and how their runs ended.

    shares: [designs, variables], see `DesignSpace`
    status: [designs, starts] index into list(Status), or REFUSED; settled: [designs, starts]
    found: values of the measures by name, [designs, starts], NaN where the run failed
    costs: [goals, designs, starts] what a search makes small
    """

    shares: np.ndarray
    status: np.ndarray
    settled: np.ndarray
    found: dict[str, np.ndarray]
    costs: np.ndarray

    def __len__(self) -> int:
        return len(self.shares)

    @property
    def cost(self) -> np.ndarray:
        """[designs, starts] of the first goal."""
        return self.costs[0]

    @property
    def best_start(self) -> np.ndarray:
        """[designs] the start that leads to the best motion of each design."""
        return np.argmin(self.cost, axis=1)

    @property
    def best_cost(self) -> np.ndarray:
        """[designs] the cost of that motion."""
        return np.min(self.cost, axis=1)

    def arrays(self) -> dict[str, np.ndarray]:
        """All that a store keeps; costs follow from it."""
        return {"shares": self.shares, "status": self.status, "settled": self.settled, **self.found}

    def counts(self) -> dict[str, int]:
        """How many designs are allowed, violate a constraint, did not settle, or failed, by their best start."""
        cost = self.best_cost
        refused = np.all(self.status == REFUSED, axis=1)
        return {
            "evaluated": len(self),
            "allowed": int(np.sum(cost < INFEASIBLE)),
            "infeasible": int(np.sum((cost >= INFEASIBLE) & (cost < UNSETTLED))),
            "not settled": int(np.sum(cost == UNSETTLED)),
            "failed": int(np.sum((cost == FAILED) & ~refused)),
            "refused": int(np.sum(refused)),
        }


def population_of(problem: Problem, arrays: Mapping[str, np.ndarray]) -> Population:
    """A population from the arrays of a store, or of `evaluated`."""
    found = {name: arrays[name] for name in names(problem.measures)}
    status, settled = arrays["status"], arrays["settled"]
    costs = np.stack([goal.costs(found, settled, status != FINISHED) for goal in problem.goals])
    return Population(arrays["shares"], status, settled, found, costs)


def together(problem: Problem, populations: list[Population]) -> Population:
    """All designs of some populations, in their order."""
    every = [each.arrays() for each in populations]
    return population_of(problem, {name: np.concatenate([each[name] for each in every]) for name in every[0]})


def evaluated(problem: Problem, shares: np.ndarray) -> Population:
    """Run designs [designs, variables] from every start, until each run settles or its periods are over."""
    designs, starts = len(shares), len(problem.starts)
    arrays: dict[str, np.ndarray] = {
        "shares": shares,
        "status": np.full((designs, starts), REFUSED),
        "settled": np.zeros((designs, starts), dtype=bool),
        **{name: np.full((designs, starts), np.nan) for name in names(problem.measures)},
    }
    values = problem.space.values(shares)
    for kinds, members in _by_kind(values, designs):
        system = varied(problem.system, kinds) if kinds else problem.system
        rest = {path: column for path, column in values.items() if path not in kinds}
        try:
            results = _run(problem, system, rest, members)
        except ValueError:  # a part refuses some designs: they are left out
            accepted = [k for k in members if not refusal(system, {path: _plain(x[k]) for path, x in rest.items()})]
            if len(accepted) == len(members):
                raise
            members = np.array(accepted, dtype=int)
            results = _run(problem, system, rest, members) if accepted else {}
        for name, column in results.items():
            if name in arrays:
                arrays[name][members] = column.reshape(len(members), starts)
    return population_of(problem, arrays)


def _plain(value: Any) -> Any:
    return value if isinstance(value, str) else float(value)


def _by_kind(values: Mapping[str, np.ndarray], designs: int) -> list[tuple[dict[str, str], np.ndarray]]:
    """(kinds of parts by path, the designs that have them)."""
    chosen = [path for path in values if is_kind(path)]
    if not chosen:
        return [({}, np.arange(designs))]
    rows = list(zip(*(values[path].tolist() for path in chosen), strict=True))
    return [
        (dict(zip(chosen, kinds, strict=True)), np.array([k for k, row in enumerate(rows) if row == kinds]))
        for kinds in dict.fromkeys(rows)
    ]


def _run(problem: Problem, system: System, values: Mapping[str, np.ndarray], members: np.ndarray) -> dict[str, Any]:
    """Results of some designs from all starts, [designs * starts] by name; of samples, what counts of them."""
    over = {path: np.repeat(column[members], len(problem.starts)) for path, column in values.items()}
    for state in dict.fromkeys(name for start in problem.starts for name in start):
        over[INITIAL + state] = np.tile([start.get(state, 0.0) for start in problem.starts], len(members))
    runs, samples = len(members) * len(problem.starts), problem.samples
    over = over or {INITIAL + system.state_names[0]: np.zeros(runs)}
    found = ensemble(
        system,
        over if samples is None else samples.spread(over, runs),
        measures=problem.measures,
        periods=problem.periods,
        settle=problem.settle,
        tolerance=problem.tolerance,
        threads=problem.threads,
    )
    return found if samples is None else _over_samples(problem, found, runs)


def _over_samples(problem: Problem, found: Mapping[str, np.ndarray], runs: int) -> dict[str, Any]:
    """What counts of the samples [runs * samples] of each run.

    A run is finished where one sample is; it has settled where all have that are finished.
    """
    each = {name: column.reshape(runs, -1) for name, column in found.items()}
    finished = each["status"] == FINISHED
    first = np.argmax(finished, axis=1)
    reduced = {"status": each["status"][np.arange(runs), first], "settled": np.all(each["settled"] | ~finished, axis=1)}
    for goal in problem.goals:
        reduced |= goal.over_samples(each, finished, problem.samples.chosen)  # type: ignore[union-attr]
    return reduced
