"""A study on workers: they compute tiles, each on one thread, and this process alone stores them.

Workers are processes of this machine, which talk by pipes that no one else has, or those of any executor of
`concurrent.futures`. A process that dies, in whatever way, costs the tiles that were in work; new processes take them.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait

import numpy as np

from vibrocap.studies.plan.differences import code_differences
from vibrocap.studies.plan.study import Study, code_of
from vibrocap.studies.run.sent_study import SentStudy, sent
from vibrocap.studies.store.marks import Index
from vibrocap.studies.store.store import Store
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.tile import run_tile

AHEAD = 2  # tiles in flight per process: one that runs and one that waits
IN_FLIGHT = 256  # tiles in flight of another executor, which does not tell how many workers it has
DEATHS = 4  # in a row, without a tile stored between, after which it is not tried again
_given: list[Study | SentStudy] = []  # of a process of this machine: the study


def run_on_workers(
    store: Store,
    pending: Sequence[Index],
    workers: int | Executor,
    mixed: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Have tiles computed by so many processes, or by the workers of an executor, and store them.

    mixed: also what is computed with something else than the study was begun with; its tiles say so
    progress: called with the number of tiles done. Raises StoreError or CaseError as a tile does; StoreError where a
    worker computes with something else, or where processes die again and again.
    """
    waiting, done, deaths, study = list(reversed(pending)), 0, 0, sent(store.study)
    while waiting:
        in_work: dict[Future, Index] = {}
        own = _processes(workers, study) if isinstance(workers, int) else contextlib.nullcontext(workers)
        most = AHEAD * workers if isinstance(workers, int) else IN_FLIGHT
        given = () if isinstance(workers, int) else (study,)
        try:
            with own as executor:
                while waiting or in_work:
                    while waiting and len(in_work) < most:
                        with _deaf():
                            in_work[executor.submit(computed_tile, store.tile, waiting[-1], *given)] = waiting[-1]
                        waiting.pop()
                    for future in wait(in_work, return_when=FIRST_COMPLETED).done:
                        code, arrays = future.result()
                        other = code_differences(store.study.code, code)
                        if other and not mixed:
                            raise StoreError(
                                f"{store.path}: a worker computes with something else than the study was begun with: "
                                f"{'; '.join(other)}. Give all workers the same, or continue with --mixed (mixed=True)"
                            )
                        store.write(in_work[future], arrays, code if other else None)
                        del in_work[future]
                        done, deaths = done + 1, 0
                        if progress:
                            progress(float(done))
        except BrokenExecutor:
            deaths += 1
            if deaths == DEATHS or not isinstance(workers, int):
                raise StoreError(
                    f"{store.path}: a process that computes dies again and again, the last time on one of the tiles "
                    f"{sorted(in_work.values())}; is there enough memory? With fewer workers, --resume (resume=True) "
                    "continues"
                ) from None
            waiting += reversed(in_work.values())
        finally:
            for future in in_work:
                future.cancel()


def computed_tile(
    tile: tuple[int, ...], index: Index, study: Study | SentStudy | None = None
) -> tuple[dict[str, str], dict[str, np.ndarray]]:
    """In a worker: with what it computes, and the results of one tile."""
    study = study or _given[0]
    study = study.study() if isinstance(study, SentStudy) else study
    return code_of(study.plan), run_tile(study, tile, index, threads=1)


@contextlib.contextmanager
def _processes(count: int, study: Study | SentStudy) -> Iterator[Executor]:
    """So many processes; they end at once behind the `with` block, in the middle of a tile if need be."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin, (study,))
    try:
        yield pool
    finally:
        processes = {*multiprocessing.active_children()} - others
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """Ctrl-C is for this process, and comes after the `with` block; one that begins in it never hears of it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(study: Study | SentStudy) -> None:
    """In a helping process: what it works on. It ends when the process that began it does, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _given[:] = [study]
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()
