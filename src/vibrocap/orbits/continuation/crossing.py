"""Where a measure of the steady motion takes a value: over a parameter, between two laws, and along a branch."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number
from vibrocap.measures.during_run import check_travel, measure_table, measured, near_measure, resolved
from vibrocap.measures.of_measure import ManyOfMeasure, OneOfMeasure
from vibrocap.measures.standard import known_measure
from vibrocap.motion.simulate import check_run, initial_state, simulate
from vibrocap.orbits.closing.autonomous_orbit import near_cycle
from vibrocap.orbits.closing.orbit import Orbit, shoot
from vibrocap.orbits.closing.periodic_solution import OrbitStatus
from vibrocap.orbits.continuation.crossing_bracket import Crossing, CrossingKind, Difference, located
from vibrocap.orbits.maps.closing_map import ClosingMap
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.maps.stroboscopic_map import is_driven, named_states
from vibrocap.orbits.parameter_range import checked_range
from vibrocap.orbits.walk.following import started
from vibrocap.orbits.walk.residual import BranchPoint
from vibrocap.orbits.walk.segment import Lost, Segment
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.ranges import values_between

MEASURE_ERROR = 100.0  # tolerances of the runs by which a measure of a closed orbit may be off, over its largest value
BESIDE = 1e-3  # share of a segment over which the slope is taken

OfOrbit = Callable[[Orbit], float]


@dataclasses.dataclass(frozen=True)
class BranchCrossing(Dimensional):
    """A place of a branch where a measure passes a value, or (a jump) leaps over it at a change of the mode sequence.

    at: the parameter; error: how far it may be off, by the bracket and by the error of a closed orbit
    after_point: index of the last point of the branch before it; orbit: the steady motion there; None where lost
    """

    kind: CrossingKind
    at: Parameter
    error: Parameter
    after_point: int
    orbit: Orbit | None


def branch_crossings(
    closure: ClosingMap,
    points: Sequence[tuple[np.ndarray, float, float]],
    known: np.ndarray | None,
    measure: str | OfOrbit,
    value: float,
) -> tuple[BranchCrossing, ...]:
    """All places of a branch where a measure passes a value, in the order of the branch.

    The measure is taken at every point; where its difference to the value changes sign, the place is bracketed on
    closed orbits. Where it equals the value all along (the drift of symmetric motions) it passes it nowhere.

    measure: a name, or a function of an orbit that gives a number
    points: (state, parameter, period) of each; known: [points] the measure there, where it is known
    """
    if isinstance(measure, str):
        checked_measure((closure.system,), measure)
    if known is None:
        known = np.array([steady_value(orbit_near(closure, *point), measure) for point in points])
    size = float(np.max(np.abs(known), initial=1.0))
    pairs = sign_changes(known - value, size)
    return tuple(_located(closure, points[i], points[j], i, measure, value, size) for i, j in pairs)


def orbit_near(closure: ClosingMap, state: np.ndarray, value: float, period: float) -> Orbit:
    """The orbit closed from a state [states] at a value of the parameter; the period matters to cycles only."""
    system = closure.system.with_parameters({closure.path: value})
    if isinstance(closure, CycleMap):
        return Orbit.of(near_cycle(system, state, period, closure.tolerance))
    start = named_states(system, state)
    return shoot(system, start, closure.response_period, half=closure.half, tolerance=closure.tolerance)


def steady_value(orbit: Orbit, measure: str | OfOrbit) -> float:
    """A measure of an orbit over its whole period; drift and works are per drive period."""
    if not isinstance(measure, str):
        return float(measure(orbit))
    if measure == "drift" and orbit.drift is not None:
        return orbit.drift / max(1, orbit.response_period)
    if measure == "mean_velocity" and orbit.mean_velocity is not None:
        return orbit.mean_velocity
    if orbit.response_period:
        return float(measured(orbit.motion(), [measure], window=orbit.response_period)[measure])
    if orbit.system.drive.name != "constant":  # whose length is free to be that of the cycle
        why = f"should be constant for measures of a cycle by its period, got {orbit.system.drive.name}"
        raise ArgumentError("drive", why)
    system = orbit.system.with_parameters({"drive.duration": orbit.period})
    motion = simulate(system, periods=1, initial=orbit.state, tolerance=max(orbit.tolerance, 1e-13))
    return float(measured(motion, [measure], window=1)[measure])


def _located(
    closure: ClosingMap,
    first: tuple[np.ndarray, float, float],
    last: tuple[np.ndarray, float, float],
    after_point: int,
    measure: str | OfOrbit,
    value: float,
    size: float,
) -> BranchCrossing:
    """The place between two points of a branch at which the differences have different signs."""
    closure = closure.with_section(first[0], first[1])
    low, high = sorted((first[1], last[1]))
    lost = BranchCrossing(CrossingKind.LOST, 0.5 * (low + high), high - low, after_point, None)
    begin, end = (started(closure, closure.point(*point)) for point in (first, last))
    if begin is None or end is None:
        return lost
    segment = Segment(closure, begin, end)

    def difference(point: BranchPoint) -> float:
        return steady_value(orbit_near(closure, *closure.place(point)), measure) - value

    try:
        bracket = segment.root(difference)
        here = segment.point(bracket.left)
        beside = segment.point(bracket.left + (BESIDE if bracket.left < 0.5 else -BESIDE))
    except Lost:
        return lost
    width = abs(segment.parameter(bracket.right) - segment.parameter(bracket.left))
    kind = CrossingKind.JUMP if bracket.jumps else CrossingKind.CROSSING
    at = closure.parameter(here.x)
    rate = (difference(beside) - difference(here)) / (closure.parameter(beside.x) - at)
    error = width + MEASURE_ERROR * closure.tolerance * size / max(abs(rate), 1e-300)
    orbit = orbit_near(closure, *closure.place(here))
    if not bracket.jumps and orbit.status is OrbitStatus.NOT_CERTIFIED:
        kind = CrossingKind.NOT_CERTIFIED
    return BranchCrossing(kind, at, width if bracket.jumps else error, after_point, orbit)


NOTHING = 1e-9  # a difference of no more than this share of the measure's range (or of 1) is none


@dataclasses.dataclass(frozen=True, eq=False)
class Crossings(Dimensional):
    """All places found, and what the scan saw.

    found: `Crossing`s in the order of the parameter
    equal: ranges of the parameter over which the measure equals the value all along (zero drift of symmetric motions):
        no point of them is a crossing
    unsettled: parameters of the scan whose motion did not settle; across them nothing can be told
    parameters, differences: the scan [points]; NaN where not settled
    """

    measure: str
    over: Path
    value: OneOfMeasure
    found: tuple[Crossing, ...]
    equal: tuple[tuple[Parameter, Parameter], ...]
    unsettled: tuple[Parameter, ...]
    parameters: Parameters
    differences: ManyOfMeasure

    @property
    def places(self) -> tuple[Parameter, ...]:
        return tuple(place.at for place in self.found if place.kind is CrossingKind.CROSSING)

    def __str__(self) -> str:
        lines = []
        along, unit = self.unit_of("over"), self.unit_of("value")
        for place in self.found:
            row = f"{place.kind.value:<10}{said(place.at, along, 12)} +- {place.error:.1g}"
            if place.kind is CrossingKind.CROSSING:
                low, high = place.bracket
                slope = said(place.slope, place.unit_of("slope"), 6)
                lines.append(f"{row}, between {low!r} and {high!r}, slope {slope}")
            else:
                lines.append(f"{row}  {place.kind.advice}")
        for low, high in self.equal:
            lines.append(f"equal     all along {low:.6g} to {said(high, along, 6)}: no point of it is a crossing")
        if self.unsettled:
            ends = f"{self.unsettled[0]:.6g} to {said(self.unsettled[-1], along, 6)}"
            many = f"{len(self.unsettled)} of {len(self.parameters)} points of the scan, {ends}"
            lines.append(f"unsettled {many}: nothing is known there")
        if not any(place.kind in (CrossingKind.CROSSING, CrossingKind.LOST) for place in self.found):
            known = self.differences[np.isfinite(self.differences)]
            if len(known):
                scan = f"over the scan the difference is from {known.min():.3g} to {said(known.max(), unit, 3)}"
                lines.append(f"no crossing: {scan}")
        return "\n".join(lines)


@shows_progress("Looking for crossings")
def crossing(
    system: System,
    measure: str = "drift",
    over: Path = "machine.mass_ratio",
    between: tuple[Parameter, Parameter] = (0.01, 8.1),
    *,
    value: OneOfMeasure = 0.0,
    against: System | None = None,
    initial: ByName | None = None,
    points: int = 200,
    periods: int = 2000,
    tolerance: float = 1e-12,
    progress: Progress = None,
) -> Crossings:
    """Where the steady value of a measure equals a value, or that of another system, along a parameter.

    A scan of motions that have settled to rounding brackets every change of sign. In each bracket the steady motion is
    followed, and the bracket cut until the parameter is known to rounding. A measure that equals the value over a whole
    range, as the drift of symmetric motions is zero, has no crossing there, and the result says so. `Branch.crossings`
    looks along a branch: past folds, and where it is unstable.

    measure: a name of `measure_table()` that is a number; drift and works are per drive period
    over: parameter path; between: its least and largest value
    value: that is looked for; against: another system (another law), then value is that of the difference
    initial: start of the motions, by state (where several motions are stable it decides which is seen); a state that
        only one of two systems has is given to that one
    points, periods: of the scan: how many parameters, and drive periods to settle in at most
    tolerance: of the runs
    progress: True for a bar, or a function that is called with the share of the scan that is done

    What settles slowly is closed by shooting. Two crossings between neighbouring points of the scan are not seen.
    Returns `Crossings`. Raises ValueError for a path, range or measure that is none, before any work.
    """
    systems = (system,) if against is None else (system, against)
    low, high = _checked(systems, measure, over, between, points, value)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    starts = _starts(systems, initial)
    difference = Difference(measure, over, float(value), int(periods), tolerance)
    parameters, motions, report = values_between(low, high, points), [], told(progress)
    for i, place in enumerate(map(float, parameters)):
        motions.append(difference.settled([system.with_parameters({over: place}) for system in systems], starts))
        if report is not None:
            report((i + 1) / points)
    nothing = [math.nan] * len(systems)
    values = np.array([nothing if motion is None else [one.value(measure) for one in motion] for motion in motions])
    differences = values[:, 0] - values[:, 1:].sum(axis=1) - value
    size = float(np.max(np.abs(values), initial=1.0, where=np.isfinite(values)))
    pairs = sign_changes(differences, size)
    ends = [[(float(parameters[k]), motions[k]) for k in pair] for pair in pairs]
    return Crossings(
        measure=measure,
        over=over,
        value=value,
        found=tuple(located(difference, *pair) for pair in ends),
        equal=_ranges(parameters, np.abs(differences) <= NOTHING * size),
        unsettled=tuple(parameters[~np.isfinite(differences)].tolist()),
        parameters=parameters,
        differences=differences,
    )


def sign_changes(differences: np.ndarray, size: float) -> list[tuple[int, int]]:
    """Pairs of points between which a difference changes its sign; one at which it is none may lie between them.

    size: of the values of which NOTHING is a share; NaN: a difference that is not known
    """
    apart = np.flatnonzero(np.abs(differences) > NOTHING * size).tolist()
    pairs = ((i, j) for i, j in itertools.pairwise(apart) if differences[i] * differences[j] < 0.0)
    return [(i, j) for i, j in pairs if j - i <= 2]


def _starts(systems: tuple[System, ...], initial: Mapping[str, float] | None) -> list[dict[str, float]]:
    """The start of each system: of the states named those that it has."""
    named = dict(initial or {})
    names = {name for system in systems for name in system.state_names}
    unknown = [name for name in named if name not in names]
    if unknown:
        initial_state(systems[0], {unknown[0]: named[unknown[0]]})  # raises, naming it and what is near
    return [initial_state(system, {k: v for k, v in named.items() if k in system.state_names}) for system in systems]


def _ranges(parameters: np.ndarray, same: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Ranges of at least two neighbouring points at which the measure equals the value."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(int), [0]))))
    pairs = zip(edges[::2], edges[1::2] - 1, strict=True)
    return tuple((float(parameters[i]), float(parameters[j])) for i, j in pairs if j > i)


def checked_measure(systems: tuple[System, ...], measure: str) -> None:
    """Refuse what is no measure of these systems, or no number."""
    for system in systems:
        known = known_measure(measure, system) if isinstance(measure, str) else None
        if known is None or known.is_text:
            near = near_measure(measure, [name for name, one in measure_table(system).items() if not one.is_text])
            raise ArgumentError("measure", f"should be a number of the table of measures, got {measure!r}; {near}")
        check_travel(resolved(measure, system)[1], system)


def _checked(
    systems: tuple[System, ...], measure: str, over: str, between: Any, points: Any, value: Any
) -> tuple[float, float]:
    checked_measure(systems, measure)
    (low, high), *_ = [checked_range(system, over, between) for system in systems]
    check_whole("points", points, 2)
    if not is_number(value) or not math.isfinite(value):
        raise ArgumentError("value", f"should be a finite number, got {value!r}")
    if not all(map(is_driven, systems)):
        cure = "follow the cycles instead, branch(system, over, between).crossings(measure, value)"
        raise ArgumentError("drive", f"should change in time: of a system that cycles by itself {cure}")
    return low, high
