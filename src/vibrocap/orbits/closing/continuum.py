"""Whether a closed orbit is one of a continuum, which no start and no simulation singles out."""

import numpy as np

from vibrocap.orbits.closing.periodic_solution import CLOSE_TO_CIRCLE, OrbitStatus, PeriodicSolution, state_vector
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap

PUSH = 1e-3  # in natural sizes
CLOSED = 1e3  # tolerances, to which a neighbour closes that is steady too


def in_continuum(map_: StroboscopicMap, found: PeriodicSolution) -> bool:
    """Whether a state a little way off along a multiplier of 1 closes as well, on at least one side.

    So it is of a two-phase crawler whose phases are equally long: friction takes in one what it gives in the other,
    whatever the velocity, and each velocity has a drift of its own. At a fold, where a multiplier passes 1, the
    neighbours do not close.
    """
    if found.status is not OrbitStatus.CONVERGED or np.all(np.abs(found.multipliers - 1.0) > CLOSE_TO_CIRCLE):
        return False
    moving, state = map_.smooth_states, state_vector(found.system, found.state)
    row = map_.parameters()
    sizes = map_.scales(row)
    slope = found.derivative[np.ix_(moving, moving)] * sizes[moving] / sizes[moving, None]
    values, vectors = np.linalg.eig(slope)
    along = np.real(vectors[:, int(np.argmin(np.abs(values - 1.0)))])
    push = np.zeros(len(state))
    push[moving] = PUSH * sizes[moving] * along / np.max(np.abs(along))
    starts = state + np.stack([push, -push])
    images = map_.images(starts, np.tile(row, (2, 1)), found.response_period)
    away = np.max(np.abs((images.state - starts)[:, moving]) / sizes[moving], axis=1)
    return bool(np.any(images.finished & (away <= CLOSED * found.tolerance)))
