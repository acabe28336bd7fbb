"""Checksums: of every file of a store, bound to the study and to the place to which it belongs.

A file that was cut short, altered, or put in place of another one, of this study or of another, has another one.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

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
