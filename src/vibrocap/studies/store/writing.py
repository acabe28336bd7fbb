"""Writing so that a crash, a full disk or a second writer can do no harm: whole files or none, and a lock."""

import contextlib
import errno
import itertools
import os
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path

from vibrocap.case.case import CaseError
from vibrocap.files import WriteError

GONE = (errno.ENOENT, errno.ENOTDIR, errno.ESTALE)
_numbers = itertools.count()


class StoreError(WriteError):
    """A study that cannot be completed: its folder does not take results, or its helpers are gone.

    The message names the folder, the reason, and what to do.
    """


class DamageWarning(UserWarning):
    """Stored results were not as they were written; they are computed again."""


@contextlib.contextmanager
def kept(folder: Path) -> Iterator[None]:
    """Turn an error of the file system into a StoreError that says what becomes of what is stored already."""
    try:
        yield
    except StoreError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        if error.errno in GONE:
            raise StoreError(
                f"{folder}: was removed or changed by others while the study ran: {reason}"
                f"{f' ({error.filename})' if error.filename else ''}. What was stored there may be lost; --resume "
                "(resume=True) looks at what is left and goes on"
            ) from error
        raise StoreError(
            f"{folder}: cannot be written: {reason}. What was stored before is whole; when that is mended, go on with "
            "--resume (resume=True)"
        ) from error


def write_file(path: Path, data: bytes, unfinished: Path) -> None:
    """Write a file elsewhere (in the folder `unfinished`, on the same disk), force it to the disk, rename it.

    `files.replacing` does this for single files. It looks through their folder for what dead processes left, which
    would take longer with every tile, and puts unfinished ones where only the files of the results may be.
    """
    unfinished.mkdir(exist_ok=True)
    temporary = unfinished / f"{socket.gethostname()}-{os.getpid()}-{next(_numbers)}"
    binary = getattr(os, "O_BINARY", 0)  # without it Windows writes \r\n for \n
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | binary, 0o666)
    try:
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[os.write(handle, rest) :]
            os.fsync(handle)
        finally:
            os.close(handle)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def write_files(folder: Path, files: Mapping[str, bytes], unfinished: Path) -> None:
    """Write files given by their place below a folder; on return they and their names are on the disk.

    Their folders should be there: one that went away is no place to go on in.
    """
    places = set()
    for name, data in files.items():
        path = folder / name
        write_file(path, data, unfinished)
        places.add(path.parent)
    for place in sorted(places | {folder, folder.parent}):
        force_names(place)


def force_names(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(handle)


class Lock:
    """An exclusive lock on a file, which the system releases when the process ends, however it ends.

    Raises CaseError where another process holds it. On a file system without locks, or on Windows, it does nothing.
    """

    def __init__(self, path: Path):
        self._path = path
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            import fcntl

            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:
            pass
        except BlockingIOError:
            os.close(self._handle)
            raise CaseError(["another process is writing there; wait for it, or stop it"], str(path.parent)) from None
        except OSError as error:
            if error.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL):
                os.close(self._handle)
                raise

    def check(self) -> None:
        """StoreError where the folder is no longer the one that was locked."""
        mine = os.fstat(self._handle)
        try:
            now = os.stat(self._path)
        except OSError:
            now = None
        if now is None or not os.path.samestat(mine, now):
            raise StoreError(
                f"{self._path.parent}: was removed or replaced while the study ran; what was stored there is lost. "
                "Begin again, with --resume (resume=True) if some of it is back"
            )

    def release(self) -> None:
        """Let others write."""
        os.close(self._handle)
