"""Checksums: of every file of a store, bound to the study and to the place to which it belongs.

A file that was cut short, altered, or put in the place of another one, of this study or of another, has another one.
Files are read as what they should be: plain, in their place, and not larger than they can be.
"""

import errno
import hashlib
import json
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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


LENGTH = 16  # bytes: no chance finds two alike
_LAST = b'"checksum": "'


class ChecksumError(ValueError):
    """A text that is not as it was written."""


def checksum(identity: str, place: str, data: bytes) -> str:
    """BLAKE2b of a file, of its place in the store, and of the study's identity."""
    digest = hashlib.blake2b(f"{identity} {place}\n".encode(), digest_size=LENGTH)
    digest.update(data)
    return digest.hexdigest()


def sealed(entries: Mapping[str, Any], identity: str, place: str) -> bytes:
    """A JSON object, a line for each entry, the last of them the checksum of those before."""
    texts = {key: json.dumps(value, ensure_ascii=False, allow_nan=False) for key, value in entries.items()}
    head = ("{\n" + "".join(f"{json.dumps(key)}: {text},\n" for key, text in texts.items())).encode()
    return head + _end(identity, place, head)


def unsealed(data: bytes, identity: str | None, place: str) -> dict[str, Any]:
    """The entries of a sealed text; ChecksumError where it is not whole. identity: None for that among its entries."""
    head, _, _ = data.rpartition(_LAST)
    try:
        entries = json.loads(data)
        entries.pop("checksum")
        identity = identity or str(entries["identity"])
    except (ValueError, LookupError, AttributeError, TypeError, RecursionError):
        raise ChecksumError("is cut short or altered") from None
    if data != head + _end(identity, place, head):
        raise ChecksumError("is altered: its checksum is of another content")
    return entries


def _end(identity: str, place: str, head: bytes) -> bytes:
    return _LAST + checksum(identity, place, head).encode() + b'"\n}\n'
