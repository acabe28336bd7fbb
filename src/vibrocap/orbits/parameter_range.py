"""Ranges of a parameter: two numbers in order, both of which the system can have; ValueError naming what is wrong."""

import dataclasses
import math
from typing import Any

from vibrocap.arguments import ArgumentError, is_number
from vibrocap.physics.dimensions.conversion import quantity_in_si, value_in_words
from vibrocap.physics.names import fields_of, split_path
from vibrocap.physics.system import System

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # the share of a range at which no two frequencies have a common period by chance


def checked_pair(name: str, system: System, path: str, pair: Any) -> tuple[float, float]:
    """(low, high), finite and in order, of the parameter or the initial state at a path."""
    try:
        low, high = (float(x) for x in pair)
    except (TypeError, ValueError):
        raise ArgumentError(name, f"should be two numbers (low, high), got {pair!r}") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        words = " to ".join(value_in_words(path, end, system) for end in (low, high))
        raise ArgumentError(name, f"should be finite with low < high, got {words}")
    return low, high


def checked_range(system: System, over: str, between: Any) -> tuple[float, float]:
    """The range of a parameter that is a number, both of whose ends the system can have."""
    try:
        value = system.parameter(over)
    except ValueError as error:
        raise ArgumentError("over", f"{error}") from None
    if not is_number(value):
        raise ArgumentError("over", f"should be a parameter that is a number, but {over} is {value!r}")
    low, high = checked_pair("between", system, over, between)
    if system.controller is not None and system.controller.sampled:
        _check_samples(system, over, low, high)
    for end in (low, high):
        system_at(system, over, end)
    if not repeats_at(system, over, low + GOLDEN * (high - low)):
        why = f"{over} decides whether the machine repeats in the drive's period; compare values of it by a sweep"
        raise ArgumentError("over", why)
    return low, high


def repeats_at(system: System, path: str, value: float) -> bool:
    """Whether what depends on time in the machine repeats in the drive's period at another value of a parameter.

    True where a part cannot have that value.
    """
    part, name = split_path(path)
    try:
        parts = fields_of(system.parts | {part: dataclasses.replace(system.parts[part], **{name: value})})
    except ValueError:
        return True
    return parts["machine"].driven_by(parts["drive"], parts["drives"]).repeats_after(parts["drive"].period)


def _check_samples(system: System, over: str, low: float, high: float) -> None:
    """ValueError for a parameter that decides how many samples a period has."""
    part, name = split_path(over)
    for value in (low, 0.5 * (low + high)):
        changed = dataclasses.replace(system.parts[part], **{name: value})
        drive = changed if part == "drive" else system.drive
        time = getattr(changed if part == "controller" else system.controller, "sample_time", None)
        if (drive.period, time) != (system.drive.period, system.parameter("controller.sample_time")):
            why = f"{over} decides how many samples a period has; compare them one by one, by a sweep"
            raise ArgumentError("over", why)


def system_at(system: System, over: str, value: float) -> System:
    """The system at one value of a parameter within a range."""
    try:
        return system.with_parameters({over: float(value)})
    except ValueError as error:
        complaints = getattr(error, "complaints", (str(error),))
        text = "; ".join(getattr(complaint, "text", complaint) for complaint in complaints)
        words = f"{quantity_in_si(over, system).path} cannot be {value_in_words(over, value, system)}"
        raise ArgumentError("between", f"{words}: {text.rpartition(', got ')[0] or text}") from None
