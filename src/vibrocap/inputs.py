"""Files that are read: plain ones, whole, and pipes for as long as someone writes into them.

What a user or a stranger names as a file may be a pipe into which nobody writes; then to open it, or to read it, would
wait without end and without a word.
"""

import errno
import os
import select
import stat
from pathlib import Path

PATIENCE = 10.0  # s for which nothing may come from a pipe
READING = os.O_RDONLY  # how a file is opened that may be a pipe
for _name in ("O_NONBLOCK", "O_CLOEXEC", "O_BINARY"):
    READING |= getattr(os, _name, 0)
PIECE = 2**20  # bytes
READ: set[tuple[int, int]] = set()  # files (device, number) that were read


def read_input(path: str | Path, most: int) -> bytes:
    """The content of a file that a user names; within a command it is not replaced. Otherwise as `read_own`."""
    _noted(path)
    return read_own(path, most)


def read_own(path: str | Path, most: int) -> bytes:
    """The content of a file, a pipe or a device until its end; at most so many bytes.

    Commands read their own earlier files with it, which they may replace.
    Raises OSError: that of a file that cannot be read, TimeoutError where nothing comes from a pipe for ten seconds.
    """
    with os.fdopen(os.open(path, READING), "rb", buffering=0) as file:
        status = os.fstat(file.fileno())
        if stat.S_ISREG(status.st_mode) or os.name != "posix":
            pieces, left = [], most
            while left > 0 and (piece := file.read(min(left, 64 * PIECE))):
                pieces.append(piece)
                left -= len(piece)
            return b"".join(pieces)
        content = bytearray()
        while len(content) < most:
            if not select.select([file], [], [], PATIENCE)[0]:
                words = f"is a pipe or a device, from which nothing came for {PATIENCE:g} s; give a file"
                raise TimeoutError(errno.ETIMEDOUT, words, str(path))
            piece = file.read(min(PIECE, most - len(content)))
            if piece == b"":
                break
            content += piece or b""
        return bytes(content)


def require_plain_file(path: str | Path) -> None:
    """OSError for a pipe, a device or a folder: of those a library that opens files by name would wait for ever."""
    status = _noted(path)
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "is a folder", str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "is a pipe or a device; give a file", str(path))


def _noted(path: str | Path) -> os.stat_result:
    """The status of a file that is an input."""
    status = os.stat(path)
    READ.add((status.st_dev, status.st_ino))
    return status
