"""study.json: what it holds, and the look at it before anything in it is used. A store may come from a stranger."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from vibrocap.case.case import CaseError
from vibrocap.studies.plan.runs import Runs, tile_counts
from vibrocap.studies.plan.study import FORMAT, PLANS
from vibrocap.studies.store.marks import ChecksumError, sealed, unsealed
from vibrocap.studies.store.places import RESULTS, STUDY, read_plain, why_unread

LARGEST = 2**30  # bytes of study.json: of some ten million values
MOST_RUNS_OF_A_TILE, MOST_TILES = 2**26, 2**24


class DamagedRecord(CaseError):
    """A study.json that is not as it was written."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


_Path = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*$")]
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
