"""Tables in files of named arrays: NPZ of NumPy, and JSON."""

import dataclasses
import json
import zipfile
import zlib
from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.inputs import read_input, require_plain_file
from vibrocap.records.reading.columns import Table, quantity_of
from vibrocap.records.record import RecordError

NAMES_KEY = "columns"  # the array that names the columns of two-dimensional ones
MOST_BYTES = 2**30  # of a file's content in memory; a small file can claim to unpack to any size
UNREADABLE = (ValueError, TypeError, OSError, IndexError, EOFError, MemoryError)  # what readers raise on damage
UNREADABLE_NPZ = (*UNREADABLE, KeyError, RuntimeError, zipfile.BadZipFile, zlib.error)


def npz_tables(path: Path) -> list[Table]:
    """The tables of a NumPy file .npz; see `tables_of`."""
    check_plain(path)
    try:
        with zipfile.ZipFile(path) as archive:
            check_size(sum(info.file_size for info in archive.infolist()), path)
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except RecordError:
        raise
    except UNREADABLE_NPZ as error:
        reason = "holds Python objects" if "allow_pickle" in str(error) else "cannot be read as .npz"
        raise RecordError([f"{reason}; should be written by numpy.savez from arrays of numbers"], str(path)) from None
    return tables_of(arrays, path)


def json_tables(path: Path) -> list[Table]:
    """The tables of a JSON file: an object of lists, of such objects, or a list of samples; see `tables_of`."""
    try:
        content = json.loads(read_input(path, MOST_BYTES))
        if isinstance(content, list):
            content = {name: [sample.get(name) for sample in content] for name in dict.fromkeys(chain(*content))}
        return tables_of(_with_arrays(content), path)
    except RecordError:
        raise
    except (*UNREADABLE, AttributeError, RecursionError):
        wanted = '{"time": [...], "force": [...], "velocity": [...]}'
        raise RecordError([f"cannot be read as .json; should be such as {wanted}"], str(path)) from None


def _with_arrays(value: Any) -> Any:
    """Lists of numbers as arrays, null as NaN, in objects at any depth."""
    if isinstance(value, dict):
        return {name: _with_arrays(element) for name, element in value.items()}
    numbers = isinstance(value, list) and all(element is None or type(element) in (int, float) for element in value)
    return np.array(value, dtype=np.float64) if numbers else value


def check_plain(path: Path) -> None:
    """RecordError for a pipe or a device, of which the libraries would wait."""
    try:
        require_plain_file(path)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise RecordError([str(error.strerror)], str(path)) from None


def check_size(size: int, path: Path) -> None:
    """RecordError for more content than a measured record has."""
    if size > MOST_BYTES:
        most = f"{MOST_BYTES // 2**20} MB"
        raise RecordError([f"unpacks to more than {most}; give the records in several files"], str(path))


def tables_of(variables: Mapping[str, Any], path: Path) -> list[Table]:
    """The tables among named arrays, in any of the usual layouts.

    - columns by name: `time`, `force`, `velocity`, ... of equal length are one record;
    - with the record in front: `run1_force`, `run1_velocity`, `run2_force`, ...;
    - a structure, or a structured array, for each record;
    - a two-dimensional array for each record, with its columns named by the array `columns`.
    Single numbers (dt, fs, mass_kg) go with every record.
    """
    numbers: dict[str, np.ndarray] = {}
    tables: list[Table] = []
    names: list[str] = []
    for key, value in variables.items():
        if isinstance(value, Mapping):
            tables += _tables_by_prefix({name: np.asarray(column) for name, column in value.items()}, key, path)
            continue
        array = np.squeeze(np.asarray(value))  # a column is one, whichever way it stands
        if array.dtype.names:
            tables += _tables_by_prefix({name: array[name] for name in array.dtype.names}, key, path)
        elif key == NAMES_KEY and array.dtype.kind == "U":
            names = [str(name).strip() for name in array.ravel()]
        elif array.dtype.kind in "fiu":
            numbers[key] = array
    tables += [_table_of_matrix(array, names, key, path) for key, array in numbers.items() if array.ndim == 2]
    tables += _tables_by_prefix(numbers, "", path)
    if not tables:
        only = ", ".join(map(repr, variables)) or "nothing"
        raise RecordError([f"holds no columns of numbers, only {only}"], str(path))
    scalars = {name: float(array) for name, array in numbers.items() if array.ndim == 0}
    return [dataclasses.replace(table, scalars={**scalars, **table.scalars}) for table in tables]


def _table_of_matrix(array: np.ndarray, names: list[str], key: str, path: Path) -> Table:
    if array.shape[1] > array.shape[0]:
        array = array.T
    if names and len(names) != array.shape[1]:
        other = f"{NAMES_KEY!r} names {len(names)}: {', '.join(names)}"
        raise RecordError([f"{key}: has {array.shape[1]} columns, but {other}"], str(path))
    columns = dict(zip(names or map(str, range(array.shape[1])), array.T, strict=True))
    return Table(key, str(path), columns, named=bool(names))


def _tables_by_prefix(arrays: Mapping[str, np.ndarray], key: str, path: Path) -> list[Table]:
    """Columns grouped by what stands before the name of a quantity; those without are one record, or serve all."""
    groups: dict[str, dict[str, np.ndarray]] = {"": {}}
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "fiu"}
    for name, values in numbers.items():
        prefix, rest = _split(name)
        if values.ndim == 1:
            groups.setdefault(prefix, {})[rest] = values
    scalars = {name: float(array) for name, array in numbers.items() if array.ndim == 0}
    own = groups.pop("")
    if not groups:
        return [Table(key or path.stem, str(path), own, scalars=scalars)] if own else []
    names = {prefix: f"{key}_{prefix}" if key else prefix for prefix in groups}
    return [Table(names[prefix], str(path), own | group, scalars=scalars) for prefix, group in groups.items()]


def _split(name: str) -> tuple[str, str]:
    """(prefix, quantity) of "run1_force"; ("", name) where the whole name, or no end of it, is a usual one."""
    for place in (place for place, mark in enumerate(name) if mark == "_" and quantity_of(name) is None):
        if quantity_of(name[place + 1 :]) is not None:
            return name[:place], name[place + 1 :]
    return "", name
