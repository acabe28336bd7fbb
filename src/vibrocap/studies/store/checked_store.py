"""A store as Zarr reads it: what was looked at, chunks as they were written, and nothing else."""

from collections.abc import AsyncIterator, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from zarr.abc.store import ByteRequest, Store
from zarr.core.buffer import Buffer, BufferPrototype, default_buffer_prototype

from vibrocap.studies.store.marks import DamageError, read_chunk, read_first, read_mark
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.store.zarr_form import TEXT, Results

LONGEST_WORD = 1024  # bytes; words of phases have 104 letters at most
ZSTD = b"\x28\xb5\x2f\xfd"


class CheckedStore(Store):
    """The results of a study for Zarr, to be read only.

    Chunks are compared with their checksums, and may not ask for more memory than an array of their size takes, before
    Zarr gets them. A tile without a mark is not there, even if some of its chunks are.
    """

    def __init__(self, path: Path, record: Mapping[str, Any], results: Results):
        super().__init__(read_only=True)
        self.path, self.record, self.results = path, record, results

    def __eq__(self, value: object) -> bool:
        return isinstance(value, CheckedStore) and (value.path, value.record) == (self.path, self.record)

    @property
    def supports_writes(self) -> bool:
        """No."""
        return False

    @property
    def supports_deletes(self) -> bool:
        """No."""
        return False

    @property
    def supports_listing(self) -> bool:
        """Of what was looked at."""
        return True

    def content(self, key: str) -> bytes | None:
        """What stands at a place; None where nothing does. StoreError where it is damaged."""
        if key in self.results.metadata:
            return self.results.metadata[key]
        name, _, chunk = key.partition("/c.")
        array = self.results.arrays.get(name)
        if array is None or not chunk:
            return None
        try:
            if not array.along_runs:
                data = read_first(self.path, self.record, key)
            else:
                index = tuple(map(int, chunk.split(".")))
                mark = read_mark(self.path, self.record, index)
                if mark is None:
                    return None
                data = read_chunk(self.path, self.record, name, index, mark)
            _check_content(name, data, array.chunk_size, self.results.types[name])
        except DamageError as error:
            what = f"tile {chunk}: {error}" if array.along_runs else str(error)
            raise StoreError(
                f"{self.path}: is damaged: {what}. `vibrocap verify` names all damage, the sweep with --resume "
                "(resume=True) mends it"
            ) from None
        return data

    async def get(
        self, key: str, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        """What stands at a place."""
        if byte_range is not None:
            raise NotImplementedError("a store is read chunk by chunk")
        data = self.content(key)
        return None if data is None else (prototype or default_buffer_prototype()).buffer.from_bytes(data)

    async def get_partial_values(
        self, prototype: BufferPrototype, key_ranges: Iterable[tuple[str, ByteRequest | None]]
    ) -> list[Buffer | None]:
        """What stands at several places."""
        return [await self.get(key, prototype, byte_range) for key, byte_range in key_ranges]

    async def exists(self, key: str) -> bool:
        """Whether something stands at a place."""
        return self.content(key) is not None

    async def list(self) -> AsyncIterator[str]:
        """All that says what the arrays are."""
        for key in self.results.metadata:
            yield key

    async def list_prefix(self, prefix: str) -> AsyncIterator[str]:
        """The same below a place."""
        for key in self.results.metadata:
            if key.startswith(prefix):
                yield key

    async def list_dir(self, prefix: str) -> AsyncIterator[str]:
        """The same directly below a place."""
        below = f"{prefix.rstrip('/')}/" if prefix else ""
        for name in dict.fromkeys(
            key.removeprefix(below).partition("/")[0] for key in self.results.metadata if key.startswith(below)
        ):
            yield name

    async def set(self, key: str, value: Buffer) -> None:
        """Nothing is written."""
        self._check_writable()

    async def delete(self, key: str) -> None:
        """Nothing is removed."""
        self._check_writable()


def _check_content(name: str, data: bytes, values: int, kind: str) -> None:
    """DamageError for a chunk that does not unpack to so many values."""
    from numcodecs.vlen import VLenUTF8
    from numcodecs.zstd import decompress

    size = unpacked_size(data)
    room = 4 + values * (4 + LONGEST_WORD) if kind == TEXT else values * np.dtype(kind).itemsize
    if size is None or size > room or (kind != TEXT and size != room):
        raise DamageError(f"{name} is no array of {values:,} values")
    try:
        unpacked = decompress(data)
        if kind == TEXT:
            if int.from_bytes(bytes(unpacked[:4]), "little") != values:
                raise ValueError
            VLenUTF8().decode(unpacked)
    except (ValueError, RuntimeError):
        raise DamageError(f"{name} is no array of {values:,} values") from None


def unpacked_size(data: bytes) -> int | None:
    """Bytes that a Zstandard frame says it unpacks to; None where it does not say.   RFC 8878, section 3.1.1"""
    if data[:4] != ZSTD or len(data) < 6:
        return None
    descriptor = data[4]
    single, flag = bool(descriptor & 0x20), descriptor >> 6
    start = 5 + (not single) + (0, 1, 2, 4)[descriptor & 3]
    length = (int(single), 2, 4, 8)[flag]
    if not length or len(data) < start + length:
        return None
    return int.from_bytes(data[start : start + length], "little") + (256 if flag == 1 else 0)
