"""Following a branch of cycles that nothing drives in time: the section is set anew where it leaves its phase.

The branch is born at the Hopf point to which small cycles shrink. Where a cycle loses its only stick, the smooth cycles
next to it graze rest. On the side with the stick its duration goes to zero like a square root, and orbits near it do
not close. On the side without it the cycles are smooth functions of the parameter, and so is the parameter p of their
least speed of sliding u: what p(u) tends to for u -> 0 is the place, by Neville's extrapolation.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.measures.recorded.sticking import by_contact
from vibrocap.motion.simulate import simulate
from vibrocap.orbits.equilibria.bifurcations import hopf
from vibrocap.orbits.equilibria.equilibrium_branch import Sliding
from vibrocap.orbits.equilibria.steady_states import SteadyEquations
from vibrocap.orbits.maps.cycle_map import CycleMap
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.orbits.walk.following import Followed, followed, started
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind, mode_change
from vibrocap.orbits.walk.residual import BranchPoint, closed_at
from vibrocap.orbits.walk.special_points import Found
from vibrocap.physics.names import numbered

SMALL = 3e-3  # amplitude over that of the first cycle at which a Hopf point is looked for
CENTRE = 3.0  # amplitudes within which the equilibrium lies
SAME_FREQUENCY = 1e-2  # by how much that of the cycle may differ from that of the Hopf point
STRETCH = 30  # points after which the section is looked at
SHORT = 0.2  # longest step over the amplitude of a smooth cycle
CROSSES = 0.5  # cosine between flow and section from which on a smooth cycle crosses it well
AMID = 0.25  # share of its phase that the section keeps from both ends
TOO_CLOSE = 1e-9  # change of the parameter, as a share of its range, below which nothing was gained by a new section
SAMPLES = 1000  # of a cycle, between which its least speed is looked for
APART = 1.6  # ratio of the least speeds of neighbours that are extrapolated
MOST, LEAST = 8, 5  # cycles that are extrapolated
FARTHEST = 1e-2  # of the largest speed of sliding: the cycle from which on none is taken
CLOSED = 1e-11  # to what share of its speeds a cycle is closed
TRUSTED = 1e-6  # share of the parameter's range by which an extrapolation may differ from one of a point less


def is_smooth(point: BranchPoint) -> bool:
    """Whether nothing happens along the cycle: no stick, no reversal, no impact."""
    return max(map(len, by_contact(point.closing.mode_sequence))) <= 1 and point.closing.impacts <= 0.0


def flow_across(closure: CycleMap, point: BranchPoint) -> tuple[float, float]:
    """(amplitude of a small cycle, cosine between the flow and the normal of the section), over natural sizes."""
    state, row = closure.state(point.x, point.closing), closure.row.copy()
    row[closure.index] = closure.parameter(point.x)
    flow = closure.map.rates(state, closure.map.contact_side(state, row), row)[closure.unknowns]
    flow = flow / closure.sizes[closure.unknowns]
    speed = float(np.linalg.norm(flow))
    cosine = float(closure.normal @ flow) / speed if speed > 0.0 else 0.0
    return speed * closure.period(point.x) / (2.0 * np.pi), cosine


def hopf_at_end(closure: CycleMap, last: BranchPoint) -> Found | None:
    """The Hopf point at which a branch of cycles ends behind its last point; None where there is none."""
    if not is_smooth(last) or (amplitude := flow_across(closure, last)[0]) > SMALL:
        return None
    state, period = closure.state(last.x, last.closing), closure.period(last.x)
    mode = _mode(closure, last)
    guess = mode.point(state[mode.problem.unknowns], closure.parameter(last.x))
    centre = closed_at(mode, guess, float(guess[-1]))
    if centre is None:
        return None
    located = hopf(mode, centre.x, complex(0.0, 2.0 * np.pi / period))
    if located is None:
        return None
    away = (mode.state(located.x) - state[mode.problem.unknowns]) / closure.sizes[mode.problem.unknowns]
    slower = abs(located.frequency * period / (2.0 * np.pi) - 1.0)
    if not (float(np.linalg.norm(away)) <= CENTRE * amplitude and slower <= SAME_FREQUENCY):
        return None  # the cycle does not surround it, or turns at another speed
    text, place = "the cycles shrink to steady sliding", mode.parameter(located.x)
    return Found.at_end(SpecialKind.HOPF, 1.0, last, located.error, text, place, frequency=located.frequency)


def _mode(closure: CycleMap, point: BranchPoint) -> Sliding:
    """The equations of equilibria in the mode of the contacts along a smooth cycle."""
    problem = SteadyEquations(closure.system, closure.path)
    state = closure.state(point.x, point.closing)
    switched = np.zeros(len(state))
    switched[closure.switched] = state[closure.switched]
    ones = np.ones(len(problem.velocities))
    row = problem.row.copy()
    row[problem.index] = closure.parameter(point.x)
    velocities = problem.values(problem.velocities, state[problem.unknowns], ones, switched, row)
    return Sliding(problem, np.where(velocities < 0.0, -1.0, 1.0), switched, closure.between)


def cycles_followed(closure: CycleMap, *arguments: Any, **options: Any) -> Followed:
    """`_followed_by_sections`, with the places where cycles lose their only stick located by the smooth ones."""
    walk = _followed_by_sections(closure, *arguments, **options)
    special = [(after, stick_loss(closure, record, walk.points, after)) for after, record in walk.special]
    return dataclasses.replace(walk, special=special)


def _followed_by_sections(
    closure: CycleMap,
    start: BranchPoint,
    towards: float,
    most: int,
    step: float,
    progress: Callable[[float], None] | None = None,
) -> Followed:
    """`followed` for cycles, whose section is set anew amid its phase where it has come near an end of it.

    The points of both sections are of the same cycles at other instants: where the section is set anew, the states jump
    along the cycle, and no special point is looked for. Cycles without events have no phases: their section is set
    across the flow where they are. So it is of any cycle that would soon touch a section that stands still, which looks
    like a fold. A branch whose cycles shrink to an equilibrium ends at its Hopf point.
    """
    points, special = [start], []
    here, sign = start, towards
    while True:
        smooth = is_smooth(here)
        longest = min(step, SHORT * flow_across(closure, here)[0]) if smooth else step
        walk = followed(closure, here, sign, min(STRETCH, most - len(points) + 1), longest, progress=progress)
        whole, walk = len(walk.points), _crossing(closure, walk)
        touches = 1 < len(walk.points) < whole
        special += [(len(points) - 1 + i, special_point) for i, special_point in walk.special]
        points += walk.points[1:]
        if (birth := hopf_at_end(closure, points[-1])) is not None:
            return Followed(points, [*special, (len(points) - 1, birth)], BranchEnd.HOPF)
        more = len(points) < most
        ended = walk.end not in (BranchEnd.TOO_MANY_POINTS, BranchEnd.NEWTON_FAILED, BranchEnd.ORBIT_CEASES)
        if ended or not more:
            return Followed(points, special, walk.end)
        stuck = walk.end is not BranchEnd.TOO_MANY_POINTS
        if stuck and abs(points[-1].x[-1] - here.x[-1]) <= TOO_CLOSE and len(walk.points) < STRETCH:
            return Followed(points, special, walk.end)
        turned = _set_anew(closure, points[-1], touches)
        if turned is None:
            if stuck or len(walk.points) == 1:
                return Followed(points, special, walk.end if stuck else BranchEnd.NEWTON_FAILED)
            here, sign = points[-1], 1.0
            continue
        closure, here = turned
        sign = 1.0
        # Where the section comes to the end of its phase multipliers jump over the last step only: the same cycle has
        # as many unstable ones as before where its section is set anew.
        jumps = [now for i, now in special[-1:] if i == len(points) - 2 and now.kind is SpecialKind.JUMP]
        if jumps and here.closing.unstable() == jumps[0].unstable[0]:
            points.pop()
            special.pop()
        points.append(here)


def _crossing(closure: CycleMap, walk: Followed) -> Followed:
    """The part of a way before the first cycle that does not cross the section well any more."""
    for k, point in enumerate(walk.points):
        if k and flow_across(closure, point)[1] < CROSSES:
            special = [(i, special_point) for i, special_point in walk.special if i < k - 1]
            return Followed(walk.points[:k], special, BranchEnd.TOO_MANY_POINTS)
    return walk


def _set_anew(closure: CycleMap, last: BranchPoint, touches: bool) -> tuple[CycleMap, BranchPoint] | None:
    """(map, point) with the section amid the phase in which it lies; None where it is amid it already.

    touches: whether cycles soon touch the section, so that it is at least set across the flow where they are
    """
    state, period = closure.state(last.x, last.closing), closure.period(last.x)
    system = closure.system.with_parameters({closure.path: closure.parameter(last.x)})
    motion = simulate(system, periods=2.0 * period / system.drive.period, initial=named_states(system, state))
    marks = [event.time for event in motion.events if event.kind != "graze"]
    if len(marks) < 2:
        return None if not is_smooth(last) else _section_at(closure, last, state)
    ends = [time - period for time in marks if time > 0.5 * period and time - period < 0.5 * period]
    first = max((time for time in ends if time <= 0.0), default=marks[0] - period)
    last_mark = min((time for time in marks if time > 0.0), default=marks[0])
    share = -first / (last_mark - first)
    if AMID <= share <= 1.0 - AMID:
        return _section_at(closure, last, state) if touches else None
    middle = 0.5 * (first + last_mark) + (period if first + last_mark < 0.0 else 0.0)
    moved = np.array([float(motion.at(middle, name)[0]) for name in motion.state_names])
    for k, velocity in enumerate(system.machine.contact_states):
        if velocity in motion.state_names and float(motion.at(middle, numbered("side", k + 1))[0]) == 0.0:
            moved[motion.state_names.index(velocity)] = 0.0
    return _section_at(closure, last, moved)


def _section_at(closure: CycleMap, last: BranchPoint, moved: np.ndarray) -> tuple[CycleMap, BranchPoint] | None:
    """(map, point) with the section across the flow at another state of the same cycle."""
    period = closure.period(last.x)
    anew = closure.with_section(moved, closure.parameter(last.x))
    point = started(anew, anew.point(moved, closure.parameter(last.x), period))
    if point is None:
        return None
    onward = float(point.tangent[-2:] @ last.tangent[-2:])
    return anew, BranchPoint(point.closing, point.tangent if onward >= 0.0 else -point.tangent)


def stick_loss(closure: CycleMap, special: Found, points: list[BranchPoint], after: int) -> Found:
    """The record of a change of mode sequence after a point, located anew where smooth cycles lie on one side of it."""
    smooth = [is_smooth(points[i]) for i in (after, after + 1)] if after + 1 < len(points) else [False, False]
    moves = special.kind in (SpecialKind.MODE_CHANGE, SpecialKind.UNLOCATED) and "S" in "".join(special.words)
    if not moves or smooth[0] == smooth[1]:
        return special
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
        return special
    place, other = _at_zero(speeds, places), _at_zero(speeds[:-1], places[:-1])
    slope = max(abs((b - a) / (v - u)) for a, b, u, v in zip(places, places[1:], speeds, speeds[1:], strict=False))
    error = 3.0 * abs(place - other) + CLOSED * (slope * largest + abs(place))
    if not error <= TRUSTED * closure.width:
        return special
    change, phases = mode_change(*special.words)
    turns = points[after].tangent[-1] * points[after + 1].tangent[-1] < 0.0
    text = "; ".join(filter(None, (phases, "the branch turns back" if turns else "")))
    known = {"place": place, "error": error, "change": change, "passed": None, "text": text}
    return dataclasses.replace(special, kind=SpecialKind.MODE_CHANGE, **known)


def _speeds(closure: CycleMap, point: BranchPoint) -> tuple[float, float]:
    """(least, largest) speed of sliding along a cycle, of the contact that comes nearest to rest."""
    from scipy.optimize import minimize_scalar  # only here: it takes long to load

    motion = closure.motion(point.closing)
    times = np.linspace(0.0, motion.end, SAMPLES)
    names = [numbered("contact_velocity", i + 1) for i in range(motion.piece_sides.shape[1])]
    slides = [(np.abs(motion.at(times, name)), name) for name in names]
    speeds, name = min(slides, key=lambda slide: np.min(slide[0]) / np.max(slide[0]))
    k = int(np.argmin(speeds))

    def speed(time: float) -> float:
        return abs(float(motion.at(np.array([time]), name)[0]))

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
