"""Runs until they settle, many side by side: where each ended, and the marks of those that go on."""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.ensemble import CHUNK
from vibrocap.numerics.expressions.graph import depends_on_time
from vibrocap.numerics.kernel import memory_layout as memory
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.orbits.steady import ROUGH, SETTLED
from vibrocap.orbits.stroboscopic_map import MOST_EVENTS, StroboscopicMap
from vibrocap.system import System

MOST_STEPS = 10**9


@dataclasses.dataclass(frozen=True)
class LongRuns:
    """Where runs ended, arrays [runs, ...].

    state: [runs, states] at a mark; ended: numbers of `memory_layout.py`; response_period: 0 where it did not settle
    drift: change of the cyclic coordinate per drive period, over the last response; NaN where it did not settle
    """

    state: np.ndarray
    ended: np.ndarray
    response_period: np.ndarray
    drift: np.ndarray

    @property
    def finished(self) -> np.ndarray:
        """Whether the run came to its end."""
        return self.ended == memory.DONE


def check_driven(map_: StroboscopicMap) -> None:
    """ValueError for a system without a drive that changes in time: whole periods are nothing to it."""
    if not depends_on_time(map_.equations.rates):
        raise ValueError(
            f"system: nothing drives it in time (the drive is {map_.system.drive.name}), so there is no stroboscopic "
            "map to look at; orbit(system, initial=...) finds its cycles"
        )


def checked_whole(name: str, value: object, least: int, most: int) -> int:
    """A whole number within bounds; ValueError for anything else."""
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or not least <= value <= most:
        raise ValueError(f"{name} should be a whole number from {least} to {most}, got {value!r}")
    return int(value)


def long_runs(
    map_: StroboscopicMap,
    states: np.ndarray,
    parameters: np.ndarray,
    periods: int,
    *,
    progress: Callable[[float], None] | None = None,
) -> LongRuns:
    """Run states [runs, states] until each settles, or for so many drive periods.

    progress: called now and then, from any thread, with the share begun
    """
    count = len(states)
    budget = Budget(periods, 1, SETTLED, ROUGH, MOST_EVENTS, MOST_STEPS)
    parts = []
    for base in range(0, count, CHUNK):
        chosen = slice(base, min(base + CHUNK, count))
        layout, results = ensemble_run(
            map_.equations,
            parameters[chosen],
            states[chosen],
            budget,
            threads=map_.threads,
            plain=map_.plain,
            progress=None if progress is None else lambda begun, base=base: progress((base + begun) / count),
        )
        first = len(memory.RESULT_HEAD)
        n = layout.states
        head = {name: results[:, memory.RESULT_HEAD.index(name)] for name in memory.RESULT_HEAD}
        settled = (head["status"] == memory.DONE) & (head["response_period"] > 0)
        drift = np.full(len(results), np.nan)
        if map_.cyclic >= 0:
            gained = results[:, first + n + map_.cyclic] - results[:, first + map_.cyclic]
            drift[settled] = gained[settled] / head["response_period"][settled]
        response = np.where(settled, head["response_period"], 0).astype(int)
        parts.append((results[:, first + n : first + 2 * n].copy(), head["status"].astype(int), response, drift))
    return LongRuns(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def continued(map_: StroboscopicMap, runs: LongRuns, chosen: np.ndarray, longer: int, periods: int) -> LongRuns:
    """The runs, of which the chosen ones went on: `longer` periods in any case, then until they settled."""
    rows = np.tile(map_.parameters(), (len(chosen), 1))
    budget = Budget(longer, 1, 0.0, ROUGH, MOST_EVENTS, MOST_STEPS)
    layout, results = ensemble_run(
        map_.equations, rows, runs.state[chosen], budget, threads=map_.threads, plain=map_.plain
    )
    first = len(memory.RESULT_HEAD) + layout.states
    later = long_runs(map_, results[:, first : first + layout.states].copy(), rows, periods)
    later.ended[:] = np.where(results[:, 0] == memory.DONE, later.ended, results[:, 0])
    later.response_period[~later.finished] = 0
    fields = {field.name: getattr(runs, field.name).copy() for field in dataclasses.fields(runs)}
    for name, column in fields.items():
        column[chosen] = getattr(later, name)
    return LongRuns(**fields)


def marks(map_: StroboscopicMap, states: np.ndarray, parameters: np.ndarray, periods: int) -> np.ndarray:
    """States at the marks [periods + 1, runs, states] of runs that go on; NaN after one that could not be completed."""
    found = np.full((periods + 1, *states.shape), np.nan)
    found[0] = states
    running = np.all(np.isfinite(states), axis=1)
    for k in range(periods):
        if not running.any():
            break
        images = map_.images(found[k, running], parameters[running], 1, tangents=False)
        found[k + 1, running] = np.where(images.finished[:, None], images.state, np.nan)
        running[running] = images.finished
    return found


def kept_states(map_: StroboscopicMap) -> list[int]:
    """All states but the cyclic coordinate."""
    return [i for i in range(map_.states) if i != map_.cyclic]


def moving_states(map_: StroboscopicMap) -> list[int]:
    """All states that change smoothly, but the cyclic coordinate: those in which small changes grow or shrink."""
    return [i for i in kept_states(map_) if map_.system.state_names[i] not in map_.system.friction.switched]


def map_of(system: System, tolerance: float, threads: int | None = None) -> StroboscopicMap:
    """The stroboscopic map of a driven system."""
    map_ = StroboscopicMap(system, tolerance, threads)
    check_driven(map_)
    return map_
