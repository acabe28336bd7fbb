"""A stand-in for `vibrocap.measures.ensemble.ensemble`: the same signature and results, numbers of no meaning, no time.

Every number depends on all values of its own run and on nothing else, as those of the engine do; some runs fail, some
do not settle, and the words are of different lengths.
"""

import math

import numpy as np

from vibrocap.measures.measure import Measure
from vibrocap.motion.status import Status


def ensemble(
    system,
    over,
    *,
    measures=("mean_velocity",),
    initial=None,
    periods=60,
    window=10,
    settle=None,
    extrapolate=True,
    tolerance=1e-8,
    max_events_per_period=10_000,
    max_steps=50_000_000,
    threads=None,
    device="cpu",
    progress=None,
):
    """Numbers made of the paths and the values of each run."""
    names = [measure.name if isinstance(measure, Measure) else measure for measure in measures]
    runs = len(next(iter(over.values())))
    every = {path: [system.parameter(path)] * runs for path in system.parameter_paths}
    every |= {f"initial.{name}": [(initial or {}).get(name, 0.0)] * runs for name in system.state_names}
    every |= over
    settings = (periods, window, settle, extrapolate, tolerance, max_events_per_period, max_steps, system.friction.name)
    options = {
        "status": np.zeros(runs, np.int8),
        "settled": np.zeros(runs, bool),
        "response_period": np.zeros(runs, np.int16),
        "window_start": np.zeros(runs, np.int32),
        "window_periods": np.full(runs, window, np.int32),
    }
    words = []
    options |= {name: np.full(runs, np.nan) for name in names if name not in ("mode_sequence", "response_period")}
    for run, row in enumerate(zip(*every.values(), strict=True)):
        values = [value if value is None or isinstance(value, str) else float(value) for value in row]
        number = _number((*zip(every, values, strict=True), settings))
        failed = number > 0.9
        options["status"][run] = list(Status).index(Status.TOO_MANY_EVENTS) if failed else 0
        options["settled"][run] = number < 0.5
        options["response_period"][run] = number < 0.5
        words.append("" if failed else "LRS"[: 1 + int(3 * number)])
        for name in names:
            if name not in ("mode_sequence", "response_period") and not failed:
                options[name][run] = _number((name, number))
    if "mode_sequence" in names:
        options["mode_sequence"] = np.array(words)
    if progress:
        progress(runs)
    return options


def _number(key):
    """A number from 0 to 1 that looks like chance and is the same in every process."""
    total = 0.5
    for letter in repr(key):
        total = math.modf(total * 7.3 + ord(letter) * 0.6180339887498949)[0]
    return total
