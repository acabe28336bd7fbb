"""Measures that are taken during the run, by name: what an ensemble or a study can ask for.

All belong to a window of whole drive periods: where the motion settled, one period of the response; else the last
periods of the run. Works and loop areas are given per drive period, so that windows of different length compare.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_threshold, check_whole, suggestion
from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import (
    Derived,
    Measure,
    Reduction,
    Standard,
    is_summed,
    own_integrands,
    signs_of_extremes,
)
from vibrocap.measures.of_measure import ByMeasure
from vibrocap.measures.recorded.travel import travelling
from vibrocap.measures.recorded.windows import usual_window, whole_periods
from vibrocap.measures.standard import COST, TRAVEL, known_measure, standard_measures
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Budget, codes, replayed
from vibrocap.numerics.expressions.graph import evaluate, evaluated
from vibrocap.physics.system import System

MEANT = {  # what a measure is called elsewhere, by its name
    "mean_velocity": "speed velocity average_speed average_velocity",
    "displacement": "distance travel",
    "drift": "progress step",
    "cost_of_transport": "efficiency cot",
    "drive_work": "energy work power",
    "peak_friction": "friction force",
    "contact_sliding_work": "dissipation",
    "displacement_loop_area": "hysteresis",
    "time_to_settle": "settling_time",
    "symmetric": "symmetry",
    "impacts": "bounces collisions grazing",
    "stick_fraction": "sticking stick",
}
SYNONYMS = {word: measure for measure, words in MEANT.items() for word in words.split()}


def measure_table(system: System | None = None) -> dict[str, Measure]:
    """The measures by name: those of a system, or (None) all."""
    return dict(standard_measures(system))


def measured(
    motion: Trajectory,
    measures: str | Measure | Iterable[str | Measure],
    *,
    window: int | None = None,
    settle: float | None = None,
) -> ByMeasure:
    """Measures of a stored motion, taken by the very code that takes them during a run.

    measures: names of `measure_table(motion.system)`, or measures of one's own
    window: the last so many whole drive periods are measured where nothing settles; 10, or all where there are fewer
    settle: None, or the threshold of `settling`: then one response period is measured from the mark on at which the
        motion has settled, as in an ensemble that stops there; of a motion that nothing drives in time None

    Returns numbers (for "mode_sequence" a text) by name. Raises ValueError for a motion that did not go to its end.
    """
    asked, needed = resolved(measures, motion.system)
    check_travel(needed, motion.system)
    done = whole_periods(motion)
    if not motion.status.ok:
        raise ValueError(f"the motion did not go to its end: {motion.status.text}")
    if motion.start_phase:
        raise ArgumentError("motion", "should begin where the drive begins a period, as the runs of an ensemble do")
    window = usual_window(done) if window is None else window
    check_whole("window", window, 1, done, of=" of periods")
    check_threshold("settle", settle)
    recording = equations(motion.system)
    if settle and not recording.timed:
        cure = "ensemble() settles runs by their returns, orbit() closes the cycle"
        raise ArgumentError("settle", f"should be None, as nothing drives the system in time; {cure}")
    threshold, parameters = float(settle or 0.0), parameter_values(motion.system)
    taken = {"window": int(window), "threshold": threshold, "asked": asked_groups(needed)}
    budget = Budget(done, motion.tolerance, 0, 0, **taken)  # a motion that is replayed has no limits
    run = recording, parameters, motion, budget
    results = replayed(*run, own_integrands(needed, recording), _switch_times(motion))
    period, *scales = evaluate([recording.period, *recording.scales], 0.0, [], 1.0, parameters)
    one: Any = np.array([period]), lambda: np.array([motion.system.mirrored]), threshold, np.array([scales])
    runs = Gathered(motion.system, results, *one)
    columns = values(needed, runs)
    return {measure.name: columns[measure.name][0].item() for measure in asked}


def _switch_times(motion: Trajectory) -> list[np.ndarray]:
    """When each guard of the machine fell to zero: of those with one event the one that is least there."""
    recording = equations(motion.system)
    guards = recording.switches[recording.law_switches :]
    names = motion.system.placed.switch_events[: len(guards)]
    if not names:
        return []
    happened = np.isin(motion.event_kinds, names)
    times, kinds, after = motion.event_times[happened], motion.event_kinds[happened], motion.event_states[happened]
    piece = np.maximum(np.searchsorted(motion.piece_start, times) - 1, 0)
    length = motion.piece_length[piece]
    states, (time, parameters) = motion.piece_states(piece, length), motion.drive_at(piece, length)
    again = 1 + np.flatnonzero(times[1:] == times[:-1])
    states[:, again] = after[again - 1].T  # what another one at the instant has left
    least = evaluated(guards, time, states, motion.sides(piece), parameters, times.shape)
    least[np.array(names)[:, None] != kinds] = np.inf
    return [times[least.argmin(axis=0) == i] for i in range(len(names))]


def near_measure(name: object, table: Iterable[str]) -> str:
    """What to say of the name of a measure that is none: the one that goes by it elsewhere, or that is spelled so."""
    known, meant = list(table), SYNONYMS.get(str(name).lower().replace("-", "_").replace(" ", "_"))
    return suggestion(meant if meant in known else name, known, cutoff=0.0)


def resolved(
    measures: str | Measure | Iterable[str | Measure], system: System | None = None
) -> tuple[tuple[Measure, ...], tuple[Measure, ...]]:
    """(measures asked for, the same with all that they are derived from, each after what it needs).

    system: whose own measures may be named besides those that there are of any
    Raises ValueError for a name that does not exist, for two measures of one name, and for one derived from itself.
    """
    if isinstance(measures, (str, Measure)) or not isinstance(measures, Iterable):
        measures = [measures]
    asked_for = list(measures)
    own = {measure.name: measure for measure in asked_for if isinstance(measure, Measure)}
    for measure in asked_for:
        name = measure.name if isinstance(measure, Measure) else ""
        if name and (own[name] != measure or (known_measure(name, system) or measure) != measure):
            raise ArgumentError("measures", f"there are two measures of the name {name!r}")
    needed: dict[str, Measure] = {}

    def need(name: Any, path: tuple[str, ...]) -> Measure:
        known = (own.get(name) or known_measure(name, system)) if isinstance(name, str) else None
        if known is None:
            by = f" (of which {path[-1]!r} is derived)" if path else ""
            near = near_measure(name, {**measure_table(system), **own})
            raise ArgumentError("measures", f"there is no measure {name!r}{by}; {near}")
        if name in path:
            raise ArgumentError("measures", f"{name!r} is derived from itself, by {' -> '.join((*path, name))}")
        if name not in needed:
            how = known.how
            for other in how.of if isinstance(how, Derived) else ():
                need(other, (*path, name))
            needed[name] = known
        return known

    asked = [need(measure.name if isinstance(measure, Measure) else measure, ()) for measure in asked_for]
    return tuple(dict.fromkeys(asked)), tuple(needed.values())


def unavailable(needed: Sequence[Measure], system: System) -> dict[str, str]:
    """Why a system does not have some measures, by name: it has no travel, or not what they are functions of.

    needed: as `resolved` gives them, each after what it is derived from
    """
    reasons: dict[str, str] = {}
    for measure in needed:
        how = measure.how
        if isinstance(how, Derived) and (lacking := [reasons[name] for name in how.of if name in reasons]):
            reasons[measure.name] = f"{measure.name} needs {lacking[0]}"
        try:
            check_travel([measure], system)
            own_integrands([measure] if isinstance(how, Reduction) else (), equations(system))
        except ArgumentError as error:
            reasons[measure.name] = error.complaint.text
    return reasons


def check_travel(needed: Sequence[Measure], system: System) -> None:
    """ValueError for measures of travel of a machine that does not travel."""
    for measure in needed:
        if measure in TRAVEL or measure.name == COST:
            try:
                travelling(system)
            except ValueError as error:
                raise ArgumentError("measures", f"{measure.name}: {error}") from None


def asked_groups(needed: Sequence[Measure]) -> int:
    """Groups that have to be gathered for measures, a sum of powers of two."""
    groups = 0
    for measure in needed:
        if isinstance(measure.how, Standard):
            groups |= measure.how.groups
        elif isinstance(measure.how, Reduction):
            groups |= codes.ASK_INTEGRALS if is_summed(measure) else codes.ASK_PEAK
    return groups


def values(needed: Sequence[Measure], runs: Gathered) -> dict[str, np.ndarray]:
    """Values of measures, in the order of `resolved`: an array [runs] each."""
    columns: dict[str, np.ndarray] = {}
    contacts = len(runs.system.laws)
    # After the standard ones, see `integrands_source`.
    own_sum, own_extreme = len(runs.system.channels) + contacts * codes.FUNCTIONS_PER_CONTACT, contacts
    for measure in needed:
        how = measure.how
        if isinstance(how, Standard):
            columns[measure.name] = how.value(runs)
        elif isinstance(how, Derived):
            value = np.asarray(how.function(*(columns[name] for name in how.of)))
            columns[measure.name] = np.broadcast_to(value, (len(runs.results),))
        elif is_summed(measure):
            total = runs.results.entry("INTEGRAL", own_sum)
            columns[measure.name] = total / runs.time if how.kind == "mean" else total
            own_sum += 1
        else:
            signs = signs_of_extremes(measure)
            largest = [runs.results.entry("PEAK", own_extreme + k) for k in range(len(signs))]
            columns[measure.name] = np.maximum(*largest) if len(signs) == 2 else signs[0] * largest[0]
            own_extreme += len(signs)
    return columns
