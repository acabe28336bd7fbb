"""Goals: the measure that a design is to make large or small, and constraints on measures."""

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaints, check_one_of, check_whole, is_positive, shown
from vibrocap.case.case import Case
from vibrocap.measures import of_measure
from vibrocap.measures.during_run import resolved, unavailable
from vibrocap.measures.measure import Measure
from vibrocap.measures.standard import COST
from vibrocap.motion.trust import TRAVEL
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.physics.system import System

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
    def measures(self) -> tuple[str, ...]:
        """All measures that have to be known."""
        return tuple(dict.fromkeys((self.measure, *(constraint.measure for constraint in self.constraints))))

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


def asked_case(system: System | Case, settle: Any, complaints: Complaints, **counts: tuple[Any, int]) -> Case:
    """The case of a question about settled motions; complaints are added.

    counts: further arguments by name, each with its value and the least whole number that it may be
    """
    case = system if isinstance(system, Case) else Case(system)
    for name, (value, least) in counts.items():
        with complaints.collected():
            check_whole(name, value, least)
    if not is_positive(settle):
        complaints.add("settle", f"should be a positive threshold such as 1e-6, got {shown(settle)}")
    return case


def twice(paths: Sequence[str], system: System) -> str | None:
    """The first of some paths that names the same quantity as another; None where there is none."""
    plain = [quantity(path, system).plain for path in paths]
    return next((path for path, one in zip(paths, plain, strict=True) if plain.count(one) > 1), None)


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


def names(measures: Iterable[str | Measure]) -> list[str]:
    """Names of measures."""
    return [measure if isinstance(measure, str) else measure.name for measure in measures]
