"""Steps of the sliding velocity: the speeds of the load point, found in a record, and what the record shows of them."""

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.identification.problem.samples import Samples

WINDOWS, FEWEST = (1.0, 0.2, 0.05, 0.02), 20  # windows over the record's length; samples on each side of a step


@dataclasses.dataclass(frozen=True)
class Step:
    """The load point's speed (m/s) from a time (s, on the record's clock from its first sample) on."""

    time: float
    speed: float


def found_step(samples: Samples, displacement: np.ndarray) -> tuple[Step, Step]:
    """The one step of speed in a displacement: two straight lines that meet where the errors are least.

    The meeting point is sought in ever narrower windows, and the speeds are medians over stretches, so that jumps of
    the sensor elsewhere move neither.
    """
    time, low, high = samples.time, 0, len(samples)
    at = float(time[len(time) // 2])
    for share in WINDOWS:
        low, high = np.searchsorted(time, [at - share * time[-1], at + share * time[-1]])
        if min(np.searchsorted(time, at) - low, high - np.searchsorted(time, at)) < FEWEST:
            break
        at = _meeting_point(time[low:high], displacement[low:high])
    before, after = (_median_speed(time, displacement, part) for part in (time < at, time > at))
    return Step(0.0, before), Step(at, after)


def _meeting_point(time: np.ndarray, displacement: np.ndarray) -> float:
    """Where two lines meet that fit a displacement best."""
    from scipy.optimize import minimize_scalar

    def square(at: float) -> float:
        matrix = np.stack([np.ones_like(time), np.minimum(time - at, 0.0), np.maximum(time - at, 0.0)], axis=1)
        solution, *_ = np.linalg.lstsq(matrix, displacement, rcond=None)
        return float(np.sum((matrix @ solution - displacement) ** 2))

    places = np.linspace(time[0], time[-1], 102)[1:-1]
    least = places[int(np.argmin([square(at) for at in places]))]
    width = float(places[1] - places[0])
    options, ends = {"xatol": 1e-4 * width}, (least - width, least + width)
    best: Any = minimize_scalar(square, bounds=ends, method="bounded", options=options)
    return float(best.x)


def _median_speed(time: np.ndarray, displacement: np.ndarray, where: np.ndarray) -> float:
    """Median of the slopes over 20 stretches."""
    stretches = np.array_split(np.flatnonzero(where), 20)
    return float(np.median([np.polyfit(time[s] - time[s[0]], displacement[s], 1)[0] for s in stretches if len(s) > 2]))


def measured_stiffness(samples: Samples, steps: Sequence[Step]) -> float:
    """Stiffness (N/m) of what pulls the contact, as experimenters read it: the slope of the rise after the first step.

    The slope of the force over the load point's displacement until half of the peak, over 1 - V1/V2, for the contact
    goes on at V1 at first. It speeds up during the rise, so that this is rather too small: a lower bound.
    """
    first, step = steps[0], steps[1]
    before, after = samples.time < step.time, samples.time >= step.time
    level = float(np.median(samples.force[before][-400:]))
    time, force = samples.time[after], samples.force[after]
    width = max(int(np.searchsorted(time, time[0] + 0.002 * (time[-1] - time[0]))), 1)
    smooth = np.convolve(force, np.ones(width) / width, mode="valid") - level
    top = int(np.argmax(np.abs(smooth)))
    half = int(np.flatnonzero(np.abs(smooth) >= 0.5 * abs(smooth[top]))[0]) + width // 2
    rising = slice(0, max(half, 3) + 1)
    slope = np.polyfit(time[rising] - step.time, force[rising], 1)[0] / step.speed
    found = float(slope / (1.0 - first.speed / step.speed))
    if not (np.isfinite(found) and found > 0):
        raise ValueError(
            "machine_stiffness: the record does not show it (the force does not rise with the step); give N/m"
        )
    return found


def check_program(steps: Sequence[Step], samples: Samples, stiffness: Any) -> None:
    if len(steps) < 2:
        raise ValueError(f"program: should have at least two speeds, got {len(steps)}")
    if any(not (np.isfinite(step.speed) and step.speed > 0) for step in steps):
        speeds = ", ".join(f"{step.speed:.3g}" for step in steps)
        raise ValueError(f"program: every speed should be > 0 m/s, got {speeds}")
    times = [step.time for step in steps]
    if times[0] != 0 or any(b <= a for a, b in itertools.pairwise(times)) or times[-1] >= samples.time[-1]:
        raise ValueError(f"program: times should begin at 0, increase and end within the record, got {times}")
    if any(abs(math.log(b.speed / a.speed)) < 0.01 for a, b in itertools.pairwise(steps)):
        raise ValueError("program: the speed hardly changes; a step of it is needed")
    if stiffness is not None and (isinstance(stiffness, str) or not (np.isfinite(stiffness) and stiffness > 0)):
        raise ValueError(f"machine_stiffness: should be > 0 N/m or 'measured', got {stiffness!r}")


def relaxation_distance(samples: Samples, steps: Sequence[Step]) -> float:
    """Distance over which the force falls from its extreme after the first step by two thirds: near D_c."""
    step = steps[1]
    after = samples.time > step.time
    time, force = samples.time[after], samples.force[after]
    width = min(max(len(force) // 400, 1), len(force) // 2)
    smooth = np.convolve(force, np.ones(width) / width, mode="valid")
    change = np.abs(smooth - np.median(force))
    top = int(np.argmax(change[: max(len(change) // 2, 1)]))
    below = np.flatnonzero(change[top:] < change[top] / 3)
    span = time[top + below[0]] - step.time if len(below) else 0.1 * (time[-1] - step.time)
    return float(max(span, 1e-9) * step.speed)


def path_of(steps: Sequence[Step], end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and displacements of the load point at which its speed changes."""
    times = np.array([*(step.time for step in steps), end])
    return times, np.concatenate(([0.0], np.cumsum(np.diff(times) * [step.speed for step in steps])))
