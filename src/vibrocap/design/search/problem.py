"""A design problem: variables, goals and the run of a design. Wrong input is refused here."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, check_one_of, check_whole, is_number, shown
from vibrocap.case.case import Case, CaseError, case_text
from vibrocap.design.search.goal import Goal, asked_case, goal_of
from vibrocap.design.search.uncertainty import CRITERIA, Samples, samples_of, uncertain_quantities
from vibrocap.design.search.variables import DesignSpace, design_space
from vibrocap.measures.measure import Measure
from vibrocap.motion.simulate import initial_state
from vibrocap.motion.trust import residue
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import varied


@dataclasses.dataclass(frozen=True)
class Problem:
    """What is looked for, and how its runs are made.

    goals: one, or several for a Pareto front; each has the same constraints
    measures: all that the goals need; starts: from which each design runs; margin: by which the largest multiplier has
    to be below 1; samples: of what is uncertain, with which each design is run; guesses: [designs, variables] shares of
    designs with which the search begins
    """

    system: System
    space: DesignSpace
    goals: tuple[Goal, ...]
    measures: tuple[str | Measure, ...]
    starts: tuple[Mapping[str, float], ...]
    periods: int
    settle: float
    tolerance: float
    margin: float
    threads: int | None = None
    samples: Samples | None = None
    guesses: tuple[tuple[float, ...], ...] = ()

    @property
    def goal(self) -> Goal:
        """The first goal."""
        return self.goals[0]

    def of(self, design: Mapping[str, Any]) -> System:
        """The system of a design."""
        return varied(self.system, design)

    def variants(self, design: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        """The values of a design itself, then with each sample of what is uncertain."""
        return [design, *(self.samples.variants(design) if self.samples else [])]

    def travels(self, measured: Mapping[str, Any]) -> Any:
        """Whether motions travel by more than the residue of settled runs; True where no goal asks for travel.

        measured: measures of the goals by name, numbers or arrays
        """
        asked = [goal.measure for goal in self.goals if goal.asks_for_travel]
        sizes = [(np.abs(measured[name]), residue(self.system, name, self.settle)) for name in asked]
        return np.logical_and.reduce([np.isfinite(size) & (size > left) for size, left in sizes])

    def record(self, seed: int, **further: Any) -> dict[str, Any]:
        """All that decides the populations of a search with a seed, for its store."""
        from vibrocap import __version__

        goal = self.goal.words if len(self.goals) == 1 else [goal.words for goal in self.goals]
        return {
            "version": __version__,
            "case": case_text(Case(self.system)),
            "over": self.space.record(),
            "goal": goal,
            "starts": [dict(start) for start in self.starts],
            "seed": seed,
            **{name: getattr(self, name) for name in ("periods", "settle", "tolerance")},
            **({"uncertain": self.samples.words} if self.samples else {}),
            **({"guesses": [list(guess) for guess in self.guesses]} if self.guesses else {}),
            **further,
        }


def stated_problem(
    system: System | Case,
    over: Any,
    objectives: Sequence[str | Measure],
    senses: Sequence[str | None],
    subject_to: Any,
    starts: Any,
    *,
    through: Callable[..., Mapping[str, Any]] | None = None,
    periods: int,
    settle: float,
    tolerance: float,
    margin: float,
    threads: int | None,
    uncertain: Any = None,
    robust: str = "worst",
    samples: int = 16,
    guesses: Any = (),
    **counts: tuple[Any, int],
) -> Problem:
    """The problem that the arguments of `optimise` or `pareto_front` describe.

    counts: further arguments by name, each with its value and the least whole number that it may be
    Raises CaseError with every complaint, before any work.
    """
    complaints = Complaints()
    case = asked_case(system, settle, complaints, **counts)
    system = case.system
    if not is_driven(system):
        complaints.add("system", "should have a drive that changes in time")
    all_starts = [case.initial] if starts is None else list(starts)
    if not all_starts:
        complaints.add("starts", "should hold at least one start")
    if not (is_number(margin) and 0.0 <= margin < 1.0):
        complaints.add("margin", f"should be a number from 0 to 1, got {shown(margin)}")
    space = design_space(system, over, complaints, through)
    several = len(objectives) > 1
    goals: list[Goal] = []
    measures: dict[str | Measure, None] = {}
    for k, (objective, sense) in enumerate(zip(objectives, senses, strict=True)):
        fields = (f"objectives[{k}]", f"senses[{k}]") if several else ("objective", "sense")
        goal, needed = goal_of(system, objective, sense, subject_to if k == 0 else (), complaints, fields)
        goals.append(dataclasses.replace(goal, constraints=goals[0].constraints) if goals else goal)
        measures |= dict.fromkeys(needed)
    if several and len({goal.measure for goal in goals}) < len(goals) and not complaints:
        complaints.add("objectives", f"should be different measures, got {goals[0].measure} twice")
    first: list[tuple[float, ...]] = []
    for k, guess in enumerate(guesses if not complaints else ()):
        try:
            first.append(tuple(map(float, space.share_of(guess))))
        except ValueError as error:
            complaints.add(f"guesses[{k}]", str(error))
    drawn = None
    if uncertain is not None:
        drawn = _samples(system, space, uncertain, robust, samples, complaints)
    begun = []
    for start in all_starts:
        with complaints.collected():
            begun.append(initial_state(system, start))
    if complaints:
        raise CaseError(complaints, "the search")
    runs: dict[str, Any] = {"periods": periods, "settle": settle, "tolerance": tolerance, "threads": threads}
    further: dict[str, Any] = {"margin": margin, "samples": drawn, "guesses": tuple(first)}
    return Problem(system, space, tuple(goals), tuple(measures), tuple(begun), **runs, **further)


def _samples(
    system: System, space: DesignSpace, uncertain: Any, robust: Any, samples: Any, complaints: Complaints
) -> Samples | None:
    """Samples of what is uncertain in a search; complaints are added."""
    begun = len(complaints)
    quantities = uncertain_quantities(system, uncertain, complaints)
    with complaints.collected():
        check_one_of("robust", robust, CRITERIA)
    with complaints.collected():
        check_whole("samples", samples, 2, 2**16)
    if len(complaints) > begun:
        return None
    middle = space.parameters(np.full(len(space.variables), 0.5))
    varied_too = {quantity(path, system).plain: path for path in middle}
    for uncertain_one in quantities:
        for path in uncertain_one.paths:
            variable = varied_too.get(quantity(path, system).plain)
            if variable is not None and (variable != path or not uncertain_one.nominal):
                advice = f"its uncertainty should be {variable}=factor:..., a factor of it"
                complaints.add(path, f"is a design variable; {advice}")
    return samples_of(quantities, samples, robust)
