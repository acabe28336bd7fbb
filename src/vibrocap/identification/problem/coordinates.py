"""Coordinates of a search: parameters of a law on the scales on which a fit moves them.

Positive parameters move by factors (their logarithm is the coordinate); one that may be zero does so down to a foot and
linearly below it; a static level is its ratio, at least 1, over the Coulomb level. A box of coordinates then holds only
laws that can exist, and one step is about as large as another. A parameter may differ between records: each has its own
value, or a condition of the record decides. Each is a sum of coordinates, so that the records still are one fit.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.identification.problem.samples import Samples

Form = Literal["log", "foot", "linear", "above", "below"]
LARGEST_RATIO = 20.0
RATIOS = ("law", "search")  # who sets the least and the largest ratio of two levels
WHOSE = {"law": "of the law", "search": "of the search", "given": "that was given"}  # limit, in words
STEP = 1e-4  # square root of the driven law's tolerance, where rounding and curvature meet
COARSE_STEP = 2e-3  # over the steps that samples make when they pass from before a jump of the force to behind it
AT_LIMIT = 1e-7  # of the range of a coordinate: it stands at its end
LARGEST_SUM = 0.98  # of shares of one whole


@dataclasses.dataclass(frozen=True)
class Coordinate:
    """How one parameter p is searched, by a coordinate u.

    log: p = exp(u); foot: p = scale sinh(u), p >= 0; linear: p = scale u;
    above: p = partner exp(u) with u >= 0; below: p = partner exp(-u) with u >= 0 (partner: another parameter's value).
    low, high: bounds of p. start: where a parameter of the measurement begins. spread: standard deviation of u among
    the starts. step: change of u for differences; a coarse one for a law whose force is not smooth in a parameter;
    jumps: whether it is this one (a gap moves the instants at which a joint closes). whose: who sets the ends of the
    range of u: "law" (zero, the order of two levels), "search" (this package) or "given".
    nuisance: whether it is of the measurement, not of the law; meaning, unit: of such a one. base: the parameter whose
    value in one `record` it is, or whose change with a `condition`; state: of the contact, at the record's start.
    """

    name: str
    form: Form
    low: float
    high: float
    scale: float = 1.0
    partner: str = ""
    start: float = 0.0
    spread: float = 0.5
    step: float = STEP
    jumps: bool = False
    whose: tuple[str, str] = ("search", "search")
    nuisance: bool = False
    meaning: str = ""
    unit: str = ""
    base: str = ""
    record: str = ""
    condition: str = ""
    state: str = ""

    def at_limit(self, u: float) -> int:
        """-1 or 1 where a coordinate stands at the lower or the upper end of its range, 0 within."""
        low, high = self.range
        near = AT_LIMIT * (high - low)
        return -1 if u <= low + near else 1 if u >= high - near else 0

    def whose_limit(self, at: int) -> str:
        """Who sets the lower (-1) or upper (1) end of the range."""
        return self.whose[at > 0]

    @property
    def least(self) -> float:
        """Of the parameter, if no range held it."""
        return -math.inf if self.form == "linear" else 0.0

    @property
    def range(self) -> tuple[float, float]:
        """Bounds of the coordinate."""
        if self.form in ("above", "below"):
            return 0.0, float(np.log(LARGEST_RATIO))
        return float(self.inverse(self.low)), float(self.inverse(self.high))

    def value(self, u: np.ndarray, partner: np.ndarray | float = 1.0) -> np.ndarray:
        """The parameter at a coordinate, where its partner has the given value."""
        if self.form == "foot":
            number = self.scale * np.sinh(u)
        elif self.form == "linear":
            number = self.scale * u
        else:
            number = partner * np.exp(-u if self.form == "below" else u)
        return np.clip(number, self.low, self.high)

    def inverse(self, value: float, partner: float = 1.0) -> float:
        """The coordinate of a value of the parameter."""
        if self.form == "log":
            return float(np.log(max(value, 1e-300)))
        if self.form == "foot":
            return float(np.arcsinh(value / self.scale))
        if self.form == "linear":
            return value / self.scale
        ratio = value / partner if self.form == "above" else partner / value
        return float(np.log(max(ratio, 1.0)))

    def slope(self, value: float, u: float) -> float:
        """dp/du at fixed partner."""
        if self.form == "foot":
            return float(self.scale * np.cosh(u))
        return {"log": value, "linear": self.scale, "above": value, "below": -value}[self.form]


@dataclasses.dataclass(frozen=True)
class Space:
    """The coordinates of a search, in an order in which each partner stands before what depends on it; their bounds.

    constants: values of partners that are not searched. shares: parameters whose sum stays below one; where it would
    not, the searched ones among them are scaled down.
    """

    coordinates: tuple[Coordinate, ...]
    constants: dict[str, float] = dataclasses.field(default_factory=dict)
    shares: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(coordinate.name for coordinate in self.coordinates)

    @property
    def low(self) -> np.ndarray:
        return np.array([coordinate.range[0] for coordinate in self.coordinates])

    @property
    def high(self) -> np.ndarray:
        return np.array([coordinate.range[1] for coordinate in self.coordinates])

    def values(self, u: np.ndarray) -> np.ndarray:
        """Parameters [..., p] at coordinates [..., p]."""
        u = np.asarray(u, float)
        values = np.empty_like(u)
        for i, coordinate in enumerate(self.coordinates):
            partner: Any = self.constants.get(coordinate.partner, 1.0)
            if coordinate.partner in self.names:
                partner = values[..., self.names.index(coordinate.partner)]
            values[..., i] = coordinate.value(u[..., i], partner)
        searched = [i for i, name in enumerate(self.names) if name in self.shares]
        if searched:
            room = LARGEST_SUM - sum(self.constants[name] for name in self.shares if name not in self.names)
            total = values[..., searched].sum(axis=-1, keepdims=True)
            values[..., searched] *= np.minimum(1.0, room / total)
        return values

    def named(self, u: np.ndarray) -> dict[str, float]:
        """Parameters by name at coordinates [p]."""
        return dict(zip(self.names, self.values(u).tolist(), strict=True))

    def of(self, values: dict[str, float]) -> np.ndarray:
        """Coordinates of parameters, moved into the bounds."""
        point = []
        for coordinate in self.coordinates:
            partner = values.get(coordinate.partner, self.constants.get(coordinate.partner, 1.0))
            point.append(coordinate.inverse(values[coordinate.name], partner))
        return np.clip(point, self.low, self.high)

    def slopes(self, u: np.ndarray) -> np.ndarray:
        """dp/du [p, p]: how parameters change with coordinates."""
        values = self.values(u)
        jacobian = np.zeros((len(u), len(u)))
        for i, coordinate in enumerate(self.coordinates):
            if coordinate.partner in self.names:
                j = self.names.index(coordinate.partner)
                jacobian[i] = jacobian[j] * values[i] / values[j]
            jacobian[i, i] = coordinate.slope(values[i], u[i])
        return jacobian

    def begun(self, start: np.ndarray) -> np.ndarray:
        """Coordinates of the law, and behind them those of the measurement where they begin."""
        return np.concatenate([start, [coordinate.start for coordinate in self.coordinates[len(start) :]]])

    def with_more(self, coordinates: tuple[Coordinate, ...]) -> "Space":
        """This space and further coordinates after its own."""
        return dataclasses.replace(self, coordinates=(*self.coordinates, *coordinates))

    def with_leader(self, name: str) -> "Space":
        """An equivalent space in which the parameter `name` depends on no other, so that it can be held on a value."""
        own = self.coordinates[self.names.index(name)]
        if own.form not in ("above", "below") or own.partner not in self.names:
            return self
        other = self.coordinates[self.names.index(own.partner)]
        low, high = (other.low, other.high * LARGEST_RATIO) if own.form == "above" else (own.low, own.high)
        leader = dataclasses.replace(own, form="log", partner="", low=low, high=high, whose=other.whose)
        form: Form = "below" if own.form == "above" else "above"
        led = dataclasses.replace(other, form=form, partner=name, whose=RATIOS)
        swapped = {name: led, own.partner: leader}  # each takes the other's place, so that the leader stands first
        # the led one may have followers of its own: they keep their place after it
        order = [swapped.get(coordinate.name, coordinate) for coordinate in self.coordinates]
        return dataclasses.replace(self, coordinates=tuple(order))


LOAD = "load"  # the condition that is the mean normal force
STEEPEST = 10.0  # times its own value, by which a parameter changes over half the range of a condition


@dataclasses.dataclass(frozen=True)
class Differing:
    """A parameter p that differs between records.

    condition: "": a record has its own value p[record], of which the first record's is p; else in a record with the
        condition x it is p + p.condition (x - middle). low, high: bounds of p. followers: what keeps its ratio to p
    """

    name: str
    low: float
    high: float
    condition: str = ""
    middle: float = 0.0
    followers: tuple[str, ...] = ()

    def value(self, values: np.ndarray, names: Sequence[str], record: Samples) -> np.ndarray:
        """[...] in a record, of parameters [..., p]."""
        if not self.condition:
            own = own_name(self.name, record.name)
            return values[..., names.index(own if own in names else self.name)]
        slope = values[..., names.index(slope_name(self.name, self.condition))]
        changed = values[..., names.index(self.name)] + slope * (condition_of(record, self.condition) - self.middle)
        return np.clip(changed, self.low, self.high)


def own_name(name: str, record: str) -> str:
    """What the value of a parameter in one record is called."""
    return f"{name}[{record}]"


def slope_name(name: str, condition: str) -> str:
    """What the change of a parameter with a condition is called."""
    return f"{name}.{condition}"


def condition_of(record: Samples, name: str) -> float:
    """A number that the record was made with, or ArgumentError."""
    return condition_among({LOAD: float(np.mean(record.load)), **record.conditions}, name, record.name)


def condition_among(conditions: Mapping[str, float], name: str, record: str) -> float:
    """One of the numbers that a record was made with, or ArgumentError."""
    if name not in conditions:
        raise ArgumentError("along", f"record {record!r} has no condition {name!r}; {suggestion(name, conditions)}")
    return conditions[name]


def in_record(differing: Sequence[Differing], names: Sequence[str], values: np.ndarray, record: Samples) -> np.ndarray:
    """Parameters [..., p] as they are in a record."""
    own_values = values.copy() if differing else values
    for parameter in differing:
        if parameter.name not in names:  # a gain, of which the first record's is 1
            continue
        at = names.index(parameter.name)
        own_values[..., at] = parameter.value(values, names, record)
        for name in parameter.followers:
            own_values[..., names.index(name)] *= own_values[..., at] / values[..., at]
    return own_values


def differing_parameters(
    space: Space, start: np.ndarray, records: Sequence[Samples], by_record: Sequence[str], along: Mapping[str, str]
) -> tuple[tuple[Differing, ...], tuple[Coordinate, ...]]:
    """What differs, and the further coordinates of it, which begin where nothing differs.

    by_record: parameters with a value for each record; along: conditions, by the parameter that follows them.
    """
    differing, more = [], []
    for name in (*sorted(by_record, key=lambda name: [*space.names, name].index(name)), *along):
        check_differing(name, space.names, by_record, along, len(records))
        one, begin = space.coordinates[space.names.index(name)], float(start[space.names.index(name)])
        others = [other.name for other in space.coordinates if other.partner == name]
        followers = tuple(other for other in others if other not in by_record and other not in along)
        if name in by_record:
            differing.append(Differing(name, one.low, one.high, followers=followers))
            for record in records[1:]:
                partner = own_name(one.partner, record.name) if one.partner in by_record else one.partner
                more.append(dataclasses.replace(in_one_record(one, record.name, begin), partner=partner))
            continue
        middle, half = condition_range(along[name], [condition_of(record, along[name]) for record in records])
        size = max(abs(float(space.values(start)[space.names.index(name)])), one.scale if one.form != "log" else 0.0)
        differing.append(Differing(name, one.low, one.high, along[name], middle, followers))
        reach, slope = STEEPEST * size / half, slope_name(name, along[name])
        of: dict[str, Any] = {"nuisance": True, "base": name, "condition": along[name]}
        of |= {"meaning": one.meaning, "unit": one.unit}
        more.append(Coordinate(slope, "linear", -reach, reach, scale=0.1 * size / half, spread=0.0, **of))
    return tuple(differing), tuple(more)


def check_differing(
    name: str, searched: Sequence[str], by_record: Sequence[str], along: Mapping[str, str], records: int
) -> None:
    """ArgumentError for a parameter that cannot differ between so many records."""
    argument = "along" if name in along else "by_record"
    if name not in searched:
        raise ArgumentError(argument, f"{name!r} is not searched; {suggestion(name, searched)}")
    if name in by_record and (name in along or list(by_record).count(name) > 1):
        raise ArgumentError(argument, f"{name} is named twice")
    if records < 2:
        raise ArgumentError(argument, "needs several records to fit")


def condition_range(name: str, of_records: Sequence[float]) -> tuple[float, float]:
    """(mean of a condition, half of its range), or ArgumentError where it is the same in all records."""
    half = 0.5 * (max(of_records) - min(of_records))
    if not half > 0.0:
        raise ArgumentError("along", f"{name} is the same in all records")
    return float(np.mean(of_records)), half


def in_one_record(coordinate: Coordinate, record: str, start: float) -> Coordinate:
    """The coordinate of a parameter's value in one record."""
    of: dict[str, Any] = {"nuisance": True, "base": coordinate.name, "record": record}
    return dataclasses.replace(coordinate, name=own_name(coordinate.name, record), start=start, **of)
