"""The folder of a study: every file in it is read, written and removed through here, and no link is followed.

A folder may come from a stranger, or be changed by one: a link in it would lead what is written or removed to other
files. So a place is reached from the study's folder step by step, by handles of folders that are no links; what is
written is a new file, renamed to its place; what is removed is one plain file, or an empty folder. The folder of the
study itself may be reached by a link: it is where whoever asks for it says. A lock keeps a second writer out.
"""

import contextlib
import errno
import itertools
import os
import re
import socket
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

from vibrocap import locks
from vibrocap.case.case import CaseError
from vibrocap.files import WriteError

STUDY, RESULTS, DONE = "study.json", "results.zarr", "done"
LOCK, UNFINISHED, BEGINNING, MIXED, FINISHED = "lock", "unfinished", "beginning", "mixed", "finished"
FILE, FOLDER, LINK, OTHER = "a file", "a folder", "a link", "neither a file nor a folder"
FORM = {  # of what stands at the top
    **dict.fromkeys((STUDY, LOCK, BEGINNING, MIXED, FINISHED), FILE),
    **dict.fromkeys((RESULTS, DONE, UNFINISHED), FOLDER),
}
STRANGE = (errno.ELOOP, errno.EMLINK, errno.EISDIR, errno.ENXIO, errno.EINVAL, errno.EFBIG, errno.ENOTDIR)
GONE = (errno.ENOENT, errno.ENOTDIR, errno.ESTALE)
_NO_LINKS, _CLOSED, _BINARY, _AT_ONCE, _FOLDER = (
    getattr(os, f"O_{name}", 0) for name in ("NOFOLLOW", "CLOEXEC", "BINARY", "NONBLOCK", "DIRECTORY")
)
_READ = os.O_RDONLY | _NO_LINKS | _CLOSED | _BINARY | _AT_ONCE
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL  # which follows no link either
_FOLDERS = os.O_RDONLY | _FOLDER | _CLOSED
_LOCKED = os.O_RDWR | os.O_CREAT | _NO_LINKS | _CLOSED | _AT_ONCE  # no link, and a pipe is not waited for
_BY_HANDLE = bool(_NO_LINKS) and os.open in os.supports_dir_fd and os.scandir in os.supports_fd
_ON_ITS_WAY = re.compile(r"[\w.-]+-\d+-\d+")  # computer, process, number
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


@contextlib.contextmanager
def at(root: Path, place: str) -> Iterator[tuple[str, int | None]]:
    """(name, handle of its folder) of a place below a folder, for functions that take `dir_fd`.

    OSError with an `errno` of STRANGE where a link is on the way, or a name that no file can have. Without handles
    (Windows) each step is looked at.
    """
    *steps, name = place.split("/")
    try:
        if not _BY_HANDLE:
            for step in steps:
                root = root / step
                if root.is_symlink() or getattr(root, "is_junction", bool)():
                    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(root))
            yield str(root / name), None
            return
        handle = os.open(root, _FOLDERS)
        try:
            for number, step in enumerate(steps, 1):
                try:
                    inner = os.open(step, _FOLDERS | _NO_LINKS, dir_fd=handle)
                except OSError as error:
                    code = errno.ELOOP if _kind(step, handle) == LINK else error.errno or 0
                    raise OSError(code, os.strerror(code), str(root.joinpath(*steps[:number]))) from None
                os.close(handle)
                handle = inner
            yield name, handle
        finally:
            os.close(handle)
    except ValueError as error:  # of `os`: a name with a zero byte, or with half a character
        raise OSError(errno.EINVAL, f"is no name of a file ({error})", str(root / place)) from None


def _kind(name: str, folder: int | None) -> str | None:
    try:
        mode = os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode
    except FileNotFoundError:
        return None
    return FILE if stat.S_ISREG(mode) else FOLDER if stat.S_ISDIR(mode) else LINK if stat.S_ISLNK(mode) else OTHER


def kind(root: Path, place: str) -> str | None:
    """What stands at a place: FILE, FOLDER, LINK, OTHER; None for nothing."""
    try:
        with at(root, place) as (name, folder):
            return _kind(name, folder)
    except FileNotFoundError:
        return None


def names(root: Path, place: str = "") -> dict[str, str]:
    """What stands in a folder, by name: FILE, FOLDER, LINK or OTHER. FileNotFoundError where there is none."""
    with at(root, f"{place}/." if place else ".") as (name, folder):
        handle = os.open(name, _FOLDERS, dir_fd=folder) if folder is not None else None
        try:
            with os.scandir(name if handle is None else handle) as entries:
                return {entry.name: _kind_of(entry) for entry in entries}
        finally:
            if handle is not None:
                os.close(handle)


def _kind_of(entry: "os.DirEntry[str]") -> str:
    if entry.is_symlink() or getattr(entry, "is_junction", bool)():
        return LINK
    return FILE if entry.is_file() else FOLDER if entry.is_dir() else OTHER


