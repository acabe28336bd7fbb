"""Plans: which runs a study consists of, and how they lie along the dimensions of its results.

A plan (`Grid`, `CaseList`, `designs.Drawn`) knows its runs by rule and gives out the values of any block of them, so
that a study of any size needs memory for one block only. A grid is every combination of the values along its axes; in
a list of cases each run has values of its own.
"""

import collections
import dataclasses
import functools
import math
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Self

import numpy as np

from vibrocap.arguments import Complaint, Complaints, listed, shown, suggestion
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.physics.names import split_path
from vibrocap.ranges import values_between

Block = tuple[slice, ...]


@dataclasses.dataclass(frozen=True)
class Column:
    """The values at one path in the order in which they were given: numbers, words, or None where there is none."""

    path: str
    values: tuple[float | str | None, ...]

    @functools.cached_property
    def array(self) -> np.ndarray:
        """Floats, NaN for None; with words among them an array of objects."""
        if any(isinstance(value, str) for value in self.values):
            array = np.empty(len(self.values), dtype=object)
            array[:] = self.values
            return array
        return np.array([np.nan if value is None else value for value in self.values], dtype=float)

    @property
    def is_text(self) -> bool:
        return self.array.dtype == object


@dataclasses.dataclass(frozen=True)
class Runs:
    """What every plan offers; each defines `varied`, `shape`, `values`, `record` and `from_record`.

    kind: its name in a stored study. gridded: whether each path is a dimension of its own, with its values along it;
    if not, all runs lie along one dimension, `dim`, and each path has a value for every run.
    varied: what varies, each with its path, and whether some of its values are words; shape: runs along each dimension
    """

    kind: ClassVar[str]
    gridded: ClassVar[bool] = False
    dim: ClassVar[str] = ""

    @property
    def varied(self) -> tuple[Any, ...]:
        raise NotImplementedError

    @property
    def shape(self) -> tuple[int, ...]:
        raise NotImplementedError

    def values(self, block: Block) -> dict[str, np.ndarray]:
        """Values of the runs in a block, in C order: arrays [runs of the block] by path.

        Numbers are floats, NaN where a run has no value of its own; words (and None) are in arrays of objects.
        """
        raise NotImplementedError

    def record(self) -> dict[str, Any]:
        """The plan as JSON can hold it; all that identifies it. `from_record` is the way back."""
        raise NotImplementedError

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        raise NotImplementedError

    @property
    def paths(self) -> tuple[str, ...]:
        return tuple(variation.path for variation in self.varied)

    @property
    def dims(self) -> tuple[str, ...]:
        return self.paths if self.gridded else (self.dim,)

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def is_text(self, path: str) -> bool:
        return any(variation.path == path and variation.is_text for variation in self.varied)


class ListedRuns(Runs):
    """A plan whose values are listed. listed: the name of the field with its columns, in records too."""

    listed: ClassVar[str]

    @property
    def varied(self) -> tuple[Column, ...]:
        return getattr(self, self.listed)

    def record(self) -> dict[str, Any]:
        columns = [{"path": variation.path, "values": list(variation.values)} for variation in self.varied]
        return {"kind": self.kind, self.listed: columns}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        return cls(tuple(Column(variation["path"], tuple(variation["values"])) for variation in record[cls.listed]))  # type: ignore[call-arg]


