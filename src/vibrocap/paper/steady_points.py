"""The control points O1, O2 and the boundary points P1, P2 of the steady state: where they are, and where none is."""

import dataclasses
import math
from collections.abc import Mapping

from vibrocap.orbits.continuation.crossing import Crossings
from vibrocap.orbits.continuation.crossing_bracket import Crossing, CrossingKind
from vibrocap.paper.presets import SHORT
from vibrocap.paper.runs import Runs

PRINTED = {"O1": 4.0, "O2": 2.2, "P1": 1.18, "P2": 4.36}
BOTH = "both"  # the difference of the two laws, as a key beside their names
SOFT = 0.58  # a spring with which all four exist, in the printed order
RANGE_OF_SOFT = (0.5, 0.55, 0.58, 0.62, 0.65)


@dataclasses.dataclass(frozen=True)
class SteadyPoints:
    """The four points at one stiffness, with their errors: NaN where there is none.

    equal: for each law and for their difference the ranges of the mass ratio over which the drift is nothing
    """

    stiffness: float
    at: Mapping[str, float]
    error: Mapping[str, float]
    equal: Mapping[str, tuple[tuple[float, float], ...]]


def crossings_of(runs: Runs, stiffness: float) -> dict[str, Crossings]:
    """Zeros of the steady drift over the mass ratio, for each law, and where both laws drift alike."""
    crossings = {name: runs.crossings(name, stiffness) for name in SHORT}
    return crossings | {BOTH: runs.crossings("lugre", stiffness, "exponential")}


def steady_points(runs: Runs, stiffness: float) -> SteadyPoints:
    """O1, O2, P1, P2 of the steady drift at a stiffness.

    As in the paper, of the mirror-image solutions the one that a light capsule follows forward: O1 and O2 are the first
    zeros of LM and of EM, P1 is where EM first falls below LM, P2 where it rises above it again.
    """
    located = crossings_of(runs, stiffness)
    drift = float(located["lugre"].differences[0])
    forward = math.copysign(1.0, drift) if abs(drift) > 0.0 else 1.0
    zeros = [_first(located[name]) for name in SHORT]
    falls = _first(located[BOTH], forward)  # LM less EM rises
    rises = _first(located[BOTH], -forward, after=falls.at if falls else -math.inf)
    points = dict(zip(PRINTED, (*zeros, falls, rises), strict=True))
    return SteadyPoints(
        stiffness,
        {name: math.nan if place is None else place.at for name, place in points.items()},
        {name: math.nan if place is None else place.error for name, place in points.items()},
        {key: value.equal for key, value in located.items()},
    )


def _first(crossings: Crossings, direction: float = 0.0, after: float = -math.inf) -> Crossing | None:
    """The first crossing beyond a place, upwards (way > 0), downwards (< 0) or either way; None where there is none."""
    for place in crossings.found:
        if place.kind is CrossingKind.CROSSING and place.at > after and place.slope * direction >= 0.0:
            return place
    return None


def printed_range_in_numbers(runs: Runs, key: str, stiffness: float = 4.0) -> dict[str, float]:
    """What the search for a point at the printed parameters has seen: all numbers behind "there is none"."""
    numbers = crossings_of(runs, stiffness)[key]
    nothing = numbers.equal[0] if len(numbers.equal) == 1 else (math.nan, math.nan)
    what = "drift of LM less EM" if key == BOTH else "drift"
    return {
        f"steady: points where the {what} changes sign": float(len(numbers.places)),
        f"steady: largest |{what}|": float(abs(numbers.differences).max()),
        "steady: it is nothing from lambda": nothing[0],
        "steady: it is nothing to lambda": nothing[1],
        "steady: mass ratios not settled": float(len(numbers.unsettled)),
    }
