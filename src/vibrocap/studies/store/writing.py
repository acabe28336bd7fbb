"""Writing so that a crash, a full disk or a second writer can do no harm: whole files or none, and a lock."""

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from vibrocap import locks
from vibrocap.case.case import CaseError
from vibrocap.files import WriteError

_LOCKED = os.O_RDWR | os.O_CREAT  # how the file of a lock is opened: no link, and a pipe is not waited for
for _name in ("O_NOFOLLOW", "O_CLOEXEC", "O_NONBLOCK"):
    _LOCKED |= getattr(os, _name, 0)
GONE = (errno.ENOENT, errno.ENOTDIR, errno.ESTALE)


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
                f"{f' ({error.filename})' if error.filename else ''}. Stored tiles may be lost; --resume "
                "(resume=True) checks the others and continues"
            ) from error
        raise StoreError(
            f"{folder}: cannot be written: {reason}. What was stored before is whole; when that is mended, continue "
            "with --resume (resume=True)"
        ) from error


class Lock:
    """An exclusive lock on a file, which the system releases when the process ends, however it ends.

    Raises CaseError where another process holds it. On a file system without locks, or on Windows, it does nothing.
    """

    def __init__(self, path: Path):
        self._path = path
        self._handle = os.open(path, _LOCKED, 0o666)
        if not stat.S_ISREG(os.fstat(self._handle).st_mode):
            os.close(self._handle)
            raise OSError(errno.EINVAL, f"{path.name} is no plain file")
        try:
            import fcntl

            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:
            pass
        except BlockingIOError:
            holder = locks.in_words(locks.holder(self._handle))
            os.close(self._handle)
            raise CaseError([f"{holder} is writing there; wait for it, or end it"], str(path.parent)) from None
        except OSError as error:
            if error.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL):
                os.close(self._handle)
                raise

    def check(self) -> None:
        """StoreError where the folder is no longer the one that was locked."""
        mine = os.fstat(self._handle)
        try:
            now = os.lstat(self._path)
        except OSError:
            now = None
        if now is None or not os.path.samestat(mine, now):
            raise StoreError(
                f"{self._path.parent}: was removed or replaced while the study ran; its stored tiles are lost. "
                "Begin again, with --resume (resume=True) if some of it is back"
            )

    def release(self) -> None:
        os.close(self._handle)
