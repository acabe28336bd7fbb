"""Axes: along each of them one quantity takes a row of values; a grid is every combination of them."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, listed, shown, suggestion
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.physics.names import split_path
from vibrocap.ranges import values_between
from vibrocap.studies.plan.runs import Block, Column, ListedRuns

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
    values: list[Any] = []
    complaints = []
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
    numbers = pieces[logarithmic:]
    wanted = 3 if counted else 2
    try:
        low, high = _float(float(numbers[0])), _float(float(numbers[1]))
        count = int(numbers[2]) if counted else 0
        if len(numbers) != wanted:
            raise ValueError
    except (ValueError, IndexError):
        return None, [f"should be {form}, got {text!r}"]
    complaints = end_complaints(low, high, logarithmic, text)
    if counted and count < 2:
        complaints.append(f"a range should have at least 2 values, got {count}; a single value stands alone")
    return (None, complaints) if complaints else ((low, high, logarithmic, count), [])


def end_complaints(low: float, high: float, logarithmic: bool, asked: Any) -> list[str]:
    """What is wrong with the ends of a range."""
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
    """What is wrong with a row of values, whatever they stand for."""
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
    earlier: set[Any] = set()
    for value in values:
        if value in earlier:
            return [f"holds {shown(value)} twice"]
        earlier.add(value)
    return []