def read_plain(root: Path, place: str, limit: int) -> bytes:
    """The content of a file that is no link, pipe or device, and holds no more than so many bytes.

    Raises FileNotFoundError, and OSError with an `errno` of STRANGE for what is something else.
    """
    with at(root, place) as (name, folder):
        handle = os.open(name, _READ, dir_fd=folder)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "is no plain file", str(root / place))
    with os.fdopen(handle, "rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise OSError(errno.EFBIG, f"is larger than {limit:,} bytes", str(root / place))
    return data


def why_strange(error: OSError) -> str:
    if error.errno in (errno.ELOOP, errno.EMLINK):
        return "is a link"
    if error.errno in (errno.EISDIR, errno.ENOTDIR):
        return "is no file"
    return error.strerror or str(error)


def why_unread(error: OSError) -> str:
    return why_strange(error) if error.errno in STRANGE else f"cannot be read: {error.strerror}"


def make_folder(root: Path, place: str) -> None:
    with at(root, place) as (name, folder), contextlib.suppress(FileExistsError):
        os.mkdir(name, dir_fd=folder)


def remove(root: Path, place: str) -> None:
    """Remove a plain file, or an empty folder, if it is there; what is neither, or holds something, is an OSError."""
    with contextlib.suppress(FileNotFoundError), at(root, place) as (name, folder):
        place_kind = _kind(name, folder)
        if place_kind == FOLDER:
            os.rmdir(name, dir_fd=folder)
        elif place_kind == FILE:
            os.unlink(name, dir_fd=folder)
        elif place_kind is not None:
            raise OSError(errno.EINVAL, f"is {place_kind}", str(root / place))


def write(root: Path, files: Mapping[str, bytes]) -> None:
    """Write files by their places; on return they and their names are on the disk.

    Each is written in the folder `unfinished`, forced to the disk, and renamed. `files.replacing` does this for single
    files; it looks through their folder for what dead processes left, which would take longer with every tile.
    Their folders should be there: one that went away is no place to go on in.
    """
    make_folder(root, UNFINISHED)
    with at(root, f"{UNFINISHED}/.") as (_, unfinished):
        for place, data in files.items():
            temporary, handle = _new_file(root, unfinished)
            try:
                try:
                    rest = memoryview(data)
                    while rest:
                        rest = rest[os.write(handle, rest) :]
                    os.fsync(handle)
                finally:
                    os.close(handle)
                with at(root, place) as (name, folder):
                    os.replace(temporary, name, src_dir_fd=unfinished, dst_dir_fd=folder)
            except BaseException:
                with contextlib.suppress(OSError):
                    os.unlink(temporary, dir_fd=unfinished)
                raise
    paths = [place.split("/") for place in files]
    for folder in sorted({"/".join(steps[:deep]) for steps in paths for deep in range(len(steps))}):
        force_names(root, folder)


def _new_file(root: Path, unfinished: int | None) -> tuple[str, int]:
    """A new file among the unfinished ones: its name, for functions that take `dir_fd`, and its handle."""
    host = re.sub(r"[^\w.-]", "_", socket.gethostname()) or "host"
    while True:
        temporary = f"{host}-{os.getpid()}-{next(_numbers)}"
        temporary = temporary if unfinished is not None else str(root / UNFINISHED / temporary)
        with contextlib.suppress(FileExistsError):  # left by a process of the same number
            binary = getattr(os, "O_BINARY", 0)  # without it Windows writes \r\n for \n
            return temporary, os.open(temporary, _NEW | binary, 0o666, dir_fd=unfinished)


def rename(root: Path, old: str, new: str) -> None:
    """Give a file at the top of the folder another name there."""
    with at(root, old) as (name, folder):
        os.replace(name, new if folder is not None else str(root / new), src_dir_fd=folder, dst_dir_fd=folder)
    force_names(root)


def force_names(root: Path, place: str = "") -> None:
    """Force the names in a folder to the disk, where the system can."""
    if os.name != "posix":
        return
    with at(root, f"{place}/." if place else ".") as (_, folder):
        try:
            os.fsync(folder or 0)
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOTSUP):
                raise


def remove_unfinished(root: Path) -> None:
    """Remove what unfinished writing left, and nothing else."""
    with contextlib.suppress(FileNotFoundError):
        for name, place in names(root, UNFINISHED).items():
            if place == FILE and _ON_ITS_WAY.fullmatch(name):
                remove(root, f"{UNFINISHED}/{name}")
        try:
            remove(root, UNFINISHED)
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise


def strange_places(root: Path) -> list[str]:
    """What in the folder of a study is not of the form that this package gives it, which is for its owner to remove.

    Links, pipes and devices, files where folders belong, folders with something in them where files belong, and what
    is no file of ours among the unfinished ones. A damaged file is none of these: it is written anew.
    """
    places = []
    for name, there in sorted(names(root).items()):
        if name in FORM and there != FORM[name] and not (there == FOLDER and not names(root, name)):
            places.append(f"{name} is {there}, where {FORM[name]} belongs")
    if not places:
        for place in [place for place in (RESULTS, DONE, UNFINISHED) if kind(root, place) == FOLDER]:
            places += _strange_below(root, place, 1 if place == RESULTS else 0)
    return places


def _strange_below(root: Path, place: str, deep: int) -> list[str]:
    """The same below a folder; deep: of how many folders."""
    strange = []
    for name, there in sorted(names(root, place).items()):
        inner = f"{place}/{name}"
        if there == FOLDER and deep:
            strange += _strange_below(root, inner, deep - 1)
        elif there == FOLDER and names(root, inner):
            strange.append(f"{inner} is a folder with something in it, where a file belongs")
        elif there in (LINK, OTHER):
            strange.append(f"{inner} is {there}")
        elif place == UNFINISHED and there == FILE and not _ON_ITS_WAY.fullmatch(name):
            strange.append(f"{inner} does not belong to the study")
    return strange
