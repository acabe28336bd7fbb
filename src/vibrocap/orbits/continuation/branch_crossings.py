"""Where a measure takes a value along a branch of steady motions, stable or not, past folds too."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.during_run import measured
from vibrocap.motion.simulate import simulate
from vibrocap.orbits.closing.autonomous_orbit import near_cycle
from vibrocap.orbits.closing.orbit import Orbit, shoot
from vibrocap.orbits.closing.periodic_solution import OrbitStatus
from vibrocap.orbits.continuation.crossing import checked_measure, sign_changes
from vibrocap.orbits.continuation.crossing_bracket import CrossingKind
from vibrocap.orbits.maps.closing_map import ClosingMap
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.orbits.walk.following import started
from vibrocap.orbits.walk.residual import BranchPoint
from vibrocap.orbits.walk.segment import Lost, Segment
from vibrocap.physics.dimensions.conversion import Parameter
from vibrocap.quantities.dimensional import Dimensional

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
    if orbit.response_period == 0:
        return _of_cycle(orbit, measure)
    return float(measured(orbit.motion(), [measure], window=orbit.response_period)[measure])


def _of_cycle(orbit: Orbit, measure: str) -> float:
    """A measure of a cycle: over one period of a constant drive, whose length is free to be that of the cycle."""
    if orbit.system.drive.name != "constant":
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

    def orbit_of(point: BranchPoint) -> Orbit:
        state = closure.state(point.x, point.closing)
        return orbit_near(closure, state, closure.parameter(point.x), closure.period(point.x))

    def difference(point: BranchPoint) -> float:
        return steady_value(orbit_of(point), measure) - value

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
    orbit = orbit_of(here)
    if not bracket.jumps and orbit.status is OrbitStatus.NOT_CERTIFIED:
        kind = CrossingKind.NOT_CERTIFIED
    return BranchCrossing(kind, at, width if bracket.jumps else error, after_point, orbit)
