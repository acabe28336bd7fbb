"""How far an orbit is from a branch: whether it lies on it, begun at any of its periods, or its mirror twin does."""

import numpy as np

from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_point import corrected

ROUGHLY = 0.05  # distance from the chords of a branch beyond which it need not be known exactly


def branch_distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of an orbit from a branch of its period, in natural sizes and shares of the range; the least over twins.

    state: of the orbit at the section, [states]. Infinite where the branch does not come near.
    """
    return min(_distance(branch, each, parameter) for each in _starts(branch, state, parameter))


def _starts(branch: Branch, state: np.ndarray, parameter: float) -> list[np.ndarray]:
    """States of an orbit at the sections of its response, and of its mirror twin."""
    closure = branch.closing_map
    row = closure.row.copy()
    row[closure.index] = parameter
    here, found = state.copy(), []
    for _ in range(branch.response_period):
        found.append(here)
        here = closure.map.images(here[None], row[None], tangents=False).state[0]
    if closure.mirrored and not closure.half:
        found += [closure.map.mirrored_half(each[None], row[None], tangents=False).state[0] for each in found]
    return found


def _distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of a point from a branch: from its chords first, then from the branch across the nearest of them."""
    closure = branch.closing_map
    x = closure.point(state, parameter)
    corners = np.stack([closure.point(*each) for each in zip(branch.states, branch.parameter, strict=True)])
    ways = np.diff(corners, axis=0)
    lengths = np.maximum(np.linalg.norm(ways, axis=1), 1e-300)
    shares = np.clip(np.sum((x - corners[:-1]) * ways, axis=1) / lengths**2, 0.0, 1.0)
    feet = corners[:-1] + shares[:, None] * ways
    off = np.linalg.norm(feet - x, axis=1)
    i = int(np.argmin(off))
    if off[i] > ROUGHLY:
        return float("inf")
    normal = ways[i] / lengths[i]
    found, _ = corrected(closure, feet[i], normal, float(normal @ feet[i]))
    return float(off[i]) if found is None else float(np.linalg.norm(found.x - x))
