"""Runs a driven kernel for one or many parameter sets, over threads, and returns forces and internal states."""

import dataclasses
import functools
import itertools
import threading
from collections.abc import Callable

import numpy as np

from vibrocap.numerics.codegen.driven_source import DrivenEquations, DrivenLayout, driven_source
from vibrocap.numerics.codegen.resolution import visible_speed
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.numerics.linker import DRIVEN, compiled_kernel, linked_source, plain_kernel
from vibrocap.numerics.run.ensemble import available_threads, share

LEAP = 0.25  # of its natural size: the most by which a state changes in a step where a sharp function of it could hide
STEPS_PER_SAMPLE = 1000  # on average: the limit of the steps of a run


@dataclasses.dataclass(frozen=True)
class DrivenRuns:
    """What came back. After a run that failed its numbers are NaN from where it failed.

    force: [runs, samples]; internal: [runs, samples, states] in the law's order, or None
    status: [runs] of `codes.py`
    """

    force: np.ndarray
    internal: np.ndarray | None
    status: np.ndarray
    steps: np.ndarray  # [runs] accepted
    refused: np.ndarray  # [runs]


@functools.lru_cache(maxsize=64)
def driven_kernel(equations: DrivenEquations, plain: bool = False) -> tuple[DrivenLayout, Callable]:
    """(layout, entry) of the kernel of these equations, compiled or as plain Python."""
    layout, generated = driven_source(equations)
    text = linked_source(generated, DRIVEN)
    return layout, plain_kernel(text)["follow"] if plain else compiled_kernel(text)


def driven_runs(
    equations: DrivenEquations,
    parameters: np.ndarray,
    internal: np.ndarray,
    signals: np.ndarray,
    tolerance: float,
    threads: int | None = None,
    keep_internal: bool = False,
    plain: bool = False,
) -> DrivenRuns:
    """Follow the law through a record with every parameter set.

    parameters: [runs, parameters]; internal: [runs, states] at the start, in the law's order
    signals: [3, samples], time, velocity and load; tolerance: error per step over the natural size of a state
    """
    layout, follow = driven_kernel(equations, plain)
    place, (runs, states), samples = layout.places, internal.shape, signals.shape[1]
    kept = states if keep_internal else 0
    trace = np.full((3 + runs * (1 + kept)) * samples, np.nan)
    trace[: 3 * samples] = signals.ravel()
    order = np.array(equations.order, dtype=int)
    load = float(signals[2].max())
    inverse_scales = _inverse_scales(equations, parameters, load, tolerance)
    visible = visible_speed(equations.sharp, equations.states, parameters, load)
    status, steps, refused = (np.zeros(runs, dtype=np.int64) for _ in range(3))

    def run(i: int) -> None:
        floats, ints = layout.allocated()
        floats[place["PARAMETER"] :][: parameters.shape[1]] = parameters[i]
        floats[place["STATE"] + order] = internal[i]
        floats[place["INVERSE_SCALE"] :][:states] = inverse_scales[:, i]
        floats[place["STEP"]], floats[place["VISIBLE_SPEED"]] = np.inf, visible[i]
        floats[place["LEAP"]] = LEAP / tolerance
        ints[place["STEP_LIMIT"]] = STEPS_PER_SAMPLE * samples
        ints[place["FORCE_START"]] = (3 + i) * samples
        ints[place["INTERNAL_START"]] = (3 + runs + i * kept) * samples if kept else -1
        follow(floats, ints, trace, samples)
        status[i], steps[i], refused[i] = (ints[place[name]] for name in ("STATUS", "STEPS", "REFUSED"))

    _over_threads(run, runs, threads)
    force, rest = trace[3 * samples :][: runs * samples], trace[(3 + runs) * samples :]
    return DrivenRuns(
        force=force.reshape(runs, samples),
        internal=rest.reshape(runs, samples, states)[:, :, order] if kept else None,
        status=status,
        steps=steps,
        refused=refused,
    )


def _inverse_scales(equations: DrivenEquations, parameters: np.ndarray, load: float, tolerance: float) -> np.ndarray:
    """One over tolerance and natural size of each state [states, runs]."""
    symbols = [*([0.0] * equations.states), 0.0, load, 0.0, 0.0]
    with np.errstate(all="ignore"):  # a parameter set out of its bounds shows in its run
        scales = evaluate(equations.scales, 0.0, symbols, 1.0, parameters.T)
        inverses = [1.0 / (tolerance * np.maximum(np.abs(scale), 1e-290)) for scale in scales]
    runs = len(parameters)
    return np.stack([np.broadcast_to(value, runs) for value in inverses]) if inverses else np.empty((0, runs))


def _over_threads(run: Callable[[int], None], runs: int, threads: int | None) -> None:
    """Call run(0), run(1), ..., each by whichever thread is free."""
    workers = max(1, min(threads or available_threads(), runs))
    waiting, guard = itertools.count(), threading.Lock()

    def work(stop: threading.Event) -> None:
        while not stop.is_set():
            with guard:
                i = next(waiting)
            if i >= runs:
                return
            run(i)

    share(work, workers)
