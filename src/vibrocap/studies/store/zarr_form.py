"""The form of the Zarr files that this package writes, and the look at those of a store before Zarr opens them.

Zarr can hold arrays of Python objects whose reading runs code, and can ask for any codec that is installed. A store of
ours needs none of that: format 3, arrays of a few plain types, one codec. Anything else is refused. The files that say
so are JSON; they are read here and handed on as they were looked at, so that nothing else is ever asked.

Units of stored arrays: those that follow from the study's own case, and no others.

Measures are stored without units, with the factor by which whoever reads them multiplies (`scale_factor`, CF
conventions). Another factor would be other results, so it is compared with what the scales of the case give.
"""

import contextlib
import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from vibrocap.case.case import CaseError, case_from_text
from vibrocap.measures.of_measure import measure_unit, unit_in
from vibrocap.measures.standard import known_measure
from vibrocap.physics.system import System
from vibrocap.studies.store.marks import DamageError, is_finished, read_first
from vibrocap.studies.store.places import FILE, FOLDER, RESULTS, STRANGE, names, read_plain, why_strange
from vibrocap.studies.store.record import measure_names, plan_of
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.variables import ALWAYS, coordinate_attributes

METADATA = "zarr.json"
LARGEST = 2**24  # bytes of such a file
NUMBERS, TEXT = "float64", "string"
FILLS = {NUMBERS: "NaN", TEXT: ""}


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
    """The arrays of a store, looked at: what each should be, the type of each, and the files that say so.

    finished: whether the store says that all tiles were stored
    """

    arrays: Mapping[str, ExpectedArray]
    types: Mapping[str, str]
    metadata: Mapping[str, bytes]
    finished: bool = False


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
    arrays: dict[str, ExpectedArray] = {}
    lengths = dict(zip(plan.dims, plan.shape, strict=True))
    for path in plan.paths:
        kind = TEXT if plan.is_text(path) else NUMBERS
        if plan.gridded:
            arrays[path] = ExpectedArray((path,), (lengths[path],), (lengths[path],), (kind,), False)
        else:
            arrays[path] = ExpectedArray(plan.dims, plan.shape, tile, (kind,), True)
    for name in (*ALWAYS, *measure_names(record)):
        types = (ALWAYS[name].dtype.name,) if name in ALWAYS else (NUMBERS, TEXT)
        arrays[name] = ExpectedArray(plan.dims, plan.shape, tile, types, True)
    return arrays


def first_places(record: Mapping[str, Any]) -> list[str]:
    """The files of the results that belong to no tile, by their places."""
    arrays = expected_arrays(record)
    chunks = [f"{name}/c.0" for name, array in arrays.items() if not array.along_runs]
    return [METADATA, *(f"{name}/{METADATA}" for name in arrays), *chunks]


def checked_results(path: Path, record: Mapping[str, Any]) -> Results:
    """The results of a store, if they are of the form that this package writes; CaseError, with all that is not.

    StoreError where they are of that form and yet not as they were written.
    """
    arrays, units = expected_arrays(record), ArrayUnits(record)
    metadata: dict[str, bytes] = {}
    types: dict[str, str] = {}
    complaints = strange_names(path, arrays)
    for name in (None, *arrays):
        place = METADATA if name is None else f"{name}/{METADATA}"
        try:
            metadata[place] = read_plain(path, f"{RESULTS}/{place}", LARGEST)
            if name is None:
                _Group.model_validate_json(metadata[place])
            else:
                array = _Array.model_validate_json(metadata[place])
                types[name] = array.data_type
                wrong = _differences(name, array, arrays[name]) or units.complaints(name, dict(array.attributes))
                complaints += [f"{RESULTS}/{place}: {complaint}" for complaint in wrong]
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
    try:
        for place, data in metadata.items():
            if read_first(path, record, place) != data:
                raise DamageError(f"{RESULTS}/{place} changes while it is read")
        return Results(arrays, types, metadata, is_finished(path, record))
    except DamageError as error:
        raise StoreError(
            f"{path}: is damaged: {error}. `vibrocap sweep FOLDER --verify` names all damage, the sweep with --resume "
            "(resume=True) mends it"
        ) from None


