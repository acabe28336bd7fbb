"""A study on a Dask cluster: workers compute tiles and store them; only counts of statuses pass through the client."""

import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.motion.trajectory import Status
from vibrocap.studies.code_version import code_version
from vibrocap.studies.sent_study import SentStudy
from vibrocap.studies.store.record import read_record
from vibrocap.studies.store.store import Store
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.study import Study
from vibrocap.studies.tile import run_tile

if TYPE_CHECKING:
    from distributed import Client

Index = tuple[int, ...]
AHEAD = 2  # tiles in flight per thread of the cluster: one that runs and one that waits
PATIENCE = 30.0  # seconds until a file that a worker wrote shows on this machine, or until a scheduler answers


def run_and_store(study: Study | SentStudy, path: str, index: Index, threads: int | None = 1) -> dict[str, int]:
    """Compute one tile and store it; how many runs ended how, by the words of their status.

    What a worker of a cluster does: it is sent a study and a place in it, and answers with counts only. A tile that is
    stored already is left as it is, and nothing is counted.
    """
    store = _store_of(study.study() if isinstance(study, SentStudy) else study, Path(path))
    if store.is_done(index):
        return {}
    arrays = run_tile(store.study, store.tile, index, threads=threads)
    store.write(index, arrays)
    codes, counts = np.unique(arrays["status"], return_counts=True)
    statuses = list(Status)
    return {statuses[int(code)].value: int(count) for code, count in zip(codes, counts, strict=True)}


def run_on_cluster(
    store: Store,
    pending: Sequence[Index],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Have tiles computed and stored by a local cluster of so many processes, or by that of a scheduler's address.

    A worker that dies costs the tiles on which it was; they are given to others. Not more tiles are in flight than keep
    the workers busy, so a study of any size is no burden to the scheduler.
    progress: called with the number of tiles done.
    Raises CaseError or StoreError as a tile does; CaseError where no scheduler answers or no worker can run a tile;
    StoreError where they store into another folder than this process sees.
    """
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    waiting = iter(pending)
    sent = SentStudy.of(store.study) if store.study.own_parts else store.study
    with _client(workers, scheduler) as client:
        # A task, not scattered data: those would be lost with the last worker that holds them, a task is done again.
        study = client.submit(_itself, sent, key=f"study-{store.study.identity[:12]}")
        path = str(store.path.resolve())

        def submitted(index: Index) -> Any:
            return client.submit(run_and_store, study, path, index, key=f"tile-{store.study.identity[:12]}-{index}")

        places = {}
        running = as_completed(loop=client.loop)
        for index in _first(waiting, AHEAD * _threads(client)):
            running.add(future := submitted(index))
            places[future.key] = index
        try:
            for done, future in enumerate(running, start=1):
                index = places.pop(future.key)
                future.result()
                _check_shown(store, index)
                if progress:
                    progress(float(done))
                room = AHEAD * _threads(client) - len(places)
                for further in _first(waiting, room):
                    running.add(future := submitted(further))
                    places[future.key] = further
        except KilledWorker as error:
            complaint = f"{error.task}: every worker that took it died; has a worker enough memory?"
            raise CaseError([complaint], "the cluster") from error
        except ImportError as error:
            raise CaseError([f"a worker lacks what it needs: {error}"], "the cluster") from error


def _itself(study: Study | SentStudy) -> Study | SentStudy:
    return study


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> "Iterator[Client]":
    from distributed import Client, LocalCluster

    if scheduler is not None:
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise CaseError([f"no scheduler answers at {scheduler!r}: {error}"], "the cluster") from None
        with client:
            yield client
    else:
        with (
            LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address="127.0.0.1:0",  # any free port; by default two clusters fight for one
            ) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client


def _threads(client: "Client") -> int:
    """Threads of the cluster at present: workers may come and go."""
    threads: Any = client.nthreads()
    return max(1, sum(threads.values()))


def _first(waiting: Iterator[Index], count: int) -> list[Index]:
    return [index for _, index in zip(range(count), waiting, strict=False)]


def _store_of(study: Study, path: Path) -> Store:
    """The store of a study as a worker sees it."""
    try:
        record = read_record(path)
    except CaseError as error:
        raise StoreError(
            f"{path}: a worker on {socket.gethostname()} does not see the study there ({error.complaints[0]}); the "
            "folder should be on a file system that all machines share"
        ) from None
    if record["identity"] != study.identity:
        raise StoreError(f"{path}: holds another study than the one that a worker was sent")
    if (own := code_version()) != study.code:
        raise StoreError(
            f"{path}: a worker on {socket.gethostname()} has vibrocap {own['version']} with sources "
            f"{own['sources'][:12]}, the study needs {study.code['version']} with {study.code['sources'][:12]}"
        )
    return Store(path, study, tuple(record["tile"]))


def _check_shown(store: Store, index: Index) -> None:
    """StoreError where a tile that a worker stored does not show here: then the folder is not a shared one."""
    begun = time.monotonic()
    while not store.is_done(index):
        if time.monotonic() - begun > PATIENCE:
            raise StoreError(
                f"{store.path}: a worker stored tile {index}, but it does not show here; the folder should be on a "
                "file system that all machines share"
            )
        time.sleep(0.5)
