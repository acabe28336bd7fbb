"""What every canonical test asks of its arguments and of the motions that it makes."""

from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive
from vibrocap.motion.status import Status
from vibrocap.physics.friction.law import Law


def check_numbers(**given: Any) -> None:
    """ValueError for what is not a positive number, by name."""
    for name, value in given.items():
        if not is_positive(value):
            raise ArgumentError(name, f"should be a positive number, got {value!r}")


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
