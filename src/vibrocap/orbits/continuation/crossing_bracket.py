"""Where a difference vanishes between two neighbours of a scan: the steady motion followed, the bracket cut."""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np

from vibrocap.measures.during_run import measured
from vibrocap.measures.of_measure import OneOfMeasure, SlopeOfMeasure
from vibrocap.motion.recording.section import brought_back, section_states
from vibrocap.motion.simulate import period_marks, simulate, within_room
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Stroboscope
from vibrocap.orbits.closing.periodic_solution import CERTIFIED
from vibrocap.orbits.closing.settling_runs import SETTLED
from vibrocap.orbits.closing.shooting import closed, shortest
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, named_states, state_vector
from vibrocap.orbits.walk.segment import Lost, root
from vibrocap.physics.dimensions.conversion import Parameter
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import Dimensional
from vibrocap.results import Advised

ARRIVED = 20.0  # tolerances of the run within which a motion stands still: what is left is error of the integration
FIRST_LOOK = 24  # drive periods after which it is first asked; then after twice as many, and so on


@dataclasses.dataclass(frozen=True)
class SettledMotion:
    """A steady motion at the start of a drive period.

    state: by name, position as it came; response_period: in drive periods
    drift: per drive period; None for a machine that does not travel
    """

    system: System
    state: Mapping[str, float]
    response_period: int
    drift: float | None
    tolerance: float

    def motion(self, tolerance: float | None = None) -> Trajectory:
        """The motion over one response, at its own tolerance unless told otherwise."""
        options = {"initial": self.state, "tolerance": tolerance or self.tolerance}
        return simulate(self.system, periods=self.response_period, **options)

    @property
    def certified(self) -> bool:
        return self.motion(max(self.tolerance, CERTIFIED)).certified

    def value(self, measure: str) -> float:
        if self.drift is not None and measure in ("drift", "mean_velocity"):
            return self.drift / (1.0 if measure == "drift" else self.system.drive.period)
        return float(measured(self.motion(), [measure], window=self.response_period)[measure])


def settled_motion(
    system: System, initial: Mapping[str, float] | None, periods: int, tolerance: float = 1e-12
) -> SettledMotion | None:
    """The motion to which a start leads; None where it has not settled after so many drive periods, or a run fails.

    The motion is run until its stroboscopic states repeat within `ARRIVED` tolerances; that costs about 10 microseconds
    per period and no derivative. A motion that settles too slowly for that, but has come within `SETTLED` of where it
    goes, is closed by shooting.
    """
    state, done, most = initial, 0, FIRST_LOOK
    sizes = np.array(system.scales(), dtype=float)
    while True:
        length = min(most, periods - done)
        status, marks = period_marks(system, periods=length, initial=state, tolerance=tolerance)
        if not status.ok:
            return None
        done += length
        most = done
        state = named_states(system, marks[-1])
        over = Stroboscope(section_states(system, marks, sizes))
        response = over.settled_response(ARRIVED * tolerance, tolerance)[0]
        if response:
            return SettledMotion(system, state, response, _drift(system, marks, response), tolerance)
        if done >= periods:
            response = over.settled_response(SETTLED, tolerance)[0]
            return _closed(system, state, response, tolerance) if response else None


def _drift(system: System, marks: np.ndarray, response: int) -> float | None:
    """Travel per drive period over the last response."""
    if system.cyclic is None:
        return None
    place = system.state_names.index(system.cyclic)
    return float(marks[-1, place] - marks[-1 - response, place]) / response


def _closed(system: System, state: Mapping[str, float], response: int, tolerance: float) -> SettledMotion | None:
    map_ = StroboscopicMap(system, tolerance)
    solution = shortest(map_, closed(map_, state_vector(system, state), response))
    if not solution.closes:
        return None
    drift = None if solution.drift is None else solution.drift / solution.response_period
    return SettledMotion(system, solution.state, solution.response_period, drift, tolerance)


NARROW = 1e-13  # of the bracket at first: it is not cut further
BESIDE = 1e-3  # of the bracket at first: distance to both sides at which the slope is taken
ONE_MOTION = 1e-4  # of the natural sizes: a motion at a rigid stop changes like the root of the way to its grazing
COARSER = 10.0  # tolerances of the runs whose difference is taken for the error of the integration


class CrossingKind(Advised):
    """What was found between two neighbouring points of the scan where the difference changes its sign."""

    CROSSING = "crossing", "The measure takes the value here, on a steady motion that exists on both sides."
    GRAZING = "grazing", "The motion grazes a stop: on one side of this parameter it has an impact more."
    JUMP = (
        "jump",
        "The measure jumps over the value: the start leads to another steady motion (such as a mirror-image "
        "solution), or a motion ceases to exist. No steady motion seen here has the value.",
    )
    NOT_CERTIFIED = (
        "not certified",
        "The measure takes the value here, on a motion that contradicts the equations. Set a smaller "
        "`tolerance`, and see `simulate(...).certificate`.",
    )
    LOST = "lost", "A motion within the bracket did not settle; raise `periods`, or scan more points."


@dataclasses.dataclass(frozen=True)
class Crossing(Dimensional):
    """A place where the measure passes the value, or jumps over it.

    at: the parameter; bracket: of it, with the difference (measure less value) at both ends
    error: how far `at` may be off: the bracket's width and, over the slope, by how much the difference at `at` changes
        with ten times the tolerance; of a jump or a motion that is lost the width alone
    values: of the measure at `at`, of the system and (with `against`) of the other; none where lost
    slope: of the difference over the parameter; NaN unless a crossing
    """

    kind: CrossingKind
    at: Parameter
    bracket: tuple[Parameter, Parameter]
    differences: tuple[OneOfMeasure, OneOfMeasure]
    error: Parameter
    values: tuple[OneOfMeasure, ...]
    slope: SlopeOfMeasure


