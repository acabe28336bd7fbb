"""Records of parameters: frozen, checked when they are made, each field with its symbol, its meaning and its role.

A part of a system (a machine, a law, a drive) is such a record. Wrong values are refused with pydantic's
ValidationError (a ValueError) that names every bad field, what was given and what would be right.
"""

import dataclasses
import functools
from typing import Annotated, Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as _checked_dataclass
from pydantic.dataclasses import is_pydantic_dataclass

from vibrocap.physics.roles import Dimension, dimension_of_role, dimension_of_unit

Record = TypeVar("Record")

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]


def parameter(default: Any, symbol: str, meaning: str, role: str = "", *, unit: str = "") -> Any:
    """A field with its default, its symbol in the literature, what it means and what it does.

    role: one of `vibrocap.physics.roles.ROLES` ("level", "stiffness", "frequency"...), from which fits know where to
    start and conversions to SI its dimension. unit: in place of a role that there is not, the SI unit ("N s/m").
    Raises ValueError: a role or a unit that there is not, or both given.
    """
    if role and unit:
        raise ValueError(f"parameter: a role has its unit already; give role={role!r} or unit={unit!r}, not both")
    dimension = dimension_of_role(role) if role else dimension_of_unit(unit) if unit else None
    extra: Any = {"symbol": symbol, "role": role, "dimension": dimension}
    return Field(default=default, description=meaning, json_schema_extra=extra)


@dataclass_transform(frozen_default=True)
def parameters(cls: type[Record]) -> type[Record]:
    """Class decorator: a frozen dataclass whose fields are checked and whose unknown names are refused."""
    return _checked_dataclass(frozen=True, config=ConfigDict(extra="forbid"))(cls)  # type: ignore[return-value]


@dataclasses.dataclass(frozen=True)
class ParameterInfo:
    """What is known of one parameter: its name in code, its symbol, its meaning, its default, its role and dimension.

    role: "" where none is declared; dimension: None where neither a role nor a unit is.
    """

    name: str
    symbol: str
    meaning: str
    default: Any
    role: str = ""
    dimension: Dimension | None = None


def parameter_table(record: Any) -> tuple[ParameterInfo, ...]:
    """The parameters of a record or of its class, in order."""
    return _parameter_table(record if isinstance(record, type) else type(record))


def given_parameters(record: Any) -> dict[str, Any]:
    """The values of a record's parameters by name, without those that are none."""
    values = {info.name: getattr(record, info.name) for info in parameter_table(record)}
    return {name: value for name, value in values.items() if value is not None}


def described(record: Any, digits: int = 6) -> str:
    """A record in a line: its name, and the values of its parameters to so many digits."""
    values = given_parameters(record).items()
    words = (f"{name} {value if isinstance(value, str) else f'{value:.{digits}g}'}" for name, value in values)
    return f"{record.name}: {', '.join(words)}"


@functools.cache
def _parameter_table(cls: type) -> tuple[ParameterInfo, ...]:
    assert is_pydantic_dataclass(cls)
    fields: dict[str, Any] = cls.__pydantic_fields__
    found = []
    for name, field in fields.items():
        extra = field.json_schema_extra or {}
        known = extra.get("symbol", ""), field.description or "", field.default
        found.append(ParameterInfo(name, *known, extra.get("role", ""), extra.get("dimension")))
    return tuple(found)
