"""The Zarr files of a study, made in memory: all that `zarr_form` lets in again.

That is so little of Zarr that it is written directly, to the bytes that Zarr 3 would write (a test compares them), as a
small sweep is done before Zarr is imported.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.studies.plan.study import Study
from vibrocap.studies.store.zarr_form import COMPRESSION, GROUP, METADATA, array_entries
from vibrocap.studies.tile import tile_block
from vibrocap.studies.variables import TEXT, axis_values, coordinate_attributes, study_attributes, variables


class ZarrFiles:
    """Encodes the results of a study: `first` once, `chunks` for each tile. The same input gives the same bytes."""

    def __init__(self, study: Study, tile: tuple[int, ...]):
        self.study, self.tile = study, tile
        self._variables = variables(study)

    @property
    def names(self) -> tuple[str, ...]:
        """The arrays that are stored tile by tile."""
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
    kind = "string" if np.dtype(dtype) == TEXT else np.dtype(dtype).name
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
