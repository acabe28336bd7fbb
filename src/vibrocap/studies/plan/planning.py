"""Planning: from what a user asks for to a checked study, or every complaint at once."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

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
from vibrocap.physics.names import number_in, split_path
from vibrocap.physics.system import System
from vibrocap.studies.plan import variation
from vibrocap.studies.plan.axes import Grid, axis_of
from vibrocap.studies.plan.cases import CaseList, case_list
from vibrocap.studies.plan.checks import kind_choices, plan_complaints
from vibrocap.studies.plan.designs import Design, Drawn, range_from
from vibrocap.studies.plan.runs import Column, Runs
from vibrocap.studies.plan.study import Study
from vibrocap.studies.plan.variation import kinds_chosen, path_complaints, plainly, with_varied_parts


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
    """What is wrong with the settings of the runs."""
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
    """The values of the first run with each combination of kinds."""
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
