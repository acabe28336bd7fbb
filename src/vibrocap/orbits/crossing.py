"""Where a measure of the steady motion takes a value: control points, and points where two laws agree."""

import dataclasses
import enum
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.ensemble import ensemble
from vibrocap.measures.during_run import measure_table, measured
from vibrocap.orbits.orbit import Orbit, OrbitStatus
from vibrocap.orbits.shooting import shoot
from vibrocap.orbits.steady import orbit
from vibrocap.system import System

SETTLE = 1e-6
NOTHING = 1e-9  # a value nearer to the one wanted than this share of the measure's range (or this) equals it
NARROW = 1e-13  # of the parameter's range: a bracket is not cut further
JUMP = 0.1  # of the difference across the bracket at first: a difference that stays above it is no crossing
HALVINGS = 200


class CrossingKind(enum.Enum):
    """What was found between two neighbouring points of the scan where the difference changes its sign."""

    CROSSING = "crossing"
    JUMP = "jump"
    LOST = "lost"

    @property
    def advice(self) -> str:
        """What it means."""
        return {
            CrossingKind.CROSSING: "The measure takes the value here, on a steady motion that exists on both sides.",
            CrossingKind.JUMP: "The measure jumps over the value: the start leads to another steady motion (a mirror "
            "twin, for instance), or a motion ceases to exist. No steady motion here has the value.",
            CrossingKind.LOST: "The steady motion could not be followed to where the sign changes; refine the scan.",
        }[self]


@dataclasses.dataclass(frozen=True)
class Crossing:
    """A place where the measure passes the value, or jumps over it.

    at: the parameter; bracket: of it, with the difference (measure less value) at both ends
    error: bound of |at - the true place|, from the bracket
    values: of the measure at `at`, of the system and (with `against`) of the other
    slope: of the difference over the parameter across the last bracket; NaN for a jump
    """

    kind: CrossingKind
    at: float
    bracket: tuple[float, float]
    differences: tuple[float, float]
    error: float
    values: tuple[float, ...]
    slope: float


@dataclasses.dataclass(frozen=True, eq=False)
class Crossings:
    """All places found, and what the scan saw.

    found: `Crossing`s in the order of the parameter
    equal: ranges of the parameter over which the measure equals the value all along (zero drift of symmetric motions):
        no point of them is a crossing
    unsettled: parameters of the scan whose motion did not settle; across them nothing can be told
    parameters, differences: the scan [points]; NaN where not settled
    """

    measure: str
    over: str
    value: float
    found: tuple[Crossing, ...]
    equal: tuple[tuple[float, float], ...]
    unsettled: tuple[float, ...]
    parameters: np.ndarray
    differences: np.ndarray


def crossing(
    system: System,
    measure: str = "drift",
    over: str = "machine.mass_ratio",
    between: tuple[float, float] = (0.01, 8.1),
    *,
    value: float = 0.0,
    against: System | None = None,
    initial: Mapping[str, float] | None = None,
    points: int = 200,
    periods: int = 2000,
    tolerance: float = 1e-12,
) -> Crossings:
    """Where the steady value of a measure equals a value, or that of another system, along a parameter.

    A scan of settled motions brackets every change of sign; in each bracket the steady orbit is followed by shooting
    and the bracket halved until the parameter is known to rounding. A measure that equals the value over a whole range,
    as the drift of symmetric motions is exactly zero, has no crossing there, and the result says so.

    measure: a name of `measure_table()` that is a number
    over: parameter path; between: its least and largest value
    value: that is looked for; against: another system (another law), then value is that of the difference
    initial: start of the motions, by state (where several motions are stable it decides which is seen)
    points, periods: of the scan: how many parameters, and drive periods to settle in at most
    tolerance: of the orbits
    Returns `Crossings`. Raises ValueError for a path, range or measure that is none.
    """
    low, high = _checked(system, measure, over, between, points, against)
    parameters = np.linspace(low, high, points)
    systems = (system,) if against is None else (system, against)
    scans = [_scan(each, measure, over, parameters, initial, periods) for each in systems]
    differences = scans[0] - value if against is None else scans[0] - scans[1] - value
    size = float(np.nanmax([np.nanmax(np.abs(scan), initial=0.0) for scan in scans], initial=0.0))
    same = np.abs(differences) <= NOTHING * max(1.0, size) + SETTLE * size
    signs = np.where(same, 0.0, np.sign(differences))
    found = []
    last = -1  # the last settled point that is not equal to the value
    for i in range(points):
        if not math.isfinite(signs[i]):
            last = -1
        elif signs[i] != 0.0:
            if last >= 0 and signs[last] * signs[i] < 0.0 and i - last <= 2:
                found.append(
                    _located(systems, measure, over, (parameters[last], parameters[i]), value, initial, tolerance)
                )
            last = i
    return Crossings(
        measure=measure,
        over=over,
        value=value,
        found=tuple(found),
        equal=_ranges(parameters, same),
        unsettled=tuple(parameters[~np.isfinite(differences)].tolist()),
        parameters=parameters,
        differences=differences,
    )


