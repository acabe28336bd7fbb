"""What every canonical test asks of its arguments and of the motions that it makes."""

import math
from typing import Any

import numpy as np

from vibrocap.friction.law import Law
from vibrocap.trajectory import Status


def check_numbers(**given: Any) -> None:
    """ValueError for what is not a positive number, by name."""
    for name, value in given.items():
        number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
        if not number or not 0.0 < value < math.inf:
            raise ValueError(f"{name} should be a positive number, got {value!r}")


def check_whole(**given: Any) -> None:
    """ValueError for what is not a whole number from 1 on, by name."""
    for name, value in given.items():
        if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 1:
            raise ValueError(f"{name} should be a whole number from 1 on, got {value!r}")


def checked_list(name: str, given: Any) -> np.ndarray:
    """Positive numbers [n]; ValueError for anything else."""
    try:
        found = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} should be a list of positive numbers, got {given!r}") from None
    if found.ndim != 1 or not len(found) or not np.all((found > 0.0) & np.isfinite(found)):
        raise ValueError(f"{name} should be a list of positive numbers, got {given!r}")
    return found


def check_motion(status: Status, law: Law) -> None:
    """RuntimeError where a motion of a test could not be completed."""
    if not status.ok:
        raise RuntimeError(f"a test of the {law.name} law could not be completed ({status.value}): {status.text}")
