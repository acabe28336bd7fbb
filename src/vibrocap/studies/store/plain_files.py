"""Files read as what they should be: plain, in their place, and not larger than they can be."""

import errno
import os
import stat
from pathlib import Path

_FLAGS = os.O_RDONLY
for _name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"):
    _FLAGS |= getattr(os, _name, 0)
STRANGE = (errno.ELOOP, errno.EMLINK, errno.EISDIR, errno.ENXIO, errno.EINVAL, errno.EFBIG, errno.ENOTDIR)


def read_plain(path: Path, limit: int) -> bytes:
    """The content of a file that is no link, pipe or device, and holds no more than so many bytes.

    Raises FileNotFoundError, and OSError with an `errno` of STRANGE for what is something else.
    """
    handle = os.open(path, _FLAGS)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "is no plain file", str(path))
    with os.fdopen(handle, "rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise OSError(errno.EFBIG, f"is larger than {limit:,} bytes", str(path))
    return data


def why_strange(error: OSError) -> str:
    """What such a file is, in words."""
    if error.errno in (errno.ELOOP, errno.EMLINK):
        return "is a link"
    if error.errno in (errno.EISDIR, errno.ENOTDIR):
        return "is no file"
    return error.strerror or str(error)
