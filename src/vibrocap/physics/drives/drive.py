"""The contract of a drive: the generalised force that the actuator applies."""

import bisect
import dataclasses
import functools
import itertools
import math
import sys
from typing import Annotated, Any, ClassVar

from pydantic import Field, WrapValidator

from vibrocap.physics.elementary import cos  # noqa: F401 for parts
from vibrocap.physics.parameters import NonNegative, Number, Part, Positive, parameter, parameters  # noqa: F401 for parts

Share = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
WithinOne = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)]  # a share, but neither 0 nor 1

# None, left out in a case: of a signal, the frequency of the drive.
Frequency = Annotated[Positive, WrapValidator(lambda value, checked: value if value is None else checked(value))]

FREQUENCY = parameter(1.0, "omega", "drive frequency", "frequency", over=" over the machine's natural frequency")
ROUNDING = 64.0 * sys.float_info.epsilon  # of values over the largest, and of times over the period


class Drive(Part):
    """What every drive offers: its value, its period, and whether it is odd under half a period.

    A drive that imposes a motion, of machines such as the crawler, has a slope and a curvature too.
    """

    name: ClassVar[str]

    def value(self, t):
        """Drive at time t, periodic with `period`."""
        raise NotImplementedError

    def slope(self, t):
        """Rate of the drive at time t; only of drives that impose a motion."""
        raise NotImplementedError

    def curvature(self, t):
        """Rate of the slope at time t; only of drives that impose a motion."""
        raise NotImplementedError

    def beside(self, drive: "Drive") -> "Drive":
        """This drive as a signal beside the drive of the machine."""
        return self

    @property
    def continuous(self) -> bool:
        """Whether the value never jumps."""
        return True

    @property
    def period(self) -> float:
        """Time after which the drive repeats."""
        raise NotImplementedError

    @property
    def time_scale(self):
        """Time that measures how fast it moves a machine: its period, unless that holds many of its waves."""
        return self.period

    @property
    def odd(self) -> bool:
        """Whether value(t + period/2) = -value(t); then the half-period symmetry of the capsule holds."""
        raise NotImplementedError


class Wave(Drive):
    """A drive with an angular frequency."""

    frequency: Any

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.frequency

    def beside(self, drive: Drive) -> Drive:
        """The same with the frequency of the drive where it has none of its own."""
        if self.frequency is not None:
            return self
        frequency = drive.frequency if isinstance(drive, Wave) else 2.0 * math.pi / drive.period
        beside = object.__new__(type(self))
        vars(beside).update(vars(self), frequency=frequency)
        return beside


@dataclasses.dataclass(frozen=True)
class Segment:
    """What a drive does between two corners.

    length: share of the period, 0 or more; a segment without length is passed over
    coefficients: of the shape as a polynomial in x, the share of the period since the start of the segment
    """

    length: Any
    coefficients: tuple


class Piecewise(Drive):
    """A drive with corners or jumps: between them its shape is a polynomial in time; the value is `size` times that.

    A motion has no step across a corner: the corners are instants that are known beforehand. `segments` is called
    with numbers, and with symbols to learn how the corners and coefficients follow from the parameters; like all
    formulas of a part it should not branch on a value. What only multiplies belongs into `size`.

    joined: whether, with all numbers, each segment ends where the next one begins; else `continuous` compares them
    """

    joined: ClassVar[bool] = False

    @property
    def degree(self) -> int:
        """Of the polynomials."""
        return max(len(segment.coefficients) for segment in self.segments()) - 1

    def segments(self) -> tuple[Segment, ...]:
        """The segments of one period in order, whose lengths together are 1."""
        raise NotImplementedError

    def size(self):
        """What the shape is multiplied with."""
        return 1.0

    def on_segment(self, start: Any, coefficients: tuple) -> "Piecewise":
        """This drive while one of its segments lasts, wherever that is.

        start: time at which the segment begins; coefficients: of its shape, in powers of the time since then
        """
        held = object.__new__(type(self))
        vars(held).update(vars(self), _present=(start, coefficients))
        return held

    def _polynomial(self, t, order: int):
        present = vars(self).get("_present")
        if present is None:
            t = t - self.period * math.floor(t / self.period)
            present = segment_in_time(segment_table(self), t / self.period, self.period)
        start, coefficients = present
        powers = range(order, len(coefficients))
        factors = [math.prod(range(k - order + 1, k + 1)) * coefficients[k] for k in powers]
        result = factors[-1] if factors else 0.0
        for factor in factors[-2::-1]:
            result = result * (t - start) + factor
        return self.size() * result

    def value(self, t):
        """The polynomial of the segment in which t lies; at a corner that of the next one."""
        return self._polynomial(t, 0)

    def slope(self, t):
        return self._polynomial(t, 1)

    def curvature(self, t):
        return self._polynomial(t, 2)

    @property
    def continuous(self) -> bool:
        """Whether each segment ends where the next one begins, to rounding."""
        if self.joined or self.size() == 0.0:
            return True
        table = segment_table(self)
        plain = all(type(number) in (int, float) for row in table for number in row)
        return (_is_continuous if plain else _is_continuous.__wrapped__)(table)  # what only stands for one is not kept

    @property
    def odd(self) -> bool:
        """Whether the second half of the segments is the first one with the other sign, to rounding."""
        return self.size() == 0.0 or _is_odd(segment_table(self))


