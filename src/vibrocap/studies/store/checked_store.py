"""A store as Zarr reads it: what was looked at, chunks as they were written, and nothing else."""

from collections.abc import AsyncIterator, Iterable, Mapping
from pathlib import Path
from typing import Any

from zarr.abc.store import ByteRequest, Store
from zarr.core.buffer import Buffer, BufferPrototype, default_buffer_prototype

from vibrocap.studies.store.chunks import checked_chunk
from vibrocap.studies.store.zarr_form import Results


class CheckedStore(Store):
    """The results of a study for Zarr, to be read only; it lists what says what the arrays are.

    Chunks are looked at (`chunks`) before Zarr gets them. A tile without a mark is not there, even if some of its
    chunks are.
    """

    supports_writes, supports_deletes, supports_listing = False, False, True  # type: ignore[assignment]

    def __init__(self, path: Path, record: Mapping[str, Any], results: Results):
        super().__init__(read_only=True)
        self.path, self.record, self.results = path, record, results

    def __eq__(self, value: object) -> bool:
        return isinstance(value, CheckedStore) and (value.path, value.record) == (self.path, self.record)

    def content(self, key: str) -> bytes | None:
        """What stands at a place; None where nothing does. StoreError where it is damaged."""
        if key in self.results.metadata:
            return self.results.metadata[key]
        name, _, chunk = key.partition("/c.")
        return checked_chunk(self.path, self.record, self.results, name, chunk)

    async def get(
        self, key: str, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        if byte_range is not None:
            raise NotImplementedError("a store is read chunk by chunk")
        data = self.content(key)
        return None if data is None else (prototype or default_buffer_prototype()).buffer.from_bytes(data)

    async def get_partial_values(
        self, prototype: BufferPrototype, key_ranges: Iterable[tuple[str, ByteRequest | None]]
    ) -> list[Buffer | None]:
        return [await self.get(key, prototype, byte_range) for key, byte_range in key_ranges]

    async def exists(self, key: str) -> bool:
        return self.content(key) is not None

    async def list(self) -> AsyncIterator[str]:
        for key in self.results.metadata:
            yield key

    async def list_prefix(self, prefix: str) -> AsyncIterator[str]:
        for key in self.results.metadata:
            if key.startswith(prefix):
                yield key

    async def list_dir(self, prefix: str) -> AsyncIterator[str]:
        below = f"{prefix.rstrip('/')}/" if prefix else ""
        inner = [key.removeprefix(below).partition("/")[0] for key in self.results.metadata if key.startswith(below)]
        for name in dict.fromkeys(inner):
            yield name

    async def set(self, key: str, value: Buffer) -> None:
        self._check_writable()

    async def delete(self, key: str) -> None:
        self._check_writable()
