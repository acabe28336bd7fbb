"""The corners of a drive as functions of the parameter vector, and the segment that holds at a time."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import Expression, evaluate, evaluated, reachable

NEAR = 2.0 * float(np.finfo(float).eps)  # of the period, as in the kernel: a segment that ends so soon is over


@dataclasses.dataclass(frozen=True, eq=False)
class Corners:
    """The segments of a drive in one period, as functions of the parameter vector.

    place: number of the first parameter that belongs to the present segment; coefficients: per segment
    parts: how many equal ones the period has, to rounding, each of all these segments: samples of a controller, or 1.0
    lengths, shapes: of each segment of a part its share of the period and its coefficients in powers of the share; may
        depend on the time at which the part begins
    """

    place: int
    coefficients: int
    period: Expression
    lengths: tuple[Expression, ...]
    shapes: tuple[tuple[Expression, ...], ...]
    parts: Expression

    @property
    def row_size(self) -> int:
        """Numbers per segment of a table: the share at its end, its coefficients."""
        return 1 + self.coefficients

    @functools.cached_property
    def numbers(self) -> list[Expression]:
        """Of each segment of a part its length, then its coefficients."""
        return [e for length, shape in zip(self.lengths, self.shapes, strict=True) for e in (length, *shape)]

    @functools.cached_property
    def counted(self) -> list[int]:
        """Numbers of the parameters that decide how many parts there are, and where their corners lie."""
        return [] if self.parts.value == 1.0 else self._reached([self.period, self.parts, *self.lengths])

    @functools.cached_property
    def _moving(self) -> list[int]:
        """Numbers of the parameters on which the table depends."""
        return self._reached([*self.numbers, *([] if self.parts.value == 1.0 else [self.period])])

    @functools.cached_property
    def _decisive(self) -> list[int]:
        """Numbers of the parameters on which table and period depend."""
        return self._reached([*self.numbers, self.period, self.parts])

    def _reached(self, expressions: Sequence[Expression]) -> list[int]:
        graph = self.period.graph
        nodes = (graph.nodes[i] for i in reachable(graph, [e.index for e in expressions]))
        return [operands[0] for op, *operands in nodes if op == "parameter"]

    def count(self, parameters: np.ndarray) -> int:
        """How many parts the period has with parameters [..., parameters], as many with all of them."""
        (parts,) = evaluate([self.parts], 0.0, (), 1.0, np.moveaxis(parameters, -1, 0))
        return round(float(np.ravel(parts)[0]))

    def tables(self, parameters: np.ndarray) -> np.ndarray:
        """[runs, segments, row_size] of parameter vectors [runs, parameters]; one table if it is the same for all."""
        if np.all(parameters[:, self._moving] == parameters[:1, self._moving]):
            parameters = parameters[:1]
        runs, parts = len(parameters), self.count(parameters)
        begins = np.arange(parts)[:, None] * (self.periods(parameters) / parts)
        columns = evaluated(self.numbers, begins, (), 1.0, parameters.T, (parts, runs))
        tables = np.ascontiguousarray(columns.T).reshape(runs, parts, -1, self.row_size)
        tables[..., 0] = np.cumsum(tables[..., 0], axis=2) + (np.arange(parts) / parts)[:, None]
        tables[:, :, -1, 0] = np.arange(1, parts + 1) / parts  # where no rounding adds up
        return tables.reshape(runs, -1, self.row_size)

    def periods(self, parameters: np.ndarray) -> np.ndarray:
        """[runs] periods of the drive."""
        return evaluated([self.period], 0.0, (), 1.0, parameters.T, (len(parameters),))[0]

    def of_one(self, parameters: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """([1, segments, row_size] table, [1] period) of one parameter vector, whatever segment it holds."""
        return _of_one(self, tuple(parameters[i] for i in self._decisive))

    def filled(self, parameters: np.ndarray, time: Any = 0.0) -> np.ndarray:
        """Parameter vectors [..., parameters] with the segment that holds at a time since the start of the period."""
        rows = np.atleast_2d(np.array(parameters, dtype=float))
        known = self.of_one(tuple(rows[0])) if len(rows) == 1 else (self.tables(rows), self.periods(rows))
        _, present = self.present(*known, np.broadcast_to(time, (len(rows),)))
        rows[:, self.place :] = present.T
        return rows.reshape(np.shape(parameters))

    def present(
        self, tables: np.ndarray, periods: np.ndarray, time: np.ndarray, near: float = NEAR
    ) -> tuple[np.ndarray, np.ndarray]:
        """(number of the segment [n], its numbers in the parameter vector [2 + coefficients, n]) at times [n].

        tables: [n or 1, segments, row_size]; periods: [n or 1]; time: since the start of the period
        near: share of the period from which on a segment that is left counts as over
        """
        time = np.asarray(time, dtype=float)
        if len(tables) == 1:
            share = time / periods + near
            number = np.searchsorted(tables[0, :, 0], share, side="right")
        else:
            number = np.sum(tables[:, :, 0] <= (time / periods + near)[:, None], axis=1)
        number = np.minimum(number, tables.shape[1] - 1)
        which = np.arange(len(time)) if len(tables) > 1 else np.zeros(len(time), dtype=int)
        start = np.where(number > 0, tables[which, number - 1, 0], 0.0) * periods
        divisors = np.broadcast_to(periods, (self.coefficients, len(time))).copy()
        divisors[:1] = 1.0
        scale = np.divide.accumulate(np.vstack((np.ones((1, len(time))), divisors)))[1:].T  # as the kernel does it
        coefficients = tables[which, number, 1:] * scale
        return number, np.stack((np.broadcast_to(periods, time.shape), start, *coefficients.T))


@functools.lru_cache(maxsize=64)
def _of_one(corners: Corners, decisive: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    row = np.zeros((1, corners.place))
    row[0, corners._decisive] = decisive
    return corners.tables(row), corners.periods(row)
