"""ensemble(system, over, ...): one run per entry of equally long lists of parameters, a few numbers of each."""

import copy
import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_choice, check_threshold, check_whole, is_number, suggestion
from vibrocap.measures.during_run import asked_groups, check_travel, resolved, unavailable, values
from vibrocap.measures.gathered import ALWAYS, Gathered, balanced
from vibrocap.measures.measure import Measure, own_integrands
from vibrocap.measures.of_measure import FINAL, ByMeasure
from vibrocap.measures.recorded.windows import usual_window
from vibrocap.motion.evidence import certified
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import STATUSES, check_room, check_run, initial_state
from vibrocap.motion.status import Status
from vibrocap.motion.trust import residue
from vibrocap.numerics import api as numerics
from vibrocap.numerics.expressions.graph import evaluated
from vibrocap.physics.closed_loop.sampling import MOST_SAMPLES
from vibrocap.physics.dimensions.conversion import values_without_units
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.names import split_path
from vibrocap.physics.parameters import ParameterError
from vibrocap.physics.system import System
from vibrocap.progress import reporting
from vibrocap.quantities.declared import ByName

MOST_PERIODS = 2**31 - 1
INITIAL = "initial."
# Index into list(Status) by the number that the kernel gives.
STATUS_CODES = np.zeros(max(STATUSES) + 1, dtype=np.int8)
for _number, _status in STATUSES.items():
    STATUS_CODES[_number] = list(Status).index(_status)
FINISHED = list(Status).index(Status.FINISHED)
NOT_CERTIFIED = list(Status).index(Status.NOT_CERTIFIED)


def ensemble(
    system: System,
    over: Mapping[str, Any],
    *,
    measures: Sequence[str | Measure] = ("mean_velocity",),
    initial: ByName | None = None,
    periods: int = 60,
    window: int | None = None,
    settle: float | None = None,
    extrapolate: bool = True,
    tolerance: float = 1e-8,
    max_events_per_period: int = 10_000,
    max_steps: int = 50_000_000,
    threads: int | None = None,
    device: str = "cpu",
    final_states: bool = False,
    progress: Callable[[int], None] | bool | None = None,
) -> ByMeasure:
    """Many runs of one machine, law and drive; their measures are kept.

    over: values by parameter path ("machine.mass_ratio") or initial state ("initial.angle"), [runs] each; of a system
        that knows its scales also in SI ("drive.frequency_Hz"), while the measures stay without units
    measures: names of `measure_table(system)`, or measures of one's own
    initial: start of all runs by state; others start at zero
    periods: whole drive periods, the budget of a run
    window: whole drive periods at the end of the budget that are measured where nothing settles; by default 10, or all
    settle: None, or the threshold of `measures.settling`, as a share of the natural size of each state: a run ends as
        soon as its stroboscopic state has come that near to a steady motion, and is measured over one response period
        (one or more drive periods) more. Where nothing drives the system in time, a run ends when the states in which a
        contact comes to rest repeat, after up to 62 returns, and is measured over one turn of the cycle more; or when
        it stands still. "Per drive period" is then per turn
    extrapolate: whether a run that settles may continue from the extrapolated limit of its stroboscopic states, where
        that returns to itself within the threshold with the run's own mode sequence (docs/numerics.md); never where
        `time_to_settle` is measured, of a rotor, of a response of several periods, or where nothing drives the system
    tolerance: error per step, relative to the natural size of each state
    threads: at most so many; by default all cores that the process may use
    device: "cpu", or a device that another package brings, such as "cuda" (docs/sweeps.md)
    final_states: whether to return "final.angle" and so on too, the states in which runs ended
    progress: True for a bar, or a function that is called now and then, from any thread, with the number of runs begun

    Returns arrays [runs] by name: "status", the index into list(Status); "settled"; "response_period" in drive periods
    (of a cycle of its own in returns), 0 where not settled; "window_start" and "window_periods" in drive periods (-1
    and 0 where none was begun; of a turn of a cycle 1); then the measures, NaN (for "mode_sequence" an empty text)
    where the run failed. A run is "not certified", with its measures, where evidence gathered during the run is beyond
    the bounds of a certificate (`motion.evidence`, and where works are measured `gathered.balanced`).

    The results have the same bits with any number of threads, in any order of the runs and division into calls; those
    of another device agree with them to rounding, with stiff bristles within the tolerance. Raises ValueError, naming
    the field, before any work.
    """
    start = initial_state(system, initial)
    asked, needed = resolved(measures, system)
    check_travel(needed, system)
    columns = _columns(system, over)  # without units from here on
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    check_whole("periods", periods, 1, MOST_PERIODS)
    window = usual_window(periods) if window is None else window
    check_whole("window", window, 1, int(periods))
    check_whole("threads", 1 if threads is None else threads, 1, 2**16)
    runner = numerics.device(device)
    run_all = functools.partial(runner.run, threads=threads)
    check_threshold("settle", settle)
    check_choice("extrapolate", extrapolate)
    _check_values(system, columns)
    _check_room(system, columns, start)
    budget = numerics.Budget(
        periods=int(periods),
        window=int(window),
        threshold=float(settle or 0.0),
        tolerance=float(tolerance),
        max_events_per_period=int(max_events_per_period),
        max_steps=int(max_steps),
        asked=asked_groups(needed),
        evidence=1,
        extrapolate=extrapolate and not asked_groups(needed) & numerics.codes.ASK_TRANSIENT,
    )
    runs = len(next(iter(columns.values())))
    finals = [FINAL + name for name in system.state_names] if final_states else []
    by_measure: dict[str, np.ndarray] = {}
    done = 0
    with reporting(None if callable(progress) else progress, "Running") as bar:
        tell = progress if callable(progress) else bar and (lambda begun: bar(begun / runs))
        for members in _chunks(system, columns, runner.chunk):
            report = None if tell is None else lambda begun, base=done: tell(base + begun)
            values = {path: column[members] for path, column in columns.items()}
            part = _measured(system, values, start, budget, needed, run_all, report)
            for name in (*ALWAYS, *(measure.name for measure in asked), *finals):
                if name not in by_measure:
                    kind = part[name].dtype
                    by_measure[name] = np.empty(runs, dtype=object if kind.kind == "U" else kind)
                by_measure[name][members] = part[name]
            done += len(members)
    return {name: column.astype(str) if column.dtype == object else column for name, column in by_measure.items()}


