"""Files that are written whole or not at all, and the errors where they cannot be.

A result is written under a temporary name beside its place, forced to the disk and then renamed. So whoever looks sees
the old file or the new one, never half of it, whatever ends the writing: a full disk, an interrupt, a kill.

A link in place of a file is not followed: in a folder from a stranger it would lead to any other file.
"""

import contextlib
import csv
import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

PROTECTED: set[tuple[int, int]] = set()  # files (device, number) that are not replaced: those that a command has read
PART = ".part"  # before the ending of a temporary name, which writers look at
ABANDONED = 3600.0  # s without a change, after which a temporary file is one of a process that died
ESCAPED = "backslashreplace"  # what is done with characters that UTF-8 does not hold
FORMULAS = ("=", "+", "-", "@", "\t", "\r")  # what text begins with that spreadsheets run
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0)  # which follows no link either


class WriteError(OSError):
    """A file or folder that could not be written; the message names it and the reason. What was there before stays."""


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Gives the `with` block a temporary name to write to; what stands there at its end takes the place of `path`.

    The temporary name lies beside `path` and has its ending. The rights of a file that is replaced are kept, a link to
    a file is refused, and what is no file (a pipe that someone reads, a device) is written to directly.

    Raises WriteError for each error of the file system in the block. Whatever is raised there, the temporary file is
    removed and `path` is as before.
    """
    path = Path(path)
    with _said(path):
        if reason := other_place(path):
            raise OSError(errno.ELOOP, reason, str(path))
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file() and not target.is_dir():
            with _read_by_someone(target):
                yield target
            return
        temporary = _begun(target)
        try:
            yield temporary
            _force(temporary, os.O_RDWR)
            os.replace(temporary, target)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
        if os.name == "posix":
            with contextlib.suppress(OSError):  # the new file is whole and in its place
                _force(target.parent, os.O_RDONLY)  # its name too


def other_place(path: Path) -> str | None:
    """The reason why writing to a path would replace another file; None where it would not."""
    if path.is_symlink() and (path.is_file() or not path.exists()):
        return f"it is a link to {os.path.realpath(path)}; give the name of a file"
    with contextlib.suppress(OSError):
        status = path.stat()
        if (status.st_dev, status.st_ino) in PROTECTED:
            return "it is read by this command; give another name"
    return None


@contextlib.contextmanager
def _read_by_someone(path: Path) -> Iterator[None]:
    """Within it a pipe can be written to; OSError where nobody reads from it, which to open it would wait for."""
    if not path.is_fifo():
        yield
        return
    handle = os.open(path, os.O_WRONLY | os.O_NONBLOCK)  # kept open: else the reader sees an end
    try:
        yield
    finally:
        os.close(handle)


def write_text(path: str | Path, text: str) -> Path:
    """Write a text file in UTF-8, whole or not at all; WriteError where that cannot be.

    Bytes of a file name that are not UTF-8, which Python holds as half characters, become escapes such as \\udcff.
    """
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors=ESCAPED, newline="\n")
    return Path(path)


def write_table(path: str | Path, headings: Iterable[str], rows: Iterable[Iterable[Any]]) -> Path:
    """Write a table as CSV, whole or not at all, floats in full precision; WriteError where that cannot be."""
    with replacing(path) as temporary:
        fill_table(temporary, headings, (map(no_formula, row) for row in rows))
    return Path(path)


def fill_table(path: Path, headings: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """The same to the temporary name that `replacing` gives, cells as they are.

    A name in a stranger's file may be a formula, "=cmd|...", which a spreadsheet would run: see `no_formula`.
    """
    with path.open("w", encoding="utf-8", errors=ESCAPED, newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(map(no_formula, headings))
        table.writerows(rows)


def no_formula(cell: Any) -> Any:
    """A cell of a table, behind an apostrophe where a spreadsheet would take its text for a formula."""
    if not isinstance(cell, str) or not cell.startswith(FORMULAS):
        return cell
    try:
        float(cell)  # a number with its sign
    except ValueError:
        return f"'{cell}"
    return cell


def made_folder(folder: str | Path, own: bool = False) -> Path:
    """A folder, made with those above it where it is missing; WriteError where that cannot be.

    own: its last name is not the user's but ours; then it may be no link
    """
    folder = Path(folder)
    try:
        if own and folder.is_symlink():
            raise OSError(errno.ELOOP, f"it is a link to {os.path.realpath(folder)}")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"{folder}: this folder cannot be made: {_reason(error, folder)}") from error
    return folder


@contextlib.contextmanager
def _said(path: Path) -> Iterator[None]:
    """Errors of the file system in the `with` block are WriteErrors about this file."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        stays = "the file that is there is as before" if path.is_file() else "nothing was written"
        raise WriteError(f"{path}: cannot be written: {_reason(error, path)}; {stays}") from error


def _reason(error: OSError, path: Path) -> str:
    """What went wrong, with the name of another file that it was about."""
    if error.errno == errno.ENOENT and not path.parent.exists():
        return f"there is no folder {str(path.parent)!r}"
    reason = error.strerror or str(error) or type(error).__name__
    about = error.filename if isinstance(error.filename, str) else ""
    return reason if PART in about or about in ("", str(path)) else f"{reason} ({about})"


def _begun(target: Path) -> Path:
    """A new temporary file beside a target; what dead processes left of earlier ones is removed."""
    rights = 0o666
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if target.exists():
        if not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
        rights = stat.S_IMODE(target.stat().st_mode)
    prefix, ending = f".{target.stem[:40]}-", f"{PART}{target.suffix}"
    _remove_abandoned(target.parent, re.compile(f"{re.escape(prefix)}[0-9a-f]{{12}}{re.escape(ending)}"))
    temporary = target.with_name(f"{prefix}{secrets.token_hex(6)}{ending}")
    handle = os.open(temporary, _NEW, 0o666)
    os.close(handle)
    if rights != 0o666:
        with contextlib.suppress(OSError):
            os.chmod(temporary, rights)
    return temporary


def _remove_abandoned(folder: Path, form: re.Pattern[str]) -> None:
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if form.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with contextlib.suppress(OSError):
                    if time.time() - entry.stat(follow_symlinks=False).st_mtime > ABANDONED:
                        os.unlink(entry.path)


def _force(path: Path, how: int) -> None:
    """Force a file, or the names in a folder, to the disk where the system can."""
    handle = os.open(path, how)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(handle)
