"""The global search: differential evolution of whole populations, begun with Sobol points and restarted, and its store.

Most designs of a vibro-driven capsule do not travel, or lift off: their costs are a plateau, on which covariances learn
nothing. Differential evolution (Storn and Price 1997) compares designs only; as it converges to one place, it is begun
again with other points until the evaluations are used up. The best designs often stand on bounds, and SciPy draws what
steps over a bound anew between the bounds; so the search extends a little beyond them, with the design at the bound.

A search is deterministic, so it is resumed by going through it again: populations that are stored are read, the others
are run. The bytes are the same as those of a search that nothing interrupted.
"""

import dataclasses
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.design.search.population import Population, evaluated, not_run, population_of, together
from vibrocap.design.search.problem import INFEASIBLE, Problem
from vibrocap.files import made_folder, replacing, write_text
from vibrocap.inputs import read_own
from vibrocap.records.reading.arrays import UNREADABLE_NPZ

RECORD, POPULATIONS = "search.json", "populations"
LARGEST = 2**28  # bytes of a file that is read


@dataclasses.dataclass(frozen=True)
class SearchStore:
    """A folder with the record of a search and its populations, `populations/00000.npz` and so on."""

    folder: Path

    def _file(self, number: int) -> Path:
        return self.folder / POPULATIONS / f"{number:05d}.npz"

    def read(self, number: int, like: Mapping[str, np.ndarray]) -> dict[str, np.ndarray] | None:
        """The arrays of a population, if it is stored, whole, and of the same designs in the form of `like`."""
        try:
            with self._file(number).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
        except UNREADABLE_NPZ:  # not there, or damaged: it is run again
            return None
        form, wanted = ({name: (x.shape, x.dtype) for name, x in of.items()} for of in (arrays, like))
        return arrays if form == wanted and np.array_equal(arrays["shares"], like["shares"]) else None

    def write(self, number: int, arrays: dict[str, np.ndarray]) -> None:
        """Store the arrays of a population, whole or not at all."""
        with replacing(self._file(number)) as temporary, temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **arrays)  # type: ignore[arg-type]


def opened_store(folder: str | Path, record: dict[str, Any], resume: bool) -> SearchStore:
    """The store in a folder, made where there is none; record: all that decides the populations of the search.

    Raises ArgumentError where the folder holds a search and `resume` is False, or another search.
    """
    folder = Path(folder)
    path, advice = folder / RECORD, "give another folder"
    if path.exists():
        if not resume:
            raise ArgumentError("store", f"{str(folder)!r} holds a search; resume it, or {advice}")
        try:
            before = json.loads(read_own(path, LARGEST))
        except (OSError, ValueError) as error:
            raise ArgumentError("store", f"{str(path)!r} cannot be read as the record of a search ({error})") from None
        if other := [name for name in record if not isinstance(before, dict) or before.get(name) != record[name]]:
            raise ArgumentError("store", f"{str(folder)!r} holds another search (another {', '.join(other)}); {advice}")
    made_folder(folder / POPULATIONS)
    write_text(path, json.dumps(record, indent=2, ensure_ascii=False) + "\n")
    return SearchStore(folder)


MEMBERS = 16  # of a population for each variable
LEAST, MOST = 32, 128  # members of a population
BEYOND = 0.05  # of a range, by which the search goes beyond its bounds
CONVERGED = 1e-3  # relative spread of costs at which a population is begun again: refinement finds the digits
IDLE = 40  # generations without a better design after which it is begun again


def members_of(variables: int) -> int:
    """Designs of a population: a power of two, which suits Sobol points."""
    return int(min(MOST, max(LEAST, 2 ** np.ceil(np.log2(MEMBERS * variables)))))


class Spent(Exception):
    """All evaluations are used up."""


