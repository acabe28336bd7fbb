"""How many runs a tile of a new study has: some five seconds of work, found by timing a few of its runs."""

import time
from pathlib import Path

import numpy as np

from vibrocap.studies.plan.study import Study
from vibrocap.studies.tile import RUNS, measured_runs

SECONDS = 5.0  # of work in a tile: what an interruption loses at most, and enough to make a file worth while
SAMPLE = 16  # runs that are timed, spread over the study: so many keep the lanes of two threads busy
SIZES = (RUNS, 1024, 256, 64)  # few, so that as a rule a study has the same tiles each time that it is begun
MOST_TILES = 16_384  # that a study is cut into on that account


def tile_runs_by_time(study: Study, out: Path, threads: int | None = None) -> int | None:
    """Runs of a tile of a study that is to be stored in a new folder; None where tiles of the usual size will do.

    They do where the study would be one tile or two, where the folder holds something already, and where runs are
    quick. Nothing but the time that an interruption costs depends on it.
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
