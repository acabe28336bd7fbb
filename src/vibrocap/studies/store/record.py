"""study.json and the marks of tiles: sealed texts, and the look at them. A store may come from a stranger.

A mark is a file per stored tile, with the checksums of its chunks, written last: a tile that is marked is whole.
Checksums are bound to the study and to the place to which a file belongs: one that was cut short, altered, or put in
place of another one, of this study or of another, has another one. One file more says that all tiles are stored:
then a tile without a mark has lost it.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from vibrocap.case.case import CaseError
from vibrocap.studies.plan.runs import Runs, tile_counts
from vibrocap.studies.plan.study import FORMAT, PLANS
from vibrocap.studies.store.places import DONE, FINISHED, RESULTS, STRANGE, STUDY, read_plain, why_strange, why_unread

LENGTH = 16  # bytes: no chance finds two alike
_LAST = b'"checksum": "'
LARGEST_MARK = 2**20  # bytes of a mark
LARGEST_CHUNK = 2**30

Index = tuple[int, ...]


class ChecksumError(ValueError):
    """A text that is not as it was written."""


def checksum(identity: str, place: str, data: bytes) -> str:
    """BLAKE2b of a file, of its place in the store, and of the study's identity."""
    digest = hashlib.blake2b(f"{identity} {place}\n".encode(), digest_size=LENGTH)
    digest.update(data)
    return digest.hexdigest()


def sealed(entries: Mapping[str, Any], identity: str, place: str) -> bytes:
    """A JSON object, a line for each entry, the last of them the checksum of those before."""
    texts = {key: json.dumps(value, ensure_ascii=False, allow_nan=False) for key, value in entries.items()}
    head = ("{\n" + "".join(f"{json.dumps(key)}: {text},\n" for key, text in texts.items())).encode()
    return head + _end(identity, place, head)


def unsealed(data: bytes, identity: str | None, place: str) -> dict[str, Any]:
    """The entries of a sealed text; ChecksumError where it is not whole. identity: None for that among its entries."""
    head, _, _ = data.rpartition(_LAST)
    try:
        entries = json.loads(data)
        entries.pop("checksum")
        identity = identity or str(entries["identity"])
    except (ValueError, LookupError, AttributeError, TypeError, RecursionError):
        raise ChecksumError("is cut short or altered") from None
    if data != head + _end(identity, place, head):
        raise ChecksumError("is altered: its checksum is of another content")
    return entries


def _end(identity: str, place: str, head: bytes) -> bytes:
    return _LAST + checksum(identity, place, head).encode() + b'"\n}\n'


class DamageError(OSError):
    """Something stored that is not as it was written; the message says what."""


@dataclasses.dataclass(frozen=True)
class Mark:
    """What a mark says: the checksum of each chunk of its tile by array.

    made_by: with what the tile was computed, where that is not with what the study was begun.
    """

    chunks: Mapping[str, str]
    made_by: Mapping[str, str] | None = None


def tile_name(index: Index) -> str:
    """The name of a tile's mark, such as "3.0"."""
    return ".".join(map(str, index))


def chunk_place(name: str, index: Index) -> str:
    """Where a chunk stands among the results."""
    return f"{name}/c.{tile_name(index)}"


def mark_text(identity: str, index: Index, chunks: Mapping[str, bytes], made_by: Mapping[str, str] | None) -> bytes:
    """The content of a mark; chunks: the files of the tile by their place."""
    sums = {place.partition("/")[0]: checksum(identity, place, data) for place, data in chunks.items()}
    entries: dict[str, Any] = {"chunks": sums} | ({"made_by": dict(made_by)} if made_by else {})
    return sealed(entries, identity, f"{DONE}/{tile_name(index)}")


