"""A branch of equilibria over a parameter: steady sliding, its folds, its Hopf points, and why it ends."""

import dataclasses
from typing import Annotated

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.orbits.equilibria.equilibrium import Equilibrium, equilibrium, sorted_eigenvalues, stable
from vibrocap.orbits.equilibria.rest_set import RestSet
from vibrocap.orbits.equilibria.search import SteadyState, steady_states
from vibrocap.orbits.equilibria.sliding import Sliding
from vibrocap.orbits.equilibria.steady_equations import SteadyEquations
from vibrocap.orbits.parameter_range import checked_range, system_at
from vibrocap.orbits.walk.branch_record import BranchRecord
from vibrocap.orbits.walk.following import Walked, followed, started, walked
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path, value_in_words
from vibrocap.physics.system import System
from vibrocap.quantities.declared import AngularFrequencies, Numbers, Over, Speeds, StateColumns

LONGEST = 0.02  # step, as a share of the range and of the size of the states


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class EquilibriumBranch(BranchRecord):
    """Equilibria that go over into each other as a parameter changes, in order along the branch.

    over, between: path and range of the parameter; sides: of each contact, the same all along
    parameter: [points]; states: [points, states]; travel: [points] rate of the cyclic coordinate, NaN without one
    eigenvalues: [points, eigenvalues] largest real part first; unstable: [points] how many have positive real parts
    stable: [points]; ends: why it ends at its first and its last point
    """

    system: System
    over: Path
    between: tuple[Parameter, Parameter]
    sides: tuple[int, ...]
    parameter: Annotated[Parameters, Over("point", name="over")]
    states: Annotated[StateColumns, Over("point")]
    travel: Annotated[Speeds, Over("point", words="rate of the cyclic coordinate")]
    eigenvalues: Annotated[AngularFrequencies, Over("point", "eigenvalue", words="eigenvalue")]
    unstable: Annotated[Numbers, Over("point", words="how many eigenvalues have positive real parts")]
    stable: Annotated[Numbers, Over("point", words="no eigenvalue has a positive real part")]
    special_points: Annotated[tuple[SpecialPoint, ...], Over("special")]
    ends: tuple[BranchEnd, BranchEnd]
    mode: Sliding = dataclasses.field(compare=False)

    in_record = "over between parameter states travel eigenvalues stable special_points ends advice"

    @property
    def heading(self) -> str:
        return f"branch of steady sliding over {self.over}"

    @property
    def facts(self) -> dict[str, str]:
        special = ", ".join(f"{point.kind.value} at {point.said('parameter')}" for point in self.special_points)
        return super().facts | ({"special points": special} if special else {})

    @property
    def largest_real_part(self) -> Annotated[AngularFrequencies, Over("point", words="largest real part")]:
        """Of the eigenvalues at each point."""
        return np.real(self.eigenvalues)[:, 0]

    @property
    def hopf_points(self) -> tuple[SpecialPoint, ...]:
        """Where cycles are born."""
        return self.kind(SpecialKind.HOPF)

    def equilibrium(self, point: int) -> Equilibrium:
        system = system_at(self.system, self.over, float(self.parameter[point]))
        problem = SteadyEquations(system, self.over)
        y = self.states[point][problem.unknowns]
        n, sides = len(problem.unknowns), self.mode.sides
        state = SteadyState(y, sides, np.zeros(len(sides), dtype=bool), self.mode.switched, np.zeros((n, 0)))
        return equilibrium(problem, RestSet(state, y, y))


