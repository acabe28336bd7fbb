"""Ranges of a parameter: two numbers in order, both of which the system can have; ValueError naming what is wrong."""

import math
from typing import Any

from vibrocap.arguments import is_number
from vibrocap.physics.system import System


def checked_pair(name: str, pair: Any) -> tuple[float, float]:
    """(low, high), finite and in order."""
    try:
        low, high = (float(x) for x in pair)
    except (TypeError, ValueError):
        raise ValueError(f"{name} should be two numbers (low, high), got {pair!r}") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"{name} should be finite with low < high, got {pair!r}")
    return low, high


def checked_range(system: System, over: str, between: Any) -> tuple[float, float]:
    """The range of a parameter that is a number, both of whose ends the system can have."""
    try:
        value = system.parameter(over)
    except ValueError as error:
        raise ValueError(f"over: {error}") from None
    if not is_number(value):
        raise ValueError(f"over should be a parameter that is a number, but {over} is {value!r}")
    low, high = checked_pair("between", between)
    for end in (low, high):
        system_at(system, over, end)
    return low, high


def system_at(system: System, over: str, value: float) -> System:
    """The system at one value of a parameter within a range."""
    try:
        return system.with_parameters({over: float(value)})
    except ValueError as error:
        raise ValueError(f"between: {over} cannot be {value:g}: {error}") from None
