"""The form of the Zarr files that this package writes, and the look at those of a store before Zarr opens them.

Zarr can hold arrays of Python objects whose reading runs code, and can ask for any codec that is installed. A store of
ours needs none of that: format 3, arrays of a few plain types, one codec. What says so is a JSON file for each array:
its entries have to be those that this package writes (`array_entries`), with attributes of a few kinds. The files are
handed on as they were looked at, so that nothing else is ever asked.

Measures are stored without units, with the factor by which whoever reads them multiplies (`scale_factor`, CF
conventions). Another factor would be other results, so it is compared with what the scales of the case give.
"""

import contextlib
import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrocap.case.case import CaseError, case_from_text
from vibrocap.measures.of_measure import measure_unit, unit_in
from vibrocap.measures.standard import known_measure
from vibrocap.physics.system import System
from vibrocap.studies.store.places import FILE, FOLDER, RESULTS, StoreError, names, read_plain, why_unread
from vibrocap.studies.store.record import DamageError, is_finished, measure_names, plan_of, read_first
from vibrocap.studies.variables import ALWAYS, coordinate_attributes

METADATA = "zarr.json"
LARGEST = 2**24  # bytes of such a file
COMPRESSION = 3  # level of zstd: measures hardly shrink further
NUMBERS, STRING = "float64", "string"
FILLS = {NUMBERS: "NaN", STRING: ""}
GROUP = {"zarr_format": 3, "node_type": "group"}
PLAIN = (str, int, float, type(None))
ATTRIBUTES: dict[str, Any] = {
    **dict.fromkeys(("long_name", "units", "symbol", "flag_meanings"), str),
    **dict.fromkeys(("dimensionless_unit", "scale_factor"), (int, float)),
    "flag_values": list,
}


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


@dataclasses.dataclass(frozen=True)
class Results:
    """The arrays of a store, looked at: what each should be, the type of each, and the files that say so.

    finished: whether the store says that all tiles were stored
    """

    arrays: Mapping[str, ExpectedArray]
    types: Mapping[str, str]
    metadata: Mapping[str, bytes]
    finished: bool = False


def array_entries(
    kind: str, fill: Any, shape: tuple[int, ...], chunk: tuple[int, ...], dims: tuple[str, ...]
) -> dict[str, Any]:
    """The entries that say what an array is, but for its attributes, as they are written."""
    own: dict[str, Any] = {"name": "bytes"}
    if kind == STRING:
        own = {"name": "vlen-utf8", "configuration": {}}
    elif kind not in ("int8", "bool"):
        own["configuration"] = {"endian": "little"}
    return {
        "shape": list(shape),
        "data_type": kind,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(chunk)}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": "NaN" if fill != fill else fill,
        "codecs": [own, {"name": "zstd", "configuration": {"level": COMPRESSION, "checksum": True}}],
        "attributes": {},
        "dimension_names": list(dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }


def expected_arrays(record: Mapping[str, Any]) -> dict[str, ExpectedArray]:
    """The arrays of a study, from its record."""
    plan, tile = plan_of(record), tuple(record["tile"])
    arrays: dict[str, ExpectedArray] = {}
    lengths = dict(zip(plan.dims, plan.shape, strict=True))
    for path in plan.paths:
        kind = STRING if plan.is_text(path) else NUMBERS
        if plan.gridded:
            arrays[path] = ExpectedArray((path,), (lengths[path],), (lengths[path],), (kind,), False)
        else:
            arrays[path] = ExpectedArray(plan.dims, plan.shape, tile, (kind,), True)
    for name in (*ALWAYS, *measure_names(record)):
        types = (ALWAYS[name].dtype.name,) if name in ALWAYS else (NUMBERS, STRING)
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
            entries = json.loads(metadata[place])
            attributes = dict(entries.pop("attributes"))
            if name is None:
                kinds, wrong = dict.fromkeys(attributes, PLAIN), _differences(GROUP, entries)
            else:
                kinds, wrong = ATTRIBUTES, _array_complaints(name, entries, arrays[name])
                types[name] = entries["data_type"]
            wrong += [f"attributes.{key}: vibrocap writes no such thing" for key in _strange(attributes, kinds)]
            wrong = wrong or ([] if name is None else units.complaints(name, attributes))
            complaints += [f"{RESULTS}/{place}: {complaint}" for complaint in wrong]
        except FileNotFoundError:
            complaints.append(f"{RESULTS}/{place} is missing")
        except OSError as error:
            complaints.append(f"{RESULTS}/{place} {why_unread(error)}")
        except (ValueError, LookupError, AttributeError, TypeError, RecursionError):
            complaints.append(f"{RESULTS}/{place}: describes no array; vibrocap writes no such group")
    if complaints:
        raise CaseError(complaints, str(path))
    try:
        for place, data in metadata.items():
            if read_first(path, record, place) != data:
                raise DamageError(f"{RESULTS}/{place} changes while it is read")
        return Results(arrays, types, metadata, is_finished(path, record))
    except DamageError as error:
        raise damaged(path, str(error)) from None


