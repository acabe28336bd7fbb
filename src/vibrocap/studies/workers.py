"""A study on workers: they compute tiles, each on one thread, and this process alone stores them.

Workers are processes of this machine, which talk by pipes that no one else has, or those of any executor of
`concurrent.futures`. A process that dies, in whatever way, costs the tiles that were in work; new processes take them.

Workers are sent no code: parts of one's own they load from the same file or module.
"""

import contextlib
import dataclasses
import functools
import importlib
import multiprocessing
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from typing import Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.measures.measure import Measure
from vibrocap.physics.catalogue import register
from vibrocap.physics.part_files import PartsError, file_of, load_parts
from vibrocap.studies.plan.study import Study, code_differences, code_of
from vibrocap.studies.store.places import StoreError
from vibrocap.studies.store.record import Index
from vibrocap.studies.store.store import Store
from vibrocap.studies.tile import run_tile

AHEAD = 2  # tiles in flight per process: one that runs and one that waits
IN_FLIGHT = 256  # tiles in flight of another executor, which does not tell how many workers it has
DEATHS = 4  # in a row, without a tile stored between, after which it is not tried again


@dataclasses.dataclass(frozen=True, eq=False)
class SentStudy:
    """A study on its way to workers that have to load its own parts first: its record, measures, and their sources."""

    record: dict[str, Any]
    measures: tuple[Measure, ...]
    sources: tuple[tuple[str, str], ...]

    def study(self) -> Study:
        """The study again; StoreError where this machine does not have its parts."""
        receive(self.sources)
        return Study.from_record(self.record, self.measures)


_studies: list[Study | SentStudy] = []  # of a process of this machine: the study


def sent(study: Study) -> Study | SentStudy:
    """A study as workers are sent it; CaseError for a part that they could not find."""
    if not study.own_parts:
        return study
    own = tuple(measure for measure in study.measures if isinstance(measure, Measure))
    return SentStudy(study.record(), own, sources_of(study.own_parts.values()))


def sources_of(parts: Iterable[type]) -> tuple[tuple[str, str], ...]:
    """Where workers find parts: (file, digest) or (module, name). CaseError for one that they cannot find."""
    sources, complaints = [], []
    for part in parts:
        if (place := file_of(part)) is not None:
            sources.append((str(place[0]), place[1]))
        elif part.__module__ == "__main__" or "<locals>" in part.__qualname__:
            where = f"{part.__qualname__} stands in {part.__module__}, where workers cannot find it"
            complaints.append(f"{where}; put it in a file of its own, and name that by --parts or load_parts")
        else:
            sources.append((part.__module__, part.__qualname__))
    if complaints:
        raise CaseError(complaints, "the study")
    return tuple(dict.fromkeys(sources))


def receive(sources: Iterable[tuple[str, str]]) -> None:
    """Load the parts that a study needs; StoreError where this machine does not have them, or has others."""
    for place, what in sources:
        try:
            if place.endswith(".py"):
                load_parts(place, what)
            else:
                register(functools.reduce(getattr, what.split("."), importlib.import_module(place)))
        except (PartsError, ImportError, AttributeError) as error:
            raise StoreError(f"a worker on {socket.gethostname()} lacks parts of the study: {error}") from None


def run_on_workers(
    store: Store,
    pending: Sequence[Index],
    workers: int | Executor,
    mixed: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Have tiles computed by so many processes, or by the workers of an executor, and store them.

    mixed: also what is computed with something else than the study was begun with; its tiles say so. Raises StoreError
    where a worker computes with something else, or where processes die again and again, and what a tile raises.
    """
    waiting, done, deaths, study = list(reversed(pending)), 0, 0, sent(store.study)
    while waiting:
        in_work: dict[Future, Index] = {}
        own = processes(workers, study) if isinstance(workers, int) else contextlib.nullcontext(workers)
        most = AHEAD * workers if isinstance(workers, int) else IN_FLIGHT
        sent_along = () if isinstance(workers, int) else (study,)
        try:
            with own as executor:
                while waiting or in_work:
                    while waiting and len(in_work) < most:
                        with _deaf():
                            in_work[executor.submit(computed_tile, store.tile, waiting[-1], *sent_along)] = waiting[-1]
                        waiting.pop()
                    for future in wait(in_work, return_when=FIRST_COMPLETED).done:
                        code, arrays = future.result()
                        other = code_differences(store.study.code, code)
                        if other and not mixed:
                            raise StoreError(
                                f"{store.path}: a worker has other sources, libraries or processor than the study: "
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
    study = study or _studies[0]
    study = study.study() if isinstance(study, SentStudy) else study
    return code_of(study.plan, study.device), run_tile(study, tile, index, threads=1)


@contextlib.contextmanager
def processes(count: int, *studies: Study | SentStudy) -> Iterator[Executor]:
    """So many processes, with the study of their tiles; they end at once behind the `with` block, busy or not."""
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin, studies)
    try:
        with _deaf():
            pool.submit(int)  # they begin with the first task
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


def _begin(*studies: Study | SentStudy) -> None:
    """In a helping process: what it works on. It ends when the process that began it does, and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _studies[:] = studies
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (parent.join(), os._exit(1)), daemon=True).start()
