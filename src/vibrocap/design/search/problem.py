"""A design problem: variables, goals (measures to make large or small, with constraints on measures) and the run of a
design. Wrong input is refused here.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaints, check_one_of, check_whole, is_number, is_positive, shown
from vibrocap.case.case import Case, CaseError
from vibrocap.design.search.uncertainty import CRITERIA, Samples, samples_of, uncertain_quantities
from vibrocap.design.search.variables import DesignSpace, design_space
from vibrocap.measures import of_measure
from vibrocap.measures.during_run import resolved, unavailable
from vibrocap.measures.measure import Measure
from vibrocap.measures.standard import COST
from vibrocap.motion.simulate import initial_state
from vibrocap.motion.trust import TRAVEL
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.physics.system import System
from vibrocap.studies.plan.runs import Column, Grid
from vibrocap.studies.plan.study import Study, code_version, function_fingerprint
from vibrocap.studies.plan.variation import residues, varied

SENSES = ("maximise", "minimise")
MINIMISED = (COST, "time_to_settle")  # which nobody wants large
FORM = "MEASURE > NUMBER or MEASURE < NUMBER, such as 'least_reaction > 0.1'"
INFEASIBLE, UNSETTLED, FAILED = 1e100, 2e100, 3e100  # costs, beyond those of any design that is allowed


@dataclasses.dataclass(frozen=True)
class Constraint:
    """A bound on a measure: at least `limit` where `at_least`, else at most. Without units, as measures are."""

    measure: str
    at_least: bool
    limit: float
    words: str

    def margin(self, value: Any) -> Any:
        """How far a value, or an array of them, is on the allowed side; negative where it is violated."""
        return value - self.limit if self.at_least else self.limit - value


@dataclasses.dataclass(frozen=True)
class Goal:
    """What a design is to achieve: a measure, whether a large or a small one is better, and constraints.

    size: whether the size of the measure counts, not its sign: the mirror-image solution of a motion travels the other
    way
    """

    measure: str
    maximise: bool
    constraints: tuple[Constraint, ...]
    size: bool

    @property
    def travels(self) -> bool:
        """Whether the measure says how far or how fast the machine travels, with a direction."""
        return self.measure in TRAVEL

    @property
    def asks_for_travel(self) -> bool:
        """Whether a design that does not travel has nothing of what is asked."""
        return self.measure == COST or (self.travels and not (self.size and not self.maximise))

    @property
    def words(self) -> str:
        """The goal in a line."""
        sense = "largest" if self.maximise else "least"
        subject = f", {', '.join(constraint.words for constraint in self.constraints)}" if self.constraints else ""
        return f"{sense} {'size of ' if self.size else ''}{self.measure}{subject}"

    def merit(self, value: Any) -> Any:
        """What is to be made as large as possible, of a value of the measure or an array of them."""
        sized = np.abs(value) if self.size else np.asarray(value)
        return sized if self.maximise else -sized

    def over_samples(
        self, measured: Mapping[str, np.ndarray], finished: np.ndarray, statistic: Callable[[np.ndarray], np.ndarray]
    ) -> dict[str, np.ndarray]:
        """Measures [..., samples] of one design under uncertainty as one value each, [...].

        Of the goal it is that statistic of the merits; a run that failed counts as no travel, and leaves no value of
        another measure. Of a constraint it is the value of the sample that comes nearest to violating it.
        """
        reduced = {}
        for constraint in self.constraints:
            values = np.where(finished, measured[constraint.measure], np.nan)
            margins = np.where(np.isnan(values), -np.inf, constraint.margin(values))
            nearest = np.argmin(margins, axis=-1)[..., None]
            reduced[constraint.measure] = np.take_along_axis(values, nearest, axis=-1)[..., 0]
        values = np.where(finished, measured[self.measure], 0.0 if self.travels else np.nan)
        direction = np.ones(values.shape[:-1])
        if self.size:
            direction = np.where(np.sum(values, axis=-1) < 0.0, -1.0, 1.0)
        sign = direction if self.maximise else -direction
        reduced[self.measure] = sign * statistic(sign[..., None] * values)
        return reduced

    def costs(self, measured: Mapping[str, np.ndarray], settled: np.ndarray, failed: np.ndarray) -> np.ndarray:
        """What a search makes as small as possible, an array like those given.

        Allowed designs come first, by merit; then those that violate a constraint, by how much; then those that did not
        settle; then those that failed.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            violation = np.zeros(settled.shape)
            for constraint in self.constraints:
                lacking = np.maximum(-constraint.margin(measured[constraint.measure]), 0.0)
                lacking = lacking / max(abs(constraint.limit), 1e-3)
                violation += np.where(np.isnan(lacking), np.inf, lacking)
            cost = -self.merit(measured[self.measure])
            share = np.where(np.isinf(violation), 1.0, violation / (1.0 + np.where(np.isinf(violation), 0, violation)))
        cost = np.where(np.isfinite(cost), cost, INFEASIBLE)
        cost = np.where(violation > 0.0, INFEASIBLE * (1.0 + 0.5 * share), cost)
        return np.where(failed, FAILED, np.where(settled, cost, UNSETTLED))


