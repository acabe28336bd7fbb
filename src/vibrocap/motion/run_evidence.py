"""Whether the runs of an ensemble are motions of the equations, by the evidence that was taken while they ran."""

import numpy as np

from vibrocap.motion.evidence import EVENT_BOUND, LEAST_TOLERANCE, ROUNDING, STICK_SLACK, changes, velocity_names
from vibrocap.numerics.api import DEFECT_BOUND, RunResults
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import derivative, evaluated


def certified(recording: Equations, results: RunResults, parameters: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether what was seen of each run is within the bounds of a certificate: array [runs] of bool.

    The velocity at located events is that of the whole run. The share of its limit that a hold takes, the sign of the
    velocity and the defect are those at some points of its last response (`kernel/observe/evidence.py`), so that a
    certificate, which asks everywhere, may refuse a motion that passes here. Works: `measures/gathered.py`.

    parameters: [runs, parameters]
    """
    count = len(results)
    tolerance = max(tolerance, LEAST_TOLERANCE)
    states = results.start[:, : recording.base].T
    values = recording.filled(parameters).T
    with np.errstate(all="ignore"):  # of runs that failed
        scales, speeds = evaluated(recording.scales, 0.0, states, 1.0, values, (count,)), np.zeros(count)
        for name in velocity_names(recording):
            speeds = np.maximum(speeds, changes(recording, (name,), scales, 0.0, states, values).sum(axis=0))
    slowest = EVENT_BOUND * tolerance * speeds
    good = results.head("contact_residual") <= slowest
    rounding = ROUNDING * np.maximum(1.0, speeds)
    imposed = recording.several or any(derivative(contact.velocity, -1).value != 0.0 for contact in recording.contacts)
    good &= -results.entry("LEAST_VELOCITY") <= (np.maximum(slowest, rounding) if imposed else rounding)
    good &= results.entry("STICKING_SHARE") <= 1.0 + STICK_SLACK
    return good & (results.entry("DEFECT") <= DEFECT_BOUND * tolerance)
