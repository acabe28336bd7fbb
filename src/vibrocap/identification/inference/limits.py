"""Limits that a search reached: of the law, of the search itself, or given; and the intervals that they hold closed.

Where a parameter stands at a limit with the data pulling beyond it, an interval within the limits says more of the
limits than of the data. So its end on that side is open, and so are those of the parameters that would follow. A limit
of the law (zero, or the order of its levels) is known beforehand and holds nothing else.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from vibrocap.identification.inference.profile import Interval
from vibrocap.identification.inference.uncertainty import Problem, inverse
from vibrocap.identification.problem.coordinates import LARGEST_RATIO, WHOSE, Coordinate
from vibrocap.identification.problem.terms import TERMS

HELD = 0.25  # of half an interval: a parameter that would move so far without a limit is held by it


@dataclasses.dataclass(frozen=True)
class ReachedLimit:
    """A limit at which a parameter of the law stands, or an offset, a mass or a delay.

    side: "low" or "high" end of the parameter's range; value: of the parameter there
    whose: "law" (zero, or the order of its levels), "search" (the package's own range) or "given" (`bounds`)
    holds: parameters whose intervals are open because the data pull beyond it; a limit of the law holds none
    pressed: whether the data pull beyond it by more than chance; at one of the law, law or data are wrong then
    """

    parameter: str
    side: str
    value: float
    whose: str
    text: str
    holds: tuple[str, ...] = ()
    pressed: bool = False

    def __str__(self) -> str:
        more = f"; the data pull beyond it, so that it holds {', '.join(self.holds)}" if self.holds else ""
        return self.text + more


def reached_limits(problem: Problem) -> tuple[ReachedLimit, ...]:
    """The limits at which parameters of the law and of the sensor stand, and which intervals they hold.

    With e the errors, J their slopes and g_k = (J^T e)_k at a limit that is pressed upon, the parameters would move by
    -(J^T J)^-1 g_k without it, as far as a straight line tells.
    """
    space, best, spread = problem.prediction.space, problem.best, problem.uncertainty
    names = [coordinate.name for coordinate in space.coordinates if not coordinate.state]
    to_parameters = space.slopes(best.u)
    weighted = problem.loss.slope(best.errors)[:, None] * best.slopes
    gradient, information = weighted.T @ best.errors, inverse(weighted.T @ best.slopes)
    half = spread.threshold * np.sqrt(np.diag(spread.covariance) / spread.inflation)
    values = space.values(best.u)
    limits = []
    for j, coordinate in enumerate(space.coordinates):
        at = coordinate.at_limit(best.u[j]) if coordinate.name in names else 0
        if not at:
            continue
        alone = np.zeros(len(best.u))
        alone[j] = gradient[j] if gradient[j] * at < 0 else 0.0
        moved = to_parameters @ -(information @ alone)
        # twice the cost of keeping the limit
        cost = float(alone[j] ** 2 * information[j, j])
        pressed = bool(cost > spread.unit * spread.threshold[j] ** 2)
        held = [
            name
            for i, name in enumerate(space.names)
            if name in names and coordinate.whose_limit(at) != "law" and (abs(moved[i]) > HELD * half[i] or i == j)
        ]
        side = "low" if (at < 0) != (coordinate.form == "below") else "high"
        text = _text(coordinate, at, side, float(values[j]))
        of = coordinate.name, side, float(values[j]), coordinate.whose_limit(at)
        limits.append(ReachedLimit(*of, text, tuple(held), pressed))
    return tuple(limits)


def opened(intervals: Mapping[str, Interval], limits: Sequence[ReachedLimit], problem: Problem) -> dict[str, Interval]:
    """The intervals, open on the sides that limits hold."""
    space, best = problem.prediction.space, problem.best
    coordinates = dict(zip(space.names, space.coordinates, strict=True))
    result, to_parameters = dict(intervals), space.slopes(best.u)
    for limit in limits:
        j = space.names.index(limit.parameter)
        outward = coordinates[limit.parameter].at_limit(best.u[j])
        for name in limit.holds:
            # the direction in which a parameter goes with the coordinate, where it depends on it; else up
            follows = float(np.sign(to_parameters[space.names.index(name), j])) or 1.0
            least = -math.inf if coordinates[name].form == "linear" else 0.0
            up = limit.side == "high" if name == limit.parameter else follows * outward > 0
            side = {"high": math.inf, "high_open": True} if up else {"low": least, "low_open": True}
            result[name] = dataclasses.replace(result[name], **side, limit=limit.text)
    return result


def _text(coordinate: Coordinate, at: int, side: str, value: float) -> str:
    name, number = coordinate.name, f"{value:.4g}"
    end = {"low": "lower", "high": "upper"}[side]
    whose = WHOSE[coordinate.whose_limit(at)]
    if name in TERMS and not TERMS[name].signed and at < 0:
        return f"{name} is at 0, and no {name} is negative"
    if coordinate.form in ("above", "below"):
        ratio = f"{LARGEST_RATIO:g} times " if at > 0 else ""
        high, low = (name, coordinate.partner) if coordinate.form == "above" else (coordinate.partner, name)
        return f"{high} is at {ratio}{low}, a limit {whose}"
    return f"{name} is at {number}, the {end} limit {whose}"
