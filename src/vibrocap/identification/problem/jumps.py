"""Jumps of the predicted force: samples beside the instants at which a joint with play closes on a moving contact.

Whether such a sample lies before or after the jump hangs on a parameter by steps, not smoothly: one sample on the wrong
side costs more than all the noise. The cost then has cliffs, on which a descent and a profile get stuck, and slopes and
covariance mean nothing. So these samples take part in the search, which needs to know where the joint closes, and are
left out of the last descent and of the intervals: what remains tells of the gap by the contact's deflection after it
has closed, which is smooth. Intervals are then wider than they would have to be.
"""

from typing import Any

import numpy as np

from vibrocap.identification.problem.prediction import Prediction
from vibrocap.laboratory.driven import driven_force

BESIDE = 2  # samples on either side of a closing that are left out
FEWEST = 0.5  # share of the samples that must remain
JOINT = "engaged"


def away_from_jumps(prediction: Prediction, u: np.ndarray) -> Prediction:
    """The prediction in which samples beside a jump do not count; itself where the law has none.

    Samples count where they did; they stay if fewer than half would remain (a joint that closes all the time).
    """
    law = prediction.law(u)
    if JOINT not in law.internal:
        return prediction
    units: list[Any] = []
    left = total = 0
    for i, (record, unit) in enumerate(zip(prediction.records, prediction.units, strict=True)):
        driven = driven_force(
            law, record.time, record.velocity, load=record.load, internal=prediction.start(u, i),
            tolerance=prediction.tolerance,
        )  # fmt: skip
        closed = driven.internal[:, law.internal.index(JOINT)]
        beside = np.zeros(len(record), bool)
        for at in np.flatnonzero(closed[1:] != closed[:-1]) + 1:
            beside[max(at - BESIDE, 0) : at + BESIDE] = True
        units.append(np.where(beside, np.inf, unit))
        left, total = left + int(np.sum(~beside)), total + len(record)
    return prediction.of(prediction.records, units) if left >= FEWEST * total else prediction
