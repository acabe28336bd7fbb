"""Planning: from what a user asks for to a checked study, or every complaint at once, before any work."""

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, check_choice, check_threshold, is_whole, shown
from vibrocap.case.case import RUN_DEFAULTS, Case, CaseError
from vibrocap.case.sections import is_kind, is_part
from vibrocap.measures.during_run import resolved, unavailable
from vibrocap.measures.measure import Measure
from vibrocap.measures.recorded.settling import usual_threshold
from vibrocap.measures.recorded.windows import usual_window
from vibrocap.measures.standard import LOAD_WATCH, OUTCOME, known_measure
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.physics.names import number_in, split_path
from vibrocap.physics.system import System
from vibrocap.studies.plan import variation
from vibrocap.studies.plan.designs import Design, Drawn, range_from
from vibrocap.studies.plan.runs import CaseList, Column, Grid, Runs, axis_of, case_list
from vibrocap.studies.plan.study import Study
from vibrocap.studies.plan.variation import kinds_chosen, path_complaints, plainly, refusal, with_varied_parts

LIMIT = 20_000  # combinations tried before any work (some 20 microseconds each); the others are looked at tile by tile
SHOWN = 20  # complaints about single cases


def plan_complaints(system: System, plan: Runs) -> list[str]:
    if isinstance(plan, CaseList):
        return _case_complaints(system, plan)
    kinds = [kinds_chosen(system, kinds) for kinds in kind_choices(plan)]
    complaints = path_complaints(plan.paths, kinds, system.units)
    if complaints:
        return complaints
    return _merged(complaint for values in _trials(system, plan) for complaint in refusal(system, values))


def check_runs(system: System, values: Mapping[str, np.ndarray]) -> None:
    """CaseError for the first run whose values are refused; values: arrays [runs] by path."""
    names = [path for path in values if not path.startswith(INITIAL)]
    for row in dict.fromkeys(zip(*(values[path].tolist() for path in names), strict=True)):
        run = {path: value for path, value in zip(names, row, strict=True) if value is not None and value == value}
        if complaints := refusal(system, run):
            raise CaseError(complaints, "the run with " + ", ".join(f"{path} = {x}" for path, x in run.items()))


def kind_choices(plan: Runs) -> Iterator[dict[str, Any]]:
    """Every combination of kinds in a grid; of a design there is one, that of the case."""
    axes = [axis for axis in plan.axes if is_kind(axis.path)] if isinstance(plan, Grid) else []
    for kinds in itertools.product(*(axis.values for axis in axes)):
        yield {axis.path: kind for axis, kind in zip(axes, kinds, strict=True)}


def _case_complaints(system: System, plan: CaseList) -> list[str]:
    complaints = []
    for number in range(plan.count):
        case = plan.case(number)
        texts = path_complaints(case, [kinds_chosen(system, case)], system.units)
        if not texts and number < LIMIT:
            texts = list(refusal(system, case))
        complaints += [Complaint(f"cases[{number}]", complaint) for complaint in texts]
        if len(complaints) >= SHOWN:
            return [*complaints[:SHOWN], "and perhaps more"]
    return complaints


def _trials(system: System, plan: Runs) -> Iterator[dict[str, Any]]:
    """Values to try: all combinations that matter where they are few, else the corners and what lies along them."""
    if isinstance(plan, Drawn):
        ranges = [span for span in plan.ranges if not span.path.startswith(INITIAL)]
        ends = [Column(span.path, (span.low, span.high)) for span in ranges]
        yield from itertools.islice(_crossed(ends), LIMIT)
        return
    assert isinstance(plan, Grid)
    first = {axis.path: axis.values[0] for axis in plan.axes if not axis.path.startswith(INITIAL)}
    for kinds in kind_choices(plan):
        yield first | kinds
    parts: dict[str, list[Column]] = {}
    for axis in plan.axes:
        if not is_kind(axis.path) and not axis.path.startswith(INITIAL):
            parts.setdefault(split_path(axis.path)[0], []).append(axis)
    for kinds, (part, axes) in itertools.product(kind_choices(plan), parts.items()):
        chosen = kinds_chosen(system, kinds)[part]
        kind = chosen if isinstance(chosen, type) else type(chosen)
        # Where a part has rules between its fields, values that are good one by one may be refused together.
        ruled = bool(kind.__pydantic_decorators__.model_validators) or hasattr(kind, "__post_init__")
        few = int(np.prod([len(axis.values) for axis in axes], dtype=object)) <= LIMIT
        for values in _crossed(axes) if ruled and few else _along(axes, ruled):
            yield first | kinds | values


