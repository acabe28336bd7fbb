"""A branch of steady motions over a parameter: labelled arrays, its special points, and why it ends."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated

import numpy as np

from vibrocap.arguments import ArgumentError, check_one_of, check_whole
from vibrocap.measures.of_measure import OneOfMeasure
from vibrocap.motion.recording.section import whole_turns
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.closing.orbit import orbit as steady_orbit
from vibrocap.orbits.closing.periodic_solution import OrbitStatus
from vibrocap.orbits.continuation.crossing import BranchCrossing, OfOrbit, branch_crossings, orbit_near
from vibrocap.orbits.continuation.cycle_following import cycles_followed
from vibrocap.orbits.maps.closing_map import ClosingMap
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.maps.stroboscopic_map import is_driven, state_vector
from vibrocap.orbits.parameter_range import checked_range
from vibrocap.orbits.walk.branch_record import BranchRecord
from vibrocap.orbits.walk.branch_switching import branches_at_corner, switched_point
from vibrocap.orbits.walk.following import Followed, end_at, followed, started, walked
from vibrocap.orbits.walk.kinds import CORNERS, BranchEnd, SpecialKind
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE, BranchPoint, corrected
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path, value_in_words
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import AlongTurns, ByName, Lengths, Numbers, Over, Speeds, StateColumns, Times
from vibrocap.quantities.dimensional import said

ROUGHLY = 0.05  # distance from the chords of a branch beyond which it need not be known exactly


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Branch(BranchRecord):
    """Steady motions that go over into each other as a parameter changes, in order of the arclength.

    over, between: path and range of the parameter; response_period: of all its orbits, in drive periods; 0 for cycles
        of a system that nothing drives in time
    period: [points] length of a response
    parameter, drift, mean_velocity, arclength, stable, mode_sequence: [points]; states: [points, states] at the section
    certified: [points] whether the motion along the orbit is one of the equations: by the evidence taken as it was
        closed, and where that is beyond the bounds of a certificate, by the certificate of the recorded motion
    multipliers: [points, multipliers] modulo the drift, largest first; drift: NaN without a cyclic coordinate
    winding: [points, coordinates that turn] whole turns over a response
    symmetric: whether its orbits are their own mirror images; None where the system has no such symmetry
    special_points: in order; ends: why it was not followed beyond its first and its last point
    start: index of the point it was followed from; -1 where no orbit closed there and the branch is empty

    Two branches are equal if all of this is: every point, special point and end.
    """

    system: System
    over: Path
    between: tuple[Parameter, Parameter]
    response_period: int
    symmetric: bool | None
    parameter: Annotated[Parameters, Over("point", name="over")]
    period: Annotated[Times, Over("point", words="length of one response")]
    states: Annotated[StateColumns, Over("point")]
    drift: Annotated[Lengths, Over("point", words="drift over one response")]
    mean_velocity: Annotated[Speeds, Over("point", words="mean velocity")]
    multipliers: Annotated[Numbers, Over("point", "multiplier", words="Floquet multiplier")]
    stable: Annotated[Numbers, Over("point", words="all multipliers inside the unit circle")]
    mode_sequence: Annotated[Numbers, Over("point", words="phases: F forward, S stuck, B back")]
    arclength: Annotated[
        Numbers, Over("point", name="arclength", words="arclength, in natural sizes and shares of the range")
    ]
    certified: Annotated[Numbers, Over("point", words="the motion is one of the equations, by its certificate")]
    winding: Annotated[np.ndarray, AlongTurns(), Over("point", words="whole turns over one response")]
    special_points: Annotated[tuple[SpecialPoint, ...], Over("special")]
    ends: tuple[BranchEnd, BranchEnd]
    start: int
    closing_map: ClosingMap = dataclasses.field(compare=False)

    in_record = (
        "response_period symmetric parameter period drift mean_velocity stable mode_sequence certified "
        "special_points ends advice"
    )

    @property
    def heading(self) -> str:
        what = f"orbits of {self.response_period} drive period(s)" if self.response_period else "cycles"
        return f"branch of {self._kind}{what} over {self.over}"

    @property
    def facts(self) -> dict[str, str]:
        points, *others = super().facts.items()
        refused = np.sum(~self.certified)
        return dict([points, *([("certificate", f"{refused} of them not certified")] if refused else []), *others])

    @property
    def _kind(self) -> str:
        """The word for its orbits, with a space behind."""
        kind = {True: "symmetric ", False: "travelling ", None: ""}[self.symmetric]
        drifts = self.closing_map.map.cyclic >= 0
        return kind if drifts or self.symmetric is not False else "asymmetric "

    def orbit(self, point: int) -> Orbit:
        """The orbit at a point of the branch, closed anew, with all that an `Orbit` tells."""
        place = self.states[point], float(self.parameter[point]), float(self.period[point])
        return orbit_near(self.closing_map, *place)

    def orbits_at(self, value: Parameter) -> list[Orbit]:
        """The orbits of the branch at a value of its parameter: one for each time that it passes there."""
        orbits = []
        for i in range(len(self) - 1):
            left, right = self.parameter[i : i + 2]
            if min(left, right) <= value < max(left, right) or (i == len(self) - 2 and value == right):
                share = (value - left) / (right - left)
                state = self.states[i] + share * (self.states[i + 1] - self.states[i])
                period = self.period[i] + share * (self.period[i + 1] - self.period[i])
                orbits.append(orbit_near(self.closing_map, state, value, float(period)))
        return orbits

    def crossings(self, measure: str | OfOrbit = "drift", value: OneOfMeasure = 0.0) -> tuple[BranchCrossing, ...]:
        """All places of the branch where a measure passes a value, in its order; see `branch_crossings`.

        measure: a name of `measure_table()` that is a number (drift and works are per drive period), or a function of
            an orbit without units, such as `lambda orbit: abs(orbit.multipliers[0]) - 0.5`
        Raises ValueError for what is no measure of the system.
        """
        points = list(zip(self.states, self.parameter.tolist(), self.period.tolist(), strict=True))
        known = {"drift": self.drift / max(self.response_period, 1), "mean_velocity": self.mean_velocity}
        return branch_crossings(self.closing_map, points, known.get(str(measure)), measure, value)

    @property
    def largest_multiplier(self) -> Annotated[Numbers, Over("point", words="largest size of a multiplier")]:
        """The largest |multiplier| at each point, 0 where there is none."""
        return np.max(np.abs(self.multipliers), axis=1, initial=0.0)

    def __str__(self) -> str:
        if self.certified.all():
            return super().__str__()
        wrong = self.parameter[~self.certified]
        span = f"{wrong.min():.6g} to {said(wrong.max(), self.unit_of('parameter'), 6)}"
        refused = f"{len(wrong)} points from {span} not certified: their motions are not those of the equations"
        return f"{super().__str__()}\n  {refused}"


def empty_branch(closure: ClosingMap) -> Branch:
    """The record of a branch of which not even the first orbit closed."""
    names = len(closure.system.state_names)
    none, nowhere = np.empty(0), (BranchEnd.START_FAILED, BranchEnd.START_FAILED)
    multipliers = np.empty((0, len(closure.unknowns)), dtype=complex)
    return Branch(
        closure.system, closure.path, closure.between, closure.response_period, closure.symmetric, none, none,
        np.empty((0, names)), none, none, multipliers, np.empty(0, dtype=bool), np.empty(0, dtype=str),
        none, np.empty(0, dtype=bool), np.empty((0, len(closure.system.turns)), dtype=int), (), nowhere, -1,
        closure,
    )  # fmt: skip


def joined(closure: ClosingMap, back: Followed | None, onward: Followed | None) -> Branch:
    """The record of a branch from the ways followed from one start, against and along its order."""
    walk = walked(closure, back, onward)
    points = walk.points

    def confirmed(point: BranchPoint) -> bool:
        """Whether the recorded motion along the orbit has its certificate."""
        return orbit_near(closure, *closure.place(point)).status is OrbitStatus.CONVERGED

    multipliers = np.stack([point.multipliers(closure.half) for point in points])
    periods = np.array([closure.period(point.x) for point in points])
    drift = np.array([closure.drift(point.closing) for point in points])
    return Branch(
        system=closure.system,
        over=closure.path,
        between=closure.between,
        response_period=closure.response_period,
        symmetric=closure.symmetric,
        parameter=np.array([closure.parameter(point.x) for point in points]),
        period=periods,
        states=np.stack([closure.state(point.x, point.closing) for point in points]),
        drift=drift,
        mean_velocity=drift / periods,
        multipliers=multipliers,
        stable=np.all(np.abs(multipliers) < 1.0 - CLOSE_TO_CIRCLE, axis=1),
        mode_sequence=np.array([point.closing.mode_sequence for point in points]),
        arclength=walk.ways,
        certified=np.array([point.closing.certified or confirmed(point) for point in points]),
        winding=np.array([point.closing.winding for point in points], dtype=int).reshape(len(points), -1),
        special_points=walk.special_points,
        ends=walk.ends,
        start=walk.start,
        closing_map=closure,
    )


@shows_progress("Following the branch")
def branch(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    *,
    orbit: Orbit | None = None,
    initial: ByName | None = None,
    half: bool | None = None,
    towards: str = "both",
    points: int = 1000,
    step: float = 0.01,
    settle_periods: int = 2000,
    tolerance: float = 1e-12,
    progress: Progress = None,
) -> Branch:
    """The branch of steady motions through one of them, over a range of a parameter.

    Followed by its arclength, so that it continues past folds and as an unstable branch; folds, pitchforks, flips,
    Neimark-Sacker points and changes of the mode sequence are located on the way (`Branch.special_points`).

    over: path of the parameter, such as "drive.amplitude"; between: its least and largest value
    orbit: the motion to start from; by default the one to which `initial` leads at the system's own parameters (where
        these are out of the range, at its nearer end)
    half: whether the branch of symmetric orbits is meant (fixed points of the half-period map); by default as the orbit
    towards: "both", "up" or "down", direction of the parameter at the start
    points: most points in each direction; step: longest, as a share of the range of the parameter and of the states,
        in natural sizes of those that are smaller
    settle_periods, tolerance: as for `orbit`
    progress: True for a bar, or a function that is called with the share of the range that is passed

    Returns a `Branch`; its `ends` give the reason for its end, with advice. If no orbit closes at the start it is
    empty. Raises ValueError, naming the argument, before any work.
    """
    check_options(towards, points, step)
    low, high = checked_range(system, over, between)
    mirrored = mirrored_all_over(system, over, (low, high))
    if half and not mirrored:
        raise ArgumentError("half", "should be False: the system has no half-period symmetry (drive, machine or law)")
    begun = first_orbit(system, over, between, orbit, initial, settle_periods, tolerance)
    if half is None:
        half = bool(begun.symmetric) and mirrored
    period = begun.response_period
    if half and period % 2 == 0:
        raise ArgumentError("half", f"should be False for an orbit of an even number of drive periods, got {period}")
    base = begun.system
    state = state_vector(base, begun.state)
    closure: ClosingMap
    if not is_driven(base):
        if not begun.closes:
            return empty_branch(ClosingMap(base, over, (low, high), 1, False, tolerance, False))
        closure = CycleMap(base, over, (low, high), state, begun.period, tolerance)
    else:
        closure = ClosingMap(base, over, (low, high), max(period, 1), half, tolerance, mirrored)
    first = None
    if begun.closes or half:
        first = started(closure, closure.point(state, float(base.parameter(over))))
    if first is None:
        return empty_branch(closure)
    follow = cycles_followed if isinstance(closure, CycleMap) else followed
    report, ways = told(progress), 2.0 if towards == "both" else 1.0
    down = report and (lambda share: report(share / ways))
    up = report and (lambda share: report(1.0 - (1.0 - share) / ways))
    back = None if towards == "up" else follow(closure, first, -1.0, points, step, progress=down)  # type: ignore[arg-type]
    if back is not None and back.end is BranchEnd.CLOSED:
        return joined(closure, None, back)
    onward = None if towards == "down" else follow(closure, first, 1.0, points, step, progress=up)  # type: ignore[arg-type]
    return joined(closure, back, onward)


def leaving(parent: Branch, special: SpecialPoint, *, points: int = 1000, step: float = 0.01) -> Branch | None:
    """The branch that leaves another at a pitchfork (of two solutions the one that travels forward) or a flip.

    Also at a change of the mode sequence, or of the impacts, where the multipliers jump over -1; there it is searched
    on both sides, and None is returned where nothing is found. Raises ValueError at a point from which none leaves.
    """
    map_, located = parent.closing_map, special.found
    if special.kind in (SpecialKind.PITCHFORK, SpecialKind.FLIP) and located.direction is not None:
        finer, first = switched_point(map_, located)
        walk = followed(finer, first, 1.0, points, step, from_parent=True)
        if len(walk.points) < 2:
            return None
        if walk.points[1].closing.drift < 0.0:
            turned = dataclasses.replace(first, tangent=-first.tangent)
            walk = followed(finer, turned, 1.0, points, step, from_parent=True)
        assert isinstance(finer, ClosingMap)
        result = joined(finer, None, walk)
        return dataclasses.replace(result, ends=(end_at(special), result.ends[1]))
    if special.kind in CORNERS and special.passed in (SpecialKind.PITCHFORK, SpecialKind.FLIP):
        for finer, first in branches_at_corner(map_, located):
            assert isinstance(finer, ClosingMap)
            ways = [followed(finer, first, sign, points, step) for sign in (-1.0, 1.0)]
            return joined(finer, *ways)
        return None
    wanted = "should be a pitchfork or a flip, from which a branch leaves"
    raise ArgumentError("special", f"{wanted}, got a {special.kind.value}")


def check_options(towards: str, points: int, step: float) -> None:
    """How a branch is to be followed; raises ValueError, naming the argument."""
    check_one_of("towards", towards, ("both", "up", "down"))
    check_whole("points", points, 2)
    if not 1e-6 <= step <= 0.5:
        raise ArgumentError("step", f"should be a share of the range, from 1e-6 to 0.5, got {step!r}")


def first_orbit(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    orbit: Orbit | None,
    initial: Mapping[str, float] | None,
    settle_periods: int,
    tolerance: float,
) -> Orbit:
    """The orbit from which a branch is followed; ValueError where it is none of the system or out of the range."""
    between = checked_range(system, over, between)
    if orbit is not None and initial is not None:
        raise ArgumentError("orbit and initial", "should not both be given: a start is one of them")
    variant = system if orbit is None else orbit.system
    if orbit is not None and variant.with_parameters({over: system.parameter(over)}) != system:
        raise ArgumentError("orbit", f"should be of the system, at any {over}: another parameter differs")
    value = float(variant.parameter(over))
    inside = min(max(value, between[0]), between[1])
    if orbit is not None:
        if value != inside:
            low, high, got = (value_in_words(over, number, system) for number in (*between, value))
            raise ArgumentError("orbit", f"should have its {over} within {low} to {high}, got {got}")
        return orbit
    system = system if value == inside else system.with_parameters({over: inside})
    return steady_orbit(system, initial=initial, settle_periods=settle_periods, tolerance=tolerance)


def mirrored_all_over(system: System, over: str, between: tuple[float, float]) -> bool:
    """Whether the half-period symmetry holds all over the range of the parameter."""
    if not is_driven(system):
        return False
    low, high = between
    values = (low, 0.5 * (low + high), high)
    return all(system.with_parameters({over: value}).mirrored for value in values)


def branch_distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of an orbit from a branch of its period, in natural sizes and shares of the range; the least over twins.

    state: of the orbit at the section, [states]. Infinite where the branch does not come near.
    """
    closure = branch.closing_map
    row = closure.row.copy()
    row[closure.index] = parameter
    here, starts = state.copy(), []
    for _ in range(branch.response_period):
        starts.append(here)
        here = closure.map.images(here[None], row[None], tangents=False).state[0]
    if closure.mirrored and not closure.half:
        starts += [closure.map.mirrored_half(start[None], row[None], tangents=False).state[0] for start in starts]
    return min(_distance(branch, start, parameter) for start in starts)


