"""optimise(system, over=...): the design whose settled, stable motion is best, and its limits."""

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import Case
from vibrocap.design.search.evolution import Evaluations, best_designs, evolve, opened_store
from vibrocap.design.search.population import REFUSED, Population, evaluated, together
from vibrocap.design.search.problem import FAILED, INFEASIBLE, UNSETTLED, Problem, measure_unit, stated_problem
from vibrocap.design.search.refinement import ClosedDesigns
from vibrocap.measures.measure import Measure
from vibrocap.measures.of_measure import MeasuresInUnits, Slopes
from vibrocap.motion.simulate import within_room
from vibrocap.motion.status import Status
from vibrocap.orbits.attractors.attractors import Attractors, attractors
from vibrocap.orbits.closing.orbit import Orbit, orbit
from vibrocap.physics.dimensions.conversion import Design
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Number, NumberInUnit, States
from vibrocap.quantities.dimensional import said
from vibrocap.results import Advised, Result

APART = 0.05  # share of every range within which designs count as the same candidate
EACH = 100  # orbits that are closed in the refinement for each variable
TRIED, REFINED = 20, 3  # most candidates that are closed; most that are refined
REACHED = 1e-4  # relative difference of a measure within which a start leads to the orbit


class OptimumStatus(Advised):
    """The end of a search for a design; `advice` gives the next step."""

    FOUND = "found", "A settled, stable design was found; no search can prove that there is no better one."
    NOT_ALLOWED = (
        "no allowed design",
        "No design settles and fulfils the constraints. Loosen the constraints, widen the bounds, give other `starts`, "
        "or raise `evaluations` or `periods`.",
    )
    NOT_STABLE = (
        "no stable design",
        "The best designs that were tried do not close to stable orbits that fulfil the constraints. Loosen `margin` "
        "or the constraints, or raise `evaluations`.",
    )
    NO_TRAVEL = (
        "no design travels",
        "No settled design travels by more than the residue of its run, so none is better than another. Vary "
        "parameters that break the symmetry of the machine, its friction or its drive, or drive it harder.",
    )


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Optimum(Result):
    """The best design of a search, in the units that the paths and the measure have in the results of the system.

    status: `OptimumStatus`; with anything but FOUND `design`, `value` and `orbit` are None
    design: values by path, or by name, as they were given; value: of the measure `measure`, in `unit`; its size where a
        twin travels the other way; maximised: whether it was to be large; scale: one dimensionless unit in `unit`
    orbit: its steady motion, closed to rounding, with its multipliers
    constraints: values of the constrained measures, by constraint
    limits: active limits by name; slopes: d(value)/d(variable) below and above it
    reached_from: the numbers of the starts from which its runs settle to this motion
    attractors: of starts spread over the states at this design; attractor: index of its own, None where none led to it
    counts: how many designs were evaluated, allowed, infeasible, not settled, failed and refused
    rejected: better candidates that do not win, each with the reason
    nearest: without an allowed design, the nearest one and its violations
    under: statistic of the uncertain samples, and the share of them whose orbit is stable
    population: every design that was evaluated
    """

    status: OptimumStatus
    design: Design | None
    measure: str
    maximised: bool
    value: NumberInUnit | None
    unit: str
    scale: Number
    orbit: Orbit | None
    constraints: MeasuresInUnits
    limits: tuple[str, ...]
    slopes: Slopes
    starts: tuple[States, ...]
    reached_from: tuple[int, ...]
    attractors: Attractors | None = dataclasses.field(compare=False)
    attractor: int | None
    counts: dict[str, int]
    rejected: tuple[str, ...]
    nearest: tuple[Design, str] | None
    under: tuple[str, Number] | None
    population: Population = dataclasses.field(compare=False)

    in_record = (
        "status design measure value constraints limits slopes starts reached_from counts rejected nearest under "
        "attractor attractors orbit"
    )

    @property
    def heading(self) -> str:
        return f"best design for {self.measure}: {self.status.value}"

    @property
    def facts(self) -> dict[str, str]:
        facts = {"designs": ", ".join(f"{number} {name}" for name, number in self.counts.items() if number)}
        if self.design is None or self.value is None:
            if self.nearest is not None:
                facts["nearest"] = f"nearest {_in_words(self.nearest[0])}: {self.nearest[1]}"
            return facts | {"advice": self.status.advice}
        best = {"value": f"{self.measure} {said(self.value, self.unit or '1')}", "design": _in_words(self.design)}
        if self.under is not None:
            best["under uncertainty"] = f"{self.under[0]} of the samples, {100.0 * self.under[1]:.3g} % of them stable"
        best["limits"] = f"limited by {', '.join(self.limits)}"
        if self.attractors is not None:
            best["reached"] = self.reached
        return best | facts

    @property
    def reached(self) -> str:
        """The motions that spread starts lead to, in words: that of the design, its mirror image, others, none."""
        known = self.attractors
        if known is None:
            return "not asked"
        own = None if self.attractor is None else known.attractors[self.attractor]
        twin = None if own is None or own.twin in (None, self.attractor) else known.attractors[own.twin]
        mine = [motion for motion in (own, twin) if motion is not None]
        parts = [f"reached from {100.0 * (own.share if own else 0.0):.3g} % of {len(known.label)} spread starts"]
        if twin is not None:
            parts.append(f"its mirror-image solution from {100.0 * twin.share:.3g} %")
        if others := len(known.attractors) - len(mine):
            share = sum(attractor.share for attractor in known.attractors) - sum(motion.share for motion in mine)
            parts.append(f"{others} other motion{'s' if others > 1 else ''} from {100.0 * share:.3g} %")
        if lost := float(np.mean(known.label < 0)):
            parts.append(f"{100.0 * lost:.3g} % fail or do not settle")
        return ", ".join(parts)

    def case(self, periods: float = 40) -> Case:
        """A case of the design that starts on its orbit. Raises ValueError where no design was found."""
        if self.orbit is None:
            raise ValueError(f"there is no design: {self.status.advice}")
        return Case(self.orbit.system, self.orbit.state, periods=periods)