def damaged(path: Path, what: str) -> StoreError:
    """The error of a store that is not as it was written."""
    return StoreError(
        f"{path}: is damaged: {what}. `vibrocap sweep FOLDER --verify` names all damage, the sweep with --resume "
        "(resume=True) mends it"
    )


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
        return [f"{RESULTS} {why_unread(error)}"]
    return sorted(strange)


def _array_complaints(name: str, entries: Mapping[str, Any], expected: ExpectedArray) -> list[str]:
    """In what the entries of an array are not those of the array that the study has."""
    if (kind := entries["data_type"]) not in expected.types:
        return [f"data_type should be {' or '.join(expected.types)}"]
    fill = ALWAYS[name].fill if name in ALWAYS else FILLS[kind]
    wanted = array_entries(kind, fill, expected.shape, expected.chunk, expected.dims)
    del wanted["attributes"]
    return _differences(wanted, entries)


def _differences(wanted: Mapping[str, Any], entries: Mapping[str, Any]) -> list[str]:
    """Which entries of JSON are not as wanted, to the type."""
    right, texts = ({key: json.dumps(x, sort_keys=True) for key, x in own.items()} for own in (wanted, entries))
    wrong = [key for key in dict.fromkeys((*right, *texts)) if right.get(key) != texts.get(key)]
    return [f"{key} should {f'be {right[key]}' if key in right else 'not be there'}" for key in wrong]


def _strange(attributes: Mapping[str, Any], kinds: Mapping[str, Any]) -> list[str]:
    """The attributes that this package does not write, by their name or their type."""
    wrong = [key for key, value in attributes.items() if not isinstance(value, kinds.get(key, ()))]
    flags = attributes.get("flag_values", []) if kinds is ATTRIBUTES else []
    return wrong or (["flag_values"] if any(type(flag) is not int for flag in flags) else [])


FACTORS = ("dimensionless_unit", "scale_factor")


class ArrayUnits:
    """What the attributes of a study's arrays should say of units; record: that of the study.

    A case whose parts are not loaded tells nothing of its scales. Then only arrays without factors are let in.
    """

    def __init__(self, record: Mapping[str, Any]):
        self._paths = plan_of(record).paths
        self._measures = dict(zip(measure_names(record), record["study"]["measures"], strict=True))
        self._system: System | None = None
        self._unknown = ""
        try:
            self._system = case_from_text(record["study"]["case"], "its case").system
        except CaseError as error:
            self._unknown = "; ".join(error.complaints)

    def complaints(self, name: str, attributes: Mapping[str, Any]) -> list[str]:
        """In what the attributes of an array differ; attributes: None for one that is not there."""
        if self._system is None:
            factors = [key for key in FACTORS if attributes.get(key) is not None]
            return [f"{key} cannot be compared with the case of the study: {self._unknown}" for key in factors]
        expected = self._expected(name, self._system)
        complaints = []
        for key, value in expected.items():
            if attributes.get(key) != value and not (key == "units" and attributes.get(key) is None):
                wanted = "not be there" if value is None else f"be {value!r}, by the case of the study"
                complaints.append(f"{key} should {wanted}, got {attributes.get(key)!r}")
        return complaints

    def _expected(self, name: str, system: System) -> dict[str, Any]:
        """Attributes by name, None for one that should not be there; without those of which nothing is known here."""
        factors: dict[str, Any] = dict.fromkeys(FACTORS)
        if name in self._paths:
            with contextlib.suppress(KeyError, StopIteration):  # a path of a part that is not loaded
                factors["units"] = coordinate_attributes(name, system).get("units")
        if (entry := self._measures.get(name)) is None:
            return factors
        if not isinstance(entry, str):
            unit, scale = unit_in(entry["unit"], entry.get("si_unit") or "1", system)
        elif (measure := known_measure(entry, system)) is not None:
            unit, scale = measure_unit(measure, system)
        else:
            return factors
        return {"units": unit, "dimensionless_unit": scale, "scale_factor": None if scale == 1.0 else scale}
