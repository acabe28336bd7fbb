"""The cells of an adaptive map: which are halved, which points that asks for, and how the rest is filled in.

A grid of two axes, kept as the levels of its points and masks of its cells; see `adaptive.py`.
"""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.studies.plan.runs import even_in_logarithm

Levels = list[tuple[np.ndarray, np.ndarray]]  # of both axes: indices of the points of each level


def levels_of(shape: tuple[int, int], steps: tuple[int, int]) -> Levels:
    """Points of each level; cells of one point's width are not halved, and those of odd width are unevenly."""
    axes = []
    for points, step in zip(shape, steps, strict=True):
        cells = -(-(points - 1) // step)
        axes.append([np.round(np.linspace(0, points - 1, cells + 1)).astype(np.intp)])
    while any(len(levels[-1]) < points for levels, points in zip(axes, shape, strict=True)):
        for levels in axes:
            levels.append(np.union1d(levels[-1], (levels[-1][1:] + levels[-1][:-1]) // 2))
    return list(zip(*axes, strict=True))


def _halved(codes: np.ndarray, computed: np.ndarray, levels: Levels, margin: int) -> list[np.ndarray]:
    """Which cells are halved, for each level but the last: bool [cells, cells].

    A halved cell lies in a halved one, for a cell around a mixed cell is mixed, and its neighbours hold theirs.
    """
    from scipy.ndimage import binary_dilation

    least = np.where(computed, codes, np.iinfo(codes.dtype).max)
    most = np.where(computed, codes, -1)
    least = np.minimum.reduce([least[1:, 1:], least[1:, :-1], least[:-1, 1:], least[:-1, :-1]])
    most = np.maximum.reduce([most[1:, 1:], most[1:, :-1], most[:-1, 1:], most[:-1, :-1]])
    halved = []
    for upper, lower in reversed(list(itertools.pairwise(levels))):
        for axis in (0, 1):
            first = np.searchsorted(lower[axis], upper[axis][:-1])
            least, most = np.minimum.reduceat(least, first, axis), np.maximum.reduceat(most, first, axis)
        mixed = least < most
        grows = halved and margin  # not at the last halving: runs on the rims follow the border there
        halved.append(binary_dilation(mixed, np.ones((2 * margin + 1,) * 2)) if grows else mixed)
    return halved[::-1]


def _children(cells: np.ndarray, upper: tuple, lower: tuple) -> np.ndarray:
    """What is known of the cells of a level, for the cells of the next."""
    return cells[np.ix_(*(np.searchsorted(upper[axis], lower[axis][:-1], "right") - 1 for axis in (0, 1)))]


def wanted(codes: np.ndarray, computed: np.ndarray, levels: Levels, margin: int) -> np.ndarray:
    """Points that are wanted by what is known: the coarse ones, and those of the next level in halved cells."""
    wanted = np.zeros(computed.shape, dtype=bool)
    wanted[np.ix_(*levels[0])] = True
    for halved, upper, lower in zip(_halved(codes, computed, levels, margin), levels[:-1], levels[1:], strict=True):
        cells = np.pad(_children(halved, upper, lower), 1)
        wanted[np.ix_(*lower)] |= cells[1:, 1:] | cells[1:, :-1] | cells[:-1, 1:] | cells[:-1, :-1]
    return wanted


def leaf_corners(codes: np.ndarray, computed: np.ndarray, levels: Levels, margin: int) -> np.ndarray:
    """Of each point that was not run, the cell around it that is not halved: ends along both axes [4, points]."""
    point = np.nonzero(~computed)
    corners = np.zeros((4, len(point[0])), dtype=np.intp)
    exist = np.ones((len(levels[0][0]) - 1, len(levels[0][1]) - 1), dtype=bool)
    for halved, upper, lower in zip(_halved(codes, computed, levels, margin), levels[:-1], levels[1:], strict=True):
        low = [np.minimum(np.searchsorted(u, p, "right"), len(u) - 1) - 1 for u, p in zip(upper, point, strict=True)]
        inside = (exist & ~halved)[low[0], low[1]]
        points = [upper[axis][low[axis] + far] for axis in (0, 1) for far in (0, 1)]
        corners[:, inside] = np.stack(points)[:, inside]
        exist = _children(halved, upper, lower)
    return corners


def filled(
    values: np.ndarray, order: np.ndarray, computed: np.ndarray, corners: np.ndarray, axes: Any, name: str = ""
) -> np.ndarray:
    """A variable on the full grid, from its values at the points that were run and the cells around the others."""
    full = np.empty(computed.size, dtype=values.dtype)
    full[order] = values
    full = full.reshape(computed.shape)
    (i, j), (i0, i1, j0, j1) = np.nonzero(~computed), corners
    if discrete(values, name):
        full[i, j] = full[np.where(2 * i <= i0 + i1, i0, i1), np.where(2 * j <= j0 + j1, j0, j1)]
        return full
    (x, _), (y, _) = (_scale(axis) for axis in axes)
    u, v = (x[i] - x[i0]) / (x[i1] - x[i0]), (y[j] - y[j0]) / (y[j1] - y[j0])
    with np.errstate(invalid="ignore"):  # a corner may be infinite or no number
        straight = full[i0, j0] * ((1 - u) * (1 - v)) + full[i1, j1] * (u * v)
        full[i, j] = straight + (full[i1, j0] * (u * (1 - v)) + full[i0, j1] * ((1 - u) * v))
    return full


# --- labels ----------------------------------------------------------------------------------------------------------
def _scale(values: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Positions along an axis as one draws it, logarithms where it is evenly spaced in these; and the way back."""
    return (np.log(values), np.exp) if even_in_logarithm(values) else (values, np.asarray)


def middles(values: np.ndarray) -> np.ndarray:
    """Middles between neighbouring values, on that scale."""
    positions, back = _scale(values)
    return back((positions[1:] + positions[:-1]) / 2)


COUNTS = ("impacts",)  # per period of a response of several: whole numbers over that


def discrete(values: np.ndarray, name: str = "") -> bool:
    """Whether values are words, flags, whole numbers, which may be held as floats, or by their name counts per period.

    NaN and infinity are values of their own.
    """
    if values.dtype.kind in "biuUT" or name in COUNTS:
        return True
    return bool(np.all((values == np.floor(values)) | np.isnan(values)))
