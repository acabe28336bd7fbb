"""branches(...): a motion followed over a parameter together with all that branches off from it."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.motion.simulate import simulate
from vibrocap.orbits.closing.orbit import Orbit, shoot
from vibrocap.orbits.closing.orbit import orbit as steady_orbit
from vibrocap.orbits.closing.periodic_solution import OrbitStatus
from vibrocap.orbits.continuation.branch import (
    Branch,
    branch,
    branch_distance,
    check_options,
    first_orbit,
    leaving,
    mirrored_all_over,
)
from vibrocap.orbits.maps.stroboscopic_map import named_states, state_vector
from vibrocap.orbits.walk.kinds import CORNERS, BranchEnd, SpecialKind
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.physics.dimensions.conversion import Parameter, Path
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.results import Result

BRANCHING = (SpecialKind.PITCHFORK, SpecialKind.FLIP)
AT_PARENT = (BranchEnd.PITCHFORK, BranchEnd.FLIP)
MOST_BRANCHES = 40
ONE_PLACE = 1e-5  # in natural sizes and shares of the range: two bifurcations so near are one
ON_BRANCH = 1e-7  # the same of two orbits
SEEN = 200  # drive periods in which a run that fails shows why
BEYOND = 2e-3, 1e-2  # shares of the range beyond an end of stable motions; farther on where all is slow beside it


@dataclasses.dataclass(frozen=True)
class Join:
    """Where two branches of a diagram meet: a special point of the parent is the first or the last point of the child.

    parent, child: indices of branches; special: index of the parent's special point; end: 0 the child's first point, -1
    its last
    """

    parent: int
    special: int
    child: int
    end: int


@dataclasses.dataclass(frozen=True)
class Transition(Dimensional):
    """Where the stable motions of a branch end within the range, and where a simulation goes from there.

    branch: index of the branch; point: its last stable point; parameter: where; why: the special point, or the end of
    the branch, that ends them; reached: index of the branch on which a start at that point ends a little beyond, None
    where it ends on no closed orbit; leads_to: the same in words, such as "a run that ends by lift-off"
    """

    branch: int
    point: int
    parameter: Parameter
    why: str
    reached: int | None
    leads_to: str


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class BranchDiagram(Result):
    """Branches of steady motions over one parameter, and where they meet.

    Of mirror-image solutions only one is kept: the other has the opposite drift and the same multipliers.
    unfollowed: (branch, special point) of bifurcations whose branch was not followed, being too deep or not found
    transitions: where stable motions end within the range, and what follows them
    """

    system: System
    over: Path
    between: tuple[Parameter, Parameter]
    branches: tuple[Branch, ...]
    joins: tuple[Join, ...]
    unfollowed: tuple[tuple[int, int], ...]
    transitions: tuple[Transition, ...] = ()

    in_record = "over between branches joins transitions"

    @property
    def heading(self) -> str:
        return f"branches of steady motions over {self.over}"

    @property
    def facts(self) -> dict[str, str]:
        low, high = self.between
        return {
            "range": f"{low:g} to {said(high, self.unit_of('over'), 6)}",
            "branches": f"{len(self.branches)} branches of {sum(map(len, self.branches))} points",
            "special points": f"{sum(len(branch.special_points) for branch in self.branches)} special points",
        }

    def table(self) -> list[dict[str, Any]]:
        """The special points of all branches as rows of a table, by branch and then along it."""
        return [{"branch": i, **row} for i, branch in enumerate(self.branches) for row in branch.table()]

    def __str__(self) -> str:
        lines, unit = [f"[{i}] {branch}" for i, branch in enumerate(self.branches)], self.unit_of("over")
        for join in self.joins:
            place = self.branches[join.parent].special_points[join.special]
            verb = "leaves" if join.end == 0 else "ends on"
            lines.append(f"[{join.child}] {verb} [{join.parent}] at {self.over} = {said(place.parameter, unit)}")
        for transition in self.transitions:
            edge = f"{self.over} = {said(transition.parameter, unit)} ({transition.why})"
            onward = f"beyond it a simulation leads to {transition.leads_to}"
            own, point = self.branches[transition.branch], transition.point
            inner = point + (1 if np.any(own.stable[point + 1 : point + 2]) else -1)
            way = "down" if own.parameter[point] < own.parameter[inner] else "up"
            lines.append(f"[{transition.branch}] is stable {way} to {edge}; {onward}")
        return "\n".join(lines)


@shows_progress("Following branches")
def branches(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    *,
    orbit: Orbit | None = None,
    initial: ByName | None = None,
    depth: int = 2,
    points: int = 1000,
    step: float = 0.01,
    settle_periods: int = 2000,
    tolerance: float = 1e-12,
    progress: Progress = None,
) -> BranchDiagram:
    """The diagram of steady motions over a parameter: the symmetric orbits, what travels, and what has longer periods.

    The branch of symmetric orbits is followed first, where the system has the half-period symmetry; then the branches
    that leave at pitchforks and flips, and those that leave these, to a depth. The branch through the start is followed
    too if it is not among them. Where stable motions end within the range, a simulation shows what follows them, and
    the branch that it ends on is followed as well. Branches that are reached in none of these ways are not found: start
    from one of their orbits. Of a system that nothing drives in time the branch of cycles through the start is the
    whole diagram.

    progress: True for a bar, or a function that is called with the share of the branches known so far
    depth: generations after the first; other arguments as for `branch`
    Raises ValueError, naming the argument, before any work.
    """
    check_options("both", points, step)
    check_whole("depth", depth, 0)
    begun = first_orbit(system, over, between, orbit, initial, settle_periods, tolerance)
    options = {"points": points, "step": step, "tolerance": tolerance}
    diagram = _Growing(depth, points, step, told(progress))
    if mirrored_all_over(system, over, between) and not begun.symmetric:
        symmetric = shoot(begun.system, begun.state, 1, half=True, tolerance=tolerance)
        if symmetric.closes:
            diagram.add(branch(system, over, between, orbit=symmetric, **options), 0)
            diagram.grow()
    if not any(_holds(branch, begun) for branch in diagram.branches):
        diagram.add(branch(system, over, between, orbit=begun, **options), 0)
        if begun.response_period:  # of cycles that nothing drives only their own branch is followed
            diagram.grow()
    if begun.response_period:
        diagram.go_over(settle_periods)
    return diagram.finished(system, over, between)


class _Growing:
    """A diagram that is being followed."""

    def __init__(self, depth: int, points: int, step: float, progress: Callable[[float], None] | None = None):
        self.progress = progress
        self.depth, self.points, self.step = depth, points, step
        self.branches: list[Branch] = []
        self.generation: list[int] = []
        self.joins: list[Join] = []
        self.tried: set[tuple[int, int]] = set()
        self.transitions: list[Transition] = []

    def add(self, new: Branch, generation: int) -> int:
        self.branches.append(new)
        self.generation.append(generation)
        if self.progress is not None:
            left = sum(_leaves(special) for _, special in self._special())
            self.progress(len(self.branches) / max(len(self.branches) + left - len(self.tried), 1))
        return len(self.branches) - 1

    def _special(self) -> Iterator[tuple[tuple[int, int], SpecialPoint]]:
        for i, grown in enumerate(self.branches):
            yield from (((i, j), special) for j, special in enumerate(grown.special_points))

    def grow(self) -> None:
        """Follow what leaves: smooth bifurcations first, of which what leaves at an angle may be the other end."""
        while len(self.branches) < MOST_BRANCHES:
            waiting = [
                (special.discontinuous, self.generation[i], i, j)
                for (i, j), special in self._special()
                if self.generation[i] < self.depth and (i, j) not in self.tried and _leaves(special)
            ]
            if not waiting:
                return
            _, generation, i, j = min(waiting)
            self.tried.add((i, j))
            if any((join.parent, join.special) == (i, j) for join in self.joins):
                continue
            child = leaving(self.branches[i], self.branches[i].special_points[j], points=self.points, step=self.step)
            if child is None or not len(child) or self._known(child):
                continue
            self._join(self.add(child, generation + 1))

    def go_over(self, settle_periods: int) -> None:
        """Follow what stable motions go over to where they end within the range, until that is nothing new."""
        looked_at = 0
        while looked_at < len(self.branches) < MOST_BRANCHES:
            for edge in _stable_edges(self.branches[looked_at]):
                self._go_over(looked_at, edge, settle_periods)
            looked_at += 1

    def _go_over(self, index: int, edge: "_Edge", settle_periods: int) -> None:
        """Note where a simulation goes beyond an edge; nothing where a branch that begins there is followed already."""
        branch_ = self.branches[index]
        if self._joined(index, edge):
            return
        start = named_states(branch_.system, branch_.states[edge.point])

        def beyond(value: float) -> Orbit:
            system = branch_.system.with_parameters({branch_.over: value})
            return steady_orbit(system, initial=start, settle_periods=settle_periods)

        beyond_it = beyond(edge.beyond[0])
        if beyond_it.status is OrbitStatus.NOT_SETTLED:
            beyond_it = beyond(edge.beyond[-1])
        reached = None
        if beyond_it.closes and beyond_it.stable:
            holding = (i for i, known in enumerate(self.branches) if len(known) and _holds(known, beyond_it))
            reached = next(holding, None)
            if reached is None:
                options = {"points": self.points, "step": self.step, "tolerance": branch_.closing_map.tolerance}
                onward = branch(beyond_it.system, branch_.over, branch_.between, orbit=beyond_it, **options)
                reached = self.add(onward, 0)
                for child in range(len(self.branches)):
                    self._join(child)
                self.grow()
        if reached != index and not self._joined(index, edge):
            there = _without_orbit(beyond_it, start) if reached is None else f"[{reached}]"
            self.transitions.append(Transition(index, edge.point, edge.parameter, edge.why, reached, there))

    def _joined(self, index: int, edge: "_Edge") -> bool:
        """Whether a branch that is followed begins or ends where the stable motions of another one do."""
        at_special = any((join.parent, join.special) == (index, edge.special) for join in self.joins)
        return at_special or any((join.child, join.end) == (index, edge.end) for join in self.joins)

    def _known(self, child: Branch) -> bool:
        place = len(child) // 2
        kind, middle = (child.response_period, child.symmetric), (child.states[place], float(child.parameter[place]))
        alike = [branch for branch in self.branches if (branch.response_period, branch.symmetric) == kind]
        return any(branch_distance(branch, *middle) <= ON_BRANCH for branch in alike)

    def _join(self, child: int) -> None:
        """Note on which special points of others a branch begins and ends, as far as that is not known."""
        known, grown = {(join.child, join.end) for join in self.joins}, self.branches[child]
        for end in (0, -1):
            for (i, j), special in (
                self._special() if grown.ends[end] in AT_PARENT and (child, end) not in known else ()
            ):
                if i != child and _leaves(special) and _meets(self.branches[i], special, grown, end):
                    self.joins.append(Join(i, j, child, end))

    def finished(self, system: System, over: str, between: tuple[float, float]) -> BranchDiagram:
        joined = {(join.parent, join.special) for join in self.joins}
        unfollowed = tuple(place for place, special in self._special() if _leaves(special) and place not in joined)
        diagram = tuple(self.branches), tuple(self.joins), unfollowed, tuple(self.transitions)
        return BranchDiagram(system, over, (float(between[0]), float(between[1])), *diagram)


@dataclasses.dataclass(frozen=True)
class _Edge:
    """The end of a stable stretch within the range; beyond: values of the parameter a little farther on, at least one.

    special: number of the special point there; end: 0 or -1 where it is an end of the branch
    """

    point: int
    parameter: Parameter
    beyond: tuple[float, ...]
    why: str
    special: int | None
    end: int | None


def _stable_edges(branch: Branch) -> Iterator[_Edge]:
    """Where the stable stretches of a branch end within the range, as the parameter goes on."""
    low, high = branch.between
    for first, last, stable in branch.parts:
        if not stable or first == last:
            continue
        for point, inner, before in ((first, first + 1, first - 1), (last, last - 1, last)):
            going = float(np.sign(branch.parameter[point] - branch.parameter[inner]))
            end = _end_at(branch, point)
            near = [(i, known) for i, known in enumerate(branch.special_points) if known.after_point == before]
            there = [i for i, known in near if known.stability != "kept"] + [i for i, _ in near]
            special = None if end is not None or not there else there[0]
            place = branch.special_points[special] if special is not None else None
            why = branch.ends[end].value if end is not None else place.kind.value if place else "stability lost"
            at = float(branch.parameter[point]) if place is None else place.parameter
            steps = (at + going * share * (high - low) for share in BEYOND)
            beyond = tuple(value for value in steps if low <= value <= high)
            goes_on = end is not None and branch.ends[end] is BranchEnd.TOO_MANY_POINTS
            if going and beyond and not goes_on:
                yield _Edge(point, at, beyond, why, special, end)


def _without_orbit(orbit: Orbit, start: Mapping[str, float]) -> str:
    """What a start leads to that ends on no stable orbit, in words."""
    if orbit.status is OrbitStatus.RUN_FAILED:
        ended = simulate(orbit.system, initial=start, periods=SEEN).run_status
        return "a run that ends early" if ended.ok else f"a run that ends by {ended.value}"
    return "a motion that does not settle" if orbit.status is OrbitStatus.NOT_SETTLED else "no stable orbit"


def _end_at(branch: Branch, point: int) -> int | None:
    """0 or -1 where a point is an end of the branch; the last stable point may be the one before a bifurcation."""
    for end, place in ((0, 0), (-1, len(branch) - 1)):
        if abs(point - place) <= (1 if branch.ends[end] in AT_PARENT else 0):
            return end
    return None


def _leaves(special: SpecialPoint) -> bool:
    """Whether another branch leaves at a special point (and not the branch itself, which begins there)."""
    if special.kind in BRANCHING:
        return special.found.direction is not None
    return special.kind in CORNERS and special.passed in BRANCHING and special.found.beyond is not None


def _meets(parent: Branch, special: SpecialPoint, child: Branch, end: int) -> bool:
    """Whether the end of a branch is at a special point of another."""
    low, high = parent.between
    sizes = parent.closing_map.sizes[parent.closing_map.unknowns]
    there = np.array(list(special.state.values()))
    away = parent.closing_map.map.away(there, child.states[end])[parent.closing_map.unknowns]
    off = max(float(np.max(np.abs(away) / sizes)), abs(special.parameter - child.parameter[end]) / (high - low))
    return child.response_period in (parent.response_period, 2 * parent.response_period) and off <= ONE_PLACE


def _holds(known: Branch, orbit: Orbit) -> bool:
    """Whether an orbit, or its mirror-image solution, lies on a branch."""
    if orbit.response_period != known.response_period or bool(orbit.symmetric) != bool(known.symmetric):
        return False
    state = state_vector(known.system, orbit.state)
    return branch_distance(known, state, float(orbit.system.parameter(known.over))) <= ON_BRANCH
