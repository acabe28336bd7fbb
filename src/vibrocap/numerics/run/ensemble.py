"""Runs the kernel for many motions: side by side in lanes, over threads, a few measures of each, not a trace.

On this processor, or on a device that another package brings. Such a package has entry points of the group
`vibrocap.devices`: the name of a device, and a function that returns it. Its kernels have the text of all others
(`ensemble_source`, loop "portable").
"""

import concurrent.futures
import dataclasses
import functools
import os
import threading
from collections.abc import Callable, Mapping

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.numerics.codegen.source import Integrands, generated_source, holding_source, integrands_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.structure import traits
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel.arithmetic.plain_vectors import lane_count
from vibrocap.numerics.kernel.memory_layout import Layout, gathered_entries
from vibrocap.numerics.linker import Linked, ensemble_recipe, kept_kernel, linked_source, plain_kernel
from vibrocap.numerics.run.budget import COMPILED, NO_TABLES, Budget, EnsembleStart, Form, prepared_memory
from vibrocap.numerics.run.results import RunResults


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share(work: Callable[[threading.Event], None], workers: int) -> None:
    """Call `work(stop)` on so many threads at once, this one among them, and return when all have ended.

    stop: set as soon as this thread is interrupted or its work has failed; work that sees it set returns early
    What a thread raises is raised here.
    """
    stop = threading.Event()
    if workers == 1:
        return work(stop)
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        others = [pool.submit(work, stop) for _ in range(workers - 1)]
        try:
            work(stop)
            for other in others:
                other.result()
        finally:
            stop.set()


MARKS = 72  # stroboscopic states that are kept: a response of 16 periods is recognised from 65
RETURN_MARKS = 256  # of a cycle of 62 returns
BLOCK = 128  # most runs that a thread takes at a time
TURNS = 500  # of up to `run_queue.ROUNDS` steps of all lanes, between two looks at the keyboard


def ensemble_order(tolerance: float) -> int:
    """Order of the series: the cheapest of a few, so that few kernels are ever compiled."""
    return 10 if tolerance >= 1e-9 else 12


@functools.lru_cache(maxsize=64)
def ensemble_kernel(equations: Equations, form: Form, returns: bool) -> tuple[Layout, Callable]:
    """(layout, entry) of the kernel for an ensemble of these equations; returns: see `Budget`."""
    source = equations, form.order, form.lanes, form.integrands
    if form.plain:
        layout, text = ensemble_source(*source, returns=returns)
        return layout, plain_kernel(text)["advance_ensemble"]
    layout = ensemble_layout(*source, returns=returns)
    return layout, kept_kernel(lambda: ensemble_source(*source, returns=returns)[1], equations, layout, form.integrands)


def ensemble_layout(
    equations: Equations,
    order: int,
    lanes: int,
    integrands: Integrands | None = None,
    loop: str | None = None,
    returns: bool = False,
) -> Layout:
    """The memory of that kernel, see `ensemble_source`."""
    has = traits(equations, side_by_side=lanes > 1)
    switches = len(equations.switches) - equations.law_switches
    watched = 0 if has.tangent else len(equations.true_loads)
    return Layout(
        **vars(has),
        lanes=lanes,
        order=order,
        marks=RETURN_MARKS if returns else MARKS,
        gathered=gathered_entries(has, integrands or integrands_source(equations), switches, watched, returns),
        extrapolates=loop != "browser" and not (has.tangent or has.turns or returns),
    )


