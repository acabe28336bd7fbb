"""Where a cycle loses its only stick: the smooth cycles next to it graze rest, and their least speed says where.

On the side with the stick its duration goes to zero like a square root, and orbits close to it do not close. On the
side without it the cycles are smooth functions of the parameter, and so is the parameter p of their least speed of
sliding u: what p(u) tends to for u -> 0 is the place, by Neville's extrapolation.
"""

import dataclasses
from typing import Any

import numpy as np

from vibrocap.motion.simulate import simulate
from vibrocap.orbits.closing.periodic_solution import named_states
from vibrocap.orbits.continuation.branch_point import BranchPoint
from vibrocap.orbits.continuation.cycles.hopf_end import is_smooth
from vibrocap.orbits.continuation.special_points import Found, SpecialKind
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.maps.itinerary import mode_change

SAMPLES = 1000  # of a cycle, between which its least speed is looked for
APART = 1.6  # ratio of the least speeds of neighbours that are extrapolated
MOST, LEAST = 8, 5  # cycles that are extrapolated
FARTHEST = 1e-2  # of the largest speed of sliding: the cycle from which on none is taken
CLOSED = 1e-11  # to what share of its speeds a cycle is closed
TRUSTED = 1e-6  # share of the parameter's range by which an extrapolation may differ from one of a point less


def stick_loss(closure: CycleMap, found: Found, points: list[BranchPoint], after: int) -> Found:
    """The record of a change of mode sequence after a point, located anew where smooth cycles lie on one side of it."""
    smooth = [is_smooth(points[i]) for i in (after, after + 1)] if after + 1 < len(points) else [False, False]
    moves = found.kind in (SpecialKind.MODE_CHANGE, SpecialKind.UNLOCATED) and "S" in "".join(found.words)
    if not moves or smooth[0] == smooth[1]:
        return found
    side = points[after + 1 :] if smooth[1] else points[after::-1]
    speeds, places, largest = [], [], 0.0
    for point in side:
        if not is_smooth(point) or len(speeds) == MOST:
            break
        least, largest = _speeds(closure, point)
        if least > FARTHEST * largest and len(speeds) >= LEAST:
            break
        if not speeds or least > APART * speeds[-1]:
            speeds.append(least)
            places.append(closure.parameter(point.x))
    if len(speeds) < LEAST or min(speeds) <= 0.0:
        return found
    place, other = _at_zero(speeds, places), _at_zero(speeds[:-1], places[:-1])
    slope = max(abs((b - a) / (v - u)) for a, b, u, v in zip(places, places[1:], speeds, speeds[1:], strict=False))
    error = 3.0 * abs(place - other) + CLOSED * (slope * largest + abs(place))
    if not error <= TRUSTED * abs(closure.between[1] - closure.between[0]):
        return found
    change, phases = mode_change(*found.words)
    text = "; ".join(filter(None, (phases, "the branch turns back" if _turns(points, after) else "")))
    return dataclasses.replace(
        found, kind=SpecialKind.MODE_CHANGE, place=place, error=error, change=change, passed=None, text=text
    )


def _turns(points: list[BranchPoint], after: int) -> bool:
    """Whether the parameter turns at a change after a point."""
    return bool(points[after].tangent[-1] * points[after + 1].tangent[-1] < 0.0)


def _speeds(closure: CycleMap, point: BranchPoint) -> tuple[float, float]:
    """(least, largest) speed of sliding along a cycle."""
    from scipy.optimize import minimize_scalar  # only here: it takes long to load

    system = closure.system.with_parameters({closure.path: closure.parameter(point.x)})
    start = named_states(system, closure.state(point.x, point.closing))
    periods = closure.period(point.x) / system.drive.period
    motion = simulate(system, periods=periods, initial=start, tolerance=closure.tolerance)
    times = np.linspace(0.0, motion.end, SAMPLES)
    speeds = np.abs(motion.at(times, "contact_velocity"))
    k = int(np.argmin(speeds))

    def speed(time: float) -> float:
        return abs(float(motion.at(np.array([time]), "contact_velocity")[0]))

    ends = times[max(k - 1, 0)], times[min(k + 1, SAMPLES - 1)]
    least: Any = minimize_scalar(speed, bounds=ends, method="bounded", options={"xatol": 1e-11 * motion.end})
    return min(float(least.fun), float(speeds[k])), float(np.max(speeds))


def _at_zero(u: list[float], p: list[float]) -> float:
    """The polynomial through points (u, p) at u = 0, by Neville's scheme."""
    values = list(p)
    for width in range(1, len(u)):
        for i in range(len(u) - width):
            values[i] = (u[i + width] * values[i] - u[i] * values[i + 1]) / (u[i + width] - u[i])
    return values[0]