class PiecewiseWave(Wave, Piecewise):
    """A wave with corners or jumps, between heights of h and -h."""

    amplitude: Any

    def size(self):
        return self.amplitude


Table = tuple[tuple[float, ...], ...]  # a row for each segment: the share of the period at its end, its coefficients


def check_shares(**shares: float) -> None:
    """ValueError for a piece that is no longer than rounding, of which there are no coefficients."""
    for name, share in shares.items():
        if not share > ROUNDING:
            raise ValueError(f"{name} should be more than {ROUNDING:.2g} of the period, got {share:.2g} of it")


def segment_table(drive: Piecewise) -> Table:
    """The segments of a drive that have a length, as rows (share of the period at the end, coefficients)."""
    rows, end = [], 0.0
    for segment in drive.segments():
        end += segment.length
        if segment.length > 0.0:
            rows.append((end, *segment.coefficients))
    return tuple(rows)


def segment_in_time(table: Table, share: float, period: float) -> tuple[float, tuple]:
    """(start, coefficients in time) of the segment in which a share of the period lies."""
    place = next((i for i, row in enumerate(table[:-1]) if share < row[0]), len(table) - 1)
    start = table[place - 1][0] if place else 0.0
    return start * period, tuple(c / period**k for k, c in enumerate(table[place][1:]))


def _shape(row: tuple[float, ...], x: float) -> float:
    result = 0.0
    for coefficient in row[:0:-1]:
        result = result * x + coefficient
    return result


def _largest(table: Table) -> float:
    starts = (0.0, *(row[0] for row in table))
    return max(abs(_shape(row, x)) for row, start in zip(table, starts, strict=False) for x in (0.0, row[0] - start))


@functools.lru_cache(maxsize=64)
def _is_continuous(table: Table) -> bool:
    starts, bound = (0.0, *(row[0] for row in table)), ROUNDING * _largest(table)
    ends = [_shape(row, row[0] - start) for row, start in zip(table, starts, strict=False)]
    return all(abs(end - _shape(table[(i + 1) % len(table)], 0.0)) <= bound for i, end in enumerate(ends))


@functools.lru_cache(maxsize=64)
def _is_odd(table: Table) -> bool:
    """Both halves compared, between all corners, at more points than their degree allows to differ."""
    starts, ends = (0.0, *(row[0] for row in table[:-1])), [row[0] for row in table]

    def shape(x: float) -> float:
        place = min(bisect.bisect_right(ends, x), len(table) - 1)
        return _shape(table[place], x - starts[place])

    bound = ROUNDING * _largest(table)
    return all(abs(shape(x) + shape(x + 0.5)) <= bound for x in half_points(table))


def half_points(table: Table) -> list[float]:
    """Shares of the first half of the period, of which none is at a corner of either half and some between any two."""
    cuts = sorted({0.0, 0.5, *(row[0] if row[0] < 0.5 else row[0] - 0.5 for row in table)})
    shares = [(j + 0.5) / len(table[0]) for j in range(len(table[0]))]
    pairs = [(low, high) for low, high in itertools.pairwise(cuts) if high - low > ROUNDING and high <= 0.5]
    return [low + (high - low) * share for low, high in pairs for share in shares]
