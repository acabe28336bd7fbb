"""Following a branch of cycles that nothing drives in time: the section is set anew where it leaves its phase."""

from collections.abc import Callable

import numpy as np

from vibrocap.motion.simulate import simulate
from vibrocap.orbits.closing.periodic_solution import named_states
from vibrocap.orbits.continuation.branch_point import BranchPoint
from vibrocap.orbits.continuation.following import BranchEnd, Followed, followed, started
from vibrocap.orbits.maps.cycle_map import CycleMap

STRETCH = 30  # points after which the section is looked at
AMID = 0.25  # share of its phase that the section keeps from both ends
TOO_CLOSE = 1e-9  # change of the parameter, as a share of its range, below which nothing was gained by a new section


def cycles_followed(
    closure: CycleMap,
    start: BranchPoint,
    towards: float,
    most: int,
    step: float,
    progress: Callable[[float], None] | None = None,
) -> Followed:
    """`followed` for cycles, whose section is set anew amid its phase where it has come near an end of it.

    The points of both sections are of the same cycles at other instants: where the section is set anew, the states jump
    along the cycle, and no special point is looked for.
    """
    points, special = [start], []
    here, sign = start, towards
    while True:
        way = followed(closure, here, sign, min(STRETCH, most - len(points) + 1), step, progress=progress)
        special += [(len(points) - 1 + i, found) for i, found in way.special]
        points += way.points[1:]
        more = len(points) < most
        ended = way.end not in (BranchEnd.TOO_MANY_POINTS, BranchEnd.NEWTON_FAILED, BranchEnd.ORBIT_CEASES)
        if ended or not more:
            return Followed(points, special, way.end)
        stuck = way.end is not BranchEnd.TOO_MANY_POINTS
        if stuck and abs(points[-1].x[-1] - here.x[-1]) <= TOO_CLOSE and len(way.points) < STRETCH:
            return Followed(points, special, way.end)
        turned = _set_anew(closure, points[-1])
        if turned is None:
            if stuck:
                return Followed(points, special, way.end)
            here, sign = points[-1], 1.0
            continue
        closure, here = turned
        sign = 1.0
        points.append(here)


def _set_anew(closure: CycleMap, last: BranchPoint) -> tuple[CycleMap, BranchPoint] | None:
    """(map, point) with the section amid the phase in which it lies; None where it is amid it already."""
    state, period = closure.state(last.x, last.closing), closure.period(last.x)
    system = closure.system.with_parameters({closure.path: closure.parameter(last.x)})
    motion = simulate(system, periods=2.0 * period / system.drive.period, initial=named_states(system, state))
    marks = [event.time for event in motion.events if event.kind != "graze"]
    if len(marks) < 2:
        return None
    ends = [time - period for time in marks if time > 0.5 * period and time - period < 0.5 * period]
    first = max((time for time in ends if time <= 0.0), default=marks[0] - period)
    last_mark = min((time for time in marks if time > 0.0), default=marks[0])
    share = -first / (last_mark - first)
    if AMID <= share <= 1.0 - AMID:
        return None
    middle = 0.5 * (first + last_mark) + (period if first + last_mark < 0.0 else 0.0)
    moved = np.array([float(motion.at(middle, name)[0]) for name in motion.state_names])
    if float(motion.at(middle, "side")[0]) == 0.0:
        moved[motion.state_names.index(system.machine.contact_state)] = 0.0
    anew = closure.with_section(moved, closure.parameter(last.x))
    point = started(anew, anew.point(moved, closure.parameter(last.x), period))
    if point is None:
        return None
    onward = float(point.tangent[-2:] @ last.tangent[-2:])
    return anew, BranchPoint(point.closing, point.tangent if onward >= 0.0 else -point.tangent)
