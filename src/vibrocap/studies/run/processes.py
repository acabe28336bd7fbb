"""A study on processes of this machine: each computes tiles and stores them. They talk by pipes, which no one else has.

A process that dies, in whatever way, costs the tiles that were in work; new processes take them.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from vibrocap.studies.plan.study import Study
from vibrocap.studies.run.sent_study import SentStudy, sent
from vibrocap.studies.run.tile_worker import Index, run_and_store
from vibrocap.studies.store.store import Store
from vibrocap.studies.store.writing import StoreError

AHEAD = 2  # tiles in flight per process: one that runs and one that waits
DEATHS = 4  # in a row, without a tile stored between, after which it is not tried again
_given: list[Any] = []  # of a helping process: the study, its folder, and whether it may be mixed


def run_on_processes(
    store: Store, pending: Sequence[Index], workers: int, progress: Callable[[float], None] | None = None
) -> None:
    """Have tiles computed and stored by so many processes of one thread each.

    progress: called with the number of tiles done. Raises StoreError or CaseError as a tile does; StoreError where
    processes die again and again.
    """
    waiting, done, deaths = list(reversed(pending)), 0, 0
    while waiting:
        in_work: dict[Future, Index] = {}
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(
            workers,
            multiprocessing.get_context("spawn"),
            _begin,
            (sent(store.study), str(store.path.resolve()), store.made_by is not None),
        )
        try:
            while waiting or in_work:
                while waiting and len(in_work) < AHEAD * workers:
                    with _deaf():
                        in_work[pool.submit(_tile, waiting[-1])] = waiting[-1]
                    waiting.pop()
                for future in wait(in_work, return_when=FIRST_COMPLETED).done:
                    future.result()
                    del in_work[future]
                    done, deaths = done + 1, 0
                    store.check_place()
                    if progress:
                        progress(float(done))
        except BrokenProcessPool:
            deaths += 1
            if deaths == DEATHS:
                raise StoreError(
                    f"{store.path}: a process that computes dies again and again, the last time on one of the tiles "
                    f"{sorted(in_work.values())}; is there enough memory? With fewer workers, --resume (resume=True) "
                    "continues"
                ) from None
            left = [index for index in in_work.values() if not store.is_done(index)]
            done += len(in_work) - len(left)
            waiting += reversed(left)
        finally:
            _end(pool, {*multiprocessing.active_children()} - others)


def _end(pool: ProcessPoolExecutor, processes: set[Any]) -> None:
    """End processes at once, in the middle of a tile if need be: what is stored is whole whenever they end."""
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


def _begin(study: Study | SentStudy, path: str, mixed: bool) -> None:
    """In a helping process: what it works on. It ends when the process that began it does, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _given[:] = study, path, mixed
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()


def _tile(index: Index) -> dict[str, int]:
    study, path, mixed = _given
    return run_and_store(study, path, index, mixed=mixed)
