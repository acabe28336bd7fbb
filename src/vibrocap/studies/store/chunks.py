"""The Zarr files of a study without Zarr: made in memory, and chunks compared with their checksums and unpacked.

What `zarr_form` lets in is so little of Zarr that it is written directly, to the bytes that Zarr 3 would write (a test
compares them), as a small sweep is done before Zarr is imported.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.studies.plan.study import Study
from vibrocap.studies.store.record import DamageError, plan_of, read_chunk, read_first, read_mark, tile_name
from vibrocap.studies.store.zarr_form import COMPRESSION, GROUP, METADATA, STRING, Results, array_entries, damaged
from vibrocap.studies.tile import tile_block, tile_indices
from vibrocap.studies.variables import TEXT, axis_values, coordinate_attributes, study_attributes, variables


class ZarrFiles:
    """Encodes the results of a study: `first` once, `chunks` for each tile. The same input gives the same bytes."""

    def __init__(self, study: Study, tile: tuple[int, ...]):
        self.study, self.tile = study, tile
        self._variables = variables(study)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(variable.name for variable in self._variables)

    def first(self) -> dict[str, bytes]:
        """Every file but those of the tiles, by its place in the group's folder."""
        plan = self.study.plan
        attributes = study_attributes(self.study)
        if not plan.gridded:
            attributes["coordinates"] = " ".join(plan.paths)
        texts = {METADATA: _text({"attributes": attributes, **GROUP})}
        for path, values in axis_values(self.study).items():
            form = values.shape, values.shape, (path,), coordinate_attributes(path, self.study.case.system)
            texts[f"{path}/{METADATA}"] = _array_text(values.dtype, "" if values.dtype == TEXT else np.nan, *form)
            texts[f"{path}/c.0"] = _chunk(values)
        for variable in self._variables:
            form = plan.shape, self.tile, plan.dims, variable.stored_attributes
            texts[f"{variable.name}/{METADATA}"] = _array_text(variable.dtype, variable.fill, *form)
        return texts

    def chunks(self, index: tuple[int, ...], arrays: Mapping[str, np.ndarray]) -> dict[str, bytes]:
        """The files of one tile, by their place; arrays: as `run_tile` gives them."""
        lengths = [block.stop - block.start for block in tile_block(self.study.plan.shape, self.tile, index)]
        there = tuple(slice(0, length) for length in lengths)
        chunks = {}
        for variable in self._variables:
            chunk = variable.empty(self.tile)  # whole, also where the tile is cut by the edge
            chunk[there] = arrays[variable.name]
            chunks[f"{variable.name}/c.{'.'.join(map(str, index))}"] = _chunk(chunk)
        return chunks


def _array_text(dtype: Any, fill: Any, shape: Any, chunk: Any, dims: Any, attributes: Mapping[str, Any]) -> bytes:
    kind = STRING if np.dtype(dtype) == TEXT else np.dtype(dtype).name
    return _text(array_entries(kind, fill, shape, chunk, dims) | {"attributes": dict(attributes)})


def _text(entries: Mapping[str, Any]) -> bytes:
    return json.dumps(entries, indent=2).encode()


def _chunk(values: np.ndarray) -> bytes:
    from numcodecs.zstd import compress

    if values.dtype == TEXT:
        from numcodecs.vlen import VLenUTF8

        data = VLenUTF8().encode(values.astype(object))
    else:
        data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    return bytes(compress(data, COMPRESSION, checksum=True))


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
        _check_content(name, data, math.prod(array.chunk), results.types[name])
    except DamageError as error:
        raise damaged(path, f"tile {chunk}: {error}" if array.along_runs else str(error)) from None
    return data


def _check_content(name: str, data: bytes, values: int, kind: str) -> None:
    """DamageError for a chunk that does not unpack to so many values."""
    from numcodecs.vlen import VLenUTF8
    from numcodecs.zstd import decompress

    size = unpacked_size(data)
    room = 4 + values * (4 + LONGEST_WORD) if kind == STRING else values * np.dtype(kind).itemsize
    if size is None or size > room or (kind != STRING and size != room):
        raise DamageError(f"{name} is no array of {values:,} values")
    try:
        unpacked = decompress(data)
        if kind == STRING:
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