def tile_counts(shape: tuple[int, ...], tile: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(-(-length // size) for length, size in zip(shape, tile, strict=True))


MOST_VALUES = 10_000_000  # along an axis: they are listed, in memory (a gigabyte) and in the store
EVEN = 1e-9  # relative spread of the ratios along an axis that is evenly spaced in its logarithm
FORMS = "LOW:HIGH:COUNT, log:LOW:HIGH:COUNT or a list such as 1,2,3"


@dataclasses.dataclass(frozen=True)
class Grid(ListedRuns):
    """Every combination of the values of some axes; the axes are the dimensions, in their order."""

    axes: tuple[Column, ...]

    kind = "grid"
    listed = "axes"
    gridded = True

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)

    def axis(self, path: str) -> Column:
        return self.axes[self.dims.index(path)]

    def values(self, block: Block) -> dict[str, np.ndarray]:
        rows = [axis.array[part] for axis, part in zip(self.axes, block, strict=True)]
        crossed = np.meshgrid(*rows, indexing="ij")
        return {path: values.ravel() for path, values in zip(self.dims, crossed, strict=True)}


def axis_of(path: str, asked: Any) -> tuple[Column, list[str]]:
    """The axis that text, a number or a sequence describes, and what is wrong with it."""
    if isinstance(asked, str) and ":" in asked and is_kind(path):
        return Column(path, ()), [Complaint(path, f"should be a list of {listed(kinds_of(path.partition('.')[0]))}")]
    values, complaints = _text_values(asked) if isinstance(asked, str) else _listed_values(asked)
    if not complaints:
        complaints = _row_complaints(path, values)
    return Column(path, tuple(values)), [Complaint(path, complaint) for complaint in complaints]


def _listed_values(listed_values: Any) -> tuple[list[Any], list[str]]:
    if isinstance(listed_values, np.ndarray):
        if listed_values.ndim > 1:
            return [], [f"should be a list of values, got an array of shape {listed_values.shape}"]
        if len(np.atleast_1d(listed_values)) > MOST_VALUES:
            return [], [_too_many(listed_values.size)]
        listed_values = listed_values.tolist()
    if isinstance(listed_values, (int, float, np.generic)):
        listed_values = [listed_values]
    if isinstance(listed_values, Mapping) or not isinstance(listed_values, Iterable):
        return [], [f"should be a list of values, got {shown(listed_values)}"]
    values, complaints = list[Any](), []
    for value in listed_values:
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            complaints.append(f"should hold numbers or words, got {shown(value)}")
        elif isinstance(value, str):
            values.append(value)
        else:
            values.append(_float(value))
    return values, complaints[:1]


def _float(value: float) -> float:
    """A number as a float, without a sign of zero; infinite where it is beyond all floats."""
    try:
        return float(value) + 0.0
    except OverflowError:
        return math.inf


def _text_values(text: str) -> tuple[list[Any], list[str]]:
    if ":" in text:
        ends, complaints = range_of(text, counted=True)
        if ends is None:
            return [], complaints
        low, high, logarithmic, count = ends
        if count > MOST_VALUES:
            return [], [_too_many(count)]
        return values_between(low, high, count, logarithmic).tolist(), []
    words = [word.strip() for word in text.split(",")]
    if "" in words:
        return [], [f"should be {FORMS}, got {text!r}"]
    return [_number_or_word(word) for word in words], []


def _too_many(count: int) -> str:
    return f"has {count:,} values, {MOST_VALUES:,} at most can be listed; a design spreads more runs over a range"


def _number_or_word(word: str) -> float | str:
    try:
        return _float(float(word))
    except ValueError:
        return word


def range_of(text: str, *, counted: bool) -> tuple[tuple[float, float, bool, int] | None, list[str]]:
    """(low, high, logarithmic, count) of LOW:HIGH:COUNT, or of LOW:HIGH where nothing is counted; else complaints."""
    form = "LOW:HIGH:COUNT or log:LOW:HIGH:COUNT" if counted else "LOW:HIGH or log:LOW:HIGH"
    pieces = [piece.strip() for piece in text.split(":")]
    logarithmic = pieces[0] == "log"
    try:
        least, most, *counts = pieces[logarithmic:]
        low, high = _float(float(least)), _float(float(most))
        (count,) = map(int, counts) if counted else (0, *counts)
    except ValueError:
        return None, [f"should be {form}, got {text!r}"]
    complaints = end_complaints(low, high, logarithmic, text)
    if counted and count < 2:
        complaints.append(f"a range should have at least 2 values, got {count}; a single value stands alone")
    return (None, complaints) if complaints else ((low, high, logarithmic, count), [])


def end_complaints(low: float, high: float, logarithmic: bool, asked: Any) -> list[str]:
    if not (math.isfinite(low) and math.isfinite(high)):
        return [f"the ends of a range should be finite numbers, got {shown(asked)}"]
    if low == high:
        return [f"the range {shown(asked)} is empty: its ends are equal"]
    if low > high:
        return [f"the range {shown(asked)} is reversed: its lower end should come first"]
    if logarithmic and low <= 0:
        return [f"a logarithmic range should begin above 0, got {shown(asked)}"]
    return []


def even_in_logarithm(values: np.ndarray) -> bool:
    """Whether the values of an axis are positive and evenly spaced in their logarithm."""
    if len(values) < 3 or values[0] <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) <= EVEN * (ratios[0] - 1.0))


