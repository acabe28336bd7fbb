"""branch(...) and branches(...): follow a steady motion over a parameter, and all that branches off from it."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from vibrocap.equations import equations
from vibrocap.numerics.expressions.graph import depends_on_time
from vibrocap.orbits.birth import angled_births, born_point
from vibrocap.orbits.branch import Branch, SpecialPoint, empty_branch, joined
from vibrocap.orbits.branch_end import BranchEnd
from vibrocap.orbits.branch_point import BranchPoint
from vibrocap.orbits.closing_map import ClosingMap
from vibrocap.orbits.continuation import followed, started
from vibrocap.orbits.cycle_following import cycles_followed
from vibrocap.orbits.cycle_map import CycleMap
from vibrocap.orbits.orbit import Orbit, OrbitStatus
from vibrocap.orbits.special_points import SpecialKind
from vibrocap.orbits.steady import orbit as steady_orbit
from vibrocap.system import System

TOWARDS = ("both", "up", "down")


def branch(
    system: System,
    over: str,
    between: tuple[float, float],
    *,
    orbit: Orbit | None = None,
    initial: Mapping[str, float] | None = None,
    half: bool | None = None,
    towards: str = "both",
    points: int = 1000,
    step: float = 0.01,
    settle_periods: int = 2000,
    tolerance: float = 1e-12,
) -> Branch:
    """The branch of steady motions through one of them, over a range of a parameter.

    Followed by its arclength, so that it goes on past folds and as an unstable branch; folds, pitchforks, flips,
    Neimark-Sacker points and changes of the word are located on the way (`Branch.special_points`).

    over: path of the parameter, such as "drive.amplitude"; between: its least and largest value
    orbit: the motion to start from; by default the one to which `initial` leads at the system's own parameters (where
        these are out of the range, at its nearer end)
    half: whether the branch of symmetric orbits is meant (fixed points of the half-period map); by default as the orbit
    towards: "both", "up" or "down", the way of the parameter at the start
    points: most points each way; step: longest, in natural sizes of the states and shares of the range of the parameter
    settle_periods, tolerance: as for `orbit`

    Returns a `Branch`; its `ends` say why it was not followed further, with advice. If no orbit closes at the start it
    is empty. Raises ValueError, naming the argument, before any work.
    """
    _check_options(towards, points, step)
    low, high = checked_range(system, over, between)
    mirrored = mirrored_all_over(system, over, (low, high))
    if half and not mirrored:
        raise ValueError("half should be False: the system has no half-period symmetry (drive, machine or law)")
    begun = starting_orbit(system, over, between, orbit, initial, settle_periods, tolerance)
    if half is None:
        half = bool(begun.symmetric) and mirrored
    period = begun.response_period
    if half and period % 2 == 0:
        raise ValueError(f"half should be False for an orbit of an even number of drive periods, got {period}")
    base = begun.system
    state = np.array([begun.state[name] for name in base.state_names])
    closure: ClosingMap
    if nothing_drives(base):
        if begun.status is not OrbitStatus.CONVERGED:
            return empty_branch(ClosingMap(base, over, (low, high), 1, False, tolerance, False), (low, high))
        closure = CycleMap(base, over, (low, high), state, begun.period, tolerance)
    else:
        closure = ClosingMap(base, over, (low, high), max(period, 1), half, tolerance, mirrored)
    first = None
    if begun.status is OrbitStatus.CONVERGED or half:
        first = started(closure, closure.point(state, float(base.parameter(over))))
    if first is None:
        return empty_branch(closure, (low, high))
    follow = cycles_followed if isinstance(closure, CycleMap) else followed
    back = None if towards == "up" else follow(closure, first, -1.0, points, step)  # type: ignore[arg-type]
    if back is not None and back.end is BranchEnd.CLOSED:
        return joined(closure, None, back)
    onward = None if towards == "down" else follow(closure, first, 1.0, points, step)  # type: ignore[arg-type]
    return joined(closure, back, onward)


def leaving(parent: Branch, special: SpecialPoint, *, points: int = 1000, step: float = 0.01) -> Branch | None:
    """The branch that leaves another at a pitchfork (of the mirror twins the one that drifts forward first) or a flip.

    Also at a change of the word where the multipliers jump over -1; there it is searched on both sides, and None is
    returned where nothing is found. Raises ValueError at a special point from which none leaves.
    """
    map_, found = parent.closing_map, special.found
    if special.kind in (SpecialKind.PITCHFORK, SpecialKind.FLIP) and found.direction is not None:
        finer, birth = born_point(map_, found)
        way = followed(finer, birth, 1.0, points, step, born=True)
        if len(way.points) < 2:
            return None
        if _drifts_back(way.points[1]):
            turned = dataclasses.replace(birth, tangent=-birth.tangent)
            way = followed(finer, turned, 1.0, points, step, born=True)
        assert isinstance(finer, ClosingMap)
        result = joined(finer, None, way)
        return dataclasses.replace(result, ends=(_born(special), result.ends[1]))
    if special.kind is SpecialKind.WORD_CHANGE and special.passed in (SpecialKind.PITCHFORK, SpecialKind.FLIP):
        for finer, first in angled_births(map_, found):
            assert isinstance(finer, ClosingMap)
            ways = [followed(finer, first, sign, points, step) for sign in (-1.0, 1.0)]
            return joined(finer, *ways)
        return None
    raise ValueError(f"special should be a pitchfork or a flip, from which a branch leaves, got a {special.kind.value}")


def _born(special: SpecialPoint) -> BranchEnd:
    """How a branch begins that leaves at a special point."""
    return BranchEnd.PITCHFORK if SpecialKind.PITCHFORK in (special.kind, special.passed) else BranchEnd.FLIP


def _drifts_back(point: BranchPoint) -> bool:
    return point.closing.drift < 0.0


def checked_range(system: System, over: str, between: tuple[float, float]) -> tuple[float, float]:
    """The range of a parameter, as two numbers. ValueError for a path, a value or a range that makes no sense."""
    try:
        value = system.parameter(over)
    except KeyError as error:
        raise ValueError(f"over: {error.args[0]}") from None
    if isinstance(value, (bool, str)) or not isinstance(value, (int, float)):
        raise ValueError(f"over should be the path of a number, but {over} is {value!r}")
    try:
        low, high = (float(each) for each in between)
    except (TypeError, ValueError):
        raise ValueError(f"between should be two numbers, the least and the largest {over}, got {between!r}") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"between should be two numbers, the smaller one first, got {between!r}")
    for end in (low, high):
        try:
            system.with_parameters({over: end})
        except ValueError as error:
            raise ValueError(f"between: {over} cannot be {end!r}: {error}") from None
    return low, high


def nothing_drives(system: System) -> bool:
    """Whether the equations do not contain the time, so that motions have periods of their own."""
    return not depends_on_time(equations(system).rates)


def _check_options(towards: str, points: int, step: float) -> None:
    if towards not in TOWARDS:
        raise ValueError(f"towards should be one of {', '.join(TOWARDS)}, got {towards!r}")
    if not isinstance(points, (int, np.integer)) or isinstance(points, bool) or points < 2:
        raise ValueError(f"points should be a whole number >= 2, got {points!r}")
    if not 1e-6 <= step <= 0.5:
        raise ValueError(f"step should be a share of the range, from 1e-6 to 0.5, got {step!r}")


def starting_orbit(
    system: System,
    over: str,
    between: tuple[float, float],
    orbit: Orbit | None,
    initial: Mapping[str, float] | None,
    settle_periods: int,
    tolerance: float,
) -> Orbit:
    """The orbit from which a branch is followed; ValueError where it is none of the system or out of the range."""
    between = checked_range(system, over, between)
    if orbit is not None and initial is not None:
        raise ValueError("orbit and initial should not both be given: a start is one of them")
    given = system if orbit is None else orbit.system
    if orbit is not None and given.with_parameters({over: system.parameter(over)}) != system:
        raise ValueError(f"orbit should be of the system, whatever its {over}: another parameter differs")
    value = float(given.parameter(over))
    inside = min(max(value, between[0]), between[1])
    if orbit is not None:
        if value != inside:
            raise ValueError(f"orbit should have its {over} within {between[0]:g} to {between[1]:g}, got {value:g}")
        return orbit
    system = system if value == inside else system.with_parameters({over: inside})
    return steady_orbit(system, initial=initial, settle_periods=settle_periods, tolerance=tolerance)


def mirrored_all_over(system: System, over: str, between: tuple[float, float]) -> bool:
    """Whether the half-period symmetry holds all over the range of the parameter."""
    if nothing_drives(system):
        return False
    low, high = between
    values = (low, 0.5 * (low + high), high)
    return all(system.with_parameters({over: value}).mirrored for value in values)