def _distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of a point from a branch: from its chords first, then from the branch across the nearest of them."""
    closure = branch.closing_map
    x = closure.point(state, parameter)
    corners = np.stack([closure.point(*point) for point in zip(branch.states, branch.parameter, strict=True)])
    ways = np.diff(corners, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    apart = np.flatnonzero(lengths > 0.0)  # where a branch comes to a bifurcation it may have a point twice
    if not len(apart):
        return float("inf")
    turned = np.zeros_like(corners)  # whole turns, so that each chord begins as near as can be
    unknown = closure.unknowns
    turned[:, : len(unknown)] = whole_turns(branch.system, branch.states - state)[:, unknown] / closure.sizes[unknown]
    starts, ways, lengths = (corners - turned)[apart], ways[apart], lengths[apart]
    shares = np.clip(np.sum((x - starts) * ways, axis=1) / lengths**2, 0.0, 1.0)
    feet = starts + shares[:, None] * ways
    off = np.linalg.norm(feet - x, axis=1)
    i = int(np.argmin(off))
    if off[i] > ROUGHLY * max(1.0, float(np.max(np.abs(x)))):
        return float("inf")
    normal = ways[i] / lengths[i]
    foot, _ = corrected(closure, feet[i], normal, float(normal @ feet[i]))
    return float(off[i]) if foot is None else float(np.linalg.norm(foot.x - x))