class Evaluations:
    """Populations of a search, one after another; those in a store are read, not run.

    most: designs in all; the first population is run whatever its size.
    """

    def __init__(self, problem: Problem, most: int, store: SearchStore | None, report: Callable[[float], None] | None):
        self.problem, self.most, self.store, self.report = problem, most, store, report
        self.found: list[Population] = []
        self.designs = 0

    def of(self, designs: np.ndarray, until: int | None = None) -> Population:
        """The population of designs [designs, variables].

        Raises Spent where there would be more designs in all than `until`, by default `most`.
        """
        whole = self.designs + len(designs)
        if self.found and whole > (self.most if until is None else until):
            raise Spent
        number = len(self.found)
        stored = self.store.read(number, not_run(self.problem, designs)) if self.store else None
        population = population_of(self.problem, stored) if stored else evaluated(self.problem, designs, self.found)
        if self.store and stored is None:
            self.store.write(number, population.arrays())
        self.found.append(population)
        self.designs = whole
        if self.report:
            self.report(min(1.0, whole / self.most))
        return population


def first_designs(variables: int, members: int, generator: np.random.Generator) -> np.ndarray:
    """Sobol points of the unit cube, [members, variables], with which a search begins."""
    from scipy.stats import qmc

    return qmc.Sobol(variables, rng=generator).random(members) if variables else np.zeros((members, 0))


def evolve(search: Evaluations, goal: int, seed: int, until: int) -> None:
    """Differential evolution towards one goal, begun again where it has converged, until there are so many designs.

    goal: its number among those of the problem
    """
    from scipy.optimize import differential_evolution

    space = search.problem.space
    variables = len(space.variables)
    members = members_of(variables)
    beyond = np.where(np.isin(np.arange(variables), space.continuous), BEYOND, 0.0)

    def costs(places: np.ndarray) -> np.ndarray:
        return search.of(np.ascontiguousarray(np.clip(places.T, 0.0, 1.0)), until).costs[goal].min(axis=1)

    begun = 0
    try:
        while True:
            generator = np.random.default_rng([seed, begun] if goal == 0 else [seed, begun, goal])
            first = first_designs(variables, members, generator)
            if begun == 0:
                guesses = search.problem.guesses[:members]
                first[: len(guesses)] = np.reshape(guesses, (-1, variables))
            until_idle = _stopping(search.found, len(search.found))
            how: dict[str, Any] = {"init": first, "rng": generator, "callback": until_idle}
            how |= {"vectorized": True, "updating": "deferred", "polish": False, "tol": 0.0}
            bounds = list(zip(-beyond, 1.0 + beyond, strict=True))
            differential_evolution(costs, bounds, maxiter=1 + until // members, **how)
            begun += 1
    except Spent:
        return


def _stopping(populations: list[Population], first: int) -> Callable[..., bool]:
    """Whether a run of differential evolution that began with population `first` has nothing to find any more."""
    best, since = np.inf, first

    def stops(intermediate_result) -> bool:  # SciPy goes by this name
        nonlocal best, since
        cost, spread = float(intermediate_result.fun), intermediate_result.population_energies
        if cost < best - CONVERGED * abs(cost):
            best, since = cost, len(populations)
        allowed = bool(np.max(spread) < INFEASIBLE)
        converged = allowed and np.ptp(spread) <= CONVERGED * max(abs(cost), 1e-300)
        return converged or len(populations) - since >= IDLE

    return stops


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A design that may be the best: its shares, where its best run has settled, by state, and the cost of that."""

    shares: np.ndarray
    state: dict[str, float]
    cost: float


def best_designs(problem: Problem, populations: list[Population], apart: float, many: int) -> list[Candidate]:
    """The best allowed designs, best first, no two nearer than `apart` in every share."""
    every = together(problem, populations)
    cost, start = every.best_cost, every.best_start
    order = np.argsort(cost, kind="stable")
    candidates: list[Candidate] = []
    for k in map(int, order[cost[order] < INFEASIBLE]):
        here = every.shares[k]
        away = (np.max(np.abs(here - candidate.shares), initial=0.0) for candidate in candidates)
        if len(candidates) < many and all(distance > apart for distance in away):
            candidates.append(Candidate(here, every.end(problem.system.state_names, k, int(start[k])), float(cost[k])))
    return candidates
