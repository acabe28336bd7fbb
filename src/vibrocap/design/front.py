"""pareto_front(system, over=...): designs that cannot improve in one measure without a loss in the other."""

import collections
import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, require, shown
from vibrocap.case.case import Case
from vibrocap.design.optimise import OptimumStatus, closed_near, ending, stands
from vibrocap.design.search.evolution import Evaluations, Spent, evolve, first_designs, opened_store
from vibrocap.design.search.population import Population, together
from vibrocap.design.search.problem import INFEASIBLE, UNSETTLED, Problem, measure_unit, stated_problem
from vibrocap.design.search.refinement import Refined
from vibrocap.measures.measure import Measure
from vibrocap.measures.of_measure import MeasuresInUnits
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.physics.dimensions.conversion import Design
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, Numbers
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.results import Result

MEMBERS = 128  # of a population
ENDS = 0.15  # share of the designs that search each end of the front


@dataclasses.dataclass(frozen=True)
class ParetoDesign(Dimensional):
    """A design of a front: its variables by path, both measures by name and its largest |multiplier|."""

    design: Design
    measures: MeasuresInUnits
    largest_multiplier: Number


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class ParetoFront(Result):
    """Designs that cannot improve in one measure without a loss in the other, each with its settled, stable motion.

    status: `OptimumStatus`; with anything but FOUND there are no designs
    designs: values by path, best in the first measure first; values: [designs, 2] of the two `measures`, in `units`
    maximised: whether each is maximised; sized: whether its size counts, as a mirror image travels back; scales: what
        one dimensionless unit of each is in its unit
    orbits: their steady motions, closed to rounding; multipliers: the largest |multiplier| of each
    counts: how many designs were evaluated, allowed, infeasible, not settled, failed and refused
    rejected: why candidates are not on the front, with how many for each reason
    population: every design that was evaluated
    """

    status: OptimumStatus
    system: System
    designs: tuple[dict[str, Number | str], ...]
    measures: tuple[str, str]
    units: tuple[str, str]
    maximised: tuple[bool, bool]
    sized: tuple[bool, bool]
    scales: tuple[Number, Number]
    values: Numbers
    orbits: tuple[Orbit, ...]
    multipliers: Numbers
    counts: dict[str, int]
    rejected: dict[str, int]
    population: Population = dataclasses.field(compare=False)

    rows = "points"
    in_record = "status measures maximised counts rejected points"

    def __len__(self) -> int:
        return len(self.designs)

    @property
    def heading(self) -> str:
        return f"Pareto front of {self.measures[0]} and {self.measures[1]}: {self.status.value}"

    @property
    def facts(self) -> dict[str, str]:
        facts = {"designs": ", ".join(f"{number} {name}" for name, number in self.counts.items() if number)}
        if not len(self):
            return facts | {"advice": self.status.advice}
        ends = zip(self.measures, self.values.min(0), self.values.max(0), self.units, strict=True)
        spans = {name: f"{low:.6g} to {said(high, unit, 6)}" for name, low, high, unit in ends}
        left = {"left out": ", ".join(f"{number}: {why}" for why, number in self.rejected.items())}
        return {"points": str(len(self))} | spans | facts | (left if self.rejected else {})

    def others(self) -> Numbers:
        """Both measures of every motion that was evaluated and allowed, [motions, 2], as `values`."""
        design, start, _ = _allowed(self.population)
        values = np.stack([self.population.found[name][design, start] for name in self.measures], axis=1)
        return np.where(self.sized, np.abs(values), values) * self.scales

    @property
    def points(self) -> tuple[ParetoDesign, ...]:
        """Each design with both measures, as they are shown."""
        rows = zip(self.designs, self.values.tolist(), self.multipliers.tolist(), strict=True)
        return tuple(
            ParetoDesign(design, dict(zip(self.measures, values, strict=True)), largest)
            for design, values, largest in rows
        )

    def case(self, index: int, periods: float = 40) -> Case:
        """A case of one design that starts on its orbit. Raises IndexError where there is none of that number."""
        steady = self.orbits[index]
        return Case(steady.system, steady.state, periods=periods)


