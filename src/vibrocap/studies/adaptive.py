"""Adaptive maps: a map over two parameters whose borders are as sharp as on its finest grid, at a share of the runs.

What a designer reads from a map are its borders: where the mode sequence, the direction of travel or the response
period changes. So the map starts on a coarse grid, and cells are halved only where labels differ.

The grid has levels, from the coarse points (level 0) to all points (the last); a cell lies between neighbouring points
of its level. A cell is mixed where any two runs in it or on its rim, whichever level asked for them, differ in a label.
A mixed cell, with those beside it (`margin`; at the last halving without), gets the points of the next level, until no
more are wanted. So no border is interpolated: two neighbouring points with different labels have both been run. And
borders are followed: runs on its rim make a cell mixed, so a border that is found in one place is found wherever it
goes. A run can only add to what is wanted: the set of runs is the smallest one closed under this rule, in any order.

Limit: a region that holds no point of the coarse grid, such as an island between its points, is not seen unless a
border leads to it; `coarse_steps` and `coarse_spacing` of the axes state that size.
"""

import dataclasses
import inspect
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaint, check_whole, listed, suggestion
from vibrocap.case.case import RUN_DEFAULTS, Case, CaseError
from vibrocap.measures.recorded.settling import usual_threshold
from vibrocap.motion.trust import FINISHED, ZERO, Trust
from vibrocap.progress import shows_progress, told
from vibrocap.studies.plan.planning import plan_complaints, with_load_watch
from vibrocap.studies.plan.runs import Column, Grid, axis_of, even_in_logarithm
from vibrocap.studies.plan.study import Study
from vibrocap.studies.plan.variation import plainly, residues, with_varied_parts

if TYPE_CHECKING:
    import xarray

    from vibrocap.studies.variables import Variable

Evaluator = Callable[[np.ndarray, np.ndarray], Mapping[str, Any]]

UNKNOWN = -128  # travel of a run that failed
TILE = 65_536  # runs per call of the evaluator
WAYS = {-1: "back", 0: "none", 1: "forward", UNKNOWN: "unknown"}
MEANINGS: dict[str, dict[str, Any]] = {
    "computed": {"long_name": "whether this point was run; if not, it is filled in"},
    "travel": {"long_name": "direction of travel", "flag_values": [*WAYS], "flag_meanings": " ".join(WAYS.values())},
}


@dataclasses.dataclass(frozen=True, eq=False)
class Border:
    """Where a variable of a map changes, in the units of the two axes.

    points: middles of the edges of the grid whose ends differ [edges, 2]
    segments: pieces of the border across these edges [edges, 2 ends, 2]; they join to lines
    computed: whether both ends of the edge were run [edges]
    """

    points: np.ndarray
    segments: np.ndarray
    computed: np.ndarray