def strange_names(path: Path, arrays: Mapping[str, ExpectedArray]) -> list[str]:
    """What stands among the results of a store and does not belong there."""
    strange = []
    try:
        for name, kind in names(path, RESULTS).items():
            if name == METADATA or (name in arrays and kind == FOLDER):
                continue
            if name.startswith(".z") or kind != FILE or name in arrays:
                strange.append(f"{RESULTS}/{name} does not belong to the study")
    except FileNotFoundError:
        return []  # which is said of the files that should be there
    except OSError as error:
        reason = why_strange(error) if error.errno in STRANGE else f"cannot be read: {error.strerror}"
        return [f"{RESULTS} {reason}"]
    return sorted(strange)


def _differences(name: str, array: _Array, expected: ExpectedArray) -> list[str]:
    """In what an array, which is of the right form, is not the one that the study has."""
    kind, chunk = array.data_type, array.chunk_grid.configuration.chunk_shape
    fill = ALWAYS[name].fill if name in ALWAYS else FILLS.get(kind)
    differences = [
        ("data_type", kind in expected.types, " or ".join(expected.types)),
        ("shape", tuple(array.shape) == expected.shape, list(expected.shape)),
        ("dimension_names", tuple(array.dimension_names) == expected.dims, list(expected.dims)),
        ("chunk_shape", tuple(chunk) == expected.chunk, list(expected.chunk)),
        ("codecs", isinstance(array.codecs[0], _Words) == (kind == TEXT), "those of its type"),
        ("fill_value", type(array.fill_value) is type(fill) and array.fill_value == fill, json.dumps(fill)),
    ]
    return [f"{name} should be {wanted}" for name, right, wanted in differences if not right]


FACTORS = ("dimensionless_unit", "scale_factor")


class ArrayUnits:
    """What the attributes of a study's arrays should say of units; record: that of the study.

    A case whose parts are not loaded tells nothing of its scales. Then only arrays without factors are let in.
    """

    def __init__(self, record: Mapping[str, Any]):
        self._paths = plan_of(record).paths
        self._measures = {
            measure if isinstance(measure, str) else measure["name"]: measure for measure in record["study"]["measures"]
        }
        self._system: System | None = None
        self._unknown = ""
        try:
            self._system = case_from_text(record["study"]["case"], "its case").system
        except CaseError as error:
            self._unknown = "; ".join(error.complaints)

    def complaints(self, name: str, given: Mapping[str, Any]) -> list[str]:
        """In what the attributes of an array differ; given: its attributes, None for one that is not there."""
        if self._system is None:
            told = [key for key in FACTORS if given.get(key) is not None]
            return [f"{key} cannot be compared with the case of the study: {self._unknown}" for key in told]
        expected = self._expected(name, self._system)
        complaints = []
        for key, value in expected.items():
            if given.get(key) != value and not (key == "units" and given.get(key) is None):
                wanted = "not be there" if value is None else f"be {value!r}, by the case of the study"
                complaints.append(f"{key} should {wanted}, got {given.get(key)!r}")
        return complaints

    def _expected(self, name: str, system: System) -> dict[str, Any]:
        """Attributes by name, None for one that should not be there; without those of which nothing is known here."""
        factors: dict[str, Any] = dict.fromkeys(FACTORS)
        if name in self._paths:
            with contextlib.suppress(KeyError, StopIteration):  # a path of a part that is not loaded
                return factors | {"units": coordinate_attributes(name, system).get("units")}
            return factors
        if name not in self._measures:
            return factors
        entry = self._measures[name]
        if isinstance(entry, str):
            measure = known_measure(entry, system)
            if measure is None:
                return factors
            unit, scale = measure_unit(measure, system)
        else:
            unit, scale = unit_in(entry["unit"], entry.get("si_unit") or "1", system)
        return {"units": unit, "dimensionless_unit": scale, "scale_factor": None if scale == 1.0 else scale}
