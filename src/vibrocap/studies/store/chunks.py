"""Chunks of a store: read, compared with their checksums, and unpacked, without Zarr."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.studies.store.marks import DamageError, read_chunk, read_first, read_mark, tile_name
from vibrocap.studies.store.record import plan_of
from vibrocap.studies.store.zarr_form import TEXT, Results, damaged
from vibrocap.studies.tile import tile_block, tile_indices

LONGEST_WORD = 1024  # bytes; words of phases have 104 letters at most
ZSTD = b"\x28\xb5\x2f\xfd"


def stored_numbers(
    path: Path, record: Mapping[str, Any], results: Results, names: Sequence[str]
) -> Iterator[tuple[np.ndarray, ...]]:
    """Arrays of numbers of a store, tile by tile, as they are stored; tiles to come are left out.

    record, results: of the store, as `read_record` and `checked_results` give them. StoreError where it is damaged.
    """
    from numcodecs.zstd import decompress

    shape, tile = plan_of(record).shape, tuple(record["tile"])
    for index in tile_indices(shape, tile):
        there = tuple(slice(0, block.stop - block.start) for block in tile_block(shape, tile, index))
        chunks = [checked_chunk(path, record, results, name, tile_name(index)) for name in names]
        if None not in chunks:
            kinds = [np.dtype(results.types[name]).newbyteorder("<") for name in names]
            whole = zip(chunks, kinds, strict=True)
            yield tuple(np.frombuffer(decompress(data), kind).reshape(tile)[there] for data, kind in whole)


def checked_chunk(path: Path, record: Mapping[str, Any], results: Results, name: str, chunk: str) -> bytes | None:
    """A chunk, such as "3.0", of an array of a store, packed as it is; None where there is none.

    It is compared with its checksum, and may not ask for more memory than an array of its size takes. StoreError where
    it is damaged. A tile without a mark is not there, even if some of its chunks are.
    """
    array = results.arrays.get(name)
    if array is None or not chunk:
        return None
    try:
        if not array.along_runs:
            data = read_first(path, record, f"{name}/c.{chunk}")
        else:
            index = tuple(map(int, chunk.split(".")))
            mark = read_mark(path, record, index)
            if mark is None:
                if results.finished:
                    raise DamageError("its mark is missing")
                return None
            data = read_chunk(path, record, name, index, mark)
        _check_content(name, data, array.chunk_size, results.types[name])
    except DamageError as error:
        raise damaged(path, f"tile {chunk}: {error}" if array.along_runs else str(error)) from None
    return data


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
