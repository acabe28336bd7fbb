"""Equilibria of a system that nothing drives in time: steady sliding and sets of rest, with their eigenvalues."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import Expression
from vibrocap.orbits.equilibria.steady_states import SteadyEquations, SteadyState, steady_states
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.quantities.declared import AngularFrequencies, AngularFrequency, Force, Speed, States
from vibrocap.quantities.dimensional import said
from vibrocap.results import Result

SLOWEST = 1e-12  # speed over the natural one at which a law without a limit at rest is asked for its force
STRAIGHT = 1e-9  # of the size of a function by which it may leave a straight line


@dataclasses.dataclass(frozen=True, eq=False)
class RestSet:
    """A set of states of rest: a state amid it, and the least and the largest value of each state, [unknowns]."""

    centre: SteadyState
    least: np.ndarray
    most: np.ndarray


class RestSets:
    """How far the forces at the contacts at rest are from what friction can hold, as functions of the states."""

    def __init__(self, problem: SteadyEquations):
        self.problem = problem
        system, recording = problem.system, problem.recording
        self.pairs: list[tuple[Expression, Expression]] = []
        for i, (contact, law, load) in enumerate(zip(recording.contacts, system.laws, system.law_loads, strict=True)):
            if contact.sticks:
                assert contact.hold is not None
                assert contact.limit is not None
                self.pairs.append((contact.hold, contact.limit))
                continue
            name = numbered("friction", i + 1) if i else "friction"
            limit = problem.graph.expression(float("inf"))
            if contact.kind == "kinked":
                place = list(problem.unknowns).index(contact.state) if contact.state in problem.unknowns else 0
                limit = problem.graph.expression(float(law.steady_force(SLOWEST * problem.scales[place], load)))
                if system.machine.follows_load:
                    limit = limit * recording.observables[numbered("reaction", i + 1) if i else "reaction"]
            self.pairs.append((recording.observables[name], limit))

    def margins(self, state: SteadyState, y: np.ndarray) -> np.ndarray:
        """limit - hold, limit + hold of each contact at rest, [2 contacts at rest, ...] at states [unknowns, ...]."""
        pairs = [pair for pair, rest in zip(self.pairs, state.rests, strict=True) if rest]
        values = self._values(state, y, [margin for pair in pairs for margin in pair])
        held, limit = values[0::2], values[1::2]
        return np.concatenate([limit - held, limit + held])

    def _values(self, state: SteadyState, y: np.ndarray, expressions: Sequence[Expression]) -> np.ndarray:
        extra = (1,) * (y.ndim - 1)
        switched = state.switched.reshape(-1, *extra)
        return self.problem.values(expressions, y, state.sides.reshape(-1, *extra), switched)

    def of(self, states: Sequence[SteadyState]) -> list[RestSet]:
        """The sets in which states of rest lie, of those that friction can hold."""
        rest_sets: list[RestSet] = []
        for state in states:
            if any(_within(state, rest_set, self.problem.scales) for rest_set in rest_sets):
                continue
            if state.dimension == 0:
                if np.all(self.margins(state, state.y) >= 0.0):
                    rest_sets.append(RestSet(state, state.y, state.y))
            elif (flat := self._flat(state) if self._is_flat(state) else self._curved(state)) is not None:
                rest_sets.append(flat)
        return _united(rest_sets, self.problem.scales)

    def _is_flat(self, state: SteadyState) -> bool:
        """Whether the set and its margins are straight: rates stay zero along its directions, margins are linear."""
        draw = np.random.default_rng(3)
        along = (state.directions @ draw.normal(size=(state.dimension, 6))) * self.problem.scales[:, None]
        y = state.y[:, None]
        rates = self._values(state, y + along, self.problem.rates)
        size = np.max(np.abs(self._values(state, y + along, self.problem.recording.rates)), initial=0.0)
        jacobian = np.abs(self.problem.jacobian(y, state.sides[:, None], state.switched[:, None])[:, :, 0])
        size = np.max(jacobian @ np.abs(along), initial=size)
        if np.max(np.abs(rates), initial=0.0) > STRAIGHT * size:
            return False
        ahead, here, back = (self.margins(state, y + s * along) for s in (1.0, 0.0, -1.0))
        return bool(np.max(np.abs(ahead - 2.0 * here + back)) <= STRAIGHT * np.max(np.abs(ahead) + np.abs(here)))

    def _flat(self, state: SteadyState) -> RestSet | None:
        """The set by linear programming, exact; None where friction can hold nothing of it."""
        from scipy.optimize import linprog  # only here: it takes long to load

        steps = state.directions * self.problem.scales[:, None]
        base = self.margins(state, state.y)
        slopes = np.column_stack([self.margins(state, state.y + step) - base for step in steps.T])
        unit = np.max(np.abs(base[np.isfinite(base)]), initial=0.0) or 1.0
        finite = np.isfinite(base)
        a, b, free = -slopes[finite] / unit, base[finite] / unit, [(None, None)] * state.dimension
        # Amid the set the least margin is largest; along a direction in which it does not end, it stays where it was.
        amid = linprog([*(0.0,) * state.dimension, -1.0], np.column_stack([a, np.ones(len(b))]), b,
                       bounds=[*free, (None, 1e6)])  # fmt: skip
        if amid.status != 0 or amid.x[-1] < 0.0:
            return None
        least, most = state.y.copy(), state.y.copy()
        for k in range(len(state.y)):
            if np.max(np.abs(steps[k])) <= 1e-12 * self.problem.scales[k]:
                continue
            for sign, ends in ((1.0, least), (-1.0, most)):
                end = linprog(sign * steps[k] / self.problem.scales[k], a, b, bounds=free)
                ends[k] = state.y[k] + steps[k] @ end.x if end.status == 0 else -sign * np.inf
        return RestSet(dataclasses.replace(state, y=state.y + steps @ amid.x[:-1]), least, most)

    def _curved(self, state: SteadyState) -> RestSet | None:
        """The set by constrained optimisation from one of its states: what hangs together with that state."""
        from scipy.optimize import minimize  # only here: it takes long to load

        scales = self.problem.scales
        lane = state.y[:, None], state.sides[:, None], state.switched[:, None]
        rate_size = np.linalg.norm(self.problem.jacobian(*lane)[:, :, 0] * scales, axis=1)
        rate_size = np.where(rate_size > 0.0, rate_size, 1.0)
        still = [v for v, rest in zip(self.problem.velocities, state.rests, strict=True) if rest]

        def at_rest(u: np.ndarray) -> np.ndarray:
            rates = self._values(state, u * scales, self.problem.rates) / rate_size
            return np.append(rates, self._values(state, u * scales, still))

        unit = np.max(np.abs(self.margins(state, state.y))) or 1.0

        def margins(u: np.ndarray) -> np.ndarray:
            return self.margins(state, u * scales) / unit

        constraints = [{"type": "eq", "fun": at_rest}, {"type": "ineq", "fun": margins}]
        start = state.y / scales
        if np.min(margins(start)) < 0.0:
            return None
        least, most = state.y.copy(), state.y.copy()
        with np.errstate(all="ignore"):
            for k in range(len(start)):
                for sign, ends in ((1.0, least), (-1.0, most)):
                    minimum = minimize(lambda u, k=k, sign=sign: sign * u[k], start, method="SLSQP",
                                     constraints=constraints, options={"ftol": 1e-14, "maxiter": 300})  # fmt: skip
                    if minimum.success and np.max(np.abs(at_rest(minimum.x))) < 1e-8:
                        ends[k] = sign * min(sign * ends[k], sign * minimum.x[k] * scales[k])
        return RestSet(state, least, most)


def _united(rest_sets: list[RestSet], scales: np.ndarray) -> list[RestSet]:
    """Sets that are pieces of one: of bristles on several pieces of their law, or seen from several of their states.

    Sets of the same contacts at rest whose extents overlap are one, of the largest dimension among them.
    """
    whole: list[RestSet] = []
    for rest_set in sorted(rest_sets, key=lambda one: -one.centre.dimension):
        for i, other in enumerate(whole):
            one, two = rest_set.centre, other.centre
            alike = np.array_equal(one.rests, two.rests) and np.all((one.sides == two.sides)[~one.rests])
            slack = STRAIGHT * scales
            meet = np.all(rest_set.least <= other.most + slack) and np.all(other.least <= rest_set.most + slack)
            if alike and meet and two.dimension > 0:
                least, most = np.minimum(rest_set.least, other.least), np.maximum(rest_set.most, other.most)
                whole[i] = RestSet(two, least, most)
                break
        else:
            whole.append(rest_set)
    return whole


def _within(state: SteadyState, rest_set: RestSet, scales: np.ndarray) -> bool:
    """Whether a state lies along the directions of a set of its mode, or in its extent."""
    one, other = state, rest_set.centre
    same = np.array_equal(one.rests, other.rests) and np.array_equal(one.sides[~one.rests], other.sides[~one.rests])
    if not (same and np.array_equal(one.switched, other.switched) and one.dimension == other.dimension > 0):
        return False
    slack = STRAIGHT * (np.abs(rest_set.least) + np.abs(rest_set.most) + scales)
    if np.all(one.y >= rest_set.least - slack) and np.all(one.y <= rest_set.most + slack):
        return True
    away = (one.y - other.y) / scales
    off = away - other.directions @ np.linalg.lstsq(other.directions, away, rcond=None)[0]
    return bool(np.max(np.abs(off)) <= STRAIGHT * (1.0 + np.max(np.abs(away))))


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
        return tuple(steady for steady in self.found if steady.kind == "steady sliding")

    @property
    def resting(self) -> tuple[Equilibrium, ...]:
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
    sets = []
    for state in (state for state in states if not state.rests.any()):
        moves = np.any(np.abs(state.directions) > 1e-9, axis=1)  # of steady sliding: along which nothing changes
        sets.append(RestSet(state, np.where(moves, -np.inf, state.y), np.where(moves, np.inf, state.y)))
    sets += RestSets(problem).of([state for state in states if state.rests.any()])
    known = [equilibrium(problem, rest_set) for rest_set in sets]
    order = sorted(known, key=lambda steady: (0 in steady.sides, steady.sides, tuple(steady.state.values())))
    return Equilibria(system, tuple(order))


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
