"""What `vibrocap simulate` says of a motion: one record, printed as JSON or as tables for people."""

import collections
import dataclasses
import json
import math
from typing import Any

from vibrocap.measures.energy import energy_balance
from vibrocap.measures.sticking import stick_fraction
from vibrocap.measures.travel import drift, mean_velocity
from vibrocap.trajectory import Trajectory

VELOCITY_PERIODS = 10  # the mean velocity is taken over the last so many whole periods, or all where there are fewer
EVENT_KINDS = ("stick", "slip_forward", "slip_back", "reversal", "graze", "switch")


def whole_periods(motion: Trajectory) -> int:
    """Drive periods that the motion completed."""
    return max(0, len(motion.sections) - 1)


def motion_record(motion: Trajectory) -> dict[str, Any]:
    """The measures of a motion by name; None where there is none (no whole period yet, no travel, no sticking)."""
    whole = whole_periods(motion)
    started = len(motion.piece_start) > 0
    velocity: dict[str, Any] = {"value": None, "window": None, "settled": False}
    travels = whole > 0 and motion.system.machine.cyclic is not None
    if travels:
        velocity = dataclasses.asdict(mean_velocity(motion, min(VELOCITY_PERIODS, whole)))
    counts = collections.Counter(motion.event_kinds)
    return plain(
        {
            "state": motion.state,
            "time": motion.end,
            "drift": drift(motion) if travels else None,
            "mean_velocity": velocity,
            "events": {kind: counts[kind] for kind in EVENT_KINDS},
            "stick_fraction": stick_fraction(motion) if started else None,
            "energy": dataclasses.asdict(energy_balance(motion)) if started else None,
            "certificate": dataclasses.asdict(motion.certificate) if started else None,
            "status": motion.status.value,
        }
    )


def plain(value: Any) -> Any:
    """The same with JSON's own types only: tuples become lists, and numbers that JSON does not know become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return float(value) if math.isfinite(value) else None


def json_text(record: Any) -> str:
    """One JSON object in full precision."""
    return json.dumps(plain(record), indent=2, ensure_ascii=False, allow_nan=False)
