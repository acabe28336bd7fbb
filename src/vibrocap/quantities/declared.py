"""Declarations: what a number is, said by its type, `period: Time` or `state: ByName`.

Each is an `Annotated` type whose note is a `Declared`: it knows the unit and what one dimensionless unit is in it.
"""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError


@dataclasses.dataclass(frozen=True)
class WithUnit:
    """A number, or numbers, in an SI unit; dimensionless: the same without it, None where no scales are known."""

    value: Any
    unit: str
    dimensionless: Any = None

    def __format__(self, digits: str) -> str:
        return f"{self.value:{digits}} {self.unit}"


def without_unit(value: Any) -> Any:
    """The value of a quantity; what has no unit, as it is."""
    return value.value if isinstance(value, WithUnit) else value


def scaled(value: Any, factor: float) -> Any:
    """A number or a quantity times a factor; a zero without its sign."""
    if not isinstance(value, WithUnit):
        return value * factor + 0.0
    return WithUnit(value.value * factor + 0.0, value.unit, value.dimensionless * factor + 0.0)


@dataclasses.dataclass(frozen=True)
class Context:
    """Where a number stands: the system it belongs to, which knows its scales, and the records and calls around it.

    system: None where numbers are seen as they were computed, without units
    around: records, and arguments of calls by name, the nearest first
    """

    system: Any
    around: tuple[Any, ...] = ()

    @property
    def units(self) -> Any:
        """Factor and unit of every quantity, `physics.units.Units`."""
        return self.system.si

    def within(self, owner: Any) -> "Context":
        """The same, seen from inside a record or a call."""
        return dataclasses.replace(self, around=(owner, *self.around))

    def known(self, name: str) -> list[Any]:
        """What the records and calls around have under a name, the nearest first."""
        values = (owner.get(name) if isinstance(owner, Mapping) else vars(owner).get(name) for owner in self.around)
        return [value for value in values if value is not None]

    @property
    def state_names(self) -> tuple[str, ...]:
        """Of the system, or of that of the records around."""
        return (self.known("system") if self.system is None else [self.system])[0].state_names

    def kept(self) -> "Context":
        """The same with nothing of the calls but their words: what a record in SI remembers."""
        words = (
            {key: x for key, x in owner.items() if isinstance(x, (str, bool))} if isinstance(owner, Mapping) else owner
            for owner in self.around
        )
        return dataclasses.replace(self, around=tuple(words))


class Declared:
    """What a number is. Give `unit` and `scale`, or `converted` where these do not suffice."""

    def unit(self, context: Context) -> str:
        """The SI unit, "1" where there is none; ArgumentError where it holds quantities of several units."""
        raise ArgumentError(
            "name", "should name one quantity; this holds several, each with its own unit, see its names"
        )

    def seen(self, value: Any, context: Context) -> Any:
        """A value as views show it: a `WithUnit` where it has a unit; by name where it holds several."""
        unit = "1" if context.system is None or value is None or isinstance(value, str) else self.unit(context)
        return value if unit == "1" else WithUnit(self.converted(value, context), unit, value)

    def scale(self, context: Context) -> Any:
        """What one dimensionless unit is in the unit: a number, or an array that goes with the value."""
        return context.units.factor_of(self.unit(context))

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        """A value in SI; back: one in SI without units. What has no unit stays as it is, to the last bit."""
        if isinstance(value, (list, tuple)):
            return type(value)(self.converted(element, context, back) for element in value)
        if not isinstance(value, (int, float, np.ndarray, np.number)) or self.unit(context) == "1":
            return value
        return value / self.scale(context) if back else value * self.scale(context)


@dataclasses.dataclass(frozen=True)
class In(Declared):
    """A quantity that is always in the same unit, such as "N s/m"; "N m s/rad" where the contact turns."""

    name: str

    def unit(self, context: Context) -> str:
        return context.units.of_contact(self.name)


@dataclasses.dataclass(frozen=True)
class Named(Declared):
    """The quantity of a motion that an argument or a field around names: `at(t, name)`."""

    by: str

    def unit(self, context: Context) -> str:
        names = context.known(self.by)
        return context.units.unit(names[0]) if names else "1"


class WithoutUnits(dict):
    """Values by name that are without units, whatever system they are given to."""


class OfNames(Declared):
    """Values by the names of quantities; what is given under a name with its unit ("position_m") stays as it is."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        if not isinstance(value, Mapping) or (back and isinstance(value, WithoutUnits)):
            return value
        return {name: self._one(str(name), element, context, back) for name, element in value.items()}

    def seen(self, value: Any, context: Context) -> Any:
        if not isinstance(value, Mapping) or context.system is None:
            return value
        return {name: In(context.units.unit(name)).seen(element, context) for name, element in value.items()}

    @staticmethod
    def _one(name: str, value: Any, context: Context, back: bool) -> Any:
        return In(context.units.unit(name)).converted(value, context, back)


class Keyed(dict):
    """Values by name that know the keys under which they were given, such as "angle_deg"."""

    keys_given: tuple[str, ...] = ()


class OfKeys(OfNames):
    """The same; what is given under a name with its unit becomes what it is without."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        if not back or not isinstance(value, Mapping):
            return super().converted(value, context, back)
        states = Keyed(context.units.states_of(super().converted(value, context, back)))
        states.keys_given = tuple(value)
        return states