@shows_progress("Searching for the Pareto front")
def pareto_front(
    system: System | Case,
    over: Mapping[str, Any],
    objectives: Sequence[str | Measure] = ("mean_velocity", "cost_of_transport"),
    *,
    senses: Sequence[str | None] = (None, None),
    through: Callable[..., Mapping[str, Any]] | None = None,
    subject_to: str | Sequence[str] = (),
    starts: Sequence[ByName] | None = None,
    evaluations: int = 10_000,
    points: int = 100,
    seed: int = 0,
    margin: float = 1e-3,
    periods: int = 300,
    settle: float = 1e-6,
    tolerance: float = 1e-8,
    store: str | Path | None = None,
    resume: bool = False,
    threads: int | None = None,
    progress: Progress = None,
) -> ParetoFront:
    """The Pareto front of two measures: designs that cannot improve in one without a loss in the other.

    Populations run as ensembles in NSGA-II (Deb et al. 2002, by pymoo), begun with Sobol points. Of all designs that
    none dominates, at most `points` that spread along the front are closed to periodic orbits and judged as by
    `optimise`: settled, certified, stable by a margin. Measures are those of the orbits.

    objectives: two measures; senses: "maximise" or "minimise" of each; by default costs and times are minimised
    over, through, subject_to, starts, seed, margin, periods, settle, tolerance, store, resume, threads: see `optimise`
    evaluations: designs, about (a whole number of populations of 128)

    Returns a `ParetoFront`. Raises CaseError with every complaint about the problem, ArgumentError for another
    argument, ModuleNotFoundError without pymoo, before any work.
    """
    if isinstance(objectives, str) or len(list(objectives)) != 2:
        raise ArgumentError("objectives", f"should be two measures, got {shown(objectives)}")
    if isinstance(senses, str) or len(list(senses)) != 2:
        raise ArgumentError("senses", f"should be two, one for each objective, got {shown(senses)}")
    asked: dict[str, Any] = {"periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    asked |= {"through": through, "margin": margin, "evaluations": (evaluations, 1), "points": (points, 1)}
    asked["seed"] = (seed, 0)
    problem = stated_problem(system, over, list(objectives), list(senses), subject_to, starts, **asked)
    require("pareto_front", "pymoo")
    kept = None if store is None else opened_store(store, problem.record(seed, method="nsga2"), resume)
    search = Evaluations(problem, evaluations, kept, told(progress))
    _search(search, seed)
    every = together(problem, search.found)
    designs, rejected = ([], {}) if stands(problem, every) else _closed(problem, every, points)
    return _front(problem, every, designs, rejected)


def _search(search: Evaluations, seed: int) -> None:
    """Search the ends of the front one by one, then all of it by NSGA-II, begun from the best of what is known."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem as Cube

    problem, variables = search.problem, len(search.problem.space.variables)
    for k in range(2):
        evolve(search, k, seed, round((k + 1) * ENDS * search.most))
    begun = first_designs(variables, MEMBERS, np.random.default_rng([seed, 2]))
    if search.found:
        known = together(problem, search.found)
        design, _, costs = _allowed(known)
        front = not_dominated(costs)
        best = known.shares[np.unique(design[front[_spread(costs[front], MEMBERS // 2)]])]
        begun[: len(best)] = best
    method = NSGA2(pop_size=MEMBERS, sampling=begun)  # type: ignore[arg-type]
    cube = Cube(n_var=variables, n_obj=2, n_ieq_constr=1, xl=0.0, xu=1.0)
    method.setup(cube, termination=("n_gen", search.most), seed=seed, verbose=False)
    try:
        while True:
            asked: Any = method.ask()
            population = search.of(np.ascontiguousarray(asked.get("X")))
            own = np.arange(len(population)), population.best_start
            costs = np.stack([cost[own] for cost in population.costs], axis=1)
            violation = np.where(costs < INFEASIBLE, 0.0, costs / UNSETTLED).max(axis=1)  # on one scale of order 1
            asked.set("F", np.where(costs < INFEASIBLE, costs, 0.0), "G", violation[:, None])
            method.tell(infills=asked)
    except Spent:
        return


def _allowed(population: Population) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(design, start, costs [motions, goals]) of all motions that are allowed."""
    costs = np.moveaxis(population.costs, 0, -1)
    design, start = np.nonzero(np.all(costs < INFEASIBLE, axis=-1))
    return design, start, costs[design, start]


def not_dominated(costs: np.ndarray) -> np.ndarray:
    """Which of some points [points, 2] no other betters: as indices, by the first cost."""
    order = np.lexsort((costs[:, 1], costs[:, 0]))
    before = np.minimum.accumulate(np.append(np.inf, costs[order, 1]))[:-1]
    return order[costs[order, 1] < before]


def _spread(costs: np.ndarray, many: int) -> np.ndarray:
    """At most so many points of a front [points, 2], both ends and such as divide its length evenly."""
    if len(costs) <= many:
        return np.arange(len(costs))
    sizes = np.ptp(costs, axis=0)
    steps = np.diff(costs, axis=0) / np.where(sizes > 0.0, sizes, 1.0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    wanted = np.linspace(0.0, along[-1], many)
    return np.unique(np.argmin(np.abs(along[:, None] - wanted), axis=0))


def _closed(problem: Problem, every: Population, points: int) -> tuple[list[Refined], dict[str, int]]:
    """(the closed designs of the front, why others are not on it)."""
    design, start, motions = _allowed(every)
    front = not_dominated(motions)
    front = front[_spread(motions[front], points)]
    designs: list[Refined] = []
    rejected = collections.Counter[str]()
    for k in front:
        state = every.end(problem.system.state_names, int(design[k]), int(start[k]))
        near, why = closed_near(problem, every.shares[design[k]], state)
        if near is None or near.best is None:
            rejected[why] += 1
        else:
            designs.append(near.best)
    exact = np.array([[-goal.merit(one.found[goal.measure]) for goal in problem.goals] for one in designs])
    kept = not_dominated(exact.reshape(-1, 2))
    if beaten := len(designs) - len(kept):
        rejected["bettered by another's orbit"] = beaten
    return [designs[k] for k in kept], dict(rejected)


def _front(problem: Problem, every: Population, designs: list[Refined], rejected: dict[str, int]) -> ParetoFront:
    one, other = problem.goals
    units, scales = zip(*(measure_unit(problem.system, goal.measure) for goal in problem.goals), strict=True)
    values = np.array([[design.found[goal.measure] for goal in problem.goals] for design in designs]).reshape(-1, 2)
    sized = one.size, other.size
    return ParetoFront(
        status=ending(problem, every, bool(designs), rejected),
        system=problem.system,
        designs=tuple(problem.space.design(design.shares) for design in designs),
        measures=(one.measure, other.measure),
        units=units,
        maximised=(one.maximise, other.maximise),
        sized=sized,
        scales=scales,
        values=np.where(sized, np.abs(values), values) * scales,
        orbits=tuple(Orbit.of(design.solution) for design in designs),
        multipliers=np.array([np.max(np.abs(design.solution.multipliers), initial=0.0) for design in designs]),
        counts=every.counts(),
        rejected=rejected,
        population=every,
    )