def equilibrium_branch(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    *,
    start: Equilibrium | None = None,
    points: int = 2000,
) -> EquilibriumBranch:
    """The branch of steady sliding through one state of it, over a range of a parameter.

    Followed by its arclength, past folds and as an unstable branch. Folds and Hopf points are roots of equations of
    their own (`bifurcations.py`); `error` bounds the effect of rounding, so the exact place lies within it.

    over: path of the parameter, such as "machine.belt_speed"; between: its least and largest value
    start: a state of steady sliding of the system; by default the only one at the system's own parameters (where these
        are out of the range, at its nearer end)
    points: most points in each direction

    Raises ArgumentError for a system that is driven in time, one without steady sliding at the start, one with several
    of which none is given, and a start that is none of the system.
    """
    low, high = checked_range(system, over, between)
    check_whole("points", points, 10)
    if start is not None:
        if not isinstance(start, Equilibrium) or start.kind != "steady sliding" or start.dimension:
            raise ArgumentError("start", "should be a state of steady sliding, one of `equilibria(system).sliding`")
        if start.system.with_parameters({over: system.parameter(over)}) != system:
            raise ArgumentError("start", f"should be of the system, at any {over}: another parameter differs")
        system = start.system
    value = min(max(float(system.parameter(over)), low), high)
    if start is not None and value != float(system.parameter(over)):
        least, most = (value_in_words(over, number, system) for number in (low, high))
        raise ArgumentError("start", f"should have its {over} within {least} to {most}")
    problem = SteadyEquations(system_at(system, over, value), over)
    state = _start(problem, start)
    mode = Sliding(problem, state.sides, state.switched, (low, high))
    begun = started(mode, mode.point(state.y, value))
    if begun is None:
        why = f"should slide steadily at {_place(problem)}, but Newton's method leaves the state"
        raise ArgumentError("system", why)
    onward, back = followed(mode, begun, 1.0, points, LONGEST), None
    if onward.end is not BranchEnd.CLOSED:
        back = followed(mode, begun, -1.0, points, LONGEST)
    return _joined(mode, walked(mode, back, onward))


def _start(problem: SteadyEquations, start: Equilibrium | None) -> SteadyState:
    """The state from which a branch is followed."""
    moving = [state for state in steady_states(problem) if not state.rests.any() and not state.dimension]
    value = _place(problem)
    if start is not None:
        y = np.array([start.state[name] for name in problem.system.state_names])[problem.unknowns]
        limit = 1e-6 * (1.0 + np.max(np.abs(y)))
        for steady in moving:
            if np.max(np.abs(steady.y - y) / problem.scales) <= limit:
                return steady
        raise ArgumentError("start", f"should be an equilibrium of the system at {value}, but none is there")
    if not moving:
        raise ArgumentError("system", f"should slide steadily at {value}, but no such state was found")
    if len(moving) > 1:
        raise ArgumentError("start", f"should be given: at {value} there are {len(moving)} states of steady sliding")
    return moving[0]


def _place(problem: SteadyEquations) -> str:
    """The value of the parameter, in words."""
    path = str(problem.path)
    return f"{path} = {value_in_words(path, problem.system.parameter(path), problem.system)}"


def _joined(mode: Sliding, walk: Walked) -> EquilibriumBranch:
    """The public record of a branch that was walked."""
    problem, points = mode.problem, walk.points
    states = np.tile(mode.switched, (len(points), 1))
    states[:, problem.unknowns] = np.stack([mode.state(point.x) for point in points])
    cyclic = problem.recording.cyclic_state
    travel = np.full(len(points), np.nan)
    if cyclic >= 0:
        travel = np.array([mode.values([problem.recording.rates[cyclic]], point.x)[0] for point in points])
    jacobians = [point.closing.jacobian for point in points]
    return EquilibriumBranch(
        system=problem.system,
        over=str(problem.path),
        between=mode.between,
        sides=tuple(int(side) for side in mode.sides),
        parameter=np.array([mode.parameter(point.x) for point in points]),
        states=states + 0.0,
        travel=travel,
        eigenvalues=np.stack([sorted_eigenvalues(jacobian) for jacobian in jacobians]),
        unstable=np.array([point.closing.unstable() for point in points]),
        stable=np.array([stable(jacobian) is True for jacobian in jacobians]),
        special_points=walk.special_points,
        ends=walk.ends,
        mode=mode,
    )
