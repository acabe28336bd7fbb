"""The contract of a plan: which runs a study consists of, and how they lie along the dimensions of its results.

A plan (`Grid`, `CaseList`, `Drawn`) knows its runs by rule and gives out the values of any block of them, so that a
study of any size needs memory for one block only.
"""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np

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
        """Whether some value is a word."""
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
        """How many runs."""
        return math.prod(self.shape)

    def is_text(self, path: str) -> bool:
        """Whether some value at a path is a word."""
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
    """How many tiles there are along each dimension."""
    return tuple(-(-length // size) for length, size in zip(shape, tile, strict=True))
