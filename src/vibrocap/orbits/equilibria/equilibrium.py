"""Equilibria of a system that nothing drives in time: steady sliding and sets of rest, with their eigenvalues."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from vibrocap.orbits.equilibria.rest_set import RestSet, RestSets
from vibrocap.orbits.equilibria.search import SteadyState, steady_states
from vibrocap.orbits.equilibria.steady_equations import SteadyEquations
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.quantities.declared import AngularFrequencies, AngularFrequency, Force, Speed, States
from vibrocap.quantities.dimensional import said
from vibrocap.results import Result

NEUTRAL = 1e-12  # real part of an eigenvalue over the terms of which it is the sum below which its sign is rounding


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Result):
    """A state at which all rates vanish but that of travel, or a set of them.

    sides: of each contact: +1 or -1 where it slides, 0 where it rests. state: by name; amid a set. least, most: of each
    state over the set, which of a single state are the state. dimension: of the set; 0: a single state.
    travel: rate of the cyclic coordinate; None where there is none.
    friction: force at each contact.
    eigenvalues: of the linearised equations, complex, largest real part first, with those along the set, which are
        zero. Velocities that are exactly zero at rest have none.
    stable: whether all others have negative real parts: for a set, whether the interior attracts; None where the
        linearised equations do not decide: an eigenvalue on the imaginary axis, or bristles at rest, whose rates have
        a kink there.
    """

    system: System
    sides: tuple[int, ...]
    state: States
    least: States
    most: States
    dimension: int
    travel: Speed | None
    friction: tuple[Force, ...]
    eigenvalues: AngularFrequencies
    stable: bool | None

    in_record = "kind stability stable dimension sides state least most travel friction frequency eigenvalues"

    @property
    def kind(self) -> str:
        """ "steady sliding", "rest", or, where some contacts rest, "partial rest"."""
        if 0 not in self.sides:
            return "steady sliding"
        return "rest" if not any(self.sides) else "partial rest"

    @property
    def stability(self) -> str:
        """In a word."""
        return {True: "stable", False: "unstable", None: "not decided"}[self.stable]

    @property
    def frequency(self) -> AngularFrequency | None:
        """Angular frequency of the oscillation that decays least or grows most; None where nothing oscillates."""
        pairs = self.eigenvalues[np.imag(self.eigenvalues) > 0.0]
        return float(pairs[np.argmax(np.real(pairs))].imag) if len(pairs) else None

    @property
    def heading(self) -> str:
        what = self.kind if not self.dimension else f"set of {self.kind}, dimension {self.dimension}"
        return f"{what}, {self.stability}"

    @property
    def facts(self) -> dict[str, str]:
        spans = {
            name: said(value, self.unit_of(name)) if self.least[name] == self.most[name]
            else f"{self.least[name]:.10g} to {said(self.most[name], self.unit_of(name))}"
            for name, value in self.state.items() if name != self.system.cyclic
        }  # fmt: skip
        travels = {}
        if self.travel is not None and any(self.sides):
            travels["travel"] = self.said("travel") + ("" if self.si_context() else " per time")
        rate = "" if (unit := self.unit_of("eigenvalues")) == "1" else f" {unit}"
        shown_values = ", ".join(_written(value) + rate for value in self.eigenvalues)
        return {**spans, **travels, "eigenvalues": shown_values or "none"}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Equilibria(Result):
    """All equilibria that were found: steady sliding first, each sort by its first state."""

    system: System
    found: tuple[Equilibrium, ...]

    rows = "found"

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Equilibrium]:
        return iter(self.found)

    def __getitem__(self, index: int) -> Equilibrium:
        return self.found[index]

    @property
    def sliding(self) -> tuple[Equilibrium, ...]:
        """States in which every contact slides."""
        return tuple(steady for steady in self.found if steady.kind == "steady sliding")

    @property
    def resting(self) -> tuple[Equilibrium, ...]:
        """States and sets in which some contact rests."""
        return tuple(steady for steady in self.found if steady.kind != "steady sliding")

    @property
    def heading(self) -> str:
        return f"{len(self.found)} equilibria" if len(self.found) != 1 else "1 equilibrium"

    @property
    def facts(self) -> dict[str, str]:
        return {f"[{i}]": steady.heading for i, steady in enumerate(self.found)} or {"found": "none"}

    def __str__(self) -> str:
        lines = [self.heading + (":" if self.found else " found.")]
        for i, steady in enumerate(self.found):
            lines.append(f"  [{i}] {steady.heading}")
            lines += [f"        {name:20s} {text}" for name, text in steady.facts.items()]
        return "\n".join(lines)


def equilibria(system: System) -> Equilibria:
    """States of steady sliding and sets of rest of a system that nothing drives in time, and their stability.

        y' = f(y) = 0 but for the travel,      eigenvalues of df/dy in the mode of the contacts

    A block that slides steadily on a belt, a capsule that slides down a slope at constant speed (its position grows:
    steady up to the drift), a pendulum that hangs still. Where a set-valued law holds a contact, all states at which
    the sticking force is within its limit are equilibria: an interval of rest, or a set of more dimensions, shown by
    its extent along each state. Dynamic laws contribute all of their states. Newton's method runs from many starts in
    every mode of the contacts, on exact derivatives of the recorded equations.

    Returns `Equilibria`, which may be empty: a block that sticks on a moving belt is none, as its spring is stretched.
    Extents are exact where forces are linear in the states, and a local optimum else, where a set may be listed in
    pieces. Equilibria at a rigid stop, and with an actuator at its limit, are not looked for. Of more than five
    contacts only the modes are tried in which all do the same. Raises ArgumentError for a system driven in time.
    """
    problem = SteadyEquations(system)
    states = steady_states(problem)
    sets = [_unbounded(state) for state in states if not state.rests.any()]
    sets += RestSets(problem).of([state for state in states if state.rests.any()])
    known = [equilibrium(problem, rest_set) for rest_set in sets]
    order = sorted(known, key=lambda steady: (0 in steady.sides, steady.sides, tuple(steady.state.values())))
    return Equilibria(system, tuple(order))


def _unbounded(state: SteadyState) -> RestSet:
    """States of steady sliding: one, or all along the directions in which nothing changes."""
    moves = np.any(np.abs(state.directions) > 1e-9, axis=1)
    return RestSet(state, np.where(moves, -np.inf, state.y), np.where(moves, np.inf, state.y))


def equilibrium(problem: SteadyEquations, rest_set: RestSet, system: System | None = None) -> Equilibrium:
    """The public record of a steady state or a set of them; system: with other numbers than the problem's own."""
    system, state = problem.system if system is None else system, rest_set.centre
    lane = state.y[:, None], state.sides[:, None], state.switched[:, None]
    values = problem.jacobian(*lane)[:, :, 0]
    contacts = problem.recording.contacts
    still = [contact.state for contact, rest in zip(contacts, state.rests, strict=True) if rest and contact.sticks]
    moving = ~np.isin(problem.unknowns, still)
    matrix = values[np.ix_(moving, moving)]
    bristles = any(rest and not contact.sticks for contact, rest in zip(contacts, state.rests, strict=True))
    friction = [problem.recording.observables[numbered("friction", i + 1)] for i in range(len(problem.velocities))]
    cyclic = problem.recording.cyclic_state
    travel = float(problem.values([problem.recording.rates[cyclic]], *lane)[0, 0]) if cyclic >= 0 else None

    def named(y: np.ndarray) -> dict[str, float]:
        """All states by name; the cyclic one is 0."""
        whole = state.switched.copy()
        whole[problem.unknowns] = y
        return {name: value + 0.0 for name, value in named_states(problem.system, whole).items()}

    return Equilibrium(
        system=system,
        sides=tuple(0 if rest else int(side) for side, rest in zip(state.sides, state.rests, strict=True)),
        state=named(state.y),
        least=named(rest_set.least),
        most=named(rest_set.most),
        dimension=state.dimension,
        travel=travel,
        friction=tuple(problem.values(friction, *lane)[:, 0].tolist()),
        eigenvalues=sorted_eigenvalues(matrix),
        stable=None if bristles else stable(matrix, state.dimension),
    )