def read_mark(path: Path, record: Mapping[str, Any], index: Index) -> Mark | None:
    """The mark of a tile of the store at a path; None where it has none. DamageError where it is damaged."""
    try:
        data = _read(path, f"{DONE}/{tile_name(index)}", LARGEST_MARK, "its mark")
    except FileNotFoundError:
        return None
    try:
        entries = unsealed(data, record["identity"], f"{DONE}/{tile_name(index)}")
        return Mark(entries["chunks"], entries.get("made_by"))
    except ChecksumError as error:
        raise DamageError(f"its mark {error}") from None


def is_mark(path: Path, name: str) -> bool:
    """Whether a file among the marks was written as one, of whichever tile and study."""
    try:
        entries = json.loads(read_plain(path, f"{DONE}/{name}", LARGEST_MARK))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(entries, dict) and entries.keys() - {"made_by"} == {"chunks", "checksum"}


def finished_text(identity: str, tiles: int) -> bytes:
    """The content of the file that says that all tiles are stored."""
    return sealed({"tiles": tiles}, identity, FINISHED)


def is_finished(path: Path, record: Mapping[str, Any]) -> bool:
    """Whether a store says that all of its tiles were stored; DamageError where what says so is damaged."""
    try:
        unsealed(_read(path, FINISHED, LARGEST_MARK, FINISHED), record["identity"], FINISHED)
    except FileNotFoundError:
        return False
    except ChecksumError as error:
        raise DamageError(f"{FINISHED} {error}") from None
    return True


def read_chunk(path: Path, record: Mapping[str, Any], name: str, index: Index, mark: Mark) -> bytes:
    """A chunk of a marked tile; DamageError where it is missing or not as it was written."""
    return _checked(path, record, chunk_place(name, index), mark.chunks.get(name), name)


def read_first(path: Path, record: Mapping[str, Any], place: str) -> bytes:
    """A file of the results that belongs to no tile; DamageError where it is missing or not as it was written."""
    return _checked(path, record, place, record["files"].get(place), f"{RESULTS}/{place}")


def _checked(path: Path, record: Mapping[str, Any], place: str, wanted: str | None, what: str) -> bytes:
    """A file of the results that has the checksum that is wanted of it."""
    try:
        data = _read(path, f"{RESULTS}/{place}", LARGEST_CHUNK, what)
    except FileNotFoundError:
        raise DamageError(f"{what} is missing") from None
    if wanted != checksum(record["identity"], place, data):
        raise DamageError(f"{what} is altered: its checksum is of another content")
    return data


def _read(path: Path, place: str, limit: int, what: str) -> bytes:
    try:
        return read_plain(path, place, limit)
    except OSError as error:
        if error.errno in STRANGE:
            raise DamageError(f"{what} {why_strange(error)}") from None
        raise


LARGEST = 2**30  # bytes of study.json: of some ten million values
MOST_RUNS_OF_A_TILE, MOST_TILES = 2**26, 2**24