def _in_words(design: Mapping[str, Any]) -> str:
    return ", ".join(f"{path} {x if isinstance(x, str) else format(x, '.8g')}" for path, x in design.items())


@shows_progress("Searching for the best design")
def optimise(
    system: System | Case,
    over: Mapping[str, Any],
    objective: str | Measure = "mean_velocity",
    *,
    sense: str | None = None,
    through: Callable[..., Mapping[str, Any]] | None = None,
    subject_to: str | Sequence[str] = (),
    starts: Sequence[ByName] | None = None,
    guesses: Sequence[Mapping[str, Any]] = (),
    uncertain: Mapping[Any, Any] | None = None,
    robust: str = "worst",
    samples: int = 16,
    evaluations: int = 10_000,
    seed: int = 0,
    margin: float = 1e-3,
    periods: int = 300,
    settle: float = 1e-6,
    tolerance: float = 1e-8,
    refinement: int | None = None,
    spread_starts: int = 64,
    store: str | Path | None = None,
    resume: bool = False,
    threads: int | None = None,
    progress: Progress = None,
) -> Optimum:
    """The design whose settled and stable motion has the best measure, or the most robust one under uncertainty.

    Populations of designs run as ensembles in a restarted differential evolution. The best candidates are closed to
    periodic orbits, whose multipliers have to be within the unit circle by a margin, and refined on those orbits.

    over: {path: (low, high) or "LOW:HIGH" or "log:LOW:HIGH"}, or a list of choices (words, three or more numbers)
    objective: the measure; sense: "maximise" or "minimise"; by default costs and times are minimised, all else is
        maximised. Of a system with mirror-image solutions the size of travel counts, not its sign; a design whose
        drive, unlike that of the system, has no mirror-image solution keeps the sign in its value
    through: None, or a function of variables of one's own, as in `robustness`: `over` then names its arguments, it is
        called with an array [n] of each and returns arrays by path, such as those of `drive_shape`
    subject_to: constraints such as "least_reaction > 0.1", limits in SI where the results of the system are
    starts: from which each design runs, by state; by default the start of the case. Its best motion counts
    guesses: designs with which the search begins, such as `Optimum.design` of a smaller problem; none is needed
    uncertain: None, or uncertain quantities, as in `robustness`: each design runs with `samples` samples of them. Of a
        design variable, "factor:..." is its manufacturing tolerance
    robust: statistic of the samples: the "worst", their "mean", or the mean of the worst tenth ("cvar"). A run that
        lifts off counts as no travel; constraints hold for every sample
    evaluations: designs, about (a whole number of populations); seed: the same one gives the same bits, on any threads
    margin: by which the largest multiplier has to be below 1
    periods, settle, tolerance: of the runs, see `ensemble`; refinement: orbits that are closed for a candidate, at
        most; by default 300, and 100 for each variable where there are more than three
    spread_starts: initial conditions of the search for other attractors of the best design; 0: none
    store, resume: a folder for all populations, from which an interrupted search continues

    Returns an `Optimum`. Raises CaseError with every complaint about system, over, objective and subject_to,
    ArgumentError for another argument, before any work.
    """
    asked: dict[str, Any] = {"periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    asked |= {"through": through, "uncertain": uncertain, "robust": robust, "samples": samples, "guesses": guesses}
    asked |= {"evaluations": (evaluations, 1), "seed": (seed, 0), "spread_starts": (spread_starts, 0)}
    asked |= {"margin": margin, "refinement": (0 if refinement is None else refinement, 0)}
    problem = stated_problem(system, over, [objective], [sense], subject_to, starts, **asked)
    kept = None if store is None else opened_store(store, problem.record(seed), resume)
    search = Evaluations(problem, evaluations, kept, told(progress))
    evolve(search, 0, seed, evaluations)
    if refinement is None:
        refinement = EACH * max(3, len(problem.space.variables))
    every = together(problem, search.found)
    designs, rejected = (None, ()) if stands(problem, every) else _refined(problem, search.found, refinement)
    return _optimum(problem, every, designs, rejected, spread_starts)


def _refined(
    problem: Problem, populations: list[Population], refinement: int
) -> tuple[ClosedDesigns | None, tuple[str, ...]]:
    """(the best candidate, refined; why better ones do not win)."""
    accepted: list[ClosedDesigns] = []
    rejected: list[str] = []
    for best_design in best_designs(problem, populations, APART, TRIED):
        if len(accepted) == REFINED:
            break
        near, why = closed_near(problem, best_design.shares, best_design.state)
        if near is None:
            unit, scale = measure_unit(problem.system, problem.goal.measure)
            value = said(abs(best_design.cost) * scale, unit, 6)
            rejected.append(f"{problem.goal.measure} {value}: {why}")
            continue
        near.refine(refinement // len(near.near))
        accepted.append(near)
    return max(accepted, key=lambda near: near.top.merit, default=None), tuple(rejected)


def closed_near(problem: Problem, shares: np.ndarray, state: dict[str, float]) -> tuple[ClosedDesigns | None, str]:
    """(designs about one whose run has settled at a state, closed from there, ""); (None, why) where it may not win."""
    system = problem.of(problem.space.parameters(shares))
    start = {name: x for name, x in state.items() if name in system.state_names}
    return judged(problem, shares, orbit(system, initial=start))


def judged(problem: Problem, shares: np.ndarray, steady: Orbit) -> tuple[ClosedDesigns | None, str]:
    """The same of a design whose orbit is known."""
    if steady.continuum:
        return None, "one of a continuum of orbits, so that the measure is not determined"
    near = ClosedDesigns(problem, steady, shares) if steady.closes else None
    if near is None or near.best is None:
        return None, f"its orbit: {steady.status.value}"
    if near.best.allowed:
        found = {name: np.array([[value]]) for name, value in near.best.found.items()}
        travels = problem.travels(found, near.best.shares[None]).all()
        return (near, "") if travels else (None, "its orbit does not travel")
    if near.best.margins[-1] < 0.0:
        return None, f"largest multiplier {np.max(np.abs(steady.multipliers)):.6g}"
    margins = zip(problem.goal.constraints, near.best.margins, strict=False)
    broken = [constraint.words for constraint, margin in margins if margin < 0.0]
    return None, f"violates {', '.join(broken)} on its orbit" if broken else "its motion is not certified"


def _nearest(problem: Problem, every: Population) -> tuple[dict[str, Number | str], str]:
    """The design that came nearest to being allowed, and what it lacks."""
    k = int(np.argmin(every.best_cost))
    start, cost = int(every.best_start[k]), float(every.best_cost[k])
    status = int(every.status[k, start])
    if cost >= FAILED:
        why = "a part refuses it" if status == REFUSED else list(Status)[status].value
    elif cost >= UNSETTLED:
        why = f"had not settled after {problem.periods} drive periods"
    elif cost < INFEASIBLE:
        why = "its orbit is not stable, or does not fulfil the constraints"
    else:
        lacking = []
        for constraint in problem.goal.constraints:
            value = float(every.found[constraint.measure][k, start])
            if not constraint.margin(value) >= 0.0:
                value *= measure_unit(problem.system, constraint.measure)[1]
                lacking.append(f"{constraint.measure} {value:.6g}, not {constraint.words}")
        why = ", ".join(lacking) or "no value of the measure"
    return problem.space.design(every.shares[k]), why


def stands(problem: Problem, every: Population) -> bool:
    """Whether designs settle within the constraints, and none of them travels as is asked."""
    settled = np.all(every.costs <= INFEASIBLE, axis=0)
    of = np.any(settled, axis=1)
    found = {name: values[of] for name, values in every.found.items()}
    return bool(np.any(of)) and not np.any(problem.travels(found, every.shares[of]) & settled[of])


def ending(problem: Problem, every: Population, won: bool, rejected: Collection[str]) -> OptimumStatus:
    """The end of a search; won: whether it has a design; rejected: why candidates have not won."""
    if not won and stands(problem, every):
        return OptimumStatus.NO_TRAVEL
    return OptimumStatus.FOUND if won else OptimumStatus.NOT_STABLE if rejected else OptimumStatus.NOT_ALLOWED


def _optimum(
    problem: Problem, every: Population, near: ClosedDesigns | None, rejected: tuple[str, ...], spread_starts: int
) -> Optimum:
    """The result of a search."""
    goal, system, starts = problem.goal, problem.system, tuple(dict(start) for start in problem.starts)
    unit, scale = measure_unit(system, next(iter(problem.measures)))
    status = ending(problem, every, near is not None, rejected)
    common: dict[str, Any] = {"measure": goal.measure, "maximised": goal.maximise, "unit": unit, "scale": scale}
    common |= {"starts": starts, "counts": every.counts(), "rejected": rejected, "population": every}
    if near is None:
        nothing: dict[str, Any] = {"constraints": {}, "limits": (), "slopes": {}, "reached_from": ()}
        nothing |= dict.fromkeys(("design", "value", "orbit", "under", "attractors", "attractor"))
        nearest = None if status is OptimumStatus.NO_TRAVEL else _nearest(problem, every)
        return Optimum(status, **nothing, **common, nearest=nearest)
    best = near.top
    steady = Orbit.of(best.solution, near.map_.of(best.solution.system))
    others = None
    if spread_starts:
        start = {name: problem.starts[0].get(name, 0.0) for name in steady.system.state_names}
        begun = within_room(steady.system, start)
        others = attractors(steady.system, spread_starts, initial=begun, threads=problem.threads, progress=False)
    value = best.found[goal.measure]
    turned = goal.size and value < 0.0 and steady.system.mirrored
    steady = steady.twin() if turned else steady
    runs = evaluated(problem, best.shares[None])
    with np.errstate(invalid="ignore"):
        away = np.abs(goal.merit(runs.found[goal.measure][0]) - best.merit)
    reached = np.flatnonzero(runs.settled[0] & (away <= REACHED * max(abs(best.merit), 1e-12)))
    sign = -scale if turned else scale
    slopes = {path: tuple(None if x is None else float(sign * x) for x in pair) for path, pair in near.slopes().items()}
    constraints, under = {}, None
    for constraint in goal.constraints:
        constraints[constraint.words] = best.found[constraint.measure] * measure_unit(system, constraint.measure)[1]
    if problem.samples is not None:
        under = problem.samples.criterion, float(np.mean([one is not None for one in best.solutions[1:]]))
    return Optimum(
        status,
        **common,
        design=problem.space.design(best.shares),
        value=float(sign * value),
        orbit=steady,
        constraints=constraints,
        limits=near.limits(),
        slopes=slopes,  # type: ignore[arg-type]
        reached_from=tuple(map(int, reached)),
        attractors=others,
        attractor=None if others is None else others.of(steady),
        nearest=None,
        under=under,
    )