@shows_progress("Mapping", counted=True)
def adaptive_map(
    system: Any,
    over: Mapping[str, Any],
    by: Sequence[str] = ("mode_sequence", "travel", "response_period"),
    *,
    measures: Sequence[str] = ("mean_velocity",),
    coarse: int | tuple[int, int] = 16,
    margin: int = 1,
    dead_band: float | None = None,
    refine_unsettled: bool = True,
    evaluate: Evaluator | None = None,
    tile: int = TILE,
    progress: bool | Callable[[int, int], None] | None = None,
    **settings: Any,
) -> "xarray.Dataset":
    """A map over two parameters, run on a coarse grid and, down to the finest spacing, where labels change.

    over: two axes by path ("machine.mass_ratio", "initial.angle"), each (low, high, points), text as `sweep` takes
        it ("low:high:points", "log:low:high:points"), or a list or array of increasing values
    by: labels whose changes are borders: discrete measures, and "travel", the sign of the mean velocity; the status of
        the runs always counts. Measures that they need are added to `measures`
    coarse: largest spacing of the coarse grid in steps of the finest, for both axes or (first, second)
    margin: cells on each side of a mixed one that are halved with it; 0: none
    dead_band: mean velocities, without units, up to this size are no travel (0, apart from -1 and 1), by default the
        residue of each run that settles (1e-6 of others); a run that failed has -128
    refine_unsettled: False: unsettled runs (response period 0) differ in their status alone; a chaotic motion changes
        its mode sequence from point to point, and would otherwise ask for all of them
    evaluate: function that runs the points, from two arrays [runs] to arrays [runs] by name. By default the ensemble,
        to which system, measures and settings go, by default those of `sweep`
    tile: runs per call of the evaluator, which has one call for each round of refinement that is no larger
    progress: True for a bar, or a function that is called after each call with the runs done and those wanted by now

    Returns a dataset on the full grid. `computed` marks runs; other values come from the corners of the cell around a
    point, where all labels agree: real measures by bilinear interpolation (in the logarithm of an axis evenly spaced
    in it), others, and those beside a corner that is not finite, from the nearest corner. Attributes: runs computed, of
    the full grid and their ratio, rounds, labels, and for the ensemble its settings and the case.
    Raises ValueError, naming the argument, before any work, and for an evaluator that returns something else.
    """
    import xarray

    from vibrocap.studies.variables import coordinate_attributes

    if system is not None and isinstance(over, Mapping):
        system, over = with_varied_parts(system, over), plainly(over, system)
    axes = _axes(system, over, evaluate)
    steps = coarse if isinstance(coarse, tuple) and len(coarse) == 2 else (coarse, coarse)
    _check(by, steps, margin, dead_band, refine_unsettled, tile)
    attributes: dict[str, Any] = {}
    measured: dict[str, Variable] = {}
    if evaluate is None:
        evaluate, attributes, measured = _ensemble(system, axes, by, measures, settings)
    elif settings:
        raise ValueError(f"{', '.join(settings)}: settings of the ensemble do not go with an evaluator of one's own")
    if dead_band is not None or not attributes.get("settle"):
        attributes["dead_band"] = ZERO if dead_band is None else float(dead_band)

    x, y = axes.values()
    levels = levels_of((len(x), len(y)), steps)
    computed, codes = np.zeros((len(x), len(y)), dtype=bool), np.zeros((len(x), len(y)), dtype=np.int64)
    places, blocks, rounds, known = [], [], 0, dict[tuple, int]()
    while (new := np.flatnonzero(wanted(codes, computed, levels, margin) & ~computed)).size:
        rounds, goal = rounds + 1, int(computed.sum()) + len(new)
        for start in range(0, len(new), tile):
            place = new[start : start + tile]
            i, j = np.unravel_index(place, computed.shape)
            if (band := attributes.get("dead_band")) is None:
                assert system is not None
                own = dict(zip(axes, (x[i], y[j]), strict=True))
                band = residues(system, own, len(place), "mean_velocity", attributes["settle"])
            results = _checked_results(evaluate(x[i], y[j]), len(place), by, band)
            if blocks and set(results) != set(blocks[0]):
                raise ValueError(f"evaluate returned {', '.join(results)}, and before that {', '.join(blocks[0])}")
            codes[i, j], computed[i, j] = _codes(results, by, refine_unsettled, known), True
            places.append(place)
            blocks.append(results)
            if (report := told(progress)) is not None:
                report(int(computed.sum()), goal)

    order, corners = np.concatenate(places), leaf_corners(codes, computed, levels, margin)
    runs = {name: np.concatenate([results[name] for results in blocks]) for name in blocks[0]}
    variables = {name: filled(values, order, computed, corners, (x, y), name) for name, values in runs.items()}
    variables = {name: measured[name].shown(x) if name in measured else x for name, x in variables.items()}
    variables["computed"] = computed
    meanings = {name: column.attributes for name, column in measured.items()} | MEANINGS
    for path, points in zip(axes, levels[0], strict=True):
        spacing = float(np.diff(axes[path][points]).max())
        sizes = {"coarse_steps": int(np.diff(points).max()), "coarse_spacing": spacing}
        meanings[path] = (coordinate_attributes(path, system) if system is not None else {}) | sizes
    return xarray.Dataset(
        {name: (tuple(axes), values, meanings.get(name, {})) for name, values in variables.items()},
        coords={path: (path, values, meanings[path]) for path, values in axes.items()},
        attrs=attributes
        | {
            "title": "Adaptive map",
            "labels": " ".join(_compared(by, runs)),
            "margin": int(margin),
            "refine_unsettled": str(refine_unsettled),
            "runs_computed": len(order),
            "runs_of_full_grid": computed.size,
            "share_computed": len(order) / computed.size,
            "rounds": rounds,
            "limit": "a region that holds no point of the coarse grid may be missing (coarse_spacing of the axes)",
        },
    )