class DamagedRecord(CaseError):
    """A study.json that is not as it was written."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


_Path = Annotated[str, Field(pattern=r"^[A-Za-z_].*\.[A-Za-z_][A-Za-z0-9_]*$")]  # "drives.clamp.amplitude" is one too
_Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_Count = Annotated[int, Field(ge=1, le=2**62)]
_Texts = dict[str, str]


class _Axis(_Strict):
    path: _Path
    values: Annotated[list[FiniteFloat | str], Field(min_length=1)]


class _Column(_Strict):
    path: _Path
    values: Annotated[list[FiniteFloat | str | None], Field(min_length=1)]


class _Range(_Strict):
    path: _Path
    low: FiniteFloat
    high: FiniteFloat
    logarithmic: bool


class _Design(_Strict):
    kind: str
    runs: _Count
    seed: Annotated[int, Field(ge=0)]


class _Grid(_Strict):
    kind: Literal["grid"]
    axes: Annotated[list[_Axis], Field(min_length=1)]


class _Cases(_Strict):
    kind: Literal["cases"]
    columns: Annotated[list[_Column], Field(min_length=1)]


class _Drawn(_Strict):
    kind: Literal["design"]
    design: _Design
    ranges: Annotated[list[_Range], Field(min_length=1)]


class _OwnMeasure(_Strict):
    name: Annotated[str, Field(pattern=r"^\w+$")]
    meaning: str
    unit: str
    si_unit: str = "1"
    how: str
    kind: str | None = None
    of: list[str] | None = None
    function: str


class _Study(_Strict):
    case: str
    plan: Annotated[_Grid | _Cases | _Drawn, Field(discriminator="kind")]
    measures: list[Annotated[str, Field(pattern=r"^\w+$")] | _OwnMeasure]
    window: int
    settle: FiniteFloat | None
    extrapolate: bool = False
    device: str
    code: _Texts
    parts: dict[str, _Hash] = {}


class _Record(_Strict):
    format: str
    identity: _Hash
    study: _Study
    tile: Annotated[list[_Count], Field(min_length=1)]
    files: dict[str, Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]]
    made_with: _Texts


def record_text(record: Mapping[str, Any]) -> bytes:
    return sealed(record, record["identity"], STUDY)


def read_record(path: Path, name: str = STUDY) -> dict[str, Any]:
    """What study.json says; CaseError where a folder holds no store of this program, or one that does not fit together.

    name: of the file. DamagedRecord where it is not as it was written.
    """
    try:
        data = read_plain(path, name, LARGEST)
        record = json.loads(data, parse_constant=_refuse)
        known = record["format"]
    except FileNotFoundError:
        complaint = "no such folder" if not path.exists() else f"holds no study: there is no {name} in it"
        raise CaseError([complaint], str(path)) from None
    except NotADirectoryError:
        raise CaseError(["is a file, not the folder of a study"], str(path)) from None
    except OSError as error:
        raise CaseError([f"its {name} {why_unread(error)}"], str(path)) from None
    except (ValueError, KeyError, TypeError, RecursionError):
        if (path / RESULTS).is_dir():
            raise DamagedRecord([f"its {name} is damaged: it cannot be read"], str(path)) from None
        raise CaseError([f"holds no study: its {name} is of another kind"], str(path)) from None
    if known != FORMAT:
        raise CaseError([f"is of another format ({known!r}) than this version reads ({FORMAT!r})"], str(path))
    try:
        record = unsealed(data, None, STUDY)
    except ChecksumError as error:
        raise DamagedRecord([f"its {name} is damaged: it {error}"], str(path)) from None
    try:
        _Record.model_validate(record)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(step) for step in first["loc"])
        raise CaseError([f"{name}: {place}: {first['msg']}"], str(path)) from None
    if wrong := _disagreement(record):
        raise CaseError([f"{name}: {wrong}"], str(path))
    return record


def plan_of(record: Mapping[str, Any]) -> Runs:
    plan = record["study"]["plan"]
    return PLANS[plan["kind"]].from_record(plan)


def measure_names(record: Mapping[str, Any]) -> list[str]:
    """The names of a record's measures."""
    return [measure if isinstance(measure, str) else measure["name"] for measure in record["study"]["measures"]]


def _disagreement(record: Mapping[str, Any]) -> str | None:
    """What in a record, whose entries are each of the right kind, does not go together."""
    plan, names = plan_of(record), measure_names(record)
    if len({*plan.paths}) < len(plan.paths) or len({*names}) < len(names):
        return "a name is given twice"
    if len({len(column["values"]) for column in record["study"]["plan"].get("columns", ())}) > 1:
        return "its columns are of different lengths"
    tile = tuple(record["tile"])
    if len(tile) != len(plan.shape) or any(size > length for size, length in zip(tile, plan.shape, strict=True)):
        return f"tiles of the shape {tile} do not suit runs of the shape {plan.shape}"
    size, count = math.prod(tile), math.prod(tile_counts(plan.shape, tile))
    if size > MOST_RUNS_OF_A_TILE or count > MOST_TILES:
        return f"{count:,} tiles of {size:,} runs are too many or too large"
    return None


def _refuse(constant: str) -> Any:
    raise ValueError(constant)
