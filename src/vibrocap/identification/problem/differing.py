"""Parameters that differ between records: each record has its own value, or a condition of the record decides.

Each is a sum of coordinates, so that the records still are one fit. A static level keeps its ratio to its Coulomb level
where that one differs.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.identification.problem.coordinates import Coordinate, Space
from vibrocap.identification.problem.samples import Samples

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
        argument = "along" if name in along else "by_record"
        if name not in space.names:
            raise ArgumentError(argument, f"{name!r} is not searched; {suggestion(name, space.names)}")
        if name in by_record and (name in along or list(by_record).count(name) > 1):
            raise ArgumentError(argument, f"{name} is named twice")
        if len(records) < 2:
            raise ArgumentError(argument, "needs several records to fit")
        one, begin = space.coordinates[space.names.index(name)], float(start[space.names.index(name)])
        others = [other.name for other in space.coordinates if other.partner == name]
        followers = tuple(other for other in others if other not in by_record and other not in along)
        if name in by_record:
            differing.append(Differing(name, one.low, one.high, followers=followers))
            for record in records[1:]:
                partner = own_name(one.partner, record.name) if one.partner in by_record else one.partner
                more.append(dataclasses.replace(in_one_record(one, record.name, begin), partner=partner))
            continue
        conditions = [condition_of(record, along[name]) for record in records]
        half = 0.5 * (max(conditions) - min(conditions))
        if not half > 0.0:
            raise ArgumentError(argument, f"{along[name]} is the same in all records")
        size = max(abs(float(space.values(start)[space.names.index(name)])), one.scale if one.form != "log" else 0.0)
        differing.append(Differing(name, one.low, one.high, along[name], float(np.mean(conditions)), followers))
        reach, slope = STEEPEST * size / half, slope_name(name, along[name])
        of: dict[str, Any] = {"nuisance": True, "base": name, "condition": along[name]}
        of |= {"meaning": one.meaning, "unit": one.unit}
        more.append(Coordinate(slope, "linear", -reach, reach, scale=0.1 * size / half, spread=0.0, **of))
    return tuple(differing), tuple(more)


def in_one_record(coordinate: Coordinate, record: str, start: float) -> Coordinate:
    """The coordinate of a parameter's value in one record."""
    of: dict[str, Any] = {"nuisance": True, "base": coordinate.name, "record": record}
    return dataclasses.replace(coordinate, name=own_name(coordinate.name, record), start=start, **of)
