"""A study on a Dask cluster: workers compute tiles and store them; only counts of statuses pass through the client."""

import logging
import secrets
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import Complaint, shown
from vibrocap.case.case import CaseError
from vibrocap.studies.plan.runs import Runs
from vibrocap.studies.plan.study import Study, code_of
from vibrocap.studies.run.sent_study import SentStudy, sent
from vibrocap.studies.run.tile_worker import Index, run_and_store
from vibrocap.studies.store.store import Store
from vibrocap.studies.store.writing import StoreError

if TYPE_CHECKING:
    from distributed import Client

AHEAD = 2  # tiles in flight per thread of the cluster: one that runs and one that waits
PATIENCE = 10.0  # seconds until a scheduler answers, until a word is said about missing workers, until a file shows
LOOK = 1.0  # seconds between two looks at the cluster
EXTRA = "needs dask and distributed; install them with: pip install 'vibrocap[sweep]'"
PROTOCOLS = ("tcp", "tls", "ucx", "ws", "wss", "inproc")


class ClusterWarning(UserWarning):
    """A cluster does not get on; the study waits for it."""


def address_complaints(address: Any) -> list[Complaint]:
    """What is wrong with the address of a scheduler, as far as it can be seen without asking anyone."""
    wanted = "should be the address of a Dask scheduler, such as tcp://node1:8786"
    protocol, given, place = str(address).partition("://")
    host, colon, port = place.rpartition(":")
    if isinstance(address, str) and given and protocol in PROTOCOLS:
        if protocol == "inproc" or (host.strip() == host and host and colon and port.isdigit() and int(port) < 65_536):
            return []
        return [Complaint("scheduler", f"{wanted}, with a host and a port; got {shown(address)}")]
    return [Complaint("scheduler", f"{wanted}, got {shown(address)}")]


