"""Runs an ensemble on an NVIDIA GPU: the same kernel text, one thread per run.

A thread carries its lane in local memory, which the compiler interleaves, so that the threads of a warp read side by
side; a slice of one global array per thread would scatter every access, and its address is no constant. Some 8 kB per
thread, of which a step touches one.

Runs last differently long. A launch therefore makes a bounded number of steps, keeps what the threads carry in global
memory, and the next one goes on: so no watchdog strikes, Ctrl-C and progress work, and no launch waits for one endless
run. Saving and restoring costs some microseconds a launch. Within a launch a thread that has ended its run takes the
next one from a queue before the next step. Before each step all threads of a block wait for each other: the threads
of a warp then compute their series together, whichever run each is on, and the warps of a multiprocessor, one block,
read the same instructions. Without this a thread that left the loop alone kept those behind it apart, and sweeps took
1.2 to 1.5 times as long. Which thread a run meets changes nothing in its result.

Tried on an H100 and of no use: fewer registers for more threads (128, 168), a second wait between a series and its
step, and events that wait until eight or sixteen threads of a warp have one.

The code is PTX (`ptx.py`), of which the driver makes the GPU's own and keeps it. The results are those of a CPU to
rounding: sin, cos and exp are polynomials here, and which products are fused differs.
"""

import functools
import hashlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.numerics.codegen.source import Integrands
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import module_source
from vibrocap.numerics.run.budget import COMPILED, Budget, EnsembleStart, Form
from vibrocap.numerics.run.ensemble import Device, ensemble_order, ensemble_source, prepared_lanes
from vibrocap.numerics.run.results import RunResults
from vibrocap_gpu.driver import Gpu, first_gpu, gpu_problem
from vibrocap_gpu.ptx import ENTRY, ptx
from vibrocap_gpu.thread import BUSY, NEXT

CHUNK = 2**20  # runs at a time, of which a hundred thousand run at once
WARP = 32  # threads that the GPU moves together
RESIDENT = 256  # threads per multiprocessor, one block: ptxas gives each all 255 registers that it may have, of 65,536
LAUNCH = 0.25  # s, aimed at: short enough for a GPU that also draws a screen
FIRST_ROUNDS, MOST_ROUNDS = 200, 1_000_000  # steps per launch
SHARE = 0.5  # of the free memory of the GPU, for the runs and results of one chunk


def device() -> Device:
    """The first GPU, as the package's entry point names it; ArgumentError where it cannot be used."""
    problem = gpu_problem()
    if problem is not None:
        raise ArgumentError("device", problem)
    sources = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
    return Device(gpu_ensemble_run, CHUNK, tile_runs=CHUNK, code={"vibrocap-gpu": sources.hexdigest()})


def thread_text(
    equations: Equations, order: int, integrands: Integrands | None = None, returns: bool = False
) -> tuple[Layout, str]:
    """(layout, text) of the kernel of which a GPU's threads are made, for an ensemble of these equations."""
    layout, text = ensemble_source(equations, order, 1, integrands, loop="portable", returns=returns)
    text.check()
    thread = module_source(Path(__file__).with_name("thread.py"), "vibrocap_gpu/thread.py")
    return layout, f"{text}\n\n{thread}\nWHOLE_SIZE = {layout.whole_size}\n"


@functools.lru_cache(maxsize=64)
def gpu_code(
    equations: Equations, order: int, integrands: Integrands | None = None, returns: bool = False
) -> tuple[Layout, str]:
    """(layout, PTX) for all GPUs."""
    layout, text = thread_text(equations, order, integrands, returns)
    return layout, ptx(text, layout.real_size, layout.whole_size)


