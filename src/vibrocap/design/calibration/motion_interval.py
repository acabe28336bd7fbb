"""Intervals of parameters of a motion, by how far each may go before the squares contradict."""

import math
from collections.abc import Iterator

import numpy as np

from vibrocap.design.calibration.calibration import CalibratedParameter
from vibrocap.design.calibration.motion_search import SCANNED
from vibrocap.design.calibration.record_model import RecordModel
from vibrocap.identification.inference.identifiability import Verdict, verdict_within
from vibrocap.identification.inference.uncertainty import Uncertainty
from vibrocap.identification.problem.priors import SAYS_MORE

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
        refused = _refused(model, np.where(alone > 0.0, linear, point))
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


def _refused(model: RecordModel, point: np.ndarray) -> bool:
    return model.refuses(point, (model.pieces(name)[0] for name in model.records))


def _accepted(model: RecordModel, k: int, point: np.ndarray) -> Iterator[np.ndarray]:
    """The point; where a part refuses it, those at which another unknown gives way to parameter k, the nearest first.

    A static level gives way to a Coulomb level that rises above it.
    """
    if not _refused(model, point):
        yield point
        return
    for i in (i for i in range(model.many) if i != k):
        line = np.tile(point, (SCANNED, 1))
        line[:, i] = np.linspace(0.0, 1.0, SCANNED)
        accepted = sorted((tried for tried in line if not _refused(model, tried)), key=lambda x: abs(x[i] - point[i]))
        if accepted:
            inside, outside = accepted[0].copy(), point.copy()
            for _ in range(FINEST):
                middle = 0.5 * (inside + outside)
                inside, outside = (inside, middle) if _refused(model, middle) else (middle, outside)
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
