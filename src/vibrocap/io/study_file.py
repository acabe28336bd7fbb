"""Exports of a study: NetCDF and MATLAB files hold labelled arrays, CSV files and workbooks one row per run."""

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibrocap.arguments import listed
from vibrocap.io.netcdf import write_netcdf
from vibrocap.io.spreadsheets import headed, write_csv, write_matlab, write_workbook
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
    path = Path(path)
    writers: dict[str, Callable[[xarray.Dataset, Path, list[str]], None]] = {
        ".nc": _write_netcdf,
        ".csv": _write_csv,
        ".xlsx": _write_workbook,
        ".mat": _write_matlab,
    }
    if path.suffix.lower() not in writers:
        raise ValueError(f"a study is written to {listed(writers, ' or ')}, not to {str(path)!r}")
    if isinstance(source, (str, Path)):
        source = open_study(source, chunks={} if path.suffix.lower() == ".nc" else None)
    dataset = _in_order(source)
    headings = headed(_columns(dataset), lambda name: _unit(dataset, name), path, unit_headings)
    writers[path.suffix.lower()](dataset, path, headings)
    return path


def _in_order(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """The same with its axes first and all other coordinates by name: a store gives them in no order of its own."""
    import xarray

    dims = [str(dim) for dim in dataset["status"].dims]
    others = sorted({str(name) for name in dataset.coords} - set(dims))
    coordinates = {name: dataset[name].variable for name in (*dims, *others) if name in dataset.coords}
    return xarray.Dataset({name: dataset[name].variable for name in dataset.data_vars}, coordinates, dataset.attrs)


def _write_netcdf(dataset: "xarray.Dataset", path: Path, _headings: list[str]) -> None:
    dataset = dataset.copy()
    attributes = dataset["status"].attrs
    flags = np.array(attributes["flag_values"], dtype=dataset["status"].dtype)  # CF: of the type of the variable
    dataset["status"] = dataset["status"].assign_attrs(flag_values=flags)
    for variable in dataset.variables.values():  # values in their unit, as they are seen, whatever the store holds
        variable.encoding = {key: value for key, value in variable.encoding.items() if key != "scale_factor"}
    write_netcdf(dataset, path)


def _columns(dataset: "xarray.Dataset") -> list[str]:
    return [str(name) for name in (*dataset.coords, *dataset.data_vars)]


def _unit(dataset: "xarray.Dataset", name: str) -> str:
    return str(dataset[name].attrs.get("units", "1"))


def _meaning(dataset: "xarray.Dataset", name: str) -> str:
    return str(dataset[name].attrs.get("long_name", name))


def _write_csv(dataset: "xarray.Dataset", path: Path, headings: list[str]) -> None:
    """The table; beside it the case and the section [result] in TOML."""
    header = [*str(dataset.attrs["case"]).splitlines(), "", "[result]"]
    header += [f"{key} = '''{value}'''" for key, value in dataset.attrs.items() if key != "case"]
    columns = _columns(dataset)
    header += ["", "[result.units]", *(f'"{name}" = "{_unit(dataset, name)}"' for name in columns)]
    header += ["", "[result.meaning]"]
    header += [f"\"{name}\" = '''{_meaning(dataset, name)}'''" for name in columns]
    texts = (tuple(_text(value) for value in row) for rows in _rows(dataset, columns) for row in rows)
    write_csv(path, header, headings, texts)


def _write_workbook(dataset: "xarray.Dataset", path: Path, headings: list[str]) -> None:
    """Sheets with the runs, what the columns mean, and the case."""
    columns = _columns(dataset)
    about = [(name, _unit(dataset, name), _meaning(dataset, name)) for name in columns]
    about += [(key, "", str(value)) for key, value in dataset.attrs.items() if key != "case"]
    write_workbook(
        path,
        {
            "runs": (headings, (row for rows in _rows(dataset, columns) for row in rows)),
            "columns": (("name", "unit", "meaning"), about),
            "case": (("case",), ((line,) for line in str(dataset.attrs["case"]).splitlines())),
        },
        dataset["status"].size,
    )


def _write_matlab(dataset: "xarray.Dataset", path: Path, _headings: list[str]) -> None:
    """Axes and arrays as variables, of dimensions in the order of `axes`; structs with units, meanings; the case."""
    columns = _columns(dataset)
    about = {
        "axes": np.array([str(dim) for dim in dataset["status"].dims], dtype=object),
        "units": {name: _unit(dataset, name) for name in columns},
        "meaning": {name: _meaning(dataset, name) for name in columns},
        "status_words": np.array([word for _, word in _flags(dataset)], dtype=object),
        "status_numbers": np.array([code for code, _ in _flags(dataset)]),
        "result": {key: str(value) for key, value in dataset.attrs.items() if key != "case"},
        "case_toml": str(dataset.attrs["case"]),
    }
    write_matlab(path, {**{name: dataset[name].values for name in columns}, **about})


def _rows(dataset: "xarray.Dataset", columns: list[str]) -> Iterator[Iterable[tuple]]:
    """The runs in C order, some of them at a time; the status in words."""
    dims = [str(dim) for dim in dataset["status"].dims]
    shape = dataset["status"].shape
    words = {int(code): word for code, word in _flags(dataset)}
    tile = tile_shape(shape, ROWS)
    for index in tile_indices(shape, tile):
        block = tile_block(shape, tile, index)
        part = dataset.isel(dict(zip(dims, block, strict=True))).load()
        sizes = tuple(each.stop - each.start for each in block)
        texts = []
        for name in columns:
            array = part[name]
            axes = tuple(size if dim in array.dims else 1 for dim, size in zip(dims, sizes, strict=True))
            values = np.broadcast_to(array.values.reshape(axes), sizes).ravel().tolist()
            texts.append([words[value] for value in values] if name == "status" else values)
        assert all(len(text) == math.prod(sizes) for text in texts)
        yield zip(*texts, strict=True)


def _flags(dataset: "xarray.Dataset") -> Iterator[tuple[int, str]]:
    attributes = dataset["status"].attrs
    return zip(attributes["flag_values"], attributes["flag_meanings"].split(), strict=True)


def _text(value: float | str | bool) -> str:
    """A value in full precision."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)
