"""Starts at any phase of the drive: the first part of a period, up to the next section."""

import numpy as np

from vibrocap.numerics.api import Budget, codes
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap

TOLERANCE = 1e-9


def at_next_section(
    map_: StroboscopicMap, states: np.ndarray, parameters: np.ndarray, phase: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(states at the next start of a drive period [runs, states], how each run ended: numbers of `codes`).

    phase: [runs] where in the drive's period each run starts, as a share of it (whole parts do not matter); a run that
        starts at the section is there already
    """
    share = phase - np.floor(phase)
    waiting = np.flatnonzero(share)
    ends, ended = states.copy(), np.full(len(states), codes.DONE)
    if not len(waiting):
        return ends, ended
    period = np.array([map_.period(row) for row in np.unique(parameters, axis=0)])
    length = period[0] if len(period) == 1 else np.array([map_.period(row) for row in parameters[waiting]])
    found = map_.run(
        Budget(1, 1, 0.0, TOLERANCE, MOST_EVENTS, MOST_STEPS),
        states[waiting],
        parameters[waiting],
        start=share[waiting] * length,
    )
    ends[waiting], ended[waiting] = found.state, found.status
    return ends, ended