def ensemble_source(
    equations: Equations,
    order: int,
    lanes: int,
    integrands: Integrands | None = None,
    loop: str | None = None,
    returns: bool = False,
) -> tuple[Layout, Linked]:
    """(layout, text) of that kernel. One serves all standard measures: which are gathered is decided as it runs.

    lanes: 1 for one by one, else `lane_count()`
    integrands: with functions of one's own, which a kernel of their own gathers; by default the standard ones
    returns: see `Budget`
    loop: "portable" for another device, "browser" for a page; else as the lanes say, see `ensemble_recipe`
    """
    layout = ensemble_layout(equations, order, lanes, integrands, loop, returns)
    loop = loop or ("ensemble" if lanes == 1 else "simd")
    generated = [generated_source(equations, layout, loop), (integrands or integrands_source(equations)).text]
    if loop != "browser":
        generated.append(holding_source(equations, "evidence", equations.rates[: equations.base]))
    return layout, linked_source("\n\n".join(generated), ensemble_recipe(layout, loop))


def ensemble_run(
    start: EnsembleStart,
    budget: Budget,
    form: Form = COMPILED,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> RunResults:
    """Run an ensemble to its end; progress: called now and then with the runs begun."""
    order, lanes = form.order or ensemble_order(budget.tolerance), form.lanes or lane_count()
    form = dataclasses.replace(form, order=order, lanes=lanes)
    layout, advance = ensemble_kernel(start.equations, form, budget.returns)
    count, tables = len(start.initial), start.tables
    results_end = count * (layout.run_size + layout.result_size)
    trace = np.empty(results_end + tables.size)
    start.write(trace[: count * layout.run_size].reshape(count, -1))
    trace[results_end:] = tables.ravel()
    workers = max(1, min(threads or available_threads(), -(-count // layout.lanes)))
    taken = 0
    guard = threading.Lock()

    def next_block() -> tuple[int, int]:
        nonlocal taken
        with guard:
            first = taken
            # Ever smaller towards the end, so that no thread waits long for the last one.
            taken += min(max((count - first) // (4 * workers), layout.lanes), BLOCK, count - first)
            last = taken
        if progress is not None:
            progress(first)
        return first, last

    def work(stop: threading.Event) -> None:
        floats, ints = prepared_lanes(layout, budget, count, tables)
        place = layout.places
        ints[place["NEXT_RUN"]], ints[place["LAST_RUN"]] = next_block()
        while not stop.is_set():
            running = advance(floats, ints, trace, TURNS)
            if not running:
                return
            if ints[place["MORE"]] and ints[place["NEXT_RUN"]] >= ints[place["LAST_RUN"]]:
                first, last = next_block()
                ints[place["NEXT_RUN"]], ints[place["LAST_RUN"]], ints[place["MORE"]] = first, last, first < last

    share(work, workers)
    return RunResults(layout, trace[count * layout.run_size : results_end].reshape(count, -1))


def prepared_lanes(
    layout: Layout, budget: Budget, count: int, tables: np.ndarray = NO_TABLES
) -> tuple[np.ndarray, np.ndarray]:
    """The memory of the lanes of one thread, all of them free; tables: of the drive, behind the results."""
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


GROUP = "vibrocap.devices"


@dataclasses.dataclass(frozen=True)
class Device:
    """What runs ensembles.

    run: has the contract of `ensemble_run`; chunk: runs that it takes at a time
    tile_runs: runs of a study that are stored together, unless these are given; None: as many as its time allows
    code: with what its results are made, by name, beside the package; see `studies.plan.study`
    """

    run: Callable[..., RunResults]
    chunk: int
    tile_runs: int | None = None
    code: Mapping[str, str] = dataclasses.field(default_factory=dict)


PROCESSOR = Device(ensemble_run, chunk=32_768)  # some 40 MB


def device(name: str) -> Device:
    """The device of this name: "cpu", or one of an installed package.

    Raises ArgumentError where there is none, with the reason that it gives where it cannot run here.
    """
    if name == "cpu":
        return PROCESSOR
    import importlib.metadata  # only here: most runs need none

    brought = {entry_point.name: entry_point for entry_point in importlib.metadata.entry_points(group=GROUP)}
    if name not in brought:
        known = ", ".join(["cpu", *sorted(brought)])
        raise ArgumentError("device", f"should be one of: {known}; cuda needs the package vibrocap-gpu, got {name!r}")
    return brought[name].load()()
