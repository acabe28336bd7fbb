"""Settling runs: the stroboscopic map iterated until a motion repeats, for many starts side by side."""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.motion.run_evidence import certified
from vibrocap.numerics.api import Budget, codes, device
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, StroboscopicMap, in_rows

SETTLED = 1e-6  # distance to the steady motion, over natural sizes, at which a run has settled
ROUGH = 1e-9  # tolerance of these runs
MOST_STEPS = 10**9


@dataclasses.dataclass(frozen=True)
class SettlingRuns:
    """Where runs ended, arrays [runs, ...].

    state: [runs, states] at the start of a drive period, or of a system that nothing drives in time at a return to rest
        of a contact; ended: numbers of `numerics/kernel/codes.py`
    response_period: drive periods, or returns of a cycle; 0 where it did not settle
    drift: change of the cyclic coordinate per drive period, over the last response; NaN where it did not settle
    certified: whether the evidence of the last response, or else of the last drive period, is within the bounds of a
        certificate, see `motion.run_evidence`
    """

    state: np.ndarray
    ended: np.ndarray
    response_period: np.ndarray
    drift: np.ndarray
    certified: np.ndarray

    @property
    def finished(self) -> np.ndarray:
        return self.ended == codes.DONE

    def some(self, runs: np.ndarray) -> "SettlingRuns":
        """Those with these indices."""
        return SettlingRuns(**{field.name: getattr(self, field.name)[runs] for field in dataclasses.fields(self)})

    def replaced(self, runs: np.ndarray, others: "SettlingRuns") -> "SettlingRuns":
        """The runs, with others in place of the chosen ones."""
        columns = {field.name: getattr(self, field.name).copy() for field in dataclasses.fields(self)}
        for name, column in columns.items():
            column[runs] = getattr(others, name)
        return SettlingRuns(**columns)


def settling_runs(
    map_: StroboscopicMap,
    states: np.ndarray,
    periods: int,
    *,
    progress: Callable[[float], None] | None = None,
) -> SettlingRuns:
    """Run states [runs, states] until each settles, or for so many drive periods.

    progress: called now and then, from any thread, with the share begun
    """
    count, parameters = len(states), map_.parameters()
    how = {"window": 1, "threshold": SETTLED, "evidence": 1, "returns": not map_.equations.timed}
    budget = Budget(periods, ROUGH, MOST_EVENTS, MOST_STEPS, **how)
    parts = []
    chunk = device("cpu").chunk
    for base in range(0, count, chunk):
        part = slice(base, min(base + chunk, count))
        report = None if progress is None else lambda begun, base=base: progress((base + begun) / count)
        ends = map_.run(budget, states[part], parameters, progress=report)
        response = ends.response_period
        drift = np.full(len(response), np.nan)
        if map_.cyclic >= 0:
            gained, over = (
                ends.state[:, map_.cyclic] - ends.start[:, map_.cyclic],
                np.maximum(response, 1).astype(float),
            )
            if ends.layout.returns:
                turn = ends.entry("CYCLE_TIME")
                over = np.where(turn > 0.0, turn / map_.period(parameters), over)
            drift[response > 0] = (gained / over)[response > 0]
        good = certified(map_.equations, ends, in_rows(parameters, states[part]), ROUGH)
        parts.append((ends.state, ends.status, response, drift, good))
    return SettlingRuns(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def continued(
    map_: StroboscopicMap, runs: SettlingRuns, waiting: np.ndarray, longer: int, periods: int
) -> SettlingRuns:
    """The runs, of which the chosen ones went on: `longer` periods in any case, then until they settled."""
    budget = Budget(longer, ROUGH, MOST_EVENTS, MOST_STEPS, window=1)
    ends = map_.run(budget, runs.state[waiting], map_.parameters())
    later = settling_runs(map_, ends.state, periods)
    later.ended[:] = np.where(ends.finished, later.ended, ends.status)
    later.response_period[~later.finished] = 0
    return runs.replaced(waiting, later)


def iterates(map_: StroboscopicMap, states: np.ndarray, periods: int) -> np.ndarray:
    """States after 0, 1, ... drive periods [periods + 1, runs, states]; NaN after a run that could not be completed."""
    states_after = np.full((periods + 1, *states.shape), np.nan)
    states_after[0] = states
    running = np.all(np.isfinite(states), axis=1)
    for k in range(periods):
        if not running.any():
            break
        images = map_.images(states_after[k, running], map_.parameters(), 1, tangents=False)
        states_after[k + 1, running] = np.where(images.finished[:, None], images.state, np.nan)
        running[running] = images.finished
    return states_after
