"""Exports of a study: NetCDF for programs that read labelled arrays, CSV with one row per run for all others."""

import csv
import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibrocap.files import replacing
from vibrocap.io.netcdf import write_netcdf
from vibrocap.studies.dataset import open_study
from vibrocap.studies.tile import tile_block, tile_indices, tile_shape

if TYPE_CHECKING:
    import xarray

ROWS = 65_536  # of a table in memory at a time


def write_study(source: "str | Path | xarray.Dataset", path: str | Path) -> Path:
    """Write a study, a dataset or the folder of one, to a file ending in .nc or .csv, whole or not at all.

    The same study gives the same bytes, from its folder or from memory. Memory does not grow with a study that is read
    from its folder, beyond 256 MiB. Raises ValueError for another ending, WriteError where it cannot be written.
    """
    path = Path(path)
    writers: dict[str, Callable[[xarray.Dataset, Path], None]] = {".nc": _write_netcdf, ".csv": _write_csv}
    if path.suffix.lower() not in writers:
        raise ValueError(f"a study is written to {' or '.join(writers)}, not to {str(path)!r}")
    if isinstance(source, (str, Path)):
        source = open_study(source, chunks={} if path.suffix.lower() == ".nc" else None)
    writers[path.suffix.lower()](_in_order(source), path)
    return path


def _in_order(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """The same with its axes first and all other coordinates by name: a store gives them in no order of its own."""
    import xarray

    dims = [str(dim) for dim in dataset["status"].dims]
    others = sorted({str(name) for name in dataset.coords} - set(dims))
    coordinates = {name: dataset[name].variable for name in (*dims, *others) if name in dataset.coords}
    return xarray.Dataset({name: dataset[name].variable for name in dataset.data_vars}, coordinates, dataset.attrs)


def _write_netcdf(dataset: "xarray.Dataset", path: Path) -> None:
    dataset = dataset.copy()
    attributes = dataset["status"].attrs
    flags = np.array(attributes["flag_values"], dtype=dataset["status"].dtype)  # CF: of the type of the variable
    dataset["status"] = dataset["status"].assign_attrs(flag_values=flags)
    for variable in dataset.variables.values():  # values in their unit, as they are seen, whatever the store holds
        variable.encoding = {key: value for key, value in variable.encoding.items() if key != "scale_factor"}
    write_netcdf(dataset, path)


def _write_csv(dataset: "xarray.Dataset", path: Path) -> None:
    """A header of comments, which without their `# ` are the case and the section [result] in TOML, then the table."""
    header = [*str(dataset.attrs["case"]).splitlines(), "", "[result]"]
    header += [f"{key} = '''{value}'''" for key, value in dataset.attrs.items() if key != "case"]
    columns = [*(name for name in dataset.coords), *dataset.data_vars]
    header += ["", "[result.meaning]"]
    header += [f"\"{name}\" = '''{dataset[name].attrs.get('long_name', name)}'''" for name in columns]
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {line}".rstrip() + "\n" for line in header)
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        for rows in _rows(dataset, [str(name) for name in columns]):
            table.writerows(rows)


def _rows(dataset: "xarray.Dataset", columns: list[str]) -> Iterator[Iterable[tuple[str, ...]]]:
    """The runs in C order, some of them at a time."""
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
            texts.append([words[value] for value in values] if name == "status" else [_text(value) for value in values])
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
