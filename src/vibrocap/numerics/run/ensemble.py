"""Runs the kernel for many motions: side by side in lanes, over threads, a few measures of each, not a trace."""

import functools
import threading
from collections.abc import Callable

import numpy as np

from vibrocap.numerics.codegen.source import Integrands, generated_source, holding_source, integrands_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.numerics.expressions.traits import traits
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel.arithmetic.registers import lane_count
from vibrocap.numerics.kernel.gathered_entries import gathered_entries
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker.link import Linked, compiled_kernel, linked_source, plain_kernel
from vibrocap.numerics.linker.recipes import ensemble_recipe
from vibrocap.numerics.run.budget import Budget, prepared_memory
from vibrocap.numerics.run.results import RunResults
from vibrocap.numerics.run.threads import available_threads, share

MARKS = 72  # stroboscopic states that are kept: a response of 16 periods is recognised from 65
RETURN_MARKS = 256  # of a cycle of 62 returns
BLOCK = 128  # most runs that a thread takes at a time
NO_TABLES = np.empty((0, 0, 0))  # of a drive without corners
TURNS = 500  # of up to `run_queue.ROUNDS` steps of all lanes, between two looks at the keyboard


def ensemble_order(tolerance: float) -> int:
    """Order of the series: the cheapest of a few, so that few kernels are ever compiled."""
    return 10 if tolerance >= 1e-9 else 12


@functools.lru_cache(maxsize=64)
def ensemble_kernel(
    equations: Equations,
    order: int,
    lanes: int,
    plain: bool = False,
    integrands: Integrands | None = None,
    returns: bool = False,
) -> tuple[Layout, Callable]:
    """(layout, entry) of the kernel for an ensemble of these equations, compiled or as plain Python."""
    layout, text = ensemble_source(equations, order, lanes, integrands, returns=returns)
    return layout, plain_kernel(text)["advance_ensemble"] if plain else compiled_kernel(text)


def ensemble_source(
    equations: Equations,
    order: int,
    lanes: int,
    integrands: Integrands | None = None,
    loop: str | None = None,
    returns: bool = False,
) -> tuple[Layout, Linked]:
    """(layout, text) of that kernel. One serves all standard measures: which are gathered is decided as it runs.

    lanes: 1 for one by one, else `registers.lane_count()`
    integrands: with functions of one's own, which a kernel of their own gathers; by default the standard ones
    returns: see `Budget`
    loop: "portable" for another device, "browser" for a page; else as the lanes say, see `ensemble_recipe`
    """
    loop = loop or ("ensemble" if lanes == 1 else "simd")
    integrands = integrands or integrands_source(equations)
    has = traits(equations, side_by_side=loop == "simd")
    own_switches = len(equations.switches) - equations.law_switches
    watched = 0 if has.tangent else len(equations.true_loads)
    sizes = has.states, has.contacts, integrands.summed, integrands.own_extremes, own_switches
    entries = gathered_entries(*sizes, watched, returns)
    layout = Layout(
        **vars(has),
        lanes=lanes,
        order=order,
        marks=RETURN_MARKS if returns else MARKS,
        gathered=entries,
        extrapolates=loop != "browser" and not (has.tangent or has.turns or returns),
    )
    generated = [generated_source(equations, layout, loop), integrands.text]
    if loop != "browser":
        generated.append(holding_source(equations, "evidence", equations.rates[: equations.base]))
    return layout, linked_source("\n\n".join(generated), ensemble_recipe(layout, loop))


