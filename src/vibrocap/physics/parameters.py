"""Records of parameters: frozen, checked when they are made, each field with its symbol, its meaning and its role.

A part of a system (a machine, a law, a drive) is such a record. Wrong values and unknown names are refused with a
ParameterError (a ValueError) that names every bad field, what was given and what would be right.
"""

import dataclasses
import functools
import math
from collections.abc import Iterable
from typing import Annotated, Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass as _checked_dataclass
from pydantic.dataclasses import is_pydantic_dataclass

from vibrocap.arguments import Complaint, shown, suggestion
from vibrocap.physics.roles import Dimension, dimension_of_role, dimension_of_unit

Record = TypeVar("Record")

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]


def parameter(default: Any, symbol: str, meaning: str, role: str = "", *, unit: str = "", in_si: str = "") -> Any:
    """A field with its default, its symbol in the literature, what it means and what it does.

    role: one of `vibrocap.physics.roles.ROLES` ("level", "stiffness", "frequency"...), from which fits know where to
    start and conversions to SI its dimension. unit: in place of a role that there is not, the SI unit ("N s/m").
    in_si: what it means in SI, where the meaning speaks of a ratio: a "mass" in place of a "mass over another".
    Raises ValueError: a role or a unit that there is not, or both given.
    """
    if role and unit:
        raise ValueError(f"parameter: a role has its unit already; give role={role!r} or unit={unit!r}, not both")
    dimension = dimension_of_role(role) if role else dimension_of_unit(unit) if unit else None
    extra: Any = {"symbol": symbol, "role": role, "dimension": dimension, "in_si": in_si or meaning}
    return Field(default=default, description=meaning, json_schema_extra=extra)


class ParameterError(ValueError):
    """Parameters that a part does not take: `complaints` holds every one, with its field and what would be right."""

    def __init__(self, owner: str, complaints: Iterable[Complaint]):
        self.owner, self.complaints = owner, tuple(complaints)
        super().__init__(f"{owner}: " + "; ".join(self.complaints))

    def __reduce__(self):
        return type(self), (self.owner, self.complaints)

    def within(self, part: str) -> "ParameterError":
        """The same for a part of a system, with fields such as "machine.mass_ratio"."""
        return ParameterError("the system", (each.about(f"{part}.{each.field}") for each in self.complaints))


@dataclass_transform(frozen_default=True)
def parameters(cls: type[Record]) -> type[Record]:
    """Class decorator: a frozen dataclass whose fields are checked and whose unknown names are refused."""
    made: Any = _checked_dataclass(frozen=True, config=ConfigDict(extra="forbid"))(cls)
    checked = made.__init__

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

    made.__init__ = __init__
    return made


@dataclasses.dataclass(frozen=True)
class ParameterInfo:
    """What is known of one parameter: its name in code, its symbol, its meaning, its default, its role and dimension.

    role: "" where none is declared; dimension: None where neither a role nor a unit is. in_si: its meaning in SI.
    """

    name: str
    symbol: str
    meaning: str
    default: Any
    role: str = ""
    dimension: Dimension | None = None
    in_si: str = ""


def parameter_table(record: Any) -> tuple[ParameterInfo, ...]:
    """The parameters of a record or of its class, in order."""
    return _parameter_table(record if isinstance(record, type) else type(record))


def bounds(record: Any, name: str) -> tuple[float, float]:
    """(least, most) that a parameter of a record or of its class may be by itself, infinite where there is no bound.

    A value that is excluded itself, such as 0 of what is positive, is replaced by the next number.
    """
    fields: dict[str, Any] = (record if isinstance(record, type) else type(record)).__pydantic_fields__
    least, most = -math.inf, math.inf
    for each in fields[name].metadata:
        least = max(least, getattr(each, "ge", least), math.nextafter(getattr(each, "gt", -math.inf), math.inf))
        most = min(most, getattr(each, "le", most), math.nextafter(getattr(each, "lt", math.inf), -math.inf))
    return least, most


def given_parameters(record: Any) -> dict[str, Any]:
    """The values of a record's parameters by name, without those that are none."""
    values = {info.name: getattr(record, info.name) for info in parameter_table(record)}
    return {name: value for name, value in values.items() if value is not None}


def described(record: Any, digits: int = 6) -> str:
    """A record in a line: its name, and the values of its parameters to so many digits."""
    values = given_parameters(record).items()
    return f"{record.name}: {', '.join(f'{name} {_brief(value, digits)}' for name, value in values)}"


def _brief(value: Any, digits: int) -> str:
    if isinstance(value, tuple):
        return f"{len(value)} numbers"
    return value if isinstance(value, str) else f"{value:.{digits}g}"


@functools.cache
def _parameter_table(cls: type) -> tuple[ParameterInfo, ...]:
    assert is_pydantic_dataclass(cls)
    fields: dict[str, Any] = cls.__pydantic_fields__
    found = []
    for name, field in fields.items():
        extra = field.json_schema_extra or {}
        known = extra.get("symbol", ""), field.description or "", field.default
        declared = extra.get("role", ""), extra.get("dimension"), extra.get("in_si", "")
        found.append(ParameterInfo(name, *known, *declared))
    return tuple(found)


def complaint_of(said: str) -> Complaint:
    """What a part says of itself as a whole, "field should ...", about that field; of all "parameters" otherwise."""
    field, between, rest = said.partition(" should ")
    return Complaint(field, f"should {rest}") if between else Complaint("parameters", said)


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
