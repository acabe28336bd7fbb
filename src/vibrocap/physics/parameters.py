"""Parts of a system, a machine, a law or a drive: frozen records of parameters, checked when they are made.

A parameter declares beside its default its symbol, its meaning and its role, one of `ROLES`, hence its dimension:
`parameter(0.15, "eta_c", "friction coefficient at high speed", "level")`. Fits know from the role where to start,
conversions to SI by which scales to multiply. One without such a role declares its unit, `unit="N s/m"`, or nothing:
then fits start from its default, and it cannot be converted.
"""

import dataclasses
import functools
import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass as _checked_dataclass
from pydantic.dataclasses import is_pydantic_dataclass
from pydantic.fields import FieldInfo

from vibrocap.arguments import Complaint, restated, shown, suggestion


@dataclasses.dataclass(frozen=True)
class Dimension:
    """Exponents of the kinds of quantity that make up a parameter.

    coefficient: a force over the normal load, which is a force itself where the load is not known. effort: what a drive
    exerts, a force or a torque, as the machine takes it (`Machine.effort`).
    """

    coefficient: float = 0.0
    force: float = 0.0
    length: float = 0.0
    time: float = 0.0
    effort: float = 0.0

    def __mul__(self, other: "Dimension") -> "Dimension":
        return Dimension(*(a + b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __truediv__(self, other: "Dimension") -> "Dimension":
        return Dimension(*(a - b for a, b in zip(self.exponents, other.exponents, strict=True)))

    def __pow__(self, exponent: float) -> "Dimension":
        return Dimension(*(exponent * a for a in self.exponents))

    @property
    def exponents(self) -> tuple[float, ...]:
        """Of coefficient, force, length, time and effort."""
        return dataclasses.astuple(self)

    def resolved(self, effort: "Dimension", known_load: bool = True) -> "Dimension":
        """The dimension in force, length and time alone: with what a drive exerts, and with or without a known load."""
        force = self.force + (0.0 if known_load else self.coefficient)
        return Dimension(force=force, length=self.length, time=self.time) * effort**self.effort

    def unit(self, known_load: bool = True) -> str:
        """The SI unit in N, m and s, "1" for a number; what a drive exerts counts as a force."""
        own = self.resolved(FORCE, known_load)
        powers = {"N": own.force, "m": own.length, "s": own.time}
        above = [unit + ("" if e == 1 else f"^{e:g}") for unit, e in powers.items() if e > 0]
        below = [unit + ("" if e == -1 else f"^{-e:g}") for unit, e in powers.items() if e < 0]
        return (" ".join(above) or "1") + ("/" + " ".join(below) if below else "")


NUMBER = Dimension()
COEFFICIENT, EFFORT = Dimension(coefficient=1.0), Dimension(effort=1.0)
FORCE, LENGTH, TIME = Dimension(force=1.0), Dimension(length=1.0), Dimension(time=1.0)
TORQUE, SPEED, MASS, FREQUENCY = FORCE * LENGTH, LENGTH / TIME, FORCE * TIME**2 / LENGTH, NUMBER / TIME

# Every role with its dimension.
ROLES = {
    # of friction laws
    "level": COEFFICIENT,  # friction coefficient at high speed, or the only one
    "static level": COEFFICIENT,  # friction coefficient at rest, not below the level
    "Stribeck velocity": SPEED,  # speed over which friction drops
    "fading velocity": SPEED,  # speed over which the damping of the contact fades
    "decay rate": NUMBER / SPEED,  # rate of that drop over speed
    "exponent": NUMBER,  # sharpness of a knee or a drop
    "viscous damping": FORCE / SPEED,
    "stiffness": FORCE / LENGTH,  # of the contact, or of a spring along the line of travel
    "bristle damping": FORCE / SPEED,
    "fraction": NUMBER,  # between 0 and 1
    "share": NUMBER,  # one of several shares of a whole, which are less than it together
    "softening": NUMBER,  # of the contact as it yields; below zero it hardens
    "attraction rate": COEFFICIENT / TIME,  # at which a force follows its level
    "direct effect": COEFFICIENT,  # of the speed on friction, at once
    "evolution effect": COEFFICIENT,  # of the speed on friction, as the contact is renewed
    "distance": LENGTH,  # of sliding, over which the contact is renewed
    "gap": LENGTH,  # play in which no force acts
    "back ratio": NUMBER,  # level in sliding back, over that in sliding forward
    "smoothing velocity": SPEED,  # speed over which friction changes its sign
    "reference velocity": SPEED,  # a convention: at which other parameters are given
    "cutoff velocity": SPEED,  # speed below which a law ceases to hold
    "convention": NUMBER,  # a number that is chosen, not measured
    # of machines
    "mass": MASS,
    "load": FORCE,
    "speed": SPEED,
    "inertia": MASS * LENGTH**2,
    "torque": TORQUE,  # also the load of a contact whose friction is one
    "torsional stiffness": TORQUE,
    "torsional damping": TORQUE * TIME,
    # of environments
    "quadratic damping": MASS / LENGTH,  # a force over the square of a speed
    # of controllers
    "position gain": EFFORT / LENGTH,  # also of the integral of a speed
    "position integral gain": EFFORT / (LENGTH * TIME),
    "position rate gain": EFFORT / SPEED,
    "position anti-windup": LENGTH / EFFORT,
    "velocity anti-windup": SPEED / EFFORT,
    "angle rate gain": EFFORT * TIME,
    "angle anti-windup": NUMBER / EFFORT,
    # of drives
    "effort": EFFORT,  # force or torque; of a reference, what it is
    "effort rate": EFFORT / TIME,
    "effort acceleration": EFFORT / TIME**2,
    "frequency": FREQUENCY,  # angular
    "phase": NUMBER,  # an angle in radians
    "duration": TIME,
}

_UNITS = {"1": NUMBER, "rad": NUMBER, "N": FORCE, "m": LENGTH, "s": TIME, "kg": MASS, "J": TORQUE, "W": TORQUE / TIME}


@functools.cache
def dimension_of_role(role: str) -> Dimension:
    """The dimension of a role. Raises ValueError with the nearest name for a role that there is not."""
    if role not in ROLES:
        raise ValueError(f"role: there is no role {role!r}; {suggestion(role, ROLES)}")
    return ROLES[role]


@functools.cache
def dimension_of_unit(unit: str) -> Dimension:
    """The dimension of a unit such as "N s/m" or "1/s": products, one division, powers as in "s^2".

    Raises ValueError for what is none.
    """
    above, *below = unit.split("/")
    dimension = NUMBER
    for text, sign in ((above, 1.0), *((part, -1.0) for part in below)):
        for factor in text.split():
            match = re.fullmatch(r"(\w+?)(?:\^(-?\d+(?:\.\d+)?))?", factor)
            if match is None or match[1] not in _UNITS:
                raise ValueError(f"unit: {factor!r} in {unit!r} is none of {', '.join(_UNITS)}, nor a power of one")
            dimension = dimension * _UNITS[match[1]] ** (sign * float(match[2] or 1))
    if len(below) > 1 or not all(part.strip() for part in (above, *below)):
        raise ValueError(f'unit: should be as "N s/m" or "1/s", with one "/" at most, got {unit!r}')
    return dimension


Record = TypeVar("Record")

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Fraction = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
MOST = 1e300  # of a number that is finite


def allowed(wanted: str, words: tuple[str | None, ...], most: float = -1.0) -> BeforeValidator:
    """The check of a value that is one of some words, None among them, or a number from 0 to `most`.

    wanted: what is said of another value
    """

    def checked(value: Any) -> Any:
        if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value <= most:
            return float(value)
        if isinstance(value, (str, type(None))) and value in words:
            return value
        raise ValueError(f"should be {wanted}")

    return BeforeValidator(checked)


def parameter(
    default: Any, symbol: str, meaning: str, role: str = "", *, unit: str = "", over: str = "", in_si: str = ""
) -> Any:
    """A field with its default, its symbol in the literature, what it means and what it does.

    role: one of `ROLES`; unit: in place of a role that there is not, the SI unit ("N s/m")
    over: what follows the meaning but in SI, the rest of a ratio: "spring", over=", k/(m omega_0^2)".
    in_si: what it means in SI, where another ratio is meant: a "mass" in place of a "mass over another".
    Raises ValueError: a role or a unit that there is not, or both given.
    """
    if role and unit:
        raise ValueError(f"parameter: a role has its unit already; give role={role!r} or unit={unit!r}, not both")
    dimension = dimension_of_role(role) if role else dimension_of_unit(unit) if unit else None
    extra: Any = {"symbol": symbol, "role": role, "dimension": dimension, "in_si": in_si or meaning, "unit": unit}
    return Field(default=default, description=meaning + over, json_schema_extra=extra)


class ParameterError(ValueError):
    """Parameters that a part does not take: `complaints` holds every one, with its field and what would be right."""

    def __init__(self, owner: str, complaints: Iterable[Complaint]):
        self.owner, self.complaints = owner, tuple(complaints)
        super().__init__(f"{owner}: " + "; ".join(self.complaints))

    def __reduce__(self):
        return type(self), (self.owner, self.complaints)

    def within(self, part: str, asked: Mapping[str, tuple[str, Any, Any]] = {}) -> "ParameterError":
        """The same for a part of a system. asked: by field the path by which it was set, its value here and there."""
        fields = ((f"{part}.{fault.field}", fault.text) for fault in self.complaints)
        faults = ((asked.get(field, (field, None, None)), text) for field, text in fields)
        return ParameterError("the system", (Complaint(path, restated(text, *x)) for (path, *x), text in faults))


@dataclass_transform(frozen_default=True)
def parameters(cls: type[Record]) -> type[Record]:
    """Class decorator: a frozen dataclass whose fields are checked and whose unknown names are refused."""
    record: Any = _checked_dataclass(frozen=True, repr=False, eq=False, config=ConfigDict(extra="forbid"))(cls)
    record.__eq__, record.__repr__ = _same, _shown  # as dataclasses make them, but not anew for each of 90 classes
    record.__hash__ = lambda self: hash(_values(self))
    checked = record.__init__

    @functools.wraps(checked)
    def __init__(self, *values, **named):
        try:
            checked(self, *values, **named)
        except ValidationError as error:
            known = [info.name for info in parameter_table(type(self))]
            complaints = [_complaint(problem, known) for problem in error.errors()]
        else:
            return
        raise ParameterError(type(self).__name__, complaints)  # out of the block, so that it shows no other error

    record.__init__ = __init__
    return record


def _values(record: Any) -> tuple:
    return tuple(map(vars(record).__getitem__, record.__match_args__))


def _same(record: Any, other: Any) -> bool:
    return _values(record) == _values(other) if type(other) is type(record) else NotImplemented


def _shown(record: Any) -> str:
    pairs = zip(record.__match_args__, _values(record), strict=True)
    return f"{type(record).__qualname__}({', '.join(f'{name}={value!r}' for name, value in pairs)})"


@dataclasses.dataclass(frozen=True)
class ParameterInfo:
    """What is known of a parameter: role and unit "", dimension None where not declared; in_si: its meaning there."""

    name: str
    symbol: str
    meaning: str
    default: Any
    role: str = ""
    dimension: Dimension | None = None
    in_si: str = ""
    unit: str = ""


def parameter_table(record: Any) -> tuple[ParameterInfo, ...]:
    """The parameters of a record or of its class, in order."""
    return _parameter_table(record if isinstance(record, type) else type(record))


def bounds(record: Any, name: str) -> tuple[float, float]:
    """(least, most) that a parameter of a record or of its class may be by itself, infinite where there is no bound.

    A value that is excluded itself, such as 0 of what is positive, is replaced by the next number.
    """
    fields: dict[str, Any] = (record if isinstance(record, type) else type(record)).__pydantic_fields__
    least, most = -math.inf, math.inf
    for limit in fields[name].metadata:
        least = max(least, getattr(limit, "ge", least), math.nextafter(getattr(limit, "gt", -math.inf), math.inf))
        most = min(most, getattr(limit, "le", most), math.nextafter(getattr(limit, "lt", math.inf), -math.inf))
    return least, most


def given_parameters(record: Any) -> dict[str, Any]:
    """The values of a record's parameters by name, without those that are none."""
    values = {info.name: getattr(record, info.name) for info in parameter_table(record)}
    return {name: value for name, value in values.items() if value is not None}


def _declaring(cls: type) -> Any:
    """The class that declares the parameters of a class: itself, or the last one above it that declares any."""
    for kind in cls.__mro__:
        if is_pydantic_dataclass(kind):
            return kind
        if any(isinstance(value, FieldInfo) for value in vars(kind).values()):
            break
    raise TypeError(f"{cls.__name__} should have @parameters (from vibrocap import parameters) above its class")


@functools.cache
def _parameter_table(cls: type) -> tuple[ParameterInfo, ...]:
    table = []
    for name, field in _declaring(cls).__pydantic_fields__.items():
        extra = field.json_schema_extra or {}
        declared = extra.get("role", ""), extra.get("dimension"), extra.get("in_si", ""), extra.get("unit", "")
        table.append(ParameterInfo(name, extra.get("symbol", ""), field.description or "", field.default, *declared))
    return tuple(table)


def complaint_of(text: str) -> Complaint:
    """What a part says of itself as a whole, "field should ...", about that field; of all "parameters" otherwise."""
    field, between, rest = text.partition(" should ")
    return Complaint(field, f"should {rest}") if between else Complaint("parameters", text)


def _complaint(problem: Any, known: list[str]) -> Complaint:
    """One of pydantic's errors in our words: the field, what would be right and what was given."""
    kind, context = problem["type"], problem.get("ctx", {})
    field = ".".join(str(step) for step in problem["loc"])
    if kind == "unexpected_keyword_argument":
        return Complaint(field, f"there is no such parameter; {suggestion(field, known)}")
    if kind == "unexpected_positional_argument":
        return Complaint(f"value {int(field) + 1}", f"there are {len(known)} parameters: {', '.join(known)}")
    if kind in ("missing", "missing_argument"):
        return Complaint(field, "is missing")
    if kind == "value_error":  # raised by a part itself, in its own words
        wanted = str(context["error"])
        if not field:
            return complaint_of(wanted)
    else:
        wanted = {
            "greater_than": f"should be greater than {context.get('gt', 0):g}",
            "greater_than_equal": f"should be at least {context.get('ge', 0):g}",
            "less_than": f"should be less than {context.get('lt', 0):g}",
            "less_than_equal": f"should be at most {context.get('le', 0):g}",
            "finite_number": "should be a finite number",
            "float_type": "should be a number",
        }.get(kind, problem["msg"].replace("Input should", "should"))
    return Complaint(field, f"{wanted}, got {shown(problem['input'])}")


@dataclasses.dataclass(frozen=True)
class PartInSI:
    """A part whose parameters are given in SI; `System` makes the part of it, by the scales of its machine.

    part: its class. values: by keys that carry their unit, such as "bristle_stiffness_N_per_m".
    """

    part: type
    values: Mapping[str, Any]


class Part:
    """What every machine, law and drive offers besides its physics.

    source: where it was published: works separated by semicolons, each by its key in the bibliography of the package
        (`vibrocap/citations/bibliography.bib`) or in words; "vibrocap" where it was made here
    wrappers, wrapped: of the class of a wrapped part, the wrappers from the inside out, and the plain part in them
    """

    source: ClassVar[str] = ""
    wrappers: ClassVar[tuple[Callable, ...]] = ()
    wrapped: ClassVar[Any] = None

    @classmethod
    def in_si(cls, **values: Any) -> Any:
        """This part with its parameters in SI, each with its unit in its name: `Harmonic.in_si(frequency_Hz=5, ...)`.

        The keys are those of a case file in SI; `System` takes it, if its other parts are in SI too.
        """
        return PartInSI(cls, values)


def wrapped_class(wrapper: Callable, cls: Any, part: Any) -> Any:
    """Finish the class of a wrapped law or drive: its name, its documentation, its fields, and how it is pickled.

    wrapper: the function that makes it   cls: the class, whose base is the part   part: the class that is wrapped
    """
    cls.__name__ = cls.__qualname__ = f"{wrapper.__name__.title()}{part.__name__}"
    cls.__doc__ = f"{part.__name__}, {wrapper.__name__}: see `{wrapper.__module__}`.\n\n    {part.__doc__}"
    cls.name = f"{wrapper.__name__}-{part.name}"
    cls.wrappers, cls.wrapped = (*part.wrappers, wrapper), part.wrapped or part
    cls.__reduce__ = _pickled
    return parameters(cls)


def inner_part(part: Any, outer: Any) -> Any:
    """The part inside a wrapped one, with its parameters; what the wrapper says anew it does not see."""
    inner = object.__new__(part)
    vars(inner).update(vars(outer))
    return inner


def _pickled(part: Any) -> tuple:
    """How to make a wrapped part again; its class can be found in no module."""
    values = {field.name: getattr(part, field.name) for field in dataclasses.fields(part)}
    return _unpickled, (part.wrapped, part.wrappers, values)


def _unpickled(part: Any, wrappers: tuple[Callable, ...], values: Mapping[str, Any]) -> Any:
    for wrapper in wrappers:
        part = wrapper(part)
    return part(**values)
