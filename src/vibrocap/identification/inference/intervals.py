"""Intervals: how far one parameter may go while the others follow it, before the data object (profile likelihood), and
limits that a search reached, of the law, of the search itself, or given, which hold intervals closed.

Where a parameter stands at a limit with the data pulling beyond it, an interval within the limits says more of the
limits than of the data. So its end on that side is open, and so are those of the parameters that would follow. A limit
of the law (zero, or the order of its levels) is known beforehand and holds nothing else.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.inference.uncertainty import Problem, inverse
from vibrocap.identification.problem.coordinates import LARGEST_RATIO, WHOSE, Coordinate
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.problem.terms import TERMS
from vibrocap.identification.search import Minimum, descent, warm_descent

CLOSE = 0.03  # relative accuracy of an interval's half width
TRIALS = 9
NO_EFFECT = 1e-9  # change of every error per coordinate, below which a parameter does nothing
REFIT = 25  # evaluations of the others' search at one value
LONGEST = 2.5  # first step of a coordinate at most: a factor of 12
INTERVALS = ("profile", "covariance")
WORTH = 3  # times fewer samples from which a draft is used
ALIKE = 0.25  # logarithm of the ratio of standard errors up to which a draft says the same
NEAR = 0.7  # of the rise that ends an interval, from which on a limit counts that was met on the way
PRESSED = 0.1  # of the deviance that ends an interval: what the step beyond a limit would gain at least
AGAIN = 4  # how often a better fit that a profile comes upon is taken up


@dataclasses.dataclass(frozen=True)
class Interval:
    """A 95 % interval of one parameter.

    An end that the data do not set is open: it is 0 or -inf below and inf above where the parameter went to the bound
    of its search without objection. curve: (value, rise), rise = sqrt(2 (cost - least)/s^2), below `threshold` inside.
    limit: the limit that a parameter reached where an end is open for it, in words.
    """

    low: float
    high: float
    low_open: bool
    high_open: bool
    curve: tuple[tuple[float, float], ...] = ()
    threshold: float = math.nan
    limit: str = ""

    @property
    def closed(self) -> bool:
        """Whether the data set both ends."""
        return not (self.low_open or self.high_open)

    def times(self, factor: float) -> "Interval":
        """The interval of a multiple of the parameter."""
        curve = tuple((value * factor, rise) for value, rise in self.curve)
        return dataclasses.replace(self, low=self.low * factor, high=self.high * factor, curve=curve)

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


Profiles = dict[str, Interval]


class BetterFound(Exception):
    """A profile came upon a lower cost than that of the minimum, with the parameters by name that it carries."""


def profile_intervals(problem: Problem, report: Callable[[float], Any]) -> Profiles:
    """Profile-likelihood intervals (95 %) of the law's parameters; the others are searched anew at each value.

    Each side is warm_descent from the minimum by the secant of the square root of the cost's rise, which is a straight
    line for a linear model, and the others start from where the covariance says they go. Raises BetterFound.
    """
    intervals, space, names = {}, problem.prediction.space, problem.prediction.law_names
    for i, name in enumerate(names):
        j = space.names.index(name)
        if np.abs(problem.best.slopes[:, j]).max() < NO_EFFECT:
            intervals[name] = Interval(space.coordinates[j].least, math.inf, True, True)
        else:
            intervals[name] = _Profile(problem, name).interval()
        report((i + 1) / len(names))
    return intervals


class _Profile:
    """The profile of one parameter, in coordinates in which it depends on no other."""

    def __init__(self, problem: Problem, name: str):
        best, spread, own = problem.best, problem.uncertainty, problem.prediction.space
        space, values = own.with_leader(name), own.named(best.u)
        self.prediction = dataclasses.replace(problem.prediction, space=space)
        self.loss, self.spread, self.least = problem.loss, spread, best.cost
        self.u = space.of(values)
        self.j = space.names.index(name)
        order = [own.names.index(name) for name in space.names]
        back = np.linalg.inv(space.slopes(self.u))
        covariance = back @ spread.covariance[np.ix_(order, order)] @ back.T
        to_own = np.linalg.solve(own.slopes(best.u), np.eye(len(order)))[:, order]
        self.slopes = self.first_slopes = best.slopes @ to_own @ space.slopes(self.u)
        self.first_gains = self._gains(best.errors, self.slopes, self.u)
        self.threshold = float(spread.threshold[own.names.index(name)])
        self.sigma = float(np.sqrt(max(covariance[self.j, self.j], 0.0)))
        self.direction = covariance[:, self.j] / max(covariance[self.j, self.j], 1e-300)
        self.curve: list[tuple[float, float]] = [(values[name], 0.0)]
        self.blocked: tuple[float, str] = (0.0, "")  # largest rise at which a limit held another parameter, and which
        # the rise that ends the interval must be known to a hundredth: the search need not settle closer than that
        self.stop = float(np.clip(0.005 * spread.unit * self.threshold**2 / max(best.cost, 1e-300), 1e-10, 1e-4))

    def interval(self) -> Interval:
        below, below_open, below_limit = self._side(-1)
        above, above_open, above_limit = self._side(1)
        low = self.prediction.space.coordinates[self.j].least if below_open else below
        high = math.inf if above_open else above
        curve, limit = tuple(sorted(self.curve)), below_limit or above_limit
        return Interval(low, high, below_open, above_open, curve, self.threshold, limit)

    def _side(self, side: int) -> tuple[float, bool, str]:
        """Value at which the data object on one side, whether they do not up to the bound, and the limit in the way.

        Where another parameter stands at a limit and would lower the cost beyond it, the limit objects, not the data.
        """
        self.blocked = (0.0, "")
        value, unset = self._end(side)
        rise, limit = self.blocked
        if unset or rise < NEAR * self.threshold:
            return value, unset, ""
        return value, True, limit

    def _end(self, side: int) -> tuple[float, bool]:
        threshold = self.threshold
        bound = (self.prediction.space.low, self.prediction.space.high)[side > 0][self.j]
        room = abs(bound - self.u[self.j])
        if room < 1e-9:
            return self._value(bound), True
        step = min(threshold * self.sigma, LONGEST, room)
        self.slopes = self.first_slopes
        inside, outside = (0.0, 0.0), None
        where = self.u
        for _ in range(TRIALS):
            rise, where_now = self._rise(side * step, where)
            if abs(rise - threshold) <= CLOSE * threshold:
                inside = (step, rise)
                break
            if rise < threshold:
                inside, where = (step, rise), where_now
                if step >= room * (1 - 1e-9):
                    return self._value(bound), True
            else:
                outside = (step, rise)
            if outside is None:
                step = min(step * min(max(threshold / max(rise, 1e-9), 1.1), 6.0), room)
            else:
                share = (threshold - inside[1]) / (outside[1] - inside[1])
                step = inside[0] + (outside[0] - inside[0]) * min(max(share, 0.1), 0.9)
        reached = abs(inside[1] - threshold) <= CLOSE * threshold
        return self._value(self.u[self.j] + side * (inside[0] if reached else step)), outside is None and not reached

    def _rise(self, change: float, start: np.ndarray) -> tuple[float, np.ndarray]:
        u = start + self.direction * (self.u[self.j] + change - start[self.j])
        u = np.clip(np.where(np.abs(u - start) > 3.0, start, u), self.prediction.space.low, self.prediction.space.high)
        u[self.j] = self.u[self.j] + change
        until = {"held": self.j, "evaluations": REFIT, "stop": self.stop}
        minimum = warm_descent(self.prediction, u, self.slopes, self.loss, **until)
        self.slopes = minimum.slopes
        deviance = 2.0 * (minimum.cost - self.least) / self.spread.unit
        if deviance < -0.02 * self.threshold**2:
            raise BetterFound(self.prediction.space.named(minimum.u))
        rise = math.sqrt(max(deviance, 0.0))
        limit = self._pressed_limit(minimum.errors, minimum.slopes, minimum.u)
        if limit and rise > self.blocked[0]:
            self.blocked = (rise, limit)
        self.curve.append((self._value(u[self.j]), rise))
        return rise, minimum.u

    def _pressed_limit(self, errors: np.ndarray, slopes: np.ndarray, u: np.ndarray) -> str:
        """A limit, of the search or given, beyond which another parameter would lower the cost, more than at the best.

        By a good part of what ends the interval: then the limit objects to the value, not the data.
        """
        for k, gain in self._gains(errors, slopes, u).items():
            if gain - self.first_gains.get(k, 0.0) > PRESSED * self.spread.unit * self.threshold**2:
                coordinate = self.prediction.space.coordinates[k]
                return f"{coordinate.name} comes to a limit {WHOSE[coordinate.whose_limit(coordinate.at_limit(u[k]))]}"
        return ""

    def _gains(self, errors: np.ndarray, slopes: np.ndarray, u: np.ndarray) -> dict[int, float]:
        """By how much twice the cost would fall beyond each limit at which another parameter of the law stands."""
        gains = {}
        for k, coordinate in enumerate(self.prediction.space.coordinates):
            at = coordinate.at_limit(u[k]) if k != self.j and not coordinate.nuisance else 0
            if at and coordinate.whose_limit(at) != "law":
                column = self.loss.slope(errors) * slopes[:, k]
                pull, bend = -at * float(column @ errors), float(column @ slopes[:, k])
                gains[k] = max(pull, 0.0) ** 2 / max(bend, 1e-300)
        return gains

    def _value(self, u: float) -> float:
        place = self.u.copy()
        place[self.j] = u
        return float(self.prediction.space.values(place)[self.j])


def with_intervals(problem: Problem, report: Callable[[float], Any]) -> tuple[Problem, Profiles | None]:
    """The problem and the profiles of the law's parameters; None where they end at no minimum.

    A lower minimum that a profile comes upon takes the place of the first, and the profiles begin again.
    """
    for _ in range(AGAIN):
        try:
            return problem, _draft_profiles(problem, report) or profile_intervals(problem, report)
        except BetterFound as better:
            start = problem.prediction.space.of(better.args[0])
            problem = problem.at(descent(problem.prediction, start, problem.loss, evaluations=100, stop=1e-10))
    return problem, None


def _draft_profiles(problem: Problem, report: Callable[[float], Any]) -> Profiles | None:
    """Profiles on thinned samples; None where these do not say the same as all.

    The cost's rise per sample is the same on both as long as the change of the force is seen by the thinned samples as
    well. So they serve where the standard errors that follow from the slopes agree within ALIKE, and the minimum is off
    by no more than half of a standard error. The intervals are moved to the minimum on all samples.
    """
    prediction, draft, best, spread = problem.prediction, problem.draft, problem.best, problem.uncertainty
    if prediction.size < WORTH * draft.size:
        return None
    low = descent(draft, best.u, problem.loss, evaluations=60, stop=1e-8)
    share = draft.size / prediction.size
    space, law = prediction.space, [prediction.space.names.index(name) for name in prediction.law_names]
    full, thin = _errors(prediction, best), _errors(draft, low) * np.sqrt(share)
    values, thin_values = space.values(best.u), space.values(low.u)
    error = np.sqrt(np.diag(spread.covariance))
    alike = (np.abs(np.log(thin / full)) < ALIKE) & (np.abs(thin_values - values) < 0.5 * error)
    unseen = (error > values) & (np.sqrt(spread.inflation * spread.unit) * thin > thin_values)
    if not (alike | unseen)[law].all():
        return None
    scaled = dataclasses.replace(spread, unit=spread.unit * share)
    thinned = dataclasses.replace(problem, prediction=draft, best=low, uncertainty=scaled)
    profiles = profile_intervals(thinned, report)
    for name, j in zip(prediction.law_names, law, strict=True):
        if alike[j] and thin_values[j] > 0 and values[j] > 0:
            profiles[name] = profiles[name].times(values[j] / thin_values[j])
    return profiles


def _errors(prediction: Prediction, best: Minimum) -> np.ndarray:
    """Standard errors of the parameters, for errors of size 1 that are independent."""
    to_parameters = prediction.space.slopes(best.u)
    return np.sqrt(np.diag(to_parameters @ inverse(best.slopes.T @ best.slopes) @ to_parameters.T))


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
        cost = float(alone[j] ** 2 * information[j, j])  # twice that of keeping the limit
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
            up = limit.side == "high" if name == limit.parameter else follows * outward > 0
            side = {"high": math.inf, "high_open": True} if up else {"low": coordinates[name].least, "low_open": True}
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