@dataclasses.dataclass(frozen=True)
class AlongNames(Declared):
    """An array with a quantity for each index along an axis: `states` [points, states].

    names: fields around that name them, by default the states of the system
    """

    axis: int
    names: tuple[str, ...] = ()

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        names, value = self._along(context), np.asarray(value)
        shape = [1] * value.ndim
        shape[self.axis] = len(names)
        scale = np.array([context.units.factor(name) for name in names]).reshape(shape)
        return value / scale if back else value * scale

    def seen(self, value: Any, context: Context) -> Any:
        columns = dict(zip(self._along(context), np.moveaxis(np.asarray(value), self.axis, 0), strict=True))
        return OfNames().seen(columns, context)

    def _along(self, context: Context) -> list[str]:
        named = [name for element in self.names for name in context.known(element)[0]]
        return named or list(context.state_names)


class Words(Declared):
    """What a record says in words, which quote numbers without units."""

    def unit(self, context: Context) -> str:
        return "1"

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        quotes = isinstance(value, str) and any(letter.isdigit() for letter in value)
        return f"{value} (these numbers are dimensionless)" if quotes and not back else value

    def seen(self, value: Any, context: Context) -> Any:
        return value if context.system is None else self.converted(value, context)


class AsGiven(Declared):
    """What a function takes as it is given, in SI or without units, to show it."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        return value

    def seen(self, value: Any, context: Context) -> Any:
        return value


class InItsUnit(AsGiven):
    """A number that its record holds in the unit that it names itself, in the field `unit`."""

    def unit(self, context: Context) -> str:
        return next(iter(context.known("unit")), "1")

    def seen(self, value: Any, context: Context) -> Any:
        unit = self.unit(context)
        if value is None or unit == "1":
            return value
        return WithUnit(value, unit, None if context.system is None else value / context.units.factor_of(unit))


@dataclasses.dataclass(frozen=True)
class Measured(AsGiven):
    """A number that was measured in an SI unit, or a record of such numbers; "" is the unit of force of the record."""

    name: str

    def seen(self, value: Any, context: Context) -> Any:
        if dataclasses.is_dataclass(value):
            return {field.name: self.seen(getattr(value, field.name), context) for field in dataclasses.fields(value)}
        unit = self.name or context.known("force_unit")[0]
        return WithUnit(value, unit) if isinstance(value, float) and unit != "1" else value


class OverStates(Declared):
    """A matrix of derivatives of states by states: [states, states]."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        scale = np.array([context.units.factor(name) for name in context.system.state_names])
        return value / scale[:, None] * scale if back else value * scale[:, None] / scale


class Over:
    """The dimensions along which an array of a record lies, for labelled arrays and tables; it stands in the type.

    dims: names, or members of the record that hold one; of a list of records: that of the list
    name: of the array if it is a coordinate, or the member that holds it (`over`); else the array has the member's name
    words: what it is; flags: words by code, of an array of codes
    """

    def __init__(self, *dims: str, name: str = "", words: str = "", flags: Mapping[str, int] | None = None):
        self.dims, self.name, self.words, self.flags = dims, name, words, flags


class AlongTurns(Declared):
    """An array with a number for each coordinate that turns along its last axis."""

    def unit(self, context: Context) -> str:
        return "1"

    def seen(self, value: Any, context: Context) -> Any:
        return dict(zip(context.known("system")[0].turns, np.moveaxis(value, -1, 0), strict=True))


# numbers
Number = Annotated[float, In("1")]
Time = Annotated[float, In("s")]
Rate = Annotated[float, In("1/s")]
AngularFrequency = Annotated[float, In("rad/s")]
Length = Annotated[float, In("m")]
Speed = Annotated[float, In("m/s")]
Acceleration = Annotated[float, In("m/s^2")]
Force = Annotated[float, In("N")]
Damping = Annotated[float, In("N s/m")]
Work = Annotated[float, In("J")]
# arrays
Numbers = Annotated[np.ndarray, In("1")]
Times = Annotated[np.ndarray, In("s")]
Rates = Annotated[np.ndarray, In("1/s")]
AngularFrequencies = Annotated[np.ndarray, In("rad/s")]
Lengths = Annotated[np.ndarray, In("m")]
Speeds = Annotated[np.ndarray, In("m/s")]
Forces = Annotated[np.ndarray, In("N")]
Reason = Annotated[str, Words()]
# results to be shown
Shown = Annotated[Any, AsGiven()]
# measured
Seconds = Annotated[float, Measured("s")]
RecordedForce = Annotated[float, Measured("")]
# results that name their unit themselves
NumberInUnit = Annotated[float, InItsUnit()]
NumbersInUnit = Annotated[np.ndarray, InItsUnit()]
# by name
ByName = Annotated[Mapping[str, Any], OfNames()]
ByKey = Annotated[Mapping[str, Any], OfKeys()]
States = Annotated[dict[str, float], OfNames()]
StateColumns = Annotated[np.ndarray, AlongNames(-1)]  # [..., states]
StateRows = Annotated[np.ndarray, AlongNames(0)]  # [states, ...]
Derivative = Annotated[np.ndarray, OverStates()]
NamedArray = Annotated[np.ndarray, Named("name")]  # of the quantity that the argument `name` names
