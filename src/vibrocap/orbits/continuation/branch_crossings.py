"""Where a measure takes a value along a branch of steady motions, stable or not, past folds too."""

import dataclasses
import itertools

import numpy as np

from vibrocap.measures.during_run import measured
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_point import BranchPoint, corrected, null_tangent
from vibrocap.orbits.continuation.segment import Lost, Segment
from vibrocap.orbits.crossings.crossing import NOTHING, checked_measure
from vibrocap.orbits.crossings.crossing_bracket import CrossingKind
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.simulate import simulate

CLOSED = 100.0  # tolerances of the runs by which a measure of a closed orbit may be off, over its largest value
BESIDE = 1e-3  # share of a segment over which the slope is taken


@dataclasses.dataclass(frozen=True)
class BranchCrossing:
    """A place of a branch where a measure passes a value, or (a jump) where it leaps over it at a change of the word.

    at: the parameter; error: how far it may be off, by the bracket and by the error of a closed orbit
    after_point: index of the last point of the branch before it; orbit: the steady motion there; None where lost
    """

    kind: CrossingKind
    at: float
    error: float
    after_point: int
    orbit: Orbit | None


def branch_crossings(branch: Branch, measure: str = "drift", value: float = 0.0) -> tuple[BranchCrossing, ...]:
    """All places of a branch where a measure passes a value, in the order of the branch.

    The measure is taken at every point; where its difference to the value changes sign, the place is bracketed on
    closed orbits. Where it equals the value all along (the drift of symmetric motions) it passes it nowhere.

    measure: a name of `measure_table()` that is a number; drift and works are per drive period
    Raises ValueError for what is no measure of the system.
    """
    checked_measure((branch.system,), measure)
    values = np.array([_at_point(branch, measure, i) for i in range(len(branch))])
    size = float(np.max(np.abs(values), initial=1.0))
    differences = values - value
    told = [i for i in range(len(values)) if abs(differences[i]) > NOTHING * size]
    return tuple(
        _located(branch, measure, value, i, j, size)
        for i, j in itertools.pairwise(told)
        if j - i <= 2 and differences[i] * differences[j] < 0.0
    )


def _at_point(branch: Branch, measure: str, point: int) -> float:
    if measure == "mean_velocity":
        return float(branch.mean_velocity[point])
    if measure == "drift":
        return float(branch.drift[point]) / max(branch.response_period, 1)
    return steady_value(branch.orbit(point), measure)


def steady_value(orbit: Orbit, measure: str) -> float:
    """A measure of an orbit over its whole period; drift and works are per drive period."""
    if measure == "drift" and orbit.drift is not None:
        return orbit.drift / max(1, orbit.response_period)
    if measure == "mean_velocity" and orbit.mean_velocity is not None:
        return orbit.mean_velocity
    if orbit.response_period == 0:
        return _of_cycle(orbit, measure)
    return float(measured(orbit.motion(), [measure], window=orbit.response_period)[measure])


def _of_cycle(orbit: Orbit, measure: str) -> float:
    """A measure of a cycle: over one period of a constant drive, whose length is free to be that of the cycle."""
    if orbit.system.drive.name != "constant":
        raise ValueError(
            f"drive should be constant for measures of a cycle by its period, got {orbit.system.drive.name}"
        )
    system = orbit.system.with_parameters({"drive.duration": orbit.period})
    motion = simulate(system, periods=1, initial=orbit.state, tolerance=max(orbit.tolerance, 1e-13))
    return float(measured(motion, [measure], window=1)[measure])


def _located(branch: Branch, measure: str, value: float, i: int, j: int, size: float) -> BranchCrossing:
    """The place between two points of a branch at which the differences have different signs."""
    closure = branch.closing_map
    if isinstance(closure, CycleMap):  # of which the branch may have several, one for each section
        closure = closure.with_section(branch.states[i], float(branch.parameter[i]))
    across = np.zeros(len(closure.unknowns) + 1 + isinstance(closure, CycleMap))
    across[-1] = 1.0
    ends = []
    for point in (i, j):
        x = closure.point(branch.states[point], float(branch.parameter[point]), float(branch.period[point]))
        closing, _ = corrected(closure, x, across, float(x[-1]))
        if closing is None:
            return _lost(branch, i, j)
        ends.append(BranchPoint(closing, null_tangent(closing)))
    segment = Segment(closure, *ends)

    def orbit_of(point: BranchPoint) -> Orbit:
        state = closure.state(point.x, point.closing)
        return branch.orbit_near(state, closure.parameter(point.x), closure.period(point.x))

    def difference(point: BranchPoint) -> float:
        return steady_value(orbit_of(point), measure) - value

    try:
        bracket = segment.root(difference)
        here = segment.point(bracket.left)
        beside = segment.point(bracket.left + (BESIDE if bracket.left < 0.5 else -BESIDE))
    except Lost:
        return _lost(branch, i, j)
    width = abs(segment.parameter(bracket.right) - segment.parameter(bracket.left))
    kind = CrossingKind.JUMP if bracket.jumps else CrossingKind.CROSSING
    at = closure.parameter(here.x)
    rate = (difference(beside) - difference(here)) / (closure.parameter(beside.x) - at)
    error = width + CLOSED * branch.closing_map.tolerance * size / max(abs(rate), 1e-300)
    return BranchCrossing(kind, at, width if bracket.jumps else error, i, orbit_of(here))


def _lost(branch: Branch, i: int, j: int) -> BranchCrossing:
    """The record of a place between two points that could not be located."""
    low, high = sorted((float(branch.parameter[i]), float(branch.parameter[j])))
    return BranchCrossing(CrossingKind.LOST, 0.5 * (low + high), high - low, i, None)