class Cluster:
    """The workers of a scheduler, through one client.

    They and this process should see the folder of a study under the same path.
    """

    def __init__(self, client: "Client", address: str):
        self._client, self._address = client, address

    def code_of(self, plan: Runs) -> dict[str, str]:
        """With what a worker would make the results of a plan; waits for the first worker, and says so.

        Raises CaseError where a worker lacks the package.
        """
        self._wait_for_workers()
        # First by means that every worker has: one without the package would break off over a task made of its parts.
        versions: Any = self._client.run(eval, "__import__('vibrocap').__version__", on_error="return")
        lacking = sorted(worker for worker, found in versions.items() if isinstance(found, Exception))
        if lacking:
            raise CaseError([f"no vibrocap on {_few(lacking)}; install it there, or leave them out"], "the cluster")
        if wrong := {found for found in versions.values() if found != _version("vibrocap")}:
            raise CaseError([f"workers have vibrocap {_few(sorted(wrong))}, not {_version('vibrocap')}"], "the cluster")
        return self._result(self._client.submit(code_of, plan, key=f"code-{secrets.token_hex(8)}"))

    def run(
        self,
        store: Store,
        pending: Sequence[Index],
        mixed: bool = False,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Have tiles computed and stored.

        A worker that dies costs the tiles on which it was; they are given to others. Not more tiles are in flight than
        keep the workers busy, so a study of any size is no burden to the scheduler.
        progress: called with the number of tiles done.
        Raises CaseError or StoreError as a tile does; StoreError where the scheduler goes away, where every worker that
        takes a tile dies, or where they store into another folder than this process sees.
        """
        from distributed.scheduler import KilledWorker

        waiting, path, own = iter(pending), str(store.path.resolve()), secrets.token_hex(8)
        # A task, not scattered data: those would be lost with the last worker that holds them, a task is done again.
        study = self._client.submit(_itself, sent(store.study), key=f"study-{own}")

        def submitted(index: Index) -> Any:
            return self._client.submit(run_and_store, study, path, index, mixed=mixed, key=f"tile-{own}-{index}")

        running: dict[Any, Index] = {}
        done = 0
        try:
            for index in _first(waiting, self._room(0)):
                running[submitted(index)] = index
            while running:
                for future in self._finished(list(running)):
                    index = running.pop(future)
                    with _gone():
                        future.result()
                    _check_shown(store, index)
                    done += 1
                    if progress:
                        progress(float(done))
                for further in _first(waiting, self._room(len(running))):
                    running[submitted(further)] = further
        except KilledWorker as error:
            raise StoreError(
                f"{store.path}: {error.task}: every worker that took it died; has a worker enough memory? What is "
                "stored is kept, --resume (resume=True) continues"
            ) from None
        except ImportError as error:
            raise CaseError([f"a worker lacks what it needs: {error}; install vibrocap there"], "the cluster") from None
        except _Gone:
            raise StoreError(
                f"{store.path}: the scheduler at {self._address} is gone. What is stored is kept; when there is a "
                "scheduler again, continue with --resume (resume=True)"
            ) from None

    def _room(self, running: int) -> int:
        """How many tiles more should be in flight; workers may come and go."""
        return AHEAD * max(1, self._threads()) - running

    def _threads(self) -> int:
        with _gone():
            threads: Any = self._client.nthreads()
        return sum(threads.values())

    def _wait_for_workers(self) -> None:
        watch = _Watch(self._address)
        while not self._threads():
            watch.nobody()
            time.sleep(LOOK)

    def _result(self, future: Any) -> Any:
        self._finished([future])
        return future.result()

    def _finished(self, futures: list[Any]) -> list[Any]:
        """Those of some futures that are done, at least one; waits, and says where nothing can come of it."""
        from distributed import wait

        watch = _Watch(self._address)
        while True:
            with _gone():
                with self._client.as_current(), suppress(TimeoutError):  # `wait` asks for the client of its thread
                    finished: Any = wait(futures, timeout=LOOK, return_when="FIRST_COMPLETED")
                    return list(finished.done)
                if self._client.status != "running":
                    raise _Gone
            if self._threads():
                watch = _Watch(self._address)
            else:
                watch.nobody()


class _Watch:
    """Says once that there are no workers, when there have been none for a while."""

    def __init__(self, address: str):
        self._address, self._begun, self._said = address, time.monotonic(), False

    def nobody(self) -> None:
        """There is no worker at present."""
        if not self._said and time.monotonic() - self._begun > PATIENCE:
            self._said = True
            warnings.warn(
                f"the scheduler at {self._address} has no workers; the study waits for some (Ctrl-C stops it)",
                ClusterWarning,
                stacklevel=6,
            )


class _Gone(Exception):
    """The scheduler no longer answers."""


@contextmanager
def _gone() -> Iterator[None]:
    """Whatever the client says in the `with` block about a scheduler that went away is one exception."""
    from concurrent.futures import CancelledError

    from distributed import CancelledError as Cancelled
    from distributed.comm.core import CommClosedError

    try:
        yield
    except (CancelledError, Cancelled, CommClosedError, ConnectionError) as error:
        raise _Gone from error


@contextmanager
def connected(scheduler: str) -> "Iterator[Cluster]":
    """The cluster of a scheduler's address; CaseError where no scheduler answers within ten seconds."""
    try:
        from distributed import Client
    except ImportError:
        raise CaseError([EXTRA], "the cluster") from None
    if found := address_complaints(scheduler):
        raise CaseError(found, "the cluster")
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what goes wrong is said here, in words
    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise CaseError([f"no scheduler answers at {scheduler!r}: {error}"], "the cluster") from None
    with client:
        yield Cluster(client, scheduler)


def _few(names: list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _itself(study: Study | SentStudy) -> Study | SentStudy:
    return study


def _first(waiting: Iterator[Index], count: int) -> list[Index]:
    return [index for _, index in zip(range(count), waiting, strict=False)]


def _check_shown(store: Store, index: Index) -> None:
    """StoreError where a tile that a worker stored does not show here: then the folder is not a shared one."""
    begun = time.monotonic()
    while not store.is_done(index):
        store.check_place()
        if time.monotonic() - begun > PATIENCE:
            raise StoreError(
                f"{store.path}: a worker stored tile {index}, but it does not show here; the folder should be on a "
                "file system that all machines share"
            )
        time.sleep(0.5)
