"""The motion that comes nearest to what was measured, over growing stretches or in segments; and how far its parameters
may go before the squares contradict.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vibrocap.design.calibration.calibration import CalibratedParameter
from vibrocap.design.calibration.course import segments
from vibrocap.design.calibration.record_model import RecordModel
from vibrocap.design.calibration.table_model import soft
from vibrocap.design.search.uncertainty import sample_points
from vibrocap.identification.inference.identifiability import Verdict, verdict_within
from vibrocap.identification.inference.uncertainty import Uncertainty
from vibrocap.identification.problem import priors as known_before
from vibrocap.identification.problem.priors import SAYS_MORE, Prior

HORIZONS = ((0.125, 6, 15), (0.25, 4, 15), (0.5, 3, 15), (1.0, 2, 60))  # share of the records, candidates, evaluations
WEIGHTS = ((0.3, 4, 10), (10.0, 2, 10), (1e3, 1, 20), (1e5, 1, 40))  # weight of the gaps, candidates, evaluations
ROUNDS = 4  # of the search at most, each from points of its own, until two agree
SCANNED = 33  # points over the range of a parameter
PASSES = 8  # scans from minimum to minimum, at most
AGREE = 1e-3  # relative difference of the costs of rounds that end in the same minimum
FEWEST = 64  # samples of the shortest record within a horizon
SENSITIVE = 1e3  # growth of a change of the start from which on neighbouring parameters have minima of their own
SHORTEST, MOST_SEGMENTS, PER_SEGMENT = 12, 64, 3.0  # samples of a segment, segments of a record, growth in one
LOOKED, PARTS = 2, 16  # points at which the growth along the records is looked at, and parts of a record there


def sensitive_segments(model: RecordModel, seed: int) -> int:
    """Segments of each record, within which changes of a start stay of one size; 1 where they do in whole records.

    What grows along the measured motion: at wrong parameters a motion of its own would be another one.
    """
    shortest = min(len(course.measured) for course in model.courses)
    most = min(shortest // SHORTEST, MOST_SEGMENTS)
    if model.system.switched or most < 2:
        return 1
    fine = in_segments(model, min(most, PARTS))
    counts, growths = fine.counts(1.0), []
    for shares in sample_points(model.many, LOOKED, seed):
        point = fine.carried(np.concatenate((shares, np.zeros(fine.coordinates - model.many))))
        growths.append(fine.growth(fine.slopes(point, counts, {*range(model.many, fine.coordinates)}), counts))
    growth = float(np.median(growths))
    return 1 if growth <= SENSITIVE else min(most, math.ceil(math.log(growth) / math.log(PER_SEGMENT)))


def in_segments(model: RecordModel, count: int) -> RecordModel:
    """The model with each record in so many segments."""
    parts = [part for course in model.courses for part in segments(course, model.predict, count)]
    return RecordModel(model.predict, model.unknowns, parts, model.tolerance, model.threads)


def searched(model: RecordModel, starts: int, seed: int, report: Any) -> tuple[np.ndarray, bool]:
    """(best point, whether the search has settled, as two rounds end alike)."""
    counts, best, again = model.counts(1.0), (math.inf, np.zeros(0), False), False
    for k in range(ROUNDS):
        point, settled = _round(model, starts, seed + k, report and (lambda share, k=k: report((k + share) / ROUNDS)))
        cost, point = _beyond_kinks(model, point, counts)
        again = abs(cost - best[0]) <= _alike(model, cost, counts)
        best = min(best, (cost, point, settled), key=lambda minimum: minimum[0])
        if again:
            break
    return best[1], again and best[2]


def _round(model: RecordModel, starts: int, seed: int, report: Any) -> tuple[np.ndarray, bool]:
    """(best point, whether the search has settled), over longer and longer stretches of the records.

    In segments, the stretches are whole, and what grows is the weight of the gaps between them.
    """
    points = np.zeros((starts, model.coordinates))
    points[:, : model.many] = sample_points(model.many, starts, seed)
    if model.divided:
        points = np.array([model.carried(point) for point in points])
    shortest = min(len(course.measured) for course in model.courses)
    stages, settled = WEIGHTS if model.divided else HORIZONS, False
    for k, (stage, kept, most) in enumerate(stages):
        if model.divided:
            model.weight = stage
        elif stage * shortest < FEWEST and stage < 1.0:
            continue
        counts = model.counts(1.0 if model.divided else stage)
        costs = [float(np.sum(soft(model.residuals(point, counts)))) for point in points]
        ends = [model.refined(points[i], counts, most) for i in np.argsort(costs, kind="stable")[:kept]]
        ends.sort(key=lambda end: end.cost)
        points, settled = np.array([end.x for end in ends]), ends[0].status > 0
        if report:
            report((k + 1) / len(stages))
    return points[0], settled


def _beyond_kinks(model: RecordModel, point: np.ndarray, counts: Sequence[int]) -> tuple[float, np.ndarray]:
    """(sum of squares, point) of the least minimum that is seen along single parameters.

    Where a level of friction decides how often a contact sticks, the squares have a minimum for each number of times.
    Segments do not join where one parameter moves alone.
    """
    least = model.squares(point, counts)
    for _ in range(0 if model.divided else PASSES):
        points = np.tile(point, (model.many, SCANNED, 1))
        for k in range(model.many):
            points[k, :, k] = np.linspace(0.0, 1.0, SCANNED)
        points = points.reshape(-1, len(point))
        squares = [model.squares(row, counts) for row in points]
        if np.min(squares) >= least - _alike(model, least, counts):
            break
        end = model.refined(points[np.argmin(squares)], counts, HORIZONS[-1][-1])
        least, point = 2.0 * float(end.cost), end.x
    return least, point


def with_priors(model: RecordModel, point: np.ndarray, priors: Sequence[Prior]) -> np.ndarray:
    """The minimum with priors, from that without; the model is given them, with their weights."""
    counts, model.priors = model.counts(1.0), tuple(priors)
    for k in range(known_before.WEIGHTINGS if priors else 0):
        before, to_values = model.priors, model.to_values(point)
        spread = model.spread(model.residuals(point, counts), model.slopes(point, counts))
        if k == 0:
            covariance = to_values @ spread.covariance @ to_values.T
            model.priors = known_before.pulled(priors, model.names, model.values(point), covariance)
        model.priors = known_before.weighted(model.priors, model.names, spread.unit, spread.inflation)
        if known_before.settled(before, model.priors):
            break
        point = model.refined(_beyond_kinks(model, point, counts)[1], counts, 60).x
    return point


def _alike(model: RecordModel, cost: float, counts: Sequence[int]) -> float:
    """By how much squares differ where they are alike: a share of them, or what runs are exact to."""
    return max(AGREE * cost, sum(counts) * model.tolerance**2)


HALVINGS, FINEST = 6, 30  # to where the squares object to a value of a parameter; to where a part accepts another
LEAST = 1e-9  # share of a range: the first step from a value
FAINT = 1e-9  # change of every error per share, below which a parameter does nothing


def parameter_within(
    model: RecordModel, k: int, point: np.ndarray, slopes: np.ndarray, spread: Uncertainty, doubt: Verdict | None
) -> tuple[CalibratedParameter, list[np.ndarray]]:
    """A parameter with what its records say of it, and points at the ends of its interval, where they are as likely.

    It is sought where the others follow the parameter as they are correlated, and where they stay:
    where a level of friction decides whether a contact sticks, slopes tell nothing of what lies beyond.
    """
    path, unknown = model.names[k], model.ranges[k]
    value = float(model.values(point)[k])
    if doubt is Verdict.UNTRUSTED:
        return CalibratedParameter(path, value, math.nan, math.nan, math.nan, doubt), []
    limit = model.squares(point, model.counts(1.0)) + spread.unit * spread.threshold[k] ** 2
    error = math.sqrt(spread.covariance[k, k])
    alone = np.eye(len(point))[k]
    acting = np.any(np.abs(slopes) > FAINT, axis=0)
    joint = np.where(acting, spread.covariance[:, k] / spread.covariance[k, k], alone)
    half = error * float(spread.threshold[k] / math.sqrt(spread.inflation[k])) if acting[k] else 0.0
    reached: list[float] = []
    likely: list[np.ndarray] = []
    for sign in (-1.0, 1.0):
        linear = float(np.clip(point[k] + sign * half, 0.0, 1.0))
        refused = model.refuses(np.where(alone > 0.0, linear, point))
        ends = [_reach(model, k, point, sign * along, error, limit) for along in (alone, joint)]
        likely += [end for _, end in ends]
        shares = [float(point[k]) + sign * reach for reach, _ in ends]
        reached.append((min if sign < 0.0 else max)([*shares, *([] if refused else [linear])]))
    low, high = reached
    least, most = map(float, unknown.at(np.array([low, high])))
    of_prior = spread.known[k] > SAYS_MORE and any(prior.name == path for prior in model.priors)
    whole = doubt or (Verdict.PRIOR if of_prior else None)
    verdict = verdict_within(least, most, low <= 0.0, high >= 1.0, whole) if acting[k] else Verdict.NO_EFFECT
    error *= unknown.slope(float(point[k]))
    return CalibratedParameter(path, value, least, most, error, verdict), likely


def _accepted(model: RecordModel, k: int, point: np.ndarray) -> Iterator[np.ndarray]:
    """The point; where a part refuses it, those at which another unknown gives way to parameter k, the nearest first.

    A static level gives way to a Coulomb level that rises above it.
    """
    if not model.refuses(point):
        yield point
        return
    for i in (i for i in range(model.many) if i != k):
        line = np.tile(point, (SCANNED, 1))
        line[:, i] = np.linspace(0.0, 1.0, SCANNED)
        accepted = sorted((tried for tried in line if not model.refuses(tried)), key=lambda x: abs(x[i] - point[i]))
        if accepted:
            inside, outside = accepted[0].copy(), point.copy()
            for _ in range(FINEST):
                middle = 0.5 * (inside + outside)
                inside, outside = (inside, middle) if model.refuses(middle) else (middle, outside)
            yield from (inside, *accepted[::4])


def _reach(
    model: RecordModel, k: int, point: np.ndarray, along: np.ndarray, begin: float, limit: float
) -> tuple[float, np.ndarray]:
    """How far parameter k may go along a direction, in shares of its range, before the squares exceed a limit.

    And a point there at which they do not.
    """
    counts, (low, high) = model.counts(1.0), model.bounds
    room = (1.0 - point[k]) if along[k] > 0.0 else point[k]

    def allowed(change: float) -> np.ndarray | None:
        moved = np.clip(point + change * along, low, high)
        return next((tried for tried in _accepted(model, k, moved) if model.squares(tried, counts) <= limit), None)

    inside, end, step = 0.0, point, min(max(begin, LEAST), room)
    while (further := allowed(step)) is not None:
        end = further
        if step >= room:
            return room, end
        inside, step = step, min(2.0 * step, room)
    outside = step
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        further = allowed(middle)
        inside, outside, end = (inside, middle, end) if further is None else (middle, outside, further)
    return outside, end