def _crossed(axes: list[Column]) -> Iterator[dict[str, Any]]:
    for values in itertools.product(*(axis.values for axis in axes)):
        yield dict(zip((axis.path for axis in axes), values, strict=True))


def _along(axes: list[Column], ruled: bool) -> Iterator[dict[str, Any]]:
    """Each axis on its own; between the corners of the others where values must suit each other."""
    share = max(1, LIMIT // (len(axes) * (2 ** (len(axes) - 1) if ruled else 1)))
    for axis in axes:
        others = [Column(other.path, _ends(other)) for other in axes if other is not axis] if ruled else []
        step = -(-len(axis.values) // share)
        thinned = dict.fromkeys([*_ends(axis), *axis.values[::step]])
        for rest in itertools.islice(_crossed(others), LIMIT):
            for value in thinned:
                yield rest | {axis.path: value}


def _ends(axis: Column) -> tuple[Any, ...]:
    numbers = [value for value in axis.values if isinstance(value, (int, float))]
    return tuple(dict.fromkeys([*([min(numbers), max(numbers)] if numbers else []), axis.values[0]]))


def _merged(complaints: Iterable[str]) -> list[str]:
    """One line per field: its first complaint, and how many more values are refused."""
    kinds: dict[str, dict[str, None]] = {}
    for complaint in complaints:
        what = re.sub(r"\(.*?\)|, got .*", "", complaint)
        kinds.setdefault(what, {})[complaint] = None
    more = [len(texts) - 1 for texts in kinds.values()]
    firsts = [next(iter(texts)) for texts in kinds.values()]
    return [first + (f" (and {n} more such)" if n else "") for first, n in zip(firsts, more, strict=True)]


def planned_study(
    system: System,
    over: Mapping[str, Any] | None,
    *,
    measures: Sequence[str | Measure],
    cases: Iterable[Mapping[str, Any]] | None,
    design: Design | None,
    initial: Mapping[str, float] | None,
    settings: Mapping[str, Any],
    also: Iterable[str] = (),
) -> Study:
    """The study that the arguments of `sweep` describe; settings: all on how the runs are made.

    Raises CaseError with every complaint, after those in `also`.
    """
    complaints = Complaints([*also, *setting_complaints(settings)])
    plan, of_plan = _plan(over, cases, design)
    fuller = with_varied_parts(system, over if isinstance(over, Mapping) else plan.paths)
    if isinstance(over, Mapping) and (plain := plainly(over, system)) != over:
        plan, of_plan = _plan(over := plain, cases, design)
    measures, study = _measures(measures, fuller)
    complaints += study
    with complaints.collected():
        initial_state(system, initial)
    complaints += of_plan
    system = fuller
    if not of_plan:
        complaints += plan_complaints(system, plan)
    elif isinstance(over, Mapping):
        complaints += path_complaints(over, [kinds_chosen(system, kinds) for kinds in kind_choices(plan)], system.units)
    if not complaints:
        complaints += _lacking(measures, system, plan)
    if complaints:
        raise CaseError(complaints, "the study")
    run: dict[str, Any] = {name: settings[name] for name in RUN_DEFAULTS}
    run |= {name: int(value) for name, value in run.items() if name != "tolerance"}
    run["tolerance"] = float(run["tolerance"])
    start = {name: float(value) for name, value in (initial or {}).items()}
    settle, window = settings["settle"], settings["window"]
    settle = usual_threshold(run["tolerance"]) if settle is None else float(settle) or None  # 0: never
    window = usual_window(run["periods"]) if window is None else int(window)
    if isinstance(plan, CaseList):
        plan = CaseList(tuple(_without_unsaid_words(system, plan, column) for column in plan.columns))
    measures = with_load_watch(system, plan, measures)
    if settle and not equations(system).timed and OUTCOME not in measures:
        measures = (*measures, OUTCOME)
    return Study(Case(system, start, **run), plan, measures, window, settle, extrapolate=bool(settings["extrapolate"]))


def with_load_watch(system: System, plan: Runs, measures: Sequence[str | Measure]) -> tuple[str | Measure, ...]:
    """Measures and, of a machine whose constant load may hide a lift-off, the least true load, which costs little.

    A load that follows the motion hides none: there a run ends.
    """
    machine = system.machine
    names = {measure if isinstance(measure, str) else measure.name for measure in measures}
    follows = machine.follows_load and "machine.normal_load" not in plan.paths
    reactions = [name for name in equations(system).observables if number_in(name, "reaction")]
    if follows or LOAD_WATCH in names or names >= {f"least_{name}" for name in reactions}:
        return tuple(measures)
    return (*measures, LOAD_WATCH)


def setting_complaints(settings: Mapping[str, Any]) -> list[str]:
    complaints = Complaints()
    for name in RUN_DEFAULTS:
        with complaints.collected():
            check_run(**(RUN_DEFAULTS | {name: settings[name]}))
            if name == "periods" and settings[name] != int(settings[name]):
                complaints.add("periods", f"a study runs whole drive periods, got {settings[name]!r}")
    if not complaints and settings["window"] is not None and not is_whole(settings["window"], 1, settings["periods"]):
        limit = f"from 1 to the {settings['periods']} periods of a run"
        complaints.add("window", f"should be a whole number of drive periods {limit}, got {shown(settings['window'])}")
    with complaints.collected():
        check_threshold("settle", settings["settle"] or None)
        check_choice("extrapolate", settings["extrapolate"])
    return complaints


def _measures(asked: Any, system: System) -> tuple[tuple[str | Measure, ...], list[str]]:
    """The measures, those of the table by name, without repetition; and what is wrong with them."""
    listed = [asked] if isinstance(asked, (str, Measure)) else list(asked)
    complaints = Complaints()
    if not listed:
        complaints.add("measures", "there are none; ask for at least one, such as 'mean_velocity'")
    for measure in listed:
        with complaints.collected():
            resolved([measure, *(other for other in listed if isinstance(other, Measure))], system)
    if complaints:
        return (), list(dict.fromkeys(complaints))
    names = [m.name if isinstance(m, Measure) and known_measure(m.name, system) == m else m for m in listed]
    return tuple(dict.fromkeys(names)), []


def _lacking(measures: Sequence[str | Measure], system: System, plan: Runs) -> list[str]:
    """Complaints about measures that no kind of parts of a study has; where another kind has one, it is NaN."""
    reasons = []
    for case in _first_runs(plan):
        varied = variation.varied(system, case)
        reasons.append(unavailable(resolved(measures, varied)[1], varied))
    names = [measure if isinstance(measure, str) else measure.name for measure in measures]
    return [Complaint("measures", reasons[0][name]) for name in names if all(name in reason for reason in reasons)]


def _first_runs(plan: Runs) -> list[dict[str, Any]]:
    if isinstance(plan, CaseList):
        runs = [plan.case(number) for number in range(plan.count)]
    else:
        first = {path: column[0] for path, column in plan.values((slice(0, 1),) * len(plan.shape)).items()}
        runs = [first | kinds for kinds in kind_choices(plan)]
    return [*{tuple(x for path, x in run.items() if is_kind(path)): run for run in reversed(runs)}.values()]


def _plan(over: Any, cases: Any, design: Any) -> tuple[Runs, list[str]]:
    """The plan, and what is wrong with how it is given."""
    nothing = Grid(())
    if cases is not None:
        if over or design is not None:
            return nothing, [Complaint("cases", "stand alone; leave `over` and `design` out")]
        return case_list(cases)
    if not isinstance(over, Mapping) or not over:
        wanted = "should name at least one quantity with its values, such as machine.mass_ratio=1:3:21"
        return nothing, [Complaint("over", wanted)]
    if design is None:
        axes = [axis_of(path, values) for path, values in over.items()]
        good = tuple(axis for axis, complaints in axes if not complaints)
        return Grid(good), [complaint for _, entry in axes for complaint in entry]
    if not isinstance(design, Design):
        return nothing, [Complaint("design", f"should be a Design, got {shown(design)}")]
    ranges = [range_from(path, ends) for path, ends in over.items()]
    complaints = [*design.complaints(), *(complaint for _, entry in ranges for complaint in entry)]
    return Drawn(design, tuple(ranged for ranged, _ in ranges)), complaints


def _without_unsaid_words(system: System, plan: CaseList, column: Column) -> Column:
    """The column, with a word such as "weight" written out where a case gives no value and the system has that word.

    So a column in which words may stand is seen to hold words, and is stored as text.
    """
    part, name = split_path(column.path)
    if is_kind(column.path) or not is_part(part):
        return column
    values = list(column.values)
    for number, value in enumerate(values):
        if value is None:
            known = variation.values_chosen(system, kinds_chosen(system, plan.case(number)))
            own = known.get(part, {}).get(name)
            values[number] = own if isinstance(own, str) else None
    return Column(column.path, tuple(values))
