"""Timing: force and motion that are not of one instant."""

from collections.abc import Sequence

import numpy as np

from vibrocap.identification.inference.diagnosis.errors import RecordErrors
from vibrocap.identification.inference.diagnosis.pattern_test import Pattern, without

FARTHEST = 20  # samples, by one
FURTHER = 1.5  # times as far each, up to
LONGEST = 0.02  # of a record
LOOKS, POINTS = 3, 9  # looks about the best delay, ever closer, and delays that each tries


def shift(records: Sequence[RecordErrors], error: np.ndarray, absorbed: np.ndarray) -> tuple[float, Pattern]:
    """(delay s of the force behind the motion that leaves the least error, what it adds to the force).

    The predicted force of a moment before, R(t - d) - R(t), is taken off the error for d of -20 to 20 samples and, by
    factors, up to 2 % of the record; what the fit could absorb is taken off both. Between samples R is linear: it has
    no noise that this would smooth. The error itself is not moved, so that white noise stays what it is.
    """
    interval = float(np.median(np.concatenate([np.diff(each.time) for each in records])))
    reach = max(FARTHEST, LONGEST * min(len(each.time) for each in records))
    steps = [0.25, 0.5, *range(1, FARTHEST + 1)]
    while steps[-1] * FURTHER < reach:
        steps.append(steps[-1] * FURTHER)
    tried = np.array([*[-each for each in reversed(steps)], 0.0, *steps])

    def left(samples: float) -> float:
        rest = error - without(late(records, samples * interval), absorbed)
        return float(rest @ rest)

    best = tried[int(np.argmin([left(each) for each in tried]))]
    beside = np.diff(tried)[np.clip(np.searchsorted(tried, best), 0, len(tried) - 2)]
    for _ in range(LOOKS):
        near = best + beside * np.linspace(-1, 1, POINTS)
        best = near[int(np.argmin([left(each) for each in near]))]
        beside *= 2.0 / (POINTS - 1)
    delay = float(best) * interval
    columns = late(records, delay if delay else 1e-3 * interval)[:, None]
    return delay, Pattern(columns, tries=float(len(tried)), sparse=True)


def about(records: Sequence[RecordErrors], delay: float) -> np.ndarray:
    """Columns [n, 3] of a delay that is known to about a part of a sample: its own, a sample more and a sample less."""
    interval = float(np.median(np.diff(records[0].time)))
    own, *others = (late(records, delay + each * interval) for each in (0.0, -1.0, 1.0))
    return np.stack([own, *(each - own for each in others)], axis=1)


def late(records: Sequence[RecordErrors], delay: float) -> np.ndarray:
    """What a delay adds to the measured force, over the units, of the samples that count."""
    added = [(_before(each, delay) - each.predicted[each.counts]) / each.unit for each in records]
    return np.concatenate(added)


def _before(record: RecordErrors, delay: float) -> np.ndarray:
    """The force predicted for a moment before: linear between samples, but where the motion turns it may jump.

    There it is that of the sample on the same side of the instant at which the velocity, linear between samples, is 0.
    """
    time, velocity, force = record.time, record.velocity, record.predicted
    moment = np.clip(time[record.counts] - delay, time[0], time[-1])
    found = np.interp(moment, time, force)
    i = np.clip(np.searchsorted(time, moment, side="right") - 1, 0, len(time) - 2)
    turns = velocity[i] * velocity[i + 1] < 0
    i, moment = i[turns], moment[turns]
    crossing = time[i] + (time[i + 1] - time[i]) * velocity[i] / (velocity[i] - velocity[i + 1])
    found[turns] = np.where(moment < crossing, force[i], force[i + 1])
    return found
