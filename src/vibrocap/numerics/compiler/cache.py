"""Object files kept on disk for the next process, in a folder and in files that nobody else can have written.

A file is named by a hash of all that decides its content, and begins with a hash of its content and that name: what was
damaged, cut short, renamed or edited is not used, and written anew. It appears whole or not at all.
"""

import atexit
import contextlib
import functools
import hashlib
import os
import pathlib
import re
import secrets
import shutil
import stat
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator

from vibrocap import locks

HEAD = b"vibrocap kernel 1\n"
SUFFIX = ".kernel"
LIMIT = 256 * 2**20  # bytes of all object files; beyond it those used longest ago go
ABANDONED = 3600.0  # s, after which a temporary file is one of a process that died
_NO_LINKS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_NO_WAITING = _NO_LINKS | getattr(os, "O_NONBLOCK", 0)  # in the place of a file there may be a pipe
_KERNEL = re.compile(r"[0-9a-f]{40}\.kernel")  # files of ours; others in the folder are let alone
_ON_ITS_WAY = re.compile(r"\.[0-9a-f]{40}\.[0-9a-f]{16}\.tmp")
PATIENCE = 60.0  # s for which another process may make a kernel
STOPPED = 1.0  # s for which one may that is stopped
PAUSES = 0.01, 0.2  # s between two looks, at first and at last
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def foreign(status: os.stat_result) -> str | None:
    """Why a file or folder may have been written by others; None if it cannot."""
    if not hasattr(os, "geteuid"):
        return None  # rights are kept elsewhere there
    if status.st_uid != os.geteuid():
        return f"belongs to user {status.st_uid}"
    return "can be written by others" if status.st_mode & _OTHERS_WRITE else None


def _problem(folder: pathlib.Path) -> str | None:
    """Why a folder, made where there is none, is not to be trusted; raises OSError where it cannot be had at all."""
    try:
        status = os.lstat(folder)
    except FileNotFoundError:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        status = os.lstat(folder)
    if stat.S_ISLNK(status.st_mode):
        return "is a symbolic link"
    if not stat.S_ISDIR(status.st_mode):
        return "is no folder"
    return foreign(status)


def _wanted_folder() -> pathlib.Path | None:
    """VIBROCAP_CACHE, else the user's cache folder; None where there is no home."""
    named = os.environ.get("VIBROCAP_CACHE")
    if named:
        return pathlib.Path(named)
    base = os.environ.get("XDG_CACHE_HOME")
    if base and os.path.isabs(base):
        return pathlib.Path(base) / "vibrocap"
    try:
        return pathlib.Path.home() / ".cache" / "vibrocap"
    except (RuntimeError, KeyError):  # neither HOME nor an entry in the list of users
        return None


@functools.cache
def folder() -> pathlib.Path:
    """Where object files are kept: where VIBROCAP_CACHE says, else in the user's cache folder.

    Where others can write there, in a temporary folder of this process, with a warning; without one where the folder
    cannot be made at all.
    """
    wanted = _wanted_folder()
    if wanted is not None:
        try:
            problem = _problem(wanted)
        except OSError:
            problem = ""
        if problem is None:
            return wanted
        if problem:
            warnings.warn(
                f"kernels are not kept in {wanted}: it {problem}. Each process makes them anew; to keep them, let "
                "VIBROCAP_CACHE name a folder of your own that only you can write (chmod go-w)",
                RuntimeWarning,
                stacklevel=2,
            )
    return _temporary_folder()


@functools.cache
def _temporary_folder() -> pathlib.Path:
    """A folder of this process, removed at its end."""
    temporary = pathlib.Path(tempfile.mkdtemp(prefix="vibrocap-"))
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    return temporary


def key(*parts: str) -> str:
    """The name of an object file, from all that decides its content."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:40]


def _digest(name: str, code: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + code).digest()


def place(name: str) -> pathlib.Path:
    """Where the object file of this name is kept."""
    return folder() / (name + SUFFIX)


def kept(name: str) -> bytes | None:
    """The object file of this name; None where there is none that is whole and our own."""
    path = place(name)
    try:
        handle = os.open(path, os.O_RDONLY | _NO_WAITING)
    except OSError:
        return None
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode) or foreign(status) is not None:
            return None
        try:
            content = file.read(LIMIT)
        except OSError:
            return None
    start = len(HEAD) + 32
    code = content[start:]
    if content[: len(HEAD)] != HEAD or content[len(HEAD) : start] != _digest(name, code):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used just now
    return code


def keep(name: str, code: bytes) -> None:
    """Keep an object file for the next process; where that fails, it makes its own."""
    path = place(name)
    temporary = path.with_name(f".{name}.{secrets.token_hex(8)}.tmp")
    with contextlib.suppress(OSError):
        try:
            handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINKS, 0o600)
            with os.fdopen(handle, "wb") as file:
                file.write(HEAD + _digest(name, code) + code)
                file.flush()
                os.fsync(handle)
            os.replace(temporary, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder()
        _evict(path)


def _sync_folder() -> None:
    """The new name is on the disk too."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder(), os.O_RDONLY | os.O_DIRECTORY | _NO_LINKS)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _evict(newest: pathlib.Path) -> None:
    """Remove the object files used longest ago beyond the limit, and what dead processes left."""
    files = []
    with os.scandir(folder()) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if not stat.S_ISREG(status.st_mode):
                    continue
                if _ON_ITS_WAY.fullmatch(entry.name) and time.time() - status.st_mtime > ABANDONED:
                    os.unlink(entry.path)
                elif _KERNEL.fullmatch(entry.name):
                    files.append((status.st_mtime, status.st_size, entry.path))
    total = sum(size for _, size, _ in files)
    for _, size, path in sorted(files):
        if total <= LIMIT:
            break
        if path != str(newest):
            with contextlib.suppress(OSError):
                os.unlink(path)
                total -= size


@contextlib.contextmanager
def one_process_at_a_time(name: str) -> Iterator[None]:
    """Processes that want the same kernel wait for the first to make it (where the system can lock files).

    After a minute, or at once for a process that is stopped, each makes its own, with a warning that says who was
    waited for.
    """
    try:
        import fcntl

        # A few files serve all kernels, so that none need ever be removed.
        handle = os.open(folder() / f".lock-{name[0]}", os.O_RDWR | os.O_CREAT | _NO_WAITING, 0o600)
    except (ImportError, OSError):  # a folder that cannot be written, or a link in the place of the lock
        yield
        return
    try:
        with contextlib.suppress(OSError):  # a folder on a network that has no locks
            _wait_for(lambda: fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB), handle)
        yield
    finally:
        os.close(handle)


def _wait_for(lock: Callable[[], None], handle: int) -> None:
    """Take a lock, or give it up after a while, with a warning."""
    begun, (pause, longest) = time.monotonic(), PAUSES
    while True:
        try:
            return lock()
        except BlockingIOError:
            waited, holder = time.monotonic() - begun, locks.holder(handle)
        if waited > (STOPPED if locks.is_stopped(holder) else PATIENCE):
            words = f"{locks.in_words(holder)} has kept its lock in {folder()} for {waited:.0f} s"
            warnings.warn(f"a kernel is made anew: {words}", RuntimeWarning, stacklevel=2)
            return None
        time.sleep(pause)
        pause = min(2.0 * pause, longest)