def border(dataset: "xarray.Dataset", name: str) -> Border:
    """The border lines of a discrete variable of a map: where neighbouring points differ, at the finest spacing.

    Both ends of every such edge were run for the labels of the map. Middles are geometric along axes that are evenly
    spaced in their logarithm. Raises ValueError for a variable that is unknown or takes real values.
    """
    if name not in dataset.data_vars:
        raise ArgumentError("name", f"the map has no variable {name!r}; it has {listed(dataset.data_vars)}")
    paths = dataset["computed"].dims
    values, computed = dataset[name].transpose(*paths).values, dataset["computed"].values
    if not discrete(values, name):
        raise ArgumentError("name", f"{name} takes real values: no borders; choose a label or a discrete measure")
    codes = np.unique(values, return_inverse=True)[1].reshape(values.shape)
    parts = []
    for first in (0, 1):  # edges along the first axis, then along the second
        turned, ran = (codes, computed) if first == 0 else (codes.T, computed.T)
        along, across = (dataset[paths[axis]].values for axis in (first, 1 - first))
        i, j = np.nonzero(turned[1:] != turned[:-1])
        walls = np.concatenate((across[:1], middles(across), across[-1:]))
        three = [np.stack((middles(along)[i], at), axis=-1) for at in (across[j], walls[j], walls[j + 1])]
        point, start, end = three if first == 0 else (pair[:, ::-1] for pair in three)
        parts.append((point, np.stack((start, end), axis=1), ran[i, j] & ran[i + 1, j]))
    return Border(*(np.concatenate(both) for both in zip(*parts, strict=True)))


def _compared(by: Sequence[str], results: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*by, "status") if "status" in results else by))


def _checked_results(returned: Mapping[str, Any], runs: int, by: Sequence[str], band: Any) -> dict[str, np.ndarray]:
    """What the evaluator returned, as arrays, with the direction of travel where that is asked for."""
    results = {name: np.asarray(values) for name, values in returned.items()}
    results = {name: values.astype(str) if values.dtype.kind == "O" else values for name, values in results.items()}
    for name, values in results.items():
        if values.shape != (runs,):
            wanted = f"{name} should hold one value per run, shape ({runs},)"
            raise ArgumentError("evaluate", f"{wanted}, got {values.shape}")
    if "travel" in by and "travel" not in results and "mean_velocity" in results:
        trust = Trust(results.get("status", np.full(runs, FINISHED)), None, band)
        direction = trust.direction(results["mean_velocity"])
        results["travel"] = np.where(np.isnan(direction), UNKNOWN, direction).astype(np.int8)
    for label in by:
        if label not in results:
            raise ArgumentError("by", f"{label} should be among the results of evaluate, got {', '.join(results)}")
        if not discrete(results[label], label):
            raise ArgumentError("by", f"{label} takes real values and has no borders; choose a discrete measure")
    return results


def _codes(results: Mapping[str, np.ndarray], by: Sequence[str], refine_unsettled: bool, known: dict) -> np.ndarray:
    """One number per run, the same for runs whose labels all agree; `known` keeps them from call to call."""
    columns, distinct = [], []
    for name in _compared(by, results):
        values, column = np.unique(results[name], return_inverse=True)
        if not refine_unsettled and name not in ("response_period", "status"):
            column = np.where(results["response_period"] == 0, -1, column)
        columns.append(column)
        distinct.append([None if value != value else value for value in values.tolist()] + [...])  # NaN is not NaN
    rows, codes = np.unique(np.stack(columns, axis=-1), axis=0, return_inverse=True)
    keys = (tuple(values[column] for values, column in zip(distinct, row, strict=True)) for row in rows)
    return np.array([known.setdefault(key, len(known)) for key in keys])[codes.reshape(-1)]


def _axes(system: Any, over: Mapping[str, Any], evaluate: Evaluator | None) -> dict[str, np.ndarray]:
    if not isinstance(over, Mapping) or len(over) != 2:
        raise ArgumentError("over", f"should name two quantities with their values, got {over!r}")
    if system is None and evaluate is None:
        raise ArgumentError("system", "should be a System unless there is an evaluator, got None")
    axes, complaints = list[Column](), list[str]()
    for path, values in over.items():
        is_range = isinstance(values, tuple) and len(values) == 3 and isinstance(values[2], (int, np.integer))
        axis, complaint = axis_of(path, ":".join(map(str, values)) if is_range else values)
        real = not complaint and not isinstance(axis.values[0], str) and len(axis.values) > 1
        if not complaint and not (real and np.all(np.diff(axis.array) > 0.0)):
            complaint = [Complaint(path, f"a map needs two or more numbers, each above the one before, got {values!r}")]
        axes.append(axis)
        complaints += complaint
    if system is not None and not complaints:
        complaints = plan_complaints(system, Grid(tuple(axes)))
    if complaints:
        raise CaseError(complaints, "the map")
    return {axis.path: axis.array for axis in axes}


