"""Hints: the declarations of a record, a method and a function, read once from their types."""

import dataclasses
import functools
import inspect
import sys
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import numpy as np

from vibrocap.quantities.declared import Declared, Over


@functools.cache
def field_hints(record: type) -> dict[str, Any]:
    """The types of the fields of a record by name, with what they declare."""
    hints: dict[str, Any] = {}
    for cls in reversed(record.__mro__):
        for name, hint in vars(cls).get("__annotations__", {}).items():
            hints[name] = _read(hint, cls.__module__)
    return {field.name: hints[field.name] for field in dataclasses.fields(record)}


@functools.cache
def call_hints(function: Callable[..., Any]) -> dict[str, Any]:
    """The types of the arguments of a function by name and, as "return", of what it returns."""
    own = inspect.unwrap(function)
    return {name: _read(hint, own.__module__) for name, hint in own.__annotations__.items()}


def _read(hint: Any, module: str) -> Any:
    """A type that may be given as text; Any where a name in it is known to type checkers only."""
    if not isinstance(hint, str):
        return hint
    try:
        return eval(hint, vars(sys.modules[module]))  # what the interpreter makes of an annotation without quotes
    except NameError:
        return Any


def fitting(hint: Any, value: Any) -> tuple[Declared | None, Any]:
    """(what a type declares of a value, the alternative of the type that the value is of)."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        for inner in typing.get_args(hint):
            if _is_of(inner, value):
                return fitting(inner, value)
        return None, Any
    return declaration(hint), hint


def declaration(hint: Any) -> Declared | None:
    """What a type declares, None for nothing."""
    if typing.get_origin(hint) is not Annotated:
        return None
    return next((inner for inner in hint.__metadata__ if isinstance(inner, Declared)), None)


def declared_anywhere(hint: Any) -> Declared | None:
    """The first declaration in a type, whatever it is of: of `tuple[Time, Time] | None` that of a time."""
    own = declaration(hint)
    inside = () if own is not None else (inner for inner in typing.get_args(hint) if not isinstance(inner, str))
    return own or next((inner for inner in map(declared_anywhere, inside) if inner is not None), None)


def _is_of(hint: Any, value: Any) -> bool:
    inner = typing.get_args(hint)[0] if typing.get_origin(hint) is Annotated else hint
    kind = typing.get_origin(inner) or inner
    if kind is Any:
        return True
    if kind in (float, int):
        return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    if kind in (Mapping, dict):
        return isinstance(value, Mapping)
    if kind in (tuple, list, Sequence):
        return isinstance(value, (tuple, list))
    return isinstance(kind, type) and isinstance(value, kind)


def of_elements(hint: Any, count: int) -> list[Any]:
    """The types of the elements of a tuple or a list of a type."""
    inner_types = [inner for inner in typing.get_args(hint) if inner is not Ellipsis]
    if not inner_types or len(inner_types) not in (1, count):
        return [Any] * count
    return inner_types if len(inner_types) == count else inner_types * count


def undeclared(hint: Any) -> bool:
    """Whether a type holds numbers of which it does not say what they are."""
    if declaration(hint) is not None:
        return False
    if hint in (float, complex, np.ndarray):
        return True
    return any(undeclared(inner) for inner in typing.get_args(hint) if not isinstance(inner, (str, Declared)))


def over_of(hint: Any) -> Over | None:
    """The dimensions that the type of an array, or of a list of records, states; None where it states none."""
    return next((inner for inner in getattr(hint, "__metadata__", ()) if isinstance(inner, Over)), None)