def _measured(
    system: System,
    columns: Mapping[str, np.ndarray],
    start: Mapping[str, float],
    budget: numerics.Budget,
    needed: Sequence[Measure],
    run_all: Callable,
    progress: Callable[[int], None] | None,
) -> dict[str, np.ndarray]:
    """Status and measures of runs that all have equations of one form."""
    runs = len(next(iter(columns.values())))
    one, parameters = _one_form(system, columns)
    lacking = unavailable(needed, one) if one.cyclic != system.cyclic else ()
    needed = [measure for measure in needed if measure.name not in lacking]
    recording = equations(one)
    states = np.tile(list(start.values()), (runs, 1))
    for path, column in columns.items():
        if path.startswith(INITIAL):
            states[:, recording.state_names.index(path.removeprefix(INITIAL))] = column
    if budget.threshold > 0.0 and not recording.timed:
        budget = dataclasses.replace(budget, returns=True, asked=budget.asked | numerics.codes.ASK_EXTREMES)
    begin = numerics.EnsembleStart(recording, parameters, states)
    results = run_all(begin, budget, numerics.Form(integrands=own_integrands(needed, recording)), progress=progress)
    period, *scales = evaluated([recording.period, *recording.scales], 0.0, states.T, 1.0, parameters.T, (runs,))
    status = STATUS_CODES[results.status]
    finished = status == FINISHED
    sizes = np.column_stack(scales)

    everything = Gathered(one, results, period, lambda: _mirrored(one, columns), budget.threshold, sizes)
    gathered = everything.some(finished)
    begun = results.head("window_start") >= 0
    good = certified(recording, gathered.results, parameters[finished], budget.tolerance)
    if budget.asked & numerics.codes.ASK_INTEGRALS:
        good &= balanced(recording, gathered, parameters[finished], budget.tolerance)
    status[np.flatnonzero(finished)[~good]] = NOT_CERTIFIED
    by_measure = {
        "status": status,
        "settled": everything.settled,
        "response_period": everything.response_period.astype(np.int16),
        "window_start": results.head("window_start").astype(np.int32),
        "window_periods": np.where(begun, everything.periods, 0).astype(np.int32),
        **{FINAL + name: results.state[:, i] for i, name in enumerate(recording.state_names)},
    }
    for name, value in values(needed, gathered).items():
        if name not in by_measure:
            by_measure[name] = np.full(runs, "" if value.dtype.kind == "U" else np.nan, dtype=value.dtype)
            by_measure[name][finished] = value
    return by_measure | {name: np.full(runs, np.nan) for name in lacking}