def _check(by: Any, steps: tuple, margin: Any, dead_band: Any, refine_unsettled: bool, tile: Any) -> None:
    if isinstance(by, str) or not by or not all(isinstance(label, str) for label in by):
        raise ArgumentError("by", f"should be a list of labels, such as ['mode_sequence', 'travel'], got {by!r}")
    if not refine_unsettled and "response_period" not in by:
        raise ArgumentError("by", f"should hold 'response_period' where refine_unsettled is False, got {by!r}")
    for name, value, low in (*(("coarse", step, 1) for step in steps), ("margin", margin, 0), ("tile", tile, 1)):
        check_whole(name, value, low)
    if dead_band is not None and (not isinstance(dead_band, (int, float)) or not 0.0 <= dead_band < np.inf):
        raise ArgumentError("dead_band", f"should be a finite number >= 0, got {dead_band!r}")


def _ensemble(system: Any, axes: dict[str, np.ndarray], by: Sequence[str], measures: Sequence[str], settings: Any):
    """The ensemble as an evaluator of points, what the dataset says of it, and the variables, as `sweep` has them."""
    from vibrocap.measures.during_run import resolved
    from vibrocap.measures.ensemble import ensemble
    from vibrocap.measures.gathered import ALWAYS
    from vibrocap.studies.variables import study_attributes, variables

    defaults = {parameter.name: parameter.default for parameter in inspect.signature(ensemble).parameters.values()}
    known = ("initial", *RUN_DEFAULTS, "window", "settle", "extrapolate", "threads")
    for unknown in (name for name in settings if name not in known):
        raise ArgumentError(unknown, f"there is no such setting; {suggestion(unknown, known)}")
    used = {name: defaults[name] for name in known} | RUN_DEFAULTS | settings
    case = Case(system, used["initial"] or {}, **{name: used[name] for name in RUN_DEFAULTS})
    used["settle"] = usual_threshold(case.tolerance) if used["settle"] is None else used["settle"] or None
    needed = ["mean_velocity" if label == "travel" else label for label in by]
    listed = [*measures, *(name for name in needed if name not in ALWAYS)]
    names = tuple(measure.name for measure in resolved(listed, system)[0])
    grid = Grid(tuple(Column(path, tuple(values.tolist())) for path, values in axes.items()))
    names = with_load_watch(system, grid, names)
    study = Study(case, grid, names, used["window"], used["settle"], extrapolate=used["extrapolate"])

    def evaluate(x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        return ensemble(system, dict(zip(axes, (x, y), strict=True)), measures=names, **used)

    attributes = {name: value for name, value in study_attributes(study).items() if name != "identity"}  # not a sweep's
    return evaluate, attributes, {variable.name: variable for variable in variables(study)}


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
    """Which cells are halved, for each level but the last: bool [cells, cells]; each lies in a halved one."""
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
    full[i, j] = nearest = full[np.where(2 * i <= i0 + i1, i0, i1), np.where(2 * j <= j0 + j1, j0, j1)]
    if discrete(values, name):
        return full
    x, y = (_scale(axis)[0] for axis in axes)
    u, v = (x[i] - x[i0]) / (x[i1] - x[i0]), (y[j] - y[j0]) / (y[j1] - y[j0])
    with np.errstate(invalid="ignore"):  # a corner may be infinite or no number
        straight = full[i0, j0] * ((1 - u) * (1 - v)) + full[i1, j1] * (u * v)
        straight += full[i1, j0] * (u * (1 - v)) + full[i0, j1] * ((1 - u) * v)
    full[i, j] = np.where(np.isfinite(straight), straight, nearest)
    return full


def _scale(values: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """(positions along an axis, logarithms where it is evenly spaced in these; the way back)."""
    return (np.log(values), np.exp) if even_in_logarithm(values) else (values, np.asarray)


def middles(values: np.ndarray) -> np.ndarray:
    positions, back = _scale(values)
    return back((positions[1:] + positions[:-1]) / 2)


COUNTS = ("impacts",)  # per period of a response of several: whole numbers over that


def discrete(values: np.ndarray, name: str = "") -> bool:
    """Whether values are words, flags, whole numbers (also as floats, NaN or infinite), or by their name counts."""
    if values.dtype.kind in "biuUT" or name in COUNTS:
        return True
    return bool(np.all((values == np.floor(values)) | np.isnan(values)))
