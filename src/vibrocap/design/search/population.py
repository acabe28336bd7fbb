"""Populations of designs: each design run from several starts, all of them as one ensemble.

A motion from one start may lift off on its way where the settled motion does not, and so hide a good design. So a
design without an allowed motion is run once more, from where the nearest allowed design of the search has settled.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.case.sections import is_kind
from vibrocap.design.search.problem import FAILED, INFEASIBLE, UNSETTLED, Problem
from vibrocap.design.search.variables import FAR
from vibrocap.measures.ensemble import FINISHED, INITIAL, ensemble
from vibrocap.measures.of_measure import FINAL
from vibrocap.motion.simulate import within_room
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import refusal, varied

REFUSED = -2  # status of a design that was not run: a part refuses it, or it needed no further start


@dataclasses.dataclass(frozen=True)
class Population:
    """Designs and how their runs ended.

    shares: [designs, variables], see `DesignSpace`
    status: [designs, starts] index into list(Status), or REFUSED; settled: [designs, starts]. The last start is that
        where the nearest allowed design has settled, from which only designs are run that need it
    found: values of the measures by name, [designs, starts], NaN where the run failed
    ends: [designs, starts, states] the states in which runs ended
    costs: [goals, designs, starts] what a search makes small
    """

    shares: np.ndarray
    status: np.ndarray
    settled: np.ndarray
    found: dict[str, np.ndarray]
    ends: np.ndarray
    costs: np.ndarray

    def __len__(self) -> int:
        return len(self.shares)

    @property
    def best_start(self) -> np.ndarray:
        """[designs] the start that leads to the best motion of each design, by the first goal."""
        return np.argmin(self.costs[0], axis=1)

    @property
    def best_cost(self) -> np.ndarray:
        """[designs] the cost of that motion."""
        return np.min(self.costs[0], axis=1)

    def end(self, names: Sequence[str], design: int, start: int) -> dict[str, float]:
        """Where the run of a design from a start has settled, by state; names: of the states."""
        return {name: float(x) for name, x in zip(names, self.ends[design, start], strict=True) if np.isfinite(x)}

    def arrays(self) -> dict[str, np.ndarray]:
        """All that a store keeps; costs follow from it."""
        return {"shares": self.shares, "status": self.status, "settled": self.settled, "ends": self.ends, **self.found}

    def counts(self) -> dict[str, int]:
        """How many designs are allowed, violate a constraint, did not settle, or failed, by their best start."""
        cost = self.costs.max(axis=0).min(axis=1)  # of a design that lacks one of several measures, that
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
    columns = {name: arrays[name] for name in problem.measure_names}
    status, settled = arrays["status"], arrays["settled"]
    costs = np.stack([goal.costs(columns, settled, status != FINISHED) for goal in problem.goals])
    return Population(arrays["shares"], status, settled, columns, arrays["ends"], costs)


def together(problem: Problem, populations: list[Population]) -> Population:
    """All designs of some populations, in their order."""
    every = [population.arrays() for population in populations]
    return population_of(problem, {name: np.concatenate([columns[name] for columns in every]) for name in every[0]})


def not_run(problem: Problem, shares: np.ndarray) -> dict[str, np.ndarray]:
    """The arrays of a population of designs [designs, variables] none of which has run."""
    runs = len(shares), len(problem.starts) + 1
    return {
        "shares": shares,
        "status": np.full(runs, REFUSED),
        "settled": np.zeros(runs, dtype=bool),
        "ends": np.full((*runs, len(problem.system.state_names)), np.nan),
        **{name: np.full(runs, np.nan) for name in problem.measure_names},
    }


def evaluated(problem: Problem, shares: np.ndarray, known: Sequence[Population] = ()) -> Population:
    """Run designs [designs, variables] from every start, until each run settles or its periods are over.

    known: populations of the search before this one, whose settled motions are starts too
    """
    starts = np.array([list(start.values()) for start in problem.starts])
    arrays, every = not_run(problem, shares), np.arange(len(shares))
    _fill(problem, arrays, shares, every, np.tile(starts, (len(shares), 1, 1)), slice(0, len(starts)))
    population = population_of(problem, arrays)
    needing = np.flatnonzero(population.best_cost >= INFEASIBLE)
    begun = settled_nearby(problem, [*known, population], shares[needing])
    warm = np.flatnonzero(np.any(np.isfinite(begun), axis=1))  # a law may lack some of the states
    if not len(warm):
        return population
    _fill(problem, arrays, shares, needing[warm], begun[warm, None], slice(len(starts), None))
    return population_of(problem, arrays)


def settled_nearby(problem: Problem, known: Sequence[Population], shares: np.ndarray) -> np.ndarray:
    """[designs, states] where the allowed design nearest to each of shares [designs, variables] has settled.

    NaN where none is known that has the same choices.
    """
    states = np.full((len(shares), len(problem.system.state_names)), np.nan)
    if not len(shares):
        return states
    pairs = [(population, np.flatnonzero(population.best_cost < INFEASIBLE)) for population in known]
    places = np.concatenate([population.shares[good] for population, good in pairs])
    ends = np.concatenate([population.ends[good, population.best_start[good]] for population, good in pairs])
    if not len(places):
        return states
    from scipy.spatial import KDTree

    here, there = problem.space.apart(shares), problem.space.apart(places)
    distance, nearest = KDTree(there, compact_nodes=False, balanced_tree=False).query(here)
    near = distance < FAR
    states[near] = ends[np.asarray(nearest)[near]]
    return states


def _fill(
    problem: Problem,
    arrays: dict[str, np.ndarray],
    shares: np.ndarray,
    which: np.ndarray,
    begun: np.ndarray,
    columns: slice,
) -> None:
    """Run designs `which` from states begun [designs, starts, states], and write what they give into the columns."""
    values = problem.space.values(shares[which])
    paths = [path for path in values if is_kind(path)]
    rows = list(zip(*(values[path].tolist() for path in paths), strict=True)) or [()] * len(which)
    for kinds in dict.fromkeys(rows):  # of parts, and the designs that have them
        members = np.array([k for k, row in enumerate(rows) if row == kinds])
        system = varied(problem.system, dict(zip(paths, kinds, strict=True))) if kinds else problem.system
        rest = {path: column for path, column in values.items() if path not in paths}
        try:
            results = _run(problem, system, rest, members, begun)
        except ValueError:  # a part refuses some designs: they are left out
            designs = {k: problem.variants({path: _plain(x[k]) for path, x in rest.items()}) for k in members}
            accepted = [k for k, variants in designs.items() if not any(refusal(system, one) for one in variants)]
            if len(accepted) == len(members):
                raise
            members = np.array(accepted, dtype=int)
            results = _run(problem, system, rest, members, begun) if accepted else {}
        for name, column in results.items():
            if name in arrays:
                arrays[name][which[members], columns] = column.reshape(len(members), begun.shape[1])
            elif (state := name.removeprefix(FINAL)) != name and state in problem.system.state_names:
                place = problem.system.state_names.index(state)
                arrays["ends"][which[members], columns, place] = column.reshape(len(members), begun.shape[1])


def _plain(value: Any) -> Any:
    return value if isinstance(value, str) else float(value)


def _run(
    problem: Problem, system: System, values: Mapping[str, np.ndarray], members: np.ndarray, begun: np.ndarray
) -> dict[str, Any]:
    """Results [designs * starts] by name of designs from states begun [designs, starts, states]; of samples, in one."""
    over = {path: np.repeat(column[members], begun.shape[1]) for path, column in values.items()}
    for place, state in enumerate(problem.system.state_names):
        if state in system.state_names:
            over[INITIAL + state] = begun[members, :, place].ravel()
    runs, samples = len(members) * begun.shape[1], problem.samples
    over = over if samples is None else samples.spread(over, runs)
    until = {name: getattr(problem, name) for name in ("measures", "periods", "settle", "tolerance", "threads")}
    measured = ensemble(system, _within_room(system, over), final_states=True, **until)
    return measured if samples is None else _over_samples(problem, measured, runs)


def _within_room(system: System, over: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns of runs, with starts at the stop of a design where they would lie beyond it."""
    columns = {path: np.array(column) for path, column in over.items()}
    rest = {path: column for path, column in columns.items() if not path.startswith(INITIAL)}
    names = [name for name in system.state_names if INITIAL + name in columns]
    for run in range(len(next(iter(columns.values()))) if system.placed.room() else 0):
        state = {name: float(columns[INITIAL + name][run]) for name in names}
        design = varied(system, {path: _plain(column[run]) for path, column in rest.items()})
        for name, value in within_room(design, state).items():
            columns[INITIAL + name][run] = value
    return columns


def _over_samples(problem: Problem, measured: Mapping[str, np.ndarray], runs: int) -> dict[str, Any]:
    """What counts of the samples [runs * samples] of each run.

    A run is finished where one sample is; it has settled where all have that are finished.
    """
    assert problem.samples is not None
    columns = {name: column.reshape(runs, -1) for name, column in measured.items()}
    finished = columns["status"] == FINISHED
    first = np.arange(runs), np.argmax(finished, axis=1)
    reduced = {name: x[first] for name, x in columns.items() if name == "status" or name.startswith(FINAL)}
    reduced["settled"] = np.all(columns["settled"] | ~finished, axis=1)
    for goal in problem.goals:
        reduced |= goal.over_samples(columns, finished, problem.samples.chosen)
    return reduced
