"""The Zarr files of a study's results, as bytes: which file holds what, with everything that xarray needs to read it.

They are made in memory and written by `writing`, since only then every file is whole or not there at all. What is
written here is all that `zarr_form` lets in again.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.studies.plan.study import Study
from vibrocap.studies.tile import tile_block
from vibrocap.studies.variables import TEXT, axis_values, coordinate_attributes, study_attributes, variables

COMPRESSION = 3  # level of zstd: measures hardly shrink further


class ZarrFiles:
    """Encodes the results of a study: `first` once, `chunks` for each tile. The same input gives the same bytes."""

    def __init__(self, study: Study, tile: tuple[int, ...]):
        import zarr
        from zarr.storage import MemoryStore

        self.study, self.tile = study, tile
        self._files: dict[str, Any] = {}
        attributes = study_attributes(study)
        if not study.plan.gridded:
            attributes["coordinates"] = " ".join(study.plan.paths)
        group = zarr.create_group(MemoryStore(self._files), attributes=attributes)
        for path, values in axis_values(study).items():
            fill = "" if values.dtype == TEXT else np.nan
            described = coordinate_attributes(path, study.case.system)
            array = self._array(group, path, values.dtype, fill, values.shape, (path,), described)
            array[:] = values
        self._arrays = {
            each.name: self._array(
                group, each.name, each.dtype, each.fill, tile, study.plan.dims, each.stored_attributes
            )
            for each in variables(study)
        }

    def _array(self, group, name, dtype, fill, chunk, dims, attributes):
        from zarr.codecs import ZstdCodec

        return group.create_array(
            name,
            shape=tuple(chunk) if name in self.study.plan.dims else self.study.plan.shape,
            chunks=tuple(chunk),
            dtype=str if dtype == TEXT else dtype,
            fill_value=fill,
            compressors=ZstdCodec(level=COMPRESSION, checksum=True),
            chunk_key_encoding={"name": "default", "separator": "."},
            dimension_names=dims,
            attributes=attributes,
            config={"write_empty_chunks": True},
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The arrays that are stored tile by tile."""
        return tuple(self._arrays)

    def first(self) -> dict[str, bytes]:
        """Every file but those of the tiles, by its place in the group's folder."""
        return {name: buffer.to_bytes() for name, buffer in self._files.items()}

    def chunks(self, index: tuple[int, ...], arrays: Mapping[str, np.ndarray]) -> dict[str, bytes]:
        """The files of one tile, by their place; arrays: as `run_tile` gives them."""
        block = tile_block(self.study.plan.shape, self.tile, index)
        found = {}
        for name, array in self._arrays.items():
            array[block] = arrays[name]
            place = f"{name}/c.{'.'.join(map(str, index))}"
            found[place] = self._files.pop(place).to_bytes()
        return found
