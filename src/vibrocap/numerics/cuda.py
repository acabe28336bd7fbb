"""Runs an ensemble on an NVIDIA graphics card: the same generated source, one thread per run (extra `gpu`).

A thread carries its lane in local memory, which the compiler interleaves, so that the threads of a warp read side by
side; a slice of one global array per thread would scatter every access, and its address is no constant. Some 8 kB per
thread, of which a step touches one.

Runs last differently long. A launch therefore makes a bounded number of steps, keeps what the threads carry in global
memory, and the next one goes on: so no watchdog strikes, Ctrl-C and progress work, and no launch waits for one endless
run. Saving and restoring costs some microseconds a launch. Within a launch a thread that has ended its run takes the
next one from a queue before the next step (not in a loop of its own inside, at whose end the threads of its warp would
wait for each other), so that a warp steps together, whichever run each of its threads is on. Which thread a run meets
changes nothing in its result.

The results are those of a CPU to rounding: CUDA's sin, cos and exp and its fused multiply-adds are not the same. `min`
and `max` pass over a NaN there; in the kernel only their second operand can be one, which Python passes over too.
"""

import ast
import functools
import hashlib
import importlib.metadata
import importlib.util
import platform
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.numerics import lanes as memory
from vibrocap.numerics import link
from vibrocap.numerics.ensemble import Budget, ensemble_order, ensemble_source, prepared_lanes, write_runs
from vibrocap.numerics.lanes import Layout
from vibrocap.numerics.source import Integrands

BLOCK = 32  # threads per block: one warp, since blocks share nothing and few runs then spread over the whole card
RESIDENT = 256  # threads per multiprocessor: ptxas gives each all 255 registers that it may have, of 65,536
LAUNCH = 0.25  # s, aimed at: short enough for a card that also draws a screen
FIRST_ROUNDS, MOST_ROUNDS = 200, 1_000_000  # steps per launch
SHARE = 0.5  # of the free memory of the card, for the runs and results of one chunk
ENTRY = "run_all"

# Places of `queue`.
NEXT, END, BUSY = 0, 1, 2  # first run that no thread has begun; end of the runs; threads that go on in another launch

RUN_ALL = f'''
@cuda.jit(cache=True)
def {ENTRY}(tape, queue, start_real, start_whole, kept_real, kept_whole, fresh, rounds):
    """Every thread makes up to `rounds` steps, through run after run of the tape, until the queue is empty.

    kept_real, kept_whole: [entries, threads] what the threads carry between launches; fresh: begin from start_* instead
    """
    thread = cuda.grid(1)
    real = cuda.local.array(REAL_SIZE, np.float64)
    whole = cuda.local.array(WHOLE_SIZE, np.int64)
    for i in range(WORK):
        real[i] = start_real[i] if fresh != 0 else kept_real[i, thread]
    for i in range(WHOLE_SIZE):
        whole[i] = start_whole[i] if fresh != 0 else kept_whole[i, thread]
    running = True
    for _ in range(rounds):
        if whole[STATUS] != RUNNING:
            if whole[RUN] >= 0:
                end_run(real, whole, tape, 0)
            run = cuda.atomic.add(queue, {NEXT}, 1)
            if run >= queue[{END}]:
                running = False
                break
            begin_run(real, whole, tape, 0, run)
        advance(real, whole, tape, 1)
    if running:
        cuda.atomic.add(queue, {BUSY}, 1)
    for i in range(WORK):
        kept_real[i, thread] = real[i]
    for i in range(WHOLE_SIZE):
        kept_whole[i, thread] = whole[i]
'''


def cuda_text(equations: Any, order: int, integrands: Integrands | None = None) -> tuple[Layout, str]:
    """(layout, text) of the module that numba-cuda compiles for an ensemble of these equations."""
    layout, linked = ensemble_source(equations, order, 1, integrands)
    tree = ast.fix_missing_locations(link.UnsignedIndices().visit(ast.parse(linked)))
    lines = ["from numba import cuda"]
    for line in ast.unparse(tree).splitlines():
        if line.startswith("def "):
            lines.append("@cuda.jit(device=True)")
        lines.append(line)
    sizes = f"REAL_SIZE = {layout.places['WORK'] + layout.work_size}\nWHOLE_SIZE = {len(memory.WHOLE) * layout.lanes}"
    return layout, "\n".join([*lines, sizes, RUN_ALL])


@functools.lru_cache(maxsize=64)
def cuda_kernel(equations: Any, order: int, integrands: Integrands | None = None) -> tuple[Layout, Any]:
    """(layout, kernel): compiled at its first launch and kept on disk, for each kind of card, for the next process."""
    layout, text = cuda_text(equations, order, integrands)
    versions = [importlib.metadata.version(name) for name in ("numba", "numba-cuda")]
    name = hashlib.sha256(f"{platform.python_version()} {versions}\n{text}".encode()).hexdigest()[:24]
    return layout, link.loaded(name, text, ENTRY)


