"""A branch of equilibria over a parameter: steady sliding, its folds, its Hopf points, and why it ends."""

import dataclasses
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.orbits.equilibria.bifurcations import Located, first_lyapunov_coefficient, fold, hopf
from vibrocap.orbits.equilibria.equilibrium import Equilibrium, equilibrium, sorted_eigenvalues, stable
from vibrocap.orbits.equilibria.following import EquilibriumEnd, Place, between, followed, matched, placed
from vibrocap.orbits.equilibria.rest_set import RestSet
from vibrocap.orbits.equilibria.search import SteadyState, steady_states
from vibrocap.orbits.equilibria.steady_equations import Mode, SteadyEquations
from vibrocap.orbits.parameter_range import checked_range, system_at
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path
from vibrocap.physics.system import System
from vibrocap.quantities.declared import (
    AngularFrequencies,
    AngularFrequency,
    Number,
    Numbers,
    Over,
    Speeds,
    StateColumns,
    States,
)
from vibrocap.quantities.dimensional import said
from vibrocap.results import Explained, Result

ON_AXIS = 1e-9  # real part over the eigenvalue that is zero up to rounding
NEAR = 2.0  # steps of the branch within which a located point must lie
DEGENERATE = 1e-8  # first Lyapunov coefficient over omega that is zero up to rounding


