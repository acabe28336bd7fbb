"""The form of the Zarr files that this package writes, and the look at those of a store before Zarr opens them.

Zarr can hold arrays of Python objects whose reading runs code, and can ask for any codec that is installed. A store of
ours needs none of that: format 3, arrays of a few plain types, one codec. Anything else is refused. The files that say
so are JSON; they are read here and handed on as they were looked at, so that nothing else is ever asked.
"""

import dataclasses
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vibrocap.case.case import CaseError
from vibrocap.studies.store.array_units import ArrayUnits
from vibrocap.studies.store.checksums import STRANGE, read_plain, why_strange
from vibrocap.studies.store.record import RESULTS, measure_names, plan_of

METADATA = "zarr.json"
LARGEST = 2**24  # bytes of such a file
NUMBERS, TEXT = "float64", "string"
ALWAYS = {  # types of what is stored of every run
    "status": "int8",
    "settled": "bool",
    "response_period": "int16",
    "window_start": "int32",
    "window_periods": "int32",
}
FILLS: dict[str, Any] = {"float64": "NaN", "string": "", "bool": False}


@dataclasses.dataclass(frozen=True)
class ExpectedArray:
    """An array that a study has: its dimensions, their lengths, the lengths of its chunks, the types it may have.

    along_runs: whether it has a value for each run, so that it is stored tile by tile
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    types: tuple[str, ...]
    along_runs: bool

    @property
    def chunk_size(self) -> int:
        """Values in a chunk."""
        return math.prod(self.chunk)


@dataclasses.dataclass(frozen=True)
class Results:
    """The arrays of a store, looked at: what each should be, the type of each, and the files that say so."""

    arrays: Mapping[str, ExpectedArray]
    types: Mapping[str, str]
    metadata: Mapping[str, bytes]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


_Lengths = list[Annotated[int, Field(ge=1, le=2**62)]]


class _Level(_Strict):
    level: Annotated[int, Field(ge=-7, le=22)]
    checksum: bool


class _Zstd(_Strict):
    name: Literal["zstd"]
    configuration: _Level


class _Endian(_Strict):
    endian: Literal["little"]


class _Nothing(_Strict):
    pass


class _Bytes(_Strict):
    name: Literal["bytes"]
    configuration: _Endian | _Nothing | None = None


class _Words(_Strict):
    name: Literal["vlen-utf8"]
    configuration: _Nothing | None = None


class _ChunkShape(_Strict):
    chunk_shape: _Lengths


class _ChunkGrid(_Strict):
    name: Literal["regular"]
    configuration: _ChunkShape


class _Separator(_Strict):
    separator: Literal["."]


class _ChunkKeys(_Strict):
    name: Literal["default"]
    configuration: _Separator


class _ArrayAttributes(_Strict):
    long_name: str | None = None
    units: str | None = None
    symbol: str | None = None
    flag_values: list[int] | None = None
    flag_meanings: str | None = None
    dimensionless_unit: float | None = None
    scale_factor: float | None = None


class _Array(_Strict):
    zarr_format: Literal[3]
    node_type: Literal["array"]
    shape: _Lengths
    data_type: Literal["float64", "string", "int8", "int16", "int32", "bool"]
    chunk_grid: _ChunkGrid
    chunk_key_encoding: _ChunkKeys
    fill_value: str | bool | int
    codecs: tuple[_Bytes | _Words, _Zstd]
    attributes: _ArrayAttributes
    dimension_names: list[str]
    storage_transformers: Annotated[list[None], Field(max_length=0)] = []


class _Group(_Strict):
    zarr_format: Literal[3]
    node_type: Literal["group"]
    attributes: dict[str, str | bool | int | float | None]
    consolidated_metadata: None = None


def expected_arrays(record: Mapping[str, Any]) -> dict[str, ExpectedArray]:
    """The arrays of a study, from its record."""
    plan, tile = plan_of(record), tuple(record["tile"])
    found: dict[str, ExpectedArray] = {}
    lengths = dict(zip(plan.dims, plan.shape, strict=True))
    for path in plan.paths:
        kind = TEXT if plan.is_text(path) else NUMBERS
        if plan.gridded:
            found[path] = ExpectedArray((path,), (lengths[path],), (lengths[path],), (kind,), False)
        else:
            found[path] = ExpectedArray(plan.dims, plan.shape, tile, (kind,), True)
    for name in (*ALWAYS, *measure_names(record)):
        types = (ALWAYS[name],) if name in ALWAYS else (NUMBERS, TEXT)
        found[name] = ExpectedArray(plan.dims, plan.shape, tile, types, True)
    return found


def first_places(record: Mapping[str, Any]) -> list[str]:
    """The files of the results that belong to no tile, by their places."""
    arrays = expected_arrays(record)
    chunks = [f"{name}/c.0" for name, each in arrays.items() if not each.along_runs]
    return [METADATA, *(f"{name}/{METADATA}" for name in arrays), *chunks]


def checked_results(path: Path, record: Mapping[str, Any]) -> Results:
    """The results of a store, if they are of the form that this package writes; CaseError, with all that is not."""
    arrays, units = expected_arrays(record), ArrayUnits(record)
    metadata: dict[str, bytes] = {}
    types: dict[str, str] = {}
    complaints = strange_names(path / RESULTS, arrays)
    for name in (None, *arrays):
        place = METADATA if name is None else f"{name}/{METADATA}"
        try:
            metadata[place] = read_plain(path / RESULTS / place, LARGEST)
            if name is None:
                _Group.model_validate_json(metadata[place])
            else:
                array = _Array.model_validate_json(metadata[place])
                types[name] = array.data_type
                wrong = _differences(array, arrays[name]) or units.complaints(name, dict(array.attributes))
                complaints += [f"{RESULTS}/{place}: {each}" for each in wrong]
        except FileNotFoundError:
            complaints.append(f"{RESULTS}/{place} is missing")
        except OSError as error:
            reason = why_strange(error) if error.errno in STRANGE else f"cannot be read: {error.strerror}"
            complaints.append(f"{RESULTS}/{place} {reason}")
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False)[0]
            field = ".".join(map(str, (place, *first["loc"])))
            complaints.append(f"{RESULTS}/{field}: {first['msg']}; vibrocap writes no such thing")
    if complaints:
        raise CaseError(complaints, str(path))
    return Results(arrays, types, metadata)


def strange_names(folder: Path, arrays: Mapping[str, ExpectedArray]) -> list[str]:
    """What stands among the results and does not belong there."""
    found = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name == METADATA or (entry.name in arrays and entry.is_dir(follow_symlinks=False)):
                    continue
                if entry.name.startswith(".z") or entry.is_symlink() or entry.is_dir() or entry.name in arrays:
                    found.append(f"{RESULTS}/{entry.name} does not belong to the study")
    except FileNotFoundError:
        return []  # which is said of the files that should be there
    except OSError as error:
        return [f"{RESULTS} cannot be read: {error.strerror}"]
    return sorted(found)


def _differences(array: _Array, expected: ExpectedArray) -> list[str]:
    """In what an array, which is of the right form, is not the one that the study has."""
    kind, chunk = array.data_type, array.chunk_grid.configuration.chunk_shape
    found = [
        ("data_type", kind in expected.types, " or ".join(expected.types)),
        ("shape", tuple(array.shape) == expected.shape, list(expected.shape)),
        ("dimension_names", tuple(array.dimension_names) == expected.dims, list(expected.dims)),
        ("chunk_shape", tuple(chunk) == expected.chunk, list(expected.chunk)),
        ("codecs", isinstance(array.codecs[0], _Words) == (kind == TEXT), "those of its type"),
        ("fill_value", _fills(array.fill_value, kind), "that of its type"),
    ]
    return [f"{name} should be {wanted}" for name, right, wanted in found if not right]


def _fills(value: Any, kind: str) -> bool:
    if kind in FILLS:
        return value == FILLS[kind] and type(value) is type(FILLS[kind])
    return type(value) is int and np.iinfo(kind).min <= value <= np.iinfo(kind).max
