"""Differences of the stroboscopic map: what runs beside a state say of its derivative, and what contradicts them."""

import numpy as np

from vibrocap.numerics.api import Budget
from vibrocap.orbits.maps.stroboscopic_map import AGREE, MOST_EVENTS, MOST_STEPS, ORDER, PUSHES, Images, StroboscopicMap
from vibrocap.orbits.maps.variations import variational_equations

CONTRADICTS = 10.0 * AGREE  # of a derivative, or of one where it is smaller
BACKWARDS = -1e-6  # a slope that no rounding makes of one that is not negative


def keeps_order(map_: StroboscopicMap) -> bool:
    """Whether motions cannot pass one another: there is one smooth state, which no event of the machine makes jump.

    So it is of the common centre of bodies whose relative motion is imposed, under laws without memory. Two solutions
    of one scalar equation merge or stay apart, so that no derivative of the map is negative.
    """
    return len(map_.smooth_states) == 1 and not map_.system.machine.switched


def slopes_along(
    map_: StroboscopicMap,
    states: np.ndarray,
    directions: np.ndarray,
    images: np.ndarray,
    parameters: np.ndarray,
    periods: int = 1,
    mark_distance: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """(derivatives [runs, states] along directions, over natural sizes; whether the map has one there [runs]).

    states, directions, images: [runs, states]; parameters: [runs, parameters]
    It has none, as far as differences tell, where those ahead and behind, of a larger and of a smaller push, do not
    agree: where a motion grazes, or its sequence of events changes. On the kernel of the tangents, which is compiled,
    unless the equations are too stiff for it.
    """
    runs, n = states.shape
    steps = np.array([sign * push for push in PUSHES for sign in (1.0, -1.0)])
    starts = np.zeros((len(steps), runs, 2 * n))
    starts[:, :, :n] = states + steps[:, None, None] * directions
    rows = np.tile(parameters, (len(steps), 1))
    distance = None if mark_distance is None else np.tile(mark_distance, len(steps))
    budget = Budget(periods, map_.tolerance, MOST_EVENTS, MOST_STEPS, window=1)
    recording, width = (map_.equations, n) if map_.stiff else (variational_equations(map_.equations), 2 * n)
    starts = starts[:, :, :width].reshape(-1, width)
    ended = map_.run(budget, starts, rows, recording=recording, order=ORDER, mark_distance=distance)
    ends = ended.state.reshape(len(steps), runs, width)[:, :, :n]
    sizes = map_.scales(parameters)
    slopes = (ends - images) / steps[:, None, None] / sizes
    mean = slopes.mean(axis=0)
    apart = np.max(np.abs(slopes - mean), axis=(0, 2))
    finished = np.all(ended.finished.reshape(len(steps), runs), axis=0)
    return mean, finished & (apart <= AGREE * np.maximum(1.0, np.max(np.abs(mean), axis=1)))


def contradicted(
    map_: StroboscopicMap,
    state: np.ndarray,
    images: Images,
    parameters: np.ndarray,
    periods: int = 1,
    mark_distance: np.ndarray | None = None,
) -> bool:
    """Whether the derivative at a state [states] is not that of the map: four runs beside it tell, in one direction.

    images: of the state, with its derivative. A direction in which all free states take part finds whatever is wrong,
    but for a set of errors of measure zero. Where the map keeps the order of motions, a negative slope contradicts it.
    """
    assert images.jacobian is not None
    sizes, free = map_.scales(parameters), map_.free(state[None], parameters[None])[0]
    direction = np.zeros(map_.states)
    moving = map_.smooth_states[free[map_.smooth_states]]
    direction[moving] = sizes[moving] * np.cos(1.0 + np.arange(len(moving)))
    slope = images.jacobian[0] @ direction / sizes
    if keeps_order(map_) and slope[map_.smooth_states[0]] * direction[map_.smooth_states[0]] < BACKWARDS:
        return True
    at = state[None], direction[None], images.state, parameters[None]
    slopes, sure = slopes_along(map_, *at, periods, mark_distance)
    return bool(sure[0]) and differ(slope, slopes[0])


def differ(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two derivatives along a direction are not the same."""
    size = max(1.0, float(np.max(np.abs(one))), float(np.max(np.abs(other))))
    return float(np.max(np.abs(one - other))) > CONTRADICTS * size