def sorted_eigenvalues(matrix: np.ndarray) -> np.ndarray:
    """Eigenvalues, largest real part first, of a pair the one with the positive frequency first."""
    values = np.linalg.eigvals(matrix).astype(complex)
    return values[np.lexsort((-np.imag(values), -np.round(np.real(values), 14)))]


def stable(matrix: np.ndarray, dimension: int = 0) -> bool | None:
    """Whether all eigenvalues but the smallest ones, along a set of a dimension, have negative real parts.

    None where rounding decides. With left and right eigenvectors l and r, an eigenvalue is the sum of the terms in
    l J r/(l r), whatever the units of the states: a slow one is told beside a fast one that is many decades larger.
    """
    from scipy.linalg import eig  # only here: it takes long to load

    if not len(matrix):
        return True
    spectrum: Any = eig(matrix, left=True, right=True)
    values, left, right = spectrum
    terms = np.sum(np.abs(left) * (np.abs(matrix) @ np.abs(right)), axis=0)
    lengths = np.abs(np.sum(left.conj() * right, axis=0))
    across = np.argsort(np.abs(values))[dimension:]
    real, rounding = np.real(values)[across] * lengths[across], NEUTRAL * terms[across]
    if np.any(real > rounding):
        return False
    return True if np.all(real < -rounding) else None


def _written(value: complex) -> str:
    imaginary = f" {'-' if value.imag < 0.0 else '+'} {abs(value.imag):.6g}i" if value.imag else ""
    return f"{value.real:.6g}{imaginary}"
