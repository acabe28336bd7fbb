"""Marks: a file per stored tile, with the checksums of its chunks, written last: a tile that is marked is whole.

Checksums are bound to the study and to the place to which a file belongs: one that was cut short, altered, or put in
place of another one, of this study or of another, has another one. One file more says that all tiles are stored:
then a tile without a mark has lost it.
"""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrocap.studies.store.places import DONE, FINISHED, RESULTS, STRANGE, read_plain, why_strange

LENGTH = 16  # bytes: no chance finds two alike
_LAST = b'"checksum": "'
LARGEST = 2**20  # bytes of a mark
LARGEST_CHUNK = 2**30

Index = tuple[int, ...]


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


class DamageError(OSError):
    """Something stored that is not as it was written; the message says what."""


@dataclasses.dataclass(frozen=True)
class Mark:
    """What a mark says: the checksum of each chunk of its tile by array.

    made_by: with what the tile was computed, where that is not with what the study was begun.
    """

    chunks: Mapping[str, str]
    made_by: Mapping[str, str] | None = None


def tile_name(index: Index) -> str:
    """The name of a tile's mark, such as "3.0"."""
    return ".".join(map(str, index))


def chunk_place(name: str, index: Index) -> str:
    """Where a chunk stands among the results."""
    return f"{name}/c.{tile_name(index)}"


def mark_text(identity: str, index: Index, chunks: Mapping[str, bytes], made_by: Mapping[str, str] | None) -> bytes:
    """The content of a mark; chunks: the files of the tile by their place."""
    sums = {place.partition("/")[0]: checksum(identity, place, data) for place, data in chunks.items()}
    entries: dict[str, Any] = {"chunks": sums} | ({"made_by": dict(made_by)} if made_by else {})
    return sealed(entries, identity, f"{DONE}/{tile_name(index)}")


def read_mark(path: Path, record: Mapping[str, Any], index: Index) -> Mark | None:
    """The mark of a tile of the store at a path; None where it has none. DamageError where it is damaged."""
    try:
        data = _read(path, f"{DONE}/{tile_name(index)}", LARGEST, "its mark")
    except FileNotFoundError:
        return None
    try:
        entries = unsealed(data, record["identity"], f"{DONE}/{tile_name(index)}")
        return Mark(entries["chunks"], entries.get("made_by"))
    except ChecksumError as error:
        raise DamageError(f"its mark {error}") from None


def is_mark(path: Path, name: str) -> bool:
    """Whether a file among the marks was written as one, of whichever tile and study."""
    try:
        entries = json.loads(read_plain(path, f"{DONE}/{name}", LARGEST))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(entries, dict) and entries.keys() - {"made_by"} == {"chunks", "checksum"}


def finished_text(identity: str, tiles: int) -> bytes:
    """The content of the file that says that all tiles are stored."""
    return sealed({"tiles": tiles}, identity, FINISHED)


def is_finished(path: Path, record: Mapping[str, Any]) -> bool:
    """Whether a store says that all of its tiles were stored; DamageError where what says so is damaged."""
    try:
        unsealed(_read(path, FINISHED, LARGEST, FINISHED), record["identity"], FINISHED)
    except FileNotFoundError:
        return False
    except ChecksumError as error:
        raise DamageError(f"{FINISHED} {error}") from None
    return True


def read_chunk(path: Path, record: Mapping[str, Any], name: str, index: Index, mark: Mark) -> bytes:
    """A chunk of a marked tile; DamageError where it is missing or not as it was written."""
    return _checked(path, record, chunk_place(name, index), mark.chunks.get(name), name)


def read_first(path: Path, record: Mapping[str, Any], place: str) -> bytes:
    """A file of the results that belongs to no tile; DamageError where it is missing or not as it was written."""
    return _checked(path, record, place, record["files"].get(place), f"{RESULTS}/{place}")


def _checked(path: Path, record: Mapping[str, Any], place: str, wanted: str | None, what: str) -> bytes:
    """A file of the results that has the checksum that is wanted of it."""
    try:
        data = _read(path, f"{RESULTS}/{place}", LARGEST_CHUNK, what)
    except FileNotFoundError:
        raise DamageError(f"{what} is missing") from None
    if wanted != checksum(record["identity"], place, data):
        raise DamageError(f"{what} is altered: its checksum is of another content")
    return data


def _read(path: Path, place: str, limit: int, what: str) -> bytes:
    try:
        return read_plain(path, place, limit)
    except OSError as error:
        if error.errno in STRANGE:
            raise DamageError(f"{what} {why_strange(error)}") from None
        raise