def goal_of(
    system: System,
    objective: Any,
    sense: Any,
    subject_to: Any,
    complaints: Complaints,
    fields: tuple[str, str] = ("objective", "sense"),
) -> tuple[Goal, tuple[str | Measure, ...]]:
    """(the goal that the arguments of `optimise` describe, the measures to ask for); complaints are added.

    fields: what the objective and its sense are called in complaints
    Limits of constraints are in SI where the results of the system are.
    """
    nothing = Goal("mean_velocity", True, (), False)
    texts = [subject_to] if isinstance(subject_to, str) else list(subject_to or ())
    split = [_split(text, complaints) for text in texts]
    asked: list[str | Measure] = []
    for field, name in [(fields[0], objective), *(("subject_to", part[0]) for part in split if part)]:
        try:
            measures, needed = resolved([name], system)
            if lacking := unavailable(needed, system):
                raise ArgumentError(field, next(iter(lacking.values())))
        except ValueError as error:
            complaint = getattr(error, "complaint", None)
            complaints.add(field, complaint.text if complaint else str(error))
            continue
        if getattr(measures[0].how, "text", False):
            complaints.add(field, f"{measures[0].name!r} is a text; give a measure that is a number")
        asked.append(name)
    if sense is not None:
        with complaints.collected():
            check_one_of(fields[1], sense, SENSES)
    if complaints:
        return nothing, ()
    constraints = tuple(
        Constraint(measure, at_least, limit / measure_unit(system, measure)[1], words)
        for measure, at_least, limit, words in filter(None, split)
    )
    name = objective.name if isinstance(objective, Measure) else objective
    maximise = name not in MINIMISED if sense is None else sense == "maximise"
    size = name in TRAVEL and system.mirrored
    return Goal(name, maximise, constraints, size), tuple(dict.fromkeys(asked))


def asked_case(
    system: System | Case, settle: Any, complaints: Complaints, driven: bool = False, **counts: tuple[Any, int]
) -> Case:
    """The case of a question about settled motions; complaints are added.

    driven: whether something has to drive it; counts: further arguments by name, each with its value and the least
    whole number that it may be
    """
    case = system if isinstance(system, Case) else Case(system)
    for name, (value, least) in counts.items():
        with complaints.collected():
            check_whole(name, value, least)
    if not is_positive(settle):
        complaints.add("settle", f"should be a positive threshold such as 1e-6, got {shown(settle)}")
    if driven and not is_driven(case.system):
        complaints.add("system", "should have a drive that changes in time")
    return case


def _split(text: Any, complaints: Complaints) -> tuple[str, bool, float, str] | None:
    """(measure, at least, limit, words) of a constraint."""
    match = re.fullmatch(r"\s*([A-Za-z_]\w*)\s*(>=?|<=?)\s*(\S+)\s*", text) if isinstance(text, str) else None
    try:
        limit = float(match[3]) if match else math.nan
    except ValueError:
        limit = math.nan
    if match is None or not math.isfinite(limit):
        complaints.add("subject_to", f"should be {FORM}, got {shown(text)}")
        return None
    return match[1], match[2][0] == ">", limit, f"{match[1]} {match[2]} {match[3]}"


def measure_unit(system: System, measure: str | Measure) -> tuple[str, float]:
    """(unit of a measure in the results of a system, what one dimensionless unit is in it)."""
    (known,), _ = resolved([measure], system)
    unit, scale = of_measure.measure_unit(known, system)
    return unit, 1.0 if scale is None else scale


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

    @property
    def measure_names(self) -> list[str]:
        """Names of the measures."""
        return [measure if isinstance(measure, str) else measure.name for measure in self.measures]

    def of(self, design: Mapping[str, Any]) -> System:
        """The system of a design."""
        return varied(self.system, design)

    def variants(self, design: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        """The values of a design itself, then with each sample of what is uncertain."""
        return [design, *(self.samples.variants(design) if self.samples else [])]

    def travels(self, measured: Mapping[str, Any], shares: np.ndarray) -> np.ndarray:
        """Whether motions travel by more than the residue of settled runs; True where no goal asks for travel.

        measured: measures of the goals by name, [designs, starts]; shares: of the designs [designs, variables]
        """
        travel, values = np.ones((len(shares), 1), dtype=bool), self.space.values(shares)
        for goal in self.goals if len(shares) else ():
            if goal.asks_for_travel:
                size = np.abs(measured[goal.measure])
                left = residues(self.system, values, len(shares), goal.measure, self.settle)
                travel = travel & np.isfinite(size) & (size > left[:, None])
        return travel

    def record(self, seed: int, **further: Any) -> dict[str, Any]:
        """All that decides the populations of a search with a seed, for its store; code of one's own is part of it."""
        choices = tuple(variable for variable in self.space.variables if isinstance(variable, Column))
        study = Study(Case(self.system), Grid(choices), self.measures, code=code_version(drawn=True)).record()
        through = {"through": function_fingerprint(self.space.through)} if self.space.through else {}
        goal = self.goal.words if len(self.goals) == 1 else [goal.words for goal in self.goals]
        return {
            **{name: study[name] for name in ("case", "code", "measures", "parts") if name in study},
            **through,
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
    case = asked_case(system, settle, complaints, driven=True, **counts)
    system = case.system
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