def ensemble_run(
    equations: Equations,
    parameters: np.ndarray,
    initial: np.ndarray,
    budget: Budget,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    order: int | None = None,
    lanes: int | None = None,
    plain: bool = False,
    integrands: Integrands | None = None,
    mark_distance: np.ndarray | None = None,
    start: np.ndarray | None = None,
    delay: np.ndarray | None = None,
) -> RunResults:
    """Run an ensemble to its end.

    parameters: [runs, parameters]; initial: [runs, states]; progress: called now and then with the runs begun
    integrands: with functions of one's own, see `ensemble_source`
    mark_distance: [runs] time between two marks, at each of which the drive begins anew, if not the period of the drive
    start: [runs] time since the drive began its period at which a run begins, if not 0
    delay: [runs] by which the start itself moves along the tangent of a run, if at all
    """
    order = ensemble_order(budget.tolerance) if order is None else order
    lanes = lane_count() if lanes is None else lanes
    layout, advance = ensemble_kernel(equations, order, lanes, plain, integrands, budget.returns)
    count = len(initial)
    tables = drive_tables(equations, parameters)
    results_end = count * (layout.run_size + layout.result_size)
    trace = np.empty(results_end + tables.size)
    runs = trace[: count * layout.run_size].reshape(count, -1)
    write_runs(runs, equations, parameters, initial, start)
    trace[results_end:] = tables.ravel()
    if mark_distance is not None:
        runs[:, -2] = mark_distance
    if delay is not None:
        runs[:, -1] = delay
    workers = max(1, min(threads or available_threads(), -(-count // layout.lanes)))
    taken = 0
    guard = threading.Lock()

    def next_block() -> tuple[int, int]:
        nonlocal taken
        with guard:
            start = taken
            # Ever smaller towards the end, so that no thread waits long for the last one.
            taken += min(max((count - start) // (4 * workers), layout.lanes), BLOCK, count - start)
            end = taken
        if progress is not None:
            progress(start)
        return start, end

    def work(stop: threading.Event) -> None:
        floats, ints = prepared_lanes(layout, budget, count, tables)
        place = layout.places
        ints[place["NEXT_RUN"]], ints[place["LAST_RUN"]] = next_block()
        while not stop.is_set():
            running = advance(floats, ints, trace, TURNS)
            if not running:
                return
            if ints[place["MORE"]] and ints[place["NEXT_RUN"]] >= ints[place["LAST_RUN"]]:
                start, end = next_block()
                ints[place["NEXT_RUN"]], ints[place["LAST_RUN"]], ints[place["MORE"]] = start, end, start < end

    share(work, workers)
    return RunResults(layout, trace[count * layout.run_size : results_end].reshape(count, -1))


def prepared_lanes(
    layout: Layout, budget: Budget, count: int, tables: np.ndarray = NO_TABLES
) -> tuple[np.ndarray, np.ndarray]:
    """The memory of the lanes of one thread, all of them free; tables: as of `drive_tables`, behind the results."""
    return prepared_memory(
        layout,
        budget,
        STATUS=codes.DONE,
        RUN=-1,
        RESULT_START=count * layout.run_size,
        TABLE_START=count * (layout.run_size + layout.result_size),
        TABLE_STRIDE=tables[0].size if len(tables) > 1 else 0,
        SEGMENT_COUNT=tables.shape[1],
        MORE=1,
        SCALE=1.0,  # free lanes are computed along with the others
        PERIOD=1.0,
    )


def drive_tables(equations: Equations, parameters: np.ndarray) -> np.ndarray:
    """[tables, segments, numbers] of the drive, one for each run or one for all; none where it has no corners."""
    return NO_TABLES if equations.corners is None else equations.corners.tables(parameters)


def write_runs(
    runs: np.ndarray, equations: Equations, parameters: np.ndarray, initial: np.ndarray, start: np.ndarray | None = None
) -> None:
    """Fill the rows of runs that `run_queue.begin_run` reads; start: see `ensemble_run`."""
    time = np.zeros(len(runs)) if start is None else start
    parameters = equations.filled(parameters, time)
    states, count = initial.shape[1], parameters.shape[1]
    columns = parameters.T
    *scales, period = evaluate([*equations.scales, equations.period], 0.0, initial.T, 1.0, columns)
    runs[:, :states] = initial
    runs[:, states : states + count] = parameters
    for i, scale in enumerate(scales):
        runs[:, states + count + i] = scale
    runs[:, -3], runs[:, -2], runs[:, -1] = time, period, 0.0