def cuda_problem() -> str | None:
    """Why ensembles cannot run on a graphics card here, and what was found; None if they can."""
    needs = 'device: "cuda" needs an NVIDIA card, its driver and the extra `gpu` (pip install "vibrocap[gpu]"); found:'
    if importlib.util.find_spec("numba_cuda") is None:
        return f'{needs} no numba-cuda. Install the extra, or choose device="cpu".'
    found = f"numba-cuda {importlib.metadata.version('numba-cuda')}"
    try:
        from numba import cuda

        if getattr(cuda, "is_available", bool)():
            return None
        reason = " ".join(str(cuda.cuda_error() or "").split()) or "no card that it can use"
    except Exception as error:  # whatever is missing in a CUDA installation is reported, not raised
        reason = " ".join(str(error).split()) or type(error).__name__
    return f'{needs} {found}, but: {reason.rstrip(".")}. Install what is missing, or choose device="cpu".'


def cuda_ensemble_run(
    equations: Any,
    parameters: np.ndarray,
    initial: np.ndarray,
    budget: Budget,
    progress: Callable[[int], None] | None = None,
    order: int | None = None,
    integrands: Integrands | None = None,
) -> tuple[Layout, np.ndarray]:
    """Run an ensemble to its end on the first graphics card; the same contract as `ensemble.ensemble_run`.

    parameters: [runs, parameters]; initial: [runs, states]; progress: called after each launch with the runs begun
    integrands: with functions of one's own, see `ensemble.ensemble_source`
    Returns the layout and the results [runs, layout.result_size], see `lanes.RESULT_HEAD`.
    Raises ValueError, saying what was found, where there is no such card or the extra is missing.
    """
    problem = cuda_problem()
    if problem is not None:
        raise ValueError(problem)
    from numba import cuda

    order = ensemble_order(budget.tolerance) if order is None else order
    layout, kernel = cuda_kernel(equations, order, integrands)
    count = len(initial)
    results = np.empty((count, layout.result_size))
    chunk = runs_at_a_time(layout, card_threads(), cuda.current_context().get_memory_info().free)
    for first in range(0, count, chunk):
        part = slice(first, min(first + chunk, count))
        report = None if progress is None else functools.partial(_report, progress, first)
        results[part] = _chunk_run(layout, kernel, equations, parameters[part], initial[part], budget, report)
    return layout, results


def _report(progress: Callable[[int], None], before: int, begun: int) -> None:
    progress(before + begun)


def card_threads() -> int:
    """Threads that the card runs at once."""
    from numba import cuda

    return RESIDENT * cuda.get_current_device().MULTIPROCESSOR_COUNT


def runs_at_a_time(layout: Layout, threads: int, free: float) -> int:
    """Runs whose data and results fit into so many free bytes, beside what the threads carry.

    The driver keeps local memory for the 2,048 threads that a multiprocessor could hold if they used fewer registers.
    """
    local = layout.places["WORK"] + layout.work_size + len(memory.WHOLE)
    saved = layout.places["WORK"] + len(memory.WHOLE)
    carried = 8 * threads * (local * 2048 // RESIDENT + saved)
    return int(max(1, min(2**31, SHARE * max(0.0, free - carried) // (8 * (layout.run_size + layout.result_size)))))


def _chunk_run(
    layout: Layout,
    kernel: Any,
    equations: Any,
    parameters: np.ndarray,
    initial: np.ndarray,
    budget: Budget,
    progress: Callable[[int], None] | None,
) -> np.ndarray:
    """Results of runs that fit on the card, launch after launch."""
    from numba import cuda

    count, run_numbers = len(initial), len(initial) * layout.run_size
    runs = np.empty((count, layout.run_size))
    write_runs(runs, equations, parameters, initial)
    tape = _on_card(run_numbers + count * layout.result_size, np.float64)
    tape[:run_numbers].copy_to_device(runs.reshape(-1))
    real, whole = prepared_lanes(layout, budget, count)
    blocks = -(-min(card_threads(), count) // BLOCK)
    start = cuda.to_device(real), cuda.to_device(whole)
    kept = (
        _on_card((layout.places["WORK"], blocks * BLOCK), np.float64),
        _on_card((len(whole), blocks * BLOCK), np.int64),
    )
    queue = np.array([0, count, 0], dtype=np.int64)
    on_card = cuda.to_device(queue)
    with warnings.catch_warnings():  # that few runs leave most of the card idle
        warnings.simplefilter("ignore")
        launch = kernel[blocks, BLOCK]
    fresh, rounds = 1, FIRST_ROUNDS
    while True:
        began = time.perf_counter()
        launch(tape, on_card, *start, *kept, fresh, rounds)
        queue = on_card.copy_to_host()  # waits for the launch
        if progress is not None:
            progress(int(min(queue[NEXT], count)))
        if queue[BUSY] == 0:
            break
        if fresh == 0:  # the first launch may have compiled
            rounds = next_rounds(rounds, time.perf_counter() - began)
        queue[BUSY] = 0
        on_card = cuda.to_device(queue)
        fresh = 0
    return tape[run_numbers:].copy_to_host().reshape(count, -1)


def _on_card(shape: Any, dtype: Any) -> Any:
    """An array in the card's memory, its numbers not set."""
    from numba import cuda

    return cuda.device_array(shape, dtype)


def next_rounds(rounds: int, seconds: float) -> int:
    """Steps of the next launch, after one of `rounds` steps in so many seconds."""
    wanted = rounds * min(4.0, LAUNCH / max(seconds, 1e-6))
    return int(min(MOST_ROUNDS, max(1, wanted)))
