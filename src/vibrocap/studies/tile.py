"""A tile: a block of neighbouring runs, which is computed at once and stored as a whole."""

import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.case.sections import is_kind
from vibrocap.physics.dimensions.conversion import INITIAL, path_in_si
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System
from vibrocap.studies.plan.planning import check_runs
from vibrocap.studies.plan.runs import Block, tile_counts
from vibrocap.studies.plan.study import Study
from vibrocap.studies.plan.variation import kinds_apart
from vibrocap.studies.variables import as_stored, variables

RUNS = 4096  # of a tile: a second or so of work, and about 30 kB per measure
MOST_RUNS = 262_144  # of a tile, where a study would otherwise have more tiles than
MANY_TILES = 2048
SECONDS = 5.0  # of work in a tile: what an interruption loses at most, and enough to make a file worth while
SAMPLE = 16  # runs that are timed, spread over the study: so many keep the lanes of two threads busy
SIZES = (RUNS, 1024, 256, 64)  # few, so that as a rule a study has the same tiles each time that it is begun
MOST_TILES = 16_384  # that a study is cut into on that account


def tile_shape(shape: tuple[int, ...], runs: int | None = None) -> tuple[int, ...]:
    """Shape of the tiles of a study: rows of neighbouring runs, not more than about `runs` of them.

    The last dimensions are kept whole, so that tiles hold runs one after another; the one that is cut is cut evenly.
    """
    total = math.prod(shape)
    room = runs or min(max(RUNS, -(-total // MANY_TILES)), MOST_RUNS)
    lengths = []
    for length in reversed(shape):
        pieces = -(-length // room)
        lengths.append(-(-length // pieces))
        room = max(1, room // length)
    return tuple(reversed(lengths))


def tile_indices(shape: tuple[int, ...], tile: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    return itertools.product(*(range(count) for count in tile_counts(shape, tile)))


def tile_block(shape: tuple[int, ...], tile: tuple[int, ...], index: tuple[int, ...]) -> Block:
    """The runs of a tile; those at the far edges may be smaller."""
    lengths = zip(shape, tile, index, strict=True)
    return tuple(slice(i * size, min((i + 1) * size, length)) for length, size, i in lengths)


def run_tile(
    study: Study,
    tile: tuple[int, ...],
    index: tuple[int, ...],
    *,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """The results of one tile: an array of the shape of its block for each of `variables(study)`.

    Raises CaseError for values that a part refuses, if the checks before any work could not see them.
    """
    block = tile_block(study.plan.shape, tile, index)
    shape = tuple(part.stop - part.start for part in block)
    values = study.plan.values(block)
    try:
        columns = measured_runs(study, values, math.prod(shape), threads, progress)
    except ValueError as error:
        check_runs(study.case.system, values)  # says which run it is, if it is one
        raise CaseError([str(error)], f"tile {'.'.join(map(str, index))}") from error
    return {name: array.reshape(shape) for name, array in columns.items()}


def measured_runs(
    study: Study,
    values: Mapping[str, np.ndarray],
    runs: int,
    threads: int | None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """The results of runs with these values, arrays [runs]."""
    from vibrocap.measures.during_run import resolved, unavailable
    from vibrocap.measures.ensemble import ensemble

    specifications, kinds_vary = variables(study), any(map(is_kind, values))
    columns = {variable.name: variable.empty((runs,)) for variable in specifications}
    begun = 0
    for system, over, members in kinds_apart(study.case.system, values, runs):
        initial = {name: x for name, x in study.case.initial.items() if name in system.state_names}
        if not over:  # kinds alone vary: all these runs are alike
            name = system.state_names[0]
            over = {INITIAL + name: np.full(len(members), initial.get(name, 0.0))}
        report = progress and (lambda count, before=begun: progress((before + count) / runs))
        lacking = unavailable(resolved(study.measures, system)[1], system) if kinds_vary else {}
        measures = [measure for measure in study.measures if getattr(measure, "name", measure) not in lacking]
        settings = {"measures": measures, "initial": initial, **study.settings}
        results = ensemble(system, over, threads=threads, progress=report, **settings)
        begun += len(members)
        for variable in specifications:
            name = variable.name
            if variable.measured:
                columns[name][members] = results.get(name, variable.fill)  # else it is lacking
            else:
                columns[name][members] = as_stored(over[name]) if name in over else _own_value(system, initial, name)
    return columns


def _own_value(system: System, initial: Mapping[str, float], path: str) -> Any:
    """What a system that does not vary at a path has there; NaN or an empty word where it has nothing."""
    place = path_in_si(path, system.parts) if system.units is not None else None
    if place is not None:
        own = _own_value(system, initial, place[0])
        return own if isinstance(own, str) else own * system.si.per_key(place[1])
    part, name = split_path(path)
    if is_kind(path):
        return system.parts[part].name
    if path.startswith(INITIAL):
        return initial.get(name, 0.0) if name in system.state_names else np.nan
    return system.parameter(path) if path in system.parameter_paths else np.nan


def tile_runs_by_time(study: Study, out: Path, threads: int | None = None) -> int | None:
    """Runs of a tile of a study that is to be stored in a new folder; None where tiles of the usual size will do:

    where the study would be one tile or two, where the folder holds something already, and where runs are quick.
    """
    total = study.plan.count
    if total <= 2 * RUNS or (out.exists() and any(out.iterdir())):
        return None
    least = -(-total // MOST_TILES)
    _timed(study, [0], threads)  # compiles
    seconds = _timed(study, list(range(0, total, total // SAMPLE))[:SAMPLE], threads) / SAMPLE
    fitting = next((size for size in SIZES if size * seconds <= SECONDS), SIZES[-1])
    return None if fitting == RUNS else max(fitting, least)


def _timed(study: Study, places: list[int], threads: int | None) -> float:
    """How long the runs at these places take, in seconds; places: their numbers in C order."""
    columns: dict[str, list[np.ndarray]] = {}
    for place in places:
        index = np.unravel_index(place, study.plan.shape)
        for path, values in study.plan.values(tuple(slice(int(i), int(i) + 1) for i in index)).items():
            columns.setdefault(path, []).append(values)
    values = {path: np.concatenate(parts) for path, parts in columns.items()}
    begun = time.perf_counter()
    measured_runs(study, values, len(places), threads)
    return time.perf_counter() - begun
