"""Sets of rest: the states at which friction holds every contact that rests, how far they reach, and their middle."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.expressions.graph import Expression
from vibrocap.orbits.equilibria.search import SteadyState
from vibrocap.orbits.equilibria.steady_equations import SteadyEquations
from vibrocap.physics.names import numbered

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