def gpu_ensemble_run(
    start: EnsembleStart,
    budget: Budget,
    form: Form = COMPILED,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> RunResults:
    """Run an ensemble to its end on the first GPU; the same contract as `numerics.run.ensemble.ensemble_run`.

    progress: called after each launch with the runs begun; threads: of the processor, which has none here
    """
    order = form.order or ensemble_order(budget.tolerance)
    layout, code = gpu_code(start.equations, order, form.integrands, budget.returns)
    count = len(start.initial)
    results = np.empty((count, layout.result_size))
    gpu = first_gpu()
    gpu.serve()
    at_once = gpu_threads(gpu)
    chunk = runs_at_a_time(layout, at_once, gpu.free)
    with gpu.function(code, ENTRY) as function:
        for first in range(0, count, chunk):
            part = slice(first, min(first + chunk, count))
            report = None if progress is None else functools.partial(_report, progress, first)
            runs = np.empty((part.stop - first, layout.run_size))
            some = EnsembleStart(start.equations, start.parameters[part], start.initial[part])
            some.write(runs)
            _run_chunk(gpu, function, at_once, layout, runs, some.tables, budget, report, results[part])
    return RunResults(layout, results)


def _report(progress: Callable[[int], None], before: int, begun: int) -> None:
    progress(before + begun)


def gpu_threads(gpu: Gpu) -> int:
    """Threads that the GPU runs at once."""
    return RESIDENT * gpu.attribute("MULTIPROCESSOR_COUNT")


def threads_per_block(threads: int, count: int) -> int:
    """Of a GPU that runs so many threads at once, for so many runs: few runs are spread over all multiprocessors."""
    warps = -(-min(threads, count) * RESIDENT // (threads * WARP))
    return WARP * max(1, warps)


def runs_at_a_time(layout: Layout, threads: int, free: float) -> int:
    """Runs whose data and results fit into so many free bytes, beside what the threads carry.

    The driver keeps local memory for the 2,048 threads that a multiprocessor could hold if they used fewer registers.
    """
    local = layout.real_size + layout.whole_size
    saved = layout.places["WORK"] + layout.whole_size
    carried = 8 * threads * (local * 2048 // RESIDENT + saved)
    return int(max(1, min(2**31, SHARE * max(0.0, free - carried) // (8 * (layout.run_size + layout.result_size)))))


def _run_chunk(
    gpu: Gpu,
    function: Any,
    threads: int,
    layout: Layout,
    runs: np.ndarray,
    tables: np.ndarray,
    budget: Budget,
    progress: Callable[[int], None] | None,
    results: np.ndarray,
) -> None:
    """Write the results of runs that fit on the GPU, launch after launch."""
    count = len(runs)
    floats, ints = prepared_lanes(layout, budget, count, tables)
    block = threads_per_block(threads, count)
    blocks = -(-min(threads, count) // block)
    kept = 8 * blocks * block
    queue = np.array([0, count, 0], dtype=np.int64)
    sizes = (
        runs.nbytes + results.nbytes + tables.nbytes,
        *(queue.nbytes, floats.nbytes, ints.nbytes, kept * layout.places["WORK"], kept * len(ints)),
    )
    with gpu.arrays(*sizes) as addresses:
        trace, on_gpu, start_floats, start_ints, *_ = addresses
        table = trace + runs.nbytes + results.nbytes
        sent = (trace, runs), (table, tables.ravel()), (start_floats, floats), (start_ints, ints)
        for address, values in sent:
            if values.size:
                gpu.send(address, values)
        fresh, rounds = 1, FIRST_ROUNDS
        while True:
            began = time.perf_counter()
            queue[BUSY] = 0
            gpu.send(on_gpu, queue)
            gpu.launch(function, blocks, block, addresses, [fresh, rounds])
            gpu.fetch(queue, on_gpu)  # waits for the launch
            if progress is not None:
                progress(int(min(queue[NEXT], count)))
            if queue[BUSY] == 0:
                break
            rounds = next_rounds(rounds, time.perf_counter() - began)
            fresh = 0
        gpu.fetch(results, trace + runs.nbytes)


def next_rounds(rounds: int, seconds: float) -> int:
    """Steps of the next launch, after one of `rounds` steps in so many seconds."""
    wanted = rounds * min(4.0, LAUNCH / max(seconds, 1e-6))
    return int(min(MOST_ROUNDS, max(1, wanted)))
