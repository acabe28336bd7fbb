"""The global search: differential evolution over whole populations, begun with Sobol points and restarted.

Most designs of a vibro-driven capsule do not travel, or lift off: their costs are a plateau, on which covariances learn
nothing. Differential evolution (Storn and Price 1997) compares designs only, so it does not mind; but it converges to
one place, so it is begun again with other points until the evaluations are used up.
"""

from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.design.goal import INFEASIBLE
from vibrocap.design.population import Population, Problem, evaluated, population_of, together
from vibrocap.design.search_store import SearchStore

MEMBERS = 16  # of a population for each variable
LEAST, MOST = 32, 256  # members of a population
CONVERGED = 1e-10  # spread of the costs of a population, relative, at which it is begun again
IDLE = 40  # generations without a better design after which it is begun again


class _Spent(Exception):
    """All evaluations are used up."""


def members_of(variables: int) -> int:
    """Designs of a population: a power of two, which suits Sobol points."""
    return int(min(MOST, max(LEAST, 2 ** np.ceil(np.log2(MEMBERS * variables)))))


def searched(
    problem: Problem,
    evaluations: int,
    seed: int,
    store: SearchStore | None = None,
    report: Callable[[float], None] | None = None,
    seeds: Sequence[np.ndarray] = (),
) -> list[Population]:
    """All populations of a search of at most so many evaluations of designs, a whole number of populations.

    seeds: designs [variables] that the first population holds besides Sobol points
    """
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    variables = len(problem.space.variables)
    members = members_of(variables)
    found: list[Population] = []
    most = max(1, evaluations // members)

    def costs(shares: np.ndarray) -> np.ndarray:
        designs = np.ascontiguousarray(shares.T)
        if len(found) >= most:
            raise _Spent
        number = len(found)
        stored = store.read(number, designs) if store else None
        population = population_of(problem, stored) if stored else evaluated(problem, designs)
        if store and stored is None:
            store.write(number, population.arrays())
        found.append(population)
        if report:
            report(len(found) / most)
        return population.best_cost

    begun = 0
    try:
        while True:
            generator = np.random.default_rng([seed, begun])
            points = qmc.Sobol(variables, rng=generator).random(members) if variables else np.zeros((members, 0))
            if begun == 0:
                for k, each in enumerate(seeds[:members]):
                    points[k] = each
            differential_evolution(
                costs,
                [(0.0, 1.0)] * variables,
                init=points,  # type: ignore[arg-type]
                rng=generator,
                maxiter=most,
                vectorized=True,
                updating="deferred",
                polish=False,
                tol=0.0,
                callback=_stopping(found, len(found)),
            )
            begun += 1
    except _Spent:
        return found


def _stopping(found: list[Population], first: int) -> Callable[..., bool]:
    """Whether a run of differential evolution that began with population `first` has nothing to find any more."""
    best, since = np.inf, first

    def stops(intermediate_result) -> bool:  # SciPy goes by this name
        nonlocal best, since
        cost, spread = float(intermediate_result.fun), intermediate_result.population_energies
        if cost < best - CONVERGED * abs(cost):
            best, since = cost, len(found)
        allowed = bool(np.max(spread) < INFEASIBLE)
        converged = allowed and np.ptp(spread) <= CONVERGED * max(abs(cost), 1e-300)
        return converged or len(found) - since >= IDLE

    return stops


def best_designs(
    problem: Problem, populations: list[Population], apart: float, many: int
) -> list[tuple[np.ndarray, int, float]]:
    """(shares, start, cost) of the best allowed designs, best first, no two nearer than `apart` in every share."""
    every = together(problem, populations)
    cost, start = every.best_cost, every.best_start
    order = np.argsort(cost, kind="stable")
    found: list[tuple[np.ndarray, int, float]] = []
    for k in order[cost[order] < INFEASIBLE]:
        here = every.shares[k]
        if all(np.max(np.abs(here - there), initial=0.0) > apart for there, _, _ in found):
            found.append((here, int(start[k]), float(cost[k])))
            if len(found) == many:
                break
    return found
