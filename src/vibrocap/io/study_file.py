"""Exports of a study: NetCDF and MATLAB files hold labelled arrays, CSV files and workbooks one row per run."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibrocap.io.spreadsheets import Export
from vibrocap.studies.dataset import open_study
from vibrocap.studies.tile import tile_block, tile_indices, tile_shape

if TYPE_CHECKING:
    import xarray

ROWS = 65_536  # of a table in memory at a time


def write_study(source: "str | Path | xarray.Dataset", path: str | Path, *, unit_headings: bool = False) -> Path:
    """Write a study, a dataset or the folder of one, to a file ending in .nc, .csv, .xlsx or .mat, whole or not at all.

    Of a CSV file the case and the meanings are beside it, in a file of TOML with `.toml` behind the whole name. MATLAB
    files hold the arrays as they are, dots in names become underscores. NetCDF, CSV and MATLAB files of one study have
    the same bytes, from its folder or from memory. Memory does not grow with a study that is read from its folder, but
    for MATLAB files and workbooks, beyond 256 MiB.

    unit_headings: whether the columns of a .csv or .xlsx are headed by name and unit, "drift [m]", in place of names

    Raises ValueError for another ending, WriteError where it cannot be
    written.
    """
    if isinstance(source, (str, Path)):
        source = open_study(source, chunks={} if Path(path).suffix.lower() == ".nc" else None)
    return StudyExport(_in_order(source)).write(path, unit_headings)


class StudyExport(Export):
    """The runs of a study; its axes come first."""

    what, sheet = "study", "runs"

    def __init__(self, dataset: "xarray.Dataset"):
        self.runs, self.case, self.size = dataset, str(dataset.attrs["case"]), dataset["status"].size
        self.columns = [str(name) for name in (*dataset.coords, *dataset.data_vars)]
        known = {name: dataset[name].attrs for name in self.columns}
        self.units = {name: str(variable.get("units", "1")) for name, variable in known.items()}
        self.meanings = {name: str(variable.get("long_name", name)) for name, variable in known.items()}
        self.facts = {key: str(value) for key, value in dataset.attrs.items() if key != "case"}
        flags = dataset["status"].attrs
        self.words = dict(zip(flags["flag_values"], flags["flag_meanings"].split(), strict=True))

    def parts(self) -> Iterator[list[list]]:
        """The runs in C order, read some of them at a time; the status in words."""
        dims = [str(dim) for dim in self.runs["status"].dims]
        shape = self.runs["status"].shape
        tile = tile_shape(shape, ROWS)
        for index in tile_indices(shape, tile):
            block = tile_block(shape, tile, index)
            part = self.runs.isel(dict(zip(dims, block, strict=True))).load()
            sizes = tuple(column.stop - column.start for column in block)
            texts = []
            for name in self.columns:
                array = part[name]
                axes = tuple(size if dim in array.dims else 1 for dim, size in zip(dims, sizes, strict=True))
                values = np.broadcast_to(array.values.reshape(axes), sizes).ravel().tolist()
                texts.append([self.words[value] for value in values] if name == "status" else values)
            assert all(len(text) == math.prod(sizes) for text in texts)
            yield texts

    def arrays(self):
        """Axes and arrays, of dimensions in the order of `axes`; what each status is called."""
        return {name: self.runs[name].values for name in self.columns} | {
            "axes": np.array([str(dim) for dim in self.runs["status"].dims], dtype=object),
            "status_words": np.array([*self.words.values()], dtype=object),
            "status_numbers": np.array([*self.words]),
        }

    def dataset(self):
        """As it is seen, whatever a store holds."""
        dataset = self.runs.copy()
        status = dataset["status"]
        flags = np.array([*self.words], dtype=status.dtype)  # CF: of the type of the variable
        dataset["status"] = status.assign_attrs(flag_values=flags)
        for variable in dataset.variables.values():  # values in their unit
            variable.encoding = {key: value for key, value in variable.encoding.items() if key != "scale_factor"}
        return dataset


def _in_order(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """The same with its axes first and all other coordinates by name: a store gives them in no order of its own."""
    import xarray

    dims = [str(dim) for dim in dataset["status"].dims]
    others = sorted({str(name) for name in dataset.coords} - set(dims))
    coordinates = {name: dataset[name].variable for name in (*dims, *others) if name in dataset.coords}
    return xarray.Dataset({name: dataset[name].variable for name in dataset.data_vars}, coordinates, dataset.attrs)