def steady_value(found: Orbit, measure: str) -> float:
    """A measure of a steady orbit over its whole period; drift is per response, mean velocity over it."""
    if measure == "drift" and found.drift is not None:
        return found.drift / max(1, found.response_period)
    if measure == "mean_velocity" and found.mean_velocity is not None:
        return found.mean_velocity
    return float(measured(found.motion(), [measure], window=max(1, found.response_period))[measure])


def _scan(
    system: System, measure: str, over: str, parameters: np.ndarray, initial: Mapping[str, float] | None, periods: int
) -> np.ndarray:
    """Steady values along the parameter; NaN where a motion did not settle."""
    found = ensemble(system, {over: parameters}, measures=[measure], initial=initial, periods=periods, settle=SETTLE)
    return np.where(found["settled"], found[measure], np.nan)


def _located(
    systems: tuple[System, ...],
    measure: str,
    over: str,
    bracket: tuple[float, float],
    value: float,
    initial: Mapping[str, float] | None,
    tolerance: float,
) -> Crossing:
    """Follow the steady orbits from the lower end of a bracket and halve it."""
    low, high = map(float, bracket)
    start = [orbit(each.with_parameters({over: low}), initial=initial, tolerance=tolerance) for each in systems]
    end = [orbit(each.with_parameters({over: high}), initial=initial, tolerance=tolerance) for each in systems]

    def difference(orbits: list[Orbit]) -> float:
        values = [steady_value(each, measure) for each in orbits]
        return values[0] - value if len(values) == 1 else values[0] - values[1] - value

    if not all(each.status is OrbitStatus.CONVERGED for each in (*start, *end)):
        return Crossing(CrossingKind.LOST, math.nan, (low, high), (math.nan, math.nan), high - low, (), math.nan)
    first, last = difference(start), difference(end)
    across, width = abs(last - first), high - low
    here = start
    for _ in range(HALVINGS):
        middle = _next_place(low, high, first, last)
        following = [_followed(near, over, middle, tolerance) for near in here]
        if any(each is None for each in following):
            following = [_followed(near, over, middle, tolerance) for near in end]
        if any(each is None for each in following):
            if high - low <= 1e-6 * width:
                break
            return Crossing(CrossingKind.LOST, middle, (low, high), (first, last), high - low, (), math.nan)
        orbits = [each for each in following if each is not None]
        now = difference(orbits)
        if now * first > 0.0:
            low, first, here = middle, now, orbits
        else:
            high, last, end = middle, now, orbits
        if now == 0.0 or high - low <= NARROW * width:
            break
    jumped = abs(last - first) > JUMP * across
    place = low - first * (high - low) / (last - first) if last != first and not jumped else 0.5 * (low + high)
    return Crossing(
        kind=CrossingKind.JUMP if jumped else CrossingKind.CROSSING,
        at=place,
        bracket=(low, high),
        differences=(first, last),
        error=high - low,
        values=tuple(steady_value(each, measure) for each in here),
        slope=math.nan if jumped else (last - first) / (high - low) if high > low else math.nan,
    )


def _next_place(low: float, high: float, first: float, last: float) -> float:
    """The secant's place, kept away from the ends so that the bracket shrinks from both sides."""
    middle = 0.5 * (low + high)
    if last == first:
        return middle
    secant = low - first * (high - low) / (last - first)
    margin = max(1e-3 * (high - low), min(0.25 * (high - low), 1e-12 * max(abs(low), abs(high))))
    return min(max(secant, low + margin), high - margin)


def _followed(near: Orbit, over: str, place: float, tolerance: float) -> Orbit | None:
    """The orbit at another place of the parameter, from one nearby; None where it is not found there."""
    moved = near.system.with_parameters({over: place})
    found = shoot(moved, near.state, near.response_period, tolerance=tolerance)
    return found if found.status is OrbitStatus.CONVERGED else None


def _ranges(parameters: np.ndarray, same: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Ranges of at least two neighbouring points at which the measure equals the value."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(int), [0]))))
    pairs = zip(edges[::2], edges[1::2] - 1, strict=True)
    return tuple((float(parameters[i]), float(parameters[j])) for i, j in pairs if j > i)


def _checked(
    system: System, measure: str, over: str, between: Any, points: Any, against: System | None
) -> tuple[float, float]:
    """The range, or ValueError for what cannot be looked for."""
    table = measure_table()
    if measure not in table or measure == "word":
        import difflib

        near = difflib.get_close_matches(str(measure), [name for name in table if name != "word"], n=1, cutoff=0.0)[0]
        raise ValueError(
            f"measure should be a number of the table of measures, got {measure!r}; did you mean {near!r}?"
        )
    for each in (system,) if against is None else (system, against):
        try:
            now = each.parameter(over)
        except KeyError as error:
            raise ValueError(f"over: {error.args[0]}") from None
        if isinstance(now, bool) or not isinstance(now, (int, float)):
            raise ValueError(f"over should be a parameter that is a number, but {over} is {now!r}")
    low, high = map(float, between)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"between should be (least, largest) value of {over}, got {between!r}")
    if not isinstance(points, int) or points < 2:
        raise ValueError(f"points should be a whole number >= 2, got {points!r}")
    for place in (low, high):
        system.with_parameters({over: place})
    return low, high
