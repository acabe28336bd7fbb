"""How far an orbit is from a branch: zero, to rounding, for one that lies on it."""

import numpy as np

from vibrocap.motion.recording.section import whole_turns
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.walk.branch_point import corrected

ROUGHLY = 0.05  # distance from the chords of a branch beyond which it need not be known exactly


def branch_distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of an orbit from a branch of its period, in natural sizes and shares of the range; the least over twins.

    state: of the orbit at the section, [states]. Infinite where the branch does not come near.
    """
    return min(_distance(branch, start, parameter) for start in _starts(branch, state, parameter))


def _starts(branch: Branch, state: np.ndarray, parameter: float) -> list[np.ndarray]:
    """States of an orbit at the sections of its response, and of its mirror twin."""
    closure = branch.closing_map
    row = closure.row.copy()
    row[closure.index] = parameter
    here, starts = state.copy(), []
    for _ in range(branch.response_period):
        starts.append(here)
        here = closure.map.images(here[None], row[None], tangents=False).state[0]
    if closure.mirrored and not closure.half:
        starts += [closure.map.mirrored_half(start[None], row[None], tangents=False).state[0] for start in starts]
    return starts


def _distance(branch: Branch, state: np.ndarray, parameter: float) -> float:
    """Distance of a point from a branch: from its chords first, then from the branch across the nearest of them."""
    closure = branch.closing_map
    x = closure.point(state, parameter)
    corners = np.stack([closure.point(*point) for point in zip(branch.states, branch.parameter, strict=True)])
    ways = np.diff(corners, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    apart = np.flatnonzero(lengths > 0.0)  # where a branch comes to a bifurcation it may have a point twice
    if not len(apart):
        return float("inf")
    turned = np.zeros_like(corners)  # whole turns, so that each chord begins as near as can be
    unknown = closure.unknowns
    turned[:, : len(unknown)] = whole_turns(branch.system, branch.states - state)[:, unknown] / closure.sizes[unknown]
    starts, ways, lengths = (corners - turned)[apart], ways[apart], lengths[apart]
    shares = np.clip(np.sum((x - starts) * ways, axis=1) / lengths**2, 0.0, 1.0)
    feet = starts + shares[:, None] * ways
    off = np.linalg.norm(feet - x, axis=1)
    i = int(np.argmin(off))
    if off[i] > ROUGHLY:
        return float("inf")
    normal = ways[i] / lengths[i]
    foot, _ = corrected(closure, feet[i], normal, float(normal @ feet[i]))
    return float(off[i]) if foot is None else float(np.linalg.norm(foot.x - x))