def residues(system: System, over: Mapping[str, Any], measure: str, threshold: float) -> np.ndarray:
    """The residue (`motion.trust`) of a measure of each run that settled to a threshold [runs]; over: as `ensemble`."""
    columns = _columns(system, over)
    runs = len(next(iter(columns.values())))
    left = np.empty(runs)
    for members in _chunks(system, columns, runs):
        one, parameters = _one_form(system, {path: column[members] for path, column in columns.items()})
        left[members] = residue(one, measure, threshold, parameters)
    return left


def _one_form(system: System, columns: Mapping[str, np.ndarray]) -> tuple[System, np.ndarray]:
    """(the system of the first run, the parameters [runs, parameters]) of runs that have equations of one form."""
    one = _system_of_run(system, columns, 0)
    paths = equations(one).parameter_paths
    parameters = np.tile(parameter_values(one), (len(next(iter(columns.values()))), 1))
    for path in columns.keys() & set(paths):
        parameters[:, paths.index(path)] = columns[path]
    return one, parameters


def _columns(system: System, over: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The values that vary, as arrays [runs]: of numbers, or of objects where some are text."""
    if not isinstance(over, Mapping) or not over:
        why = f"should name at least one parameter or initial state with its values, got {over!r}"
        raise ArgumentError("over", why)
    plain = {path: _column(path, entries) for path, entries in over.items()} if system.units is not None else over
    over = values_without_units(plain, system.units, system.parts)
    known = (*system.parameter_paths, *(INITIAL + name for name in system.state_names))
    columns: dict[str, np.ndarray] = {}
    for path, column in over.items():
        if path not in known:
            near = suggestion(path, known, cutoff=0.0)
            raise ArgumentError("over", f"{path!r} is neither a parameter nor an initial state; {near}")
        columns[path] = _column(path, column)
    lengths = {path: len(column) for path, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ArgumentError("over", f"every list should have one value per run, got lists of lengths {lengths}")
    if 0 in lengths.values():
        raise ArgumentError("over", f"{next(iter(lengths))} should have at least one value")
    return columns


def _column(path: str, entries: Any) -> np.ndarray:
    """Values of one path as an array of numbers, or of objects where some are text."""
    if not isinstance(entries, np.ndarray):
        try:
            entries = np.array(list(entries), dtype=object)
        except TypeError:
            raise ArgumentError(path, f"should be a list of values, one per run, got {entries!r}") from None
    if entries.ndim != 1:
        raise ArgumentError(path, f"should be a list of values, one per run, got an array of shape {entries.shape}")
    if entries.dtype.kind in "OU":
        text = np.array([isinstance(value, str) for value in entries], dtype=bool)
        may_be_text = not str(path).startswith(INITIAL)
        for run, value in enumerate(entries):
            if not (is_number(value) or (may_be_text and isinstance(value, str))):
                raise ArgumentError(path, f"should be numbers, got {value!r} for run {run}")
        if text.any():
            return np.array([str(v) if t else float(v) for v, t in zip(entries, text, strict=True)], dtype=object)
    elif entries.dtype.kind not in "fiu":
        raise ArgumentError(path, f"should be numbers, got an array of {entries.dtype}")
    column = entries.astype(float)
    wrong = np.flatnonzero(~np.isfinite(column))
    if len(wrong):
        raise ArgumentError(path, f"should be finite numbers, got {column[wrong[0]]} for run {wrong[0]}")
    return column


def _check_values(system: System, columns: Mapping[str, np.ndarray]) -> None:
    """ValueError for values that a part refuses.

    Bounds of single fields are intervals, so the runs with the extremes of each column tell of all; a part that
    compares its fields is made for every combination that they take.
    """
    runs: dict[int, None] = {}
    for column in (column for path, column in columns.items() if not path.startswith(INITIAL)):
        kinds = np.unique(column.astype(str), return_index=True)[1] if column.dtype == object else ()
        runs |= dict.fromkeys((0, *map(int, kinds)))
        if column.dtype != object:
            runs |= dict.fromkeys((int(column.argmin()), int(column.argmax())))
    for part, record in system.parts.items():
        paths = [path for path in columns if path.startswith(f"{part}.")]
        if paths and type(record).__pydantic_decorators__.model_validators:
            runs |= dict.fromkeys(_different(columns, paths)[0].tolist())
    for run in runs:
        try:
            _system_of_run(system, columns, run)
        except ParameterError as error:
            raise ValueError(f"{error.complaints[0]} for run {run}") from None
        except ValueError as error:
            raise ValueError(f"{error} for run {run}") from None


def _check_room(system: System, columns: Mapping[str, np.ndarray], start: Mapping[str, float]) -> None:
    """ValueError for a run that would start beyond a rigid stop."""
    locked = (name for names in system.placed.locked.values() for name in names)
    bounded = {*system.placed.room(), *system.switched, *locked}
    parts = ("machine.", "actuator.")
    varied = [path for path in columns if path.startswith(parts) or path.removeprefix(INITIAL) in bounded]
    numbers = [columns[path].astype(float) for path in varied if columns[path].dtype != object]
    if not bounded or not numbers:
        return
    for run in map(int, np.unique(np.array(numbers), axis=1, return_index=True)[1]):
        varied_start = {name: float(columns[INITIAL + name][run]) for name in bounded if INITIAL + name in columns}
        try:
            check_room(_system_of_run(system, columns, run), {**start, **varied_start})
        except ArgumentError as error:
            raise ValueError(f"{error} for run {run}") from None


def _system_of_run(system: System, columns: Mapping[str, np.ndarray], run: int) -> System:
    own = {path: column[run] for path, column in columns.items() if not path.startswith(INITIAL)}
    own = {path: value if isinstance(value, str) else float(value) for path, value in own.items()}
    return system.with_parameters(own)


def _chunks(system: System, columns: Mapping[str, np.ndarray], size: int) -> Iterator[np.ndarray]:
    """Indices of runs that have equations of one form, not too many at a time."""
    group = np.zeros(len(next(iter(columns.values()))), dtype=np.int64)
    for path, column in columns.items():
        part, name = split_path(path)
        shape = () if part == "initial" else getattr(system.parts[part], "shape_parameters", ())
        if column.dtype == object:
            keys = np.array([value if isinstance(value, str) else "" for value in column])
        elif name in shape:
            keys = np.where(column == np.floor(column), column, np.inf)  # what is not whole is a number like others
        else:
            continue
        different, which = np.unique(keys, return_inverse=True)
        group = group * len(different) + which
    zeros = [column == 0.0 for path, column in columns.items() if path.startswith("machine.")]
    if np.any(zeros):  # which may free a coordinate
        _, first, which = np.unique(np.stack([group, *zeros]), axis=1, return_index=True, return_inverse=True)
        free = [str(_system_of_run(system, columns, int(run)).cyclic) for run in first]
        group = group * len(free) + np.unique(free, return_inverse=True)[1][which]
    if system.controller is not None and system.controller.sampled:
        group = group * MOST_SAMPLES + _sample_counts(system, columns)
    for form in np.unique(group):
        members = np.flatnonzero(group == form)
        for first in range(0, len(members), size):
            yield members[first : first + size]


def _sample_counts(system: System, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Of each run, how many samples of its controller a period of its drive has."""
    paths = [path for path in columns if path.startswith("drive.") or path == "controller.sample_time"]
    if not paths:
        return np.zeros(len(next(iter(columns.values()))), dtype=np.int64)
    first, which = _different(columns, paths)
    return np.array([_system_of_run(system, columns, int(run)).timed_drive.count for run in first])[which]


def _mirrored(system: System, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Whether each run has the half-period symmetry (`System.mirrored`)."""
    runs = len(next(iter(columns.values())))
    paths = [path for path in columns if path.startswith(("drive.", "environment."))]
    for part, record in system.parts.items():
        of_law = isinstance(record, Law) and type(record).symmetric is not Law.symmetric
        if of_law or (isinstance(record, Machine) and record.evaluated("mirror")):
            paths += [path for path in columns if path.startswith(f"{part}.")]
    if not paths:
        return np.full(runs, system.mirrored)
    first, which = _different(columns, paths)
    parts = {part: copy.copy(record) for part, record in system.parts.items()}
    varied = System.of_parts(parts)
    mirrored = np.empty(len(first), dtype=bool)
    for k, run in enumerate(first):
        for path in paths:
            part, name = split_path(path)
            value = columns[path][run]  # checked before
            object.__setattr__(parts[part], name, value if isinstance(value, str) else float(value))
        mirrored[k] = varied.mirrored
    return mirrored[which]


def _different(columns: Mapping[str, np.ndarray], paths: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """(the first run of each combination of values at some paths, words among them, which of these each run has)."""
    numbers = [columns[path] for path in paths]
    numbers = [np.unique(x.astype(str), return_inverse=True)[1] if x.dtype == object else x for x in numbers]
    _, first, which = np.unique(np.column_stack(numbers), axis=0, return_index=True, return_inverse=True)
    return first, which.ravel()