Motions = Sequence[SettledMotion]


@dataclasses.dataclass(frozen=True)
class Difference:
    """The measure less the value (and less that of a second motion) as a function of a parameter."""

    measure: str
    over: str
    value: float
    periods: int
    tolerance: float

    def of(self, motions: Motions) -> float:
        first, *others = (motion.value(self.measure) for motion in motions)
        return first - sum(others) - self.value

    def followed(self, near: Motions, place: float, tolerance: float | None = None) -> list[SettledMotion] | None:
        """The motions at another place of the parameter to which those nearby lead; None where one does not settle."""
        systems = [motion.system.with_parameters({self.over: place}) for motion in near]
        ends = zip(systems, (state_vector(motion.system, motion.state) for motion in near), strict=True)
        states = [within_room(system, named_states(system, brought_back(system, state))) for system, state in ends]
        return self.settled(systems, states, tolerance)

    def settled(
        self, systems: Sequence[System], starts: Sequence[Mapping[str, float]], tolerance: float | None = None
    ) -> list[SettledMotion] | None:
        """The motions to which the starts lead; None where one does not settle."""
        motions = []
        for system, start in zip(systems, starts, strict=True):
            motion = settled_motion(system, start, self.periods, tolerance or self.tolerance)
            if motion is None:
                return None
            motions.append(motion)
        return motions


@dataclasses.dataclass
class _End:
    """One end of a bracket."""

    place: float
    motions: Motions
    difference: float


def located(difference: Difference, first: tuple[float, Motions], last: tuple[float, Motions]) -> Crossing:
    """What happens between two points of a scan at which the difference has different signs.

    The motion of one end is followed to the other. If its own difference changes sign on the way, that place is
    bracketed; if neither end's does, the two ends lie on different motions.
    """
    low, high = (_End(place, motions, difference.of(motions)) for place, motions in (first, last))
    for near, far in ((low, high), (high, low)):
        motions = difference.followed(near.motions, far.place)
        if motions is None:
            return _untold(CrossingKind.LOST, low, high)
        reached = _End(far.place, motions, difference.of(motions))
        if near.difference * reached.difference <= 0.0:
            return _halved(difference, *((near, reached) if near is low else (reached, near)))
    return _untold(CrossingKind.JUMP, low, high)


def _halved(difference: Difference, low: _End, high: _End) -> Crossing:
    """The place between two ends where the difference changes its sign, known to rounding; a crossing or a jump."""
    width, ends = high.place - low.place, {low.place: low, high.place: high}

    def value(place: float) -> float:
        if place not in ends:
            near = min(ends.values(), key=lambda end: abs(end.place - place))
            motions = difference.followed(near.motions, place)
            if motions is None:
                raise Lost
            ends[place] = _End(place, motions, difference.of(motions))
        return ends[place].difference

    try:
        bracket = root(value, low.place, high.place, 0.5 * NARROW * width)
    except Lost:
        pairs = itertools.pairwise(ends[place] for place in sorted(ends))
        lost = next((one, other) for one, other in pairs if one.difference * other.difference < 0.0)
        return _untold(CrossingKind.LOST, *lost)
    low, high = ends[bracket.left], ends[bracket.right]
    if bracket.jumps:
        grazes = difference.measure == "impacts" and _near(low.motions, high.motions)
        return _untold(CrossingKind.GRAZING if grazes else CrossingKind.JUMP, low, high)
    at = 0.5 * (low.place + high.place)
    if high.difference != low.difference:  # where the straight line between the ends vanishes
        at = low.place - low.difference * (high.place - low.place) / (high.difference - low.difference)
    return _crossing(difference, low, high, at, BESIDE * width)


def _near(one: Motions, other: Motions) -> bool:
    """Whether the motions of two ends, as near as can be, are one: none of their states jumps."""
    for first, last in zip(one, other, strict=True):
        sizes = np.array(first.system.scales(), dtype=float)
        sizes[[i for i, name in enumerate(first.system.state_names) if name in first.system.switched]] = np.inf
        here, there = (state_vector(motion.system, motion.state) for motion in (first, last))
        away = section_states(first.system, here, sizes) - section_states(first.system, there, sizes)
        if np.any(np.abs(away) > ONE_MOTION):
            return False
    return True


def _crossing(difference: Difference, low: _End, high: _End, at: float, beside: float) -> Crossing:
    """The record of a crossing: values and slope there, and how far it may be off."""
    here = difference.followed(low.motions, at)
    around = [difference.followed(low.motions, at + step) for step in (-beside, beside)]
    coarse = None if here is None else difference.followed(here, at, COARSER * difference.tolerance)
    if here is None or coarse is None or around[0] is None or around[1] is None:
        return _untold(CrossingKind.LOST, low, high)
    slope = (difference.of(around[1]) - difference.of(around[0])) / (2.0 * beside)
    noise = abs(difference.of(coarse) - difference.of(here))
    width = 0.0 if at in (low.place, high.place) else high.place - low.place  # at an end it is zero exactly
    good = all(motion.certified for motion in here)
    return Crossing(
        kind=CrossingKind.CROSSING if good else CrossingKind.NOT_CERTIFIED,
        at=at,
        bracket=(low.place, high.place),
        differences=(low.difference, high.difference),
        error=width + (noise / abs(slope) if slope else math.inf),
        values=tuple(motion.value(difference.measure) for motion in here),
        slope=slope,
    )


def _untold(kind: CrossingKind, low: _End, high: _End) -> Crossing:
    bracket, differences = (low.place, high.place), (low.difference, high.difference)
    return Crossing(kind, 0.5 * sum(bracket), bracket, differences, high.place - low.place, (), math.nan)
