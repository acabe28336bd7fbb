"""Records of parameters: frozen, checked when they are made, each field with its symbol and meaning.

A part of a system (a machine, a law, a drive) is such a record. Wrong values are refused with pydantic's
ValidationError (a ValueError) that names every bad field, what was given and what would be right.
"""

import dataclasses
import functools
from typing import Annotated, Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as _checked_dataclass
from pydantic.dataclasses import is_pydantic_dataclass

Record = TypeVar("Record")

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]


def parameter(default: Any, symbol: str, meaning: str) -> Any:
    """A field with its default, its symbol in the literature and what it means (with its unit, where it has one)."""
    return Field(default=default, description=meaning, json_schema_extra={"symbol": symbol})


@dataclass_transform(frozen_default=True)
def parameters(cls: type[Record]) -> type[Record]:
    """Class decorator: a frozen dataclass whose fields are checked and whose unknown names are refused."""
    return _checked_dataclass(frozen=True, config=ConfigDict(extra="forbid"))(cls)  # type: ignore[return-value]


@dataclasses.dataclass(frozen=True)
class ParameterInfo:
    """What is known of one parameter: its name in code, its symbol, its meaning and its default."""

    name: str
    symbol: str
    meaning: str
    default: Any


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
    return tuple(
        ParameterInfo(name, (field.json_schema_extra or {}).get("symbol", ""), field.description or "", field.default)
        for name, field in fields.items()
    )