class EquilibriumPointKind(Explained):
    """What a special point of a branch of equilibria is; `meaning` says it in words."""

    FOLD = "fold", "Two equilibria meet (eigenvalue 0); beyond it neither exists."
    HOPF = "Hopf", "A pair of eigenvalues passes the imaginary axis: a cycle is born here."
    MODE_COUPLING = "mode coupling", "Two frequencies without damping meet; beyond it one vibration grows."
    BRANCH_POINT = "branch point", "Another branch of equilibria crosses here (eigenvalue 0)."
    UNLOCATED = "not located", "An eigenvalue passes the imaginary axis, but its equation was not solved."


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class EquilibriumPoint(Result):
    """A special point of a branch of equilibria.

    parameter, error: where, and how far off at most by rounding; after_point: the last point of the branch before it
    frequency: angular frequency at a Hopf point; None else
    lyapunov: first Lyapunov coefficient of a Hopf point; below zero a stable cycle is born (supercritical), above zero
        an unstable one (subcritical)
    vector: [states] eigenvector at the point, over its length: the shape of the cycle that is born, complex
    """

    kind: EquilibriumPointKind
    parameter: Parameter
    error: Parameter
    state: States
    after_point: int
    frequency: AngularFrequency | None
    lyapunov: Number | None
    vector: Numbers
    unstable_before: int
    unstable_after: int

    in_record = "kind parameter error frequency criticality state stability remarks"

    @property
    def criticality(self) -> str:
        """ "supercritical", "subcritical", or "degenerate" where the coefficient vanishes; "" where there is none."""
        if self.lyapunov is None or self.frequency is None:
            return ""
        if abs(self.lyapunov) <= DEGENERATE * self.frequency:
            return "degenerate"
        return "supercritical" if self.lyapunov < 0.0 else "subcritical"

    @property
    def heading(self) -> str:
        return f"{self.kind.value} at {self.said('parameter', 12)} (error {self.error:.0e})"

    @property
    def stability(self) -> str:
        """ "lost", "gained" or "kept", going along the branch."""
        if (self.unstable_before == 0) == (self.unstable_after == 0):
            return "kept"
        return "lost" if self.unstable_before == 0 else "gained"

    @property
    def remarks(self) -> str:
        """What else is to be said of it."""
        said = [] if self.frequency is None else [f"omega {self.said('frequency')}", self.criticality]
        said += [] if self.stability == "kept" else [f"stability {self.stability}"]
        return "; ".join(each for each in said if each)

    @property
    def facts(self) -> dict[str, str]:
        return {"meaning": self.kind.meaning, "remarks": self.remarks}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class EquilibriumBranch(Result):
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
    special_points: Annotated[tuple[EquilibriumPoint, ...], Over("special")]
    ends: tuple[EquilibriumEnd, EquilibriumEnd]
    mode: Mode = dataclasses.field(compare=False)

    rows = "special_points"
    in_record = "over between parameter states travel eigenvalues stable special_points ends advice"

    def __len__(self) -> int:
        return len(self.parameter)

    @property
    def heading(self) -> str:
        return f"branch of steady sliding over {self.over}"

    @property
    def facts(self) -> dict[str, str]:
        low, high = float(np.min(self.parameter)), float(np.max(self.parameter))
        special = ", ".join(f"{each.kind.value} at {each.said('parameter')}" for each in self.special_points)
        return {
            "points": f"{len(self)} points from {low:.6g} to {said(high, self.unit_of('parameter'), 6)}",
            "stability": f"{np.mean(self.stable):.0%} of them stable".replace("%", " %"),
            "special points": special or "no special points",
            "ends": f"begins: {self.ends[0].value}, ends: {self.ends[1].value}",
        }

    @property
    def largest_real_part(self) -> Annotated[AngularFrequencies, Over("point", words="largest real part")]:
        """Of the eigenvalues at each point."""
        return np.real(self.eigenvalues)[:, 0]

    @property
    def advice(self) -> tuple[str, ...]:
        """What to try at each end."""
        return tuple(end.advice for end in self.ends)

    def kind(self, *kinds: EquilibriumPointKind) -> tuple[EquilibriumPoint, ...]:
        """The special points of some kinds."""
        return tuple(each for each in self.special_points if each.kind in kinds)

    @property
    def hopf_points(self) -> tuple[EquilibriumPoint, ...]:
        """Where cycles are born."""
        return self.kind(EquilibriumPointKind.HOPF)

    def equilibrium(self, point: int) -> Equilibrium:
        """The equilibrium at a point of the branch."""
        system = system_at(self.system, self.over, float(self.parameter[point]))
        problem = SteadyEquations(system, self.over)
        y = self.states[point][problem.unknowns]
        n, sides = len(problem.unknowns), self.mode.sides
        state = SteadyState(y, sides, np.zeros(len(sides), dtype=bool), self.mode.switched, np.zeros((n, 0)))
        return equilibrium(problem, RestSet(state, y, y))

    def __str__(self) -> str:
        """The branch in words."""
        lines = [f"Branch of steady sliding over {self.over}, {len(self)} points:"]
        for each in self.special_points:
            lines.append(
                f"  {each.kind.value:20s} {each.said('parameter', 12)} (error {each.error:.0e})  {each.remarks}"
            )
        for where, value, end in zip(("begins", "ends"), self.parameter[[0, -1]], self.ends, strict=True):
            advice = f". {end.advice}" if end is not EquilibriumEnd.PARAMETER_BOUND else ""
            lines.append(f"  {where} at {said(value, self.unit_of('parameter'))}: {end.value}{advice}")
        return "\n".join(lines)


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
    their own (`bifurcations.py`); `error` is what rounding leaves of them, so that it holds the exact place.

    over: path of the parameter, such as "machine.belt_speed"; between: its least and largest value
    start: a state of steady sliding of the system; by default the only one at the system's own parameters (where these
        are out of the range, at its nearer end)
    points: most points each way

    Raises ArgumentError for a system that is driven in time, one without steady sliding at the start, one with several
    of which none is given, and a start that is none of the system.
    """
    low, high = checked_range(system, over, between)
    check_whole("points", points, 10)
    if start is not None:
        if not isinstance(start, Equilibrium) or start.kind != "steady sliding" or start.dimension:
            raise ArgumentError("start", "should be a state of steady sliding, one of `equilibria(system).sliding`")
        if start.system.with_parameters({over: system.parameter(over)}) != system:
            raise ArgumentError("start", f"should be of the system, whatever its {over}: another parameter differs")
        system = start.system
    value = min(max(float(system.parameter(over)), low), high)
    if start is not None and value != float(system.parameter(over)):
        raise ArgumentError("start", f"should have its {over} within {low:g} to {high:g}")
    problem = SteadyEquations(system_at(system, over, value), over)
    state = _start(problem, start)
    mode = Mode(problem, state.sides, state.switched, (low, high))
    x, up = mode.point(state.y, value), np.eye(len(state.y) + 1)[-1]
    forward, last = followed(mode, placed(mode, x, up), points)
    if last is EquilibriumEnd.CLOSED:
        return _joined(mode, forward, (last, last))
    back, first = followed(mode, placed(mode, x, -up, forward[0].eigenvalues), points)
    turned = [dataclasses.replace(each, tangent=-each.tangent) for each in back[:0:-1]]
    return _joined(mode, [*turned, *forward], (first, last))


def _start(problem: SteadyEquations, start: Equilibrium | None) -> SteadyState:
    """The state from which a branch is followed."""
    found = [each for each in steady_states(problem) if not each.rests.any() and not each.dimension]
    value = f"{problem.path} = {problem.system.parameter(str(problem.path)):g}"
    if start is not None:
        y = np.array([start.state[name] for name in problem.system.state_names])[problem.unknowns]
        near = [
            each for each in found if np.max(np.abs(each.y - y) / problem.scales) <= 1e-6 * (1.0 + np.max(np.abs(y)))
        ]
        if not near:
            raise ArgumentError("start", f"should be an equilibrium of the system at {value}, but none is there")
        return near[0]
    if not found:
        raise ArgumentError("system", f"should slide steadily at {value}, but no such state was found")
    if len(found) > 1:
        raise ArgumentError("start", f"should be given: at {value} there are {len(found)} states of steady sliding")
    return found[0]


def _joined(mode: Mode, places: list[Place], ends: tuple[EquilibriumEnd, EquilibriumEnd]) -> EquilibriumBranch:
    """The public record of places in order."""
    problem = mode.problem
    states = np.tile(mode.switched, (len(places), 1))
    states[:, problem.unknowns] = np.stack([mode.state(each.x) for each in places])
    cyclic = problem.recording.cyclic_state
    travel = np.full(len(places), np.nan)
    if cyclic >= 0:
        travel = np.array([mode.values([problem.recording.rates[cyclic]], each.x)[0] for each in places])
    jacobians = [mode.jacobian(each.x) for each in places]
    special: list[EquilibriumPoint] = []
    for i in range(len(places) - 1):
        special += _special_points(mode, places[i], places[i + 1], i)
    return EquilibriumBranch(
        system=problem.system,
        over=str(problem.path),
        between=mode.between,
        sides=tuple(int(side) for side in mode.sides),
        parameter=np.array([mode.parameter(each.x) for each in places]),
        states=states + 0.0,
        travel=travel,
        eigenvalues=np.stack([sorted_eigenvalues(each) for each in jacobians]),
        unstable=np.array([_unstable(each.eigenvalues) for each in places]),
        stable=np.array([stable(each) is True for each in jacobians]),
        special_points=tuple(special),
        ends=ends,
        mode=mode,
    )


def _unstable(values: np.ndarray) -> int:
    """How many real parts are positive."""
    return int(np.sum(np.real(values) > ON_AXIS * np.abs(values)))


def _special_points(mode: Mode, first: Place, last: Place, after: int) -> list[EquilibriumPoint]:
    """Special points between two neighbouring places, in order: eigenvalues that pass the imaginary axis."""
    found: list[EquilibriumPoint] = []
    old, new = first.eigenvalues, matched(last.eigenvalues, first.eigenvalues)
    neutral = [np.abs(np.real(values)) <= ON_AXIS * np.abs(values) for values in (old, new)]
    way, counts = float(np.linalg.norm(last.x - first.x)), (_unstable(old), _unstable(new))
    turns = first.tangent[-1] * last.tangent[-1] < 0.0
    for k in range(len(old)):
        sided = old[k].real * new[k].real < 0.0 and not (neutral[0][k] or neutral[1][k])
        left = neutral[0][k] != neutral[1][k] and (new[k] if neutral[0][k] else old[k]).real > 0.0
        complex_ = max(old[k].imag, new[k].imag) > 0.0 and abs(old[k].imag) > 0.0 and abs(new[k].imag) > 0.0
        if not (sided or left) or (old[k].imag < 0.0 or new[k].imag < 0.0):
            continue
        share = float(abs(old[k].real) / (abs(old[k].real) + abs(new[k].real))) if sided else 0.5
        place = between(mode, first, last, share) or first
        kind, located = EquilibriumPointKind.UNLOCATED, None
        if complex_:
            guess = complex(0.0, float((1.0 - share) * old[k].imag + share * new[k].imag))
            kind = EquilibriumPointKind.MODE_COUPLING if left else EquilibriumPointKind.HOPF
            located = hopf(mode, place.x, guess, coupled=left)
        elif turns:
            kind, located = EquilibriumPointKind.FOLD, fold(mode, place.x)
        elif old[k].imag == new[k].imag == 0.0:
            kind, located = EquilibriumPointKind.BRANCH_POINT, _branch_point(mode, first, last, k)
        if located is None or np.linalg.norm(located.x - place.x) > NEAR * way:
            kind, located = EquilibriumPointKind.UNLOCATED, _nowhere(mode, first, last, place)
        if not any(each.kind is kind and _same(each, mode.parameter(located.x), located.frequency) for each in found):
            found.append(_point(mode, kind, located, after, counts))
    along = np.sign(last.x[-1] - first.x[-1])
    return sorted(found, key=lambda each: along * each.parameter)


def _same(point: EquilibriumPoint, parameter: float, frequency: float) -> bool:
    """Whether a point is the one at a parameter with a frequency."""
    size = point.error + 1e-9 * abs(parameter)
    return abs(point.parameter - parameter) <= size and abs((point.frequency or 0.0) - frequency) <= 1e-6 * frequency


def _branch_point(mode: Mode, first: Place, last: Place, k: int) -> Located | None:
    """Where a real eigenvalue passes zero without a turn of the branch, by a bracketed root along it."""
    from scipy.optimize import brentq  # only here: it takes long to load

    def smallest(share: float) -> float:
        place = between(mode, first, last, share)
        return float("nan") if place is None else float(matched(place.eigenvalues, first.eigenvalues)[k].real)

    if not smallest(0.0) * smallest(1.0) < 0.0:
        return None
    share: Any = brentq(smallest, 0.0, 1.0, xtol=1e-14)
    place = between(mode, first, last, share)
    if place is None:
        return None
    values, vectors = np.linalg.eig(mode.jacobian(place.x))
    at = int(np.argmin(np.abs(values)))
    slope = abs(smallest(1.0) - smallest(0.0)) / abs(mode.parameter(last.x) - mode.parameter(first.x))
    # Rounding moves an eigenvalue by its condition times that of the matrix; one that is double there much farther.
    left = np.linalg.inv(vectors)[at] if np.linalg.cond(vectors) < 1e14 else np.full(len(values), np.inf)
    condition = float(np.linalg.norm(left) * np.linalg.norm(vectors[:, at]))
    noise = 16.0 * float(np.finfo(float).eps) * condition * float(np.linalg.norm(mode.jacobian(place.x)))
    width = 4e-14 * abs(mode.parameter(last.x) - mode.parameter(first.x))
    error = noise / slope + width + 1e-15 * abs(mode.parameter(place.x))
    return Located(place.x, error, 0.0, np.real(vectors[:, at]))


def _nowhere(mode: Mode, first: Place, last: Place, place: Place) -> Located:
    """What could not be located: somewhere between two places."""
    width = abs(mode.parameter(last.x) - mode.parameter(first.x))
    return Located(place.x, width, 0.0, np.zeros(mode.count))


def _point(
    mode: Mode, kind: EquilibriumPointKind, located: Located, after: int, counts: tuple[int, int]
) -> EquilibriumPoint:
    """The public record of a special point."""
    problem = mode.problem
    state, vector = mode.switched.copy(), np.zeros(len(mode.switched), dtype=complex)
    state[problem.unknowns] = mode.state(located.x)
    vector[problem.unknowns] = located.vector * problem.scales
    length = float(np.linalg.norm(vector))
    is_hopf = kind is EquilibriumPointKind.HOPF
    return EquilibriumPoint(
        kind=kind,
        parameter=mode.parameter(located.x),
        error=located.error,
        state={name: float(value) + 0.0 for name, value in zip(problem.system.state_names, state, strict=True)},
        after_point=after,
        frequency=located.frequency or None,
        lyapunov=first_lyapunov_coefficient(mode, located) if is_hopf else None,
        vector=vector / length if length > 0.0 else vector,
        unstable_before=counts[0],
        unstable_after=counts[1],
    )