def _row_complaints(path: str, values: list[Any]) -> list[str]:
    if not values:
        return ["has no values"]
    strange = [value for value in values if isinstance(value, float) and not math.isfinite(value)]
    if strange:
        return [f"should hold finite numbers, got {strange[0]} (value {values.index(strange[0]) + 1})"]
    if is_kind(path):
        known = list(kinds_of(split_path(path)[0]))
        unknown = [value for value in values if value not in known]
        if unknown:
            return [f"there is no {shown(unknown[0])}; {suggestion(unknown[0], known)}"]
    if path.startswith("initial.") and any(isinstance(value, str) for value in values):
        return [f"should hold numbers, got {shown(next(value for value in values if isinstance(value, str)))}"]
    twice = [value for value, count in collections.Counter(values).items() if count > 1]
    return [f"holds {shown(twice[0])} twice"] if twice else []


@dataclasses.dataclass(frozen=True)
class CaseList(ListedRuns):
    """A list of cases, along the dimension "case"; where one has no value, the study's own case speaks."""

    columns: tuple[Column, ...]

    kind = "cases"
    listed = "columns"
    dim = "case"

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.columns[0].values),)

    def values(self, block: Block) -> dict[str, np.ndarray]:
        return {column.path: column.array[block[0]] for column in self.columns}

    def case(self, index: int) -> dict[str, float | str]:
        pairs = ((column.path, column.values[index]) for column in self.columns)
        return {path: value for path, value in pairs if value is not None}


def case_list(cases: Iterable[Any]) -> tuple[CaseList, list[str]]:
    """The list of such cases as {path: value, ...}, and what is wrong with it (whatever the paths stand for)."""
    rows: list[Mapping[str, Any]] = []
    complaints = Complaints()
    for number, case in enumerate(cases):
        if not isinstance(case, Mapping) or not case:
            complaints.add(f"cases[{number}]", f"should be {{path: value, ...}}, got {shown(case)}")
            continue
        row = {path: value.item() if isinstance(value, np.generic) else value for path, value in case.items()}
        rows.append(row)
        for path, value in row.items():
            if complaint := _complaint(path, value):
                complaints.add(f"cases[{number}]", f"{path}: {complaint}")
    if not rows and not complaints:
        complaints.add("cases", "there are none")
    if complaints:
        return CaseList(()), complaints
    paths = dict.fromkeys(path for row in rows for path in row)
    return CaseList(tuple(Column(path, tuple(_plain(row.get(path)) for row in rows)) for path in paths)), []


def _plain(value: Any) -> float | str | None:
    return value if value is None or isinstance(value, str) else float(value) + 0.0


def _complaint(path: Any, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return f"should be a number or a word, got {shown(value)}"
    if not isinstance(value, str) and not abs(value) < math.inf:
        return f"should be a finite number, got {value}"
    if is_kind(path) and value not in (known := list(kinds_of(split_path(path)[0]))):
        return f"there is no {shown(value)}; {suggestion(value, known)}"
    if str(path).startswith(INITIAL) and isinstance(value, str):
        return f"should be a number, got {shown(value)}"
    return ""
