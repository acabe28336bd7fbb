"""Files that are read: plain ones, whole, and pipes for as long as someone writes into them.

What a user or a stranger names as a file may be a pipe into which nobody writes; then to open it, or to read it, would
wait without end and without a word.
"""

import errno
import os
import select
import stat
from collections.abc import Callable
from pathlib import Path

PATIENCE = 10.0  # s for which nothing may come from a pipe
READING = os.O_RDONLY  # how a file is opened that may be a pipe
for _name in ("O_NONBLOCK", "O_CLOEXEC", "O_BINARY"):
    READING |= getattr(os, _name, 0)
PIECE = 2**20  # bytes
READ: set[tuple[int, int]] = set()  # files (device, number) that were read


def read_input(path: str | Path, most: int) -> bytes:
    """The content of a file that a user names, at most so many bytes; of a pipe or a device what comes until its end.

    Within a command such a file is not replaced; what a command continues and writes anew it reads with `read_own`.
    Raises OSError: that of a file that cannot be read, TimeoutError where nothing comes from a pipe for ten seconds.
    """
    return _read(path, most, READ.add)


def read_own(path: str | Path, most: int) -> bytes:
    """The same of a file that an earlier run of the command wrote, and that this one may replace."""
    return _read(path, most, lambda identity: None)


def _read(path: str | Path, most: int, note: Callable[[tuple[int, int]], None]) -> bytes:
    with os.fdopen(os.open(path, READING), "rb", buffering=0) as file:
        status = os.fstat(file.fileno())
        note((status.st_dev, status.st_ino))
        if stat.S_ISREG(status.st_mode) or os.name != "posix":
            pieces, left = [], most
            while left > 0 and (piece := file.read(min(left, 64 * PIECE))):
                pieces.append(piece)
                left -= len(piece)
            return b"".join(pieces)
        found = bytearray()
        while len(found) < most:
            if not select.select([file], [], [], PATIENCE)[0]:
                words = f"is a pipe or a device, from which nothing came for {PATIENCE:g} s; give a file"
                raise TimeoutError(errno.ETIMEDOUT, words, str(path))
            piece = file.read(min(PIECE, most - len(found)))
            if piece == b"":
                break
            found += piece or b""
        return bytes(found)


def require_plain_file(path: str | Path) -> None:
    """OSError for a pipe, a device or a folder: of those a library that opens files by name would wait for ever."""
    status = os.stat(path)
    READ.add((status.st_dev, status.st_ino))
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "is a folder", str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "is a pipe or a device; give a file", str(path))
