"""What recorded equations tell before any number is known: on it depend modules, memory and text of a kernel.

Degrees in time and constant factors; which states relax faster than the motion, so that they may be slaved to all
others, and their decay; where a motion returns that comes to rest nowhere; how a kernel is to step from rest.

Powers of a contact velocity where it vanishes: steps end there, and start as v = c t^2 from stick, else as v = c t. A
power that is not whole has no series there. It is constant in the first step, in which it is negligible; v then grows
by a factor of 3 at most a step until the power is resolved (`resolution.py`). A whole power |v|^m, m > 1, has a series
with gaps, whose last terms may vanish or tell nothing: four of them bound the first step from stick (`taylor_step`),
and for m > 2 so does the first one that is left out (`resolution.py`). Where a contact leaves stick the error of v is
held to less than the tolerance, for a power that is not whole or from the third on (`taylor.leaving`).
"""

import dataclasses
import functools
import math
import operator
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative, evaluate, reachable

FREE = 10**9  # degree of a node that is no polynomial in time


class Forms:
    """Degrees and factors of the nodes of one graph, along motions with these rates."""

    def __init__(self, graph: Graph, rates: Sequence[Expression]):
        self.graph = graph
        self.rates = rates
        self._degrees: dict[int, int] = {}
        self._multiples: dict[int, tuple[Expression, int]] = {}
        self._linear: dict[int, tuple[Expression, int]] = {}
        self._affine: dict[int, bool] = {}

    def degree(self, index: int) -> int:
        """Degree in time of a node if it is a polynomial for every motion, else FREE. Higher coefficients vanish."""
        if index not in self._degrees:
            op, *operands = self.graph.nodes[index]
            if op == "time":
                degree = 1
            elif self.graph.is_constant_in_time(index) or (op == "state" and self.rates[operands[0]].value == 0.0):
                degree = 0  # of a state that changes at events only, too
            elif op in ("add", "sub", "neg"):
                degree = max(self.degree(i) for i in operands)
            elif op == "mul":
                degree = min(FREE, self.degree(operands[0]) + self.degree(operands[1]))
            elif op == "div" and self.degree(operands[1]) == 0:
                degree = self.degree(operands[0])
            else:
                degree = FREE
            self._degrees[index] = degree
        return self._degrees[index]

    def affine(self, index: int) -> bool:
        """Whether a node is a sum of multiples of states, time and constants, whose series tells it to rounding."""
        if index not in self._affine:
            op, *operands = self.graph.nodes[index]
            known = op in ("time", "state") or self.degree(index) == 0
            if op == "div":
                known = known or (self.degree(operands[1]) == 0 and self.affine(operands[0]))
            elif not known and (op in ("add", "sub", "neg") or (op == "mul" and 0 in map(self.degree, operands))):
                known = all(map(self.affine, operands))
            self._affine[index] = known
        return self._affine[index]

    def multiple(self, index: int) -> tuple[Expression, int]:
        """(factor, base): the node is factor * base with a constant factor, drawn out of products too."""
        if index not in self._multiples:
            self._multiples[index] = self._multiple(index)
        return self._multiples[index]

    def _multiple(self, index: int) -> tuple[Expression, int]:
        op, *operands = self.graph.nodes[index]
        one = self.graph.constant(1.0)
        if self.degree(index) == 0 or op not in ("neg", "mul", "div"):
            return one, index
        if op == "neg":
            factor, base = self.multiple(operands[0])
            return -factor, base
        a, b = operands
        if op == "div":
            if self.degree(b) > 0:
                return one, index
            factor, base = self.multiple(a)
            return factor / Expression(self.graph, b), base
        if self.degree(a) == 0 or self.degree(b) == 0:
            constant, varying = (a, b) if self.degree(a) == 0 else (b, a)
            factor, base = self.multiple(varying)
            return Expression(self.graph, constant) * factor, base
        (left, x), (right, y) = self.multiple(a), self.multiple(b)
        if (x, y) == (a, b):
            return one, index
        return left * right, (Expression(self.graph, x) * Expression(self.graph, y)).index

    def linear(self, index: int) -> tuple[Expression, int]:
        """(factor, base): but for constants the node is factor * base; its coefficients k >= 1 are factor * base_k."""
        if index not in self._linear:
            self._linear[index] = self._linear_form(index)
        return self._linear[index]

    def _linear_form(self, index: int) -> tuple[Expression, int]:
        op, *operands = self.graph.nodes[index]
        varying = [i for i in operands if self.degree(i) > 0] if op in ("add", "sub", "mul", "neg", "div") else []
        if len(varying) != 1 or (op == "div" and varying[0] == operands[1]):
            return self.multiple(index)
        factor, base = self.linear(varying[0])
        if op == "neg" or (op == "sub" and operands[1] == varying[0]):
            factor = -factor
        if op == "mul":
            other = operands[0] if operands[1] == varying[0] else operands[1]
            factor = Expression(self.graph, other) * factor
        if op == "div":
            factor = factor / Expression(self.graph, operands[1])
        return factor, base


def slow_bristles(equations: Equations) -> tuple[tuple[int, int], ...]:
    """(contact, internal state) of contacts whose one internal state may be slaved to all others; () with a tangent."""
    if not equations.maybe_stiff or len(equations.rates) > equations.base:
        return ()
    record_slopes(equations)
    forms = Forms(equations.graph, equations.rates)
    pairs = []
    for contact, rubbing in enumerate(equations.contacts):
        if rubbing.kind == "kinked" and len(rubbing.internal) == 1 and not equations.law_switches:
            state = rubbing.internal[0]
            rate = equations.rates[state]
            if forms.linear(rate.index)[1] == rate.index and derivative(rate, state).value != 0.0:
                pairs.append((contact, state))
    return tuple(pairs)


def slow_states(equations: Equations) -> tuple[tuple[int, int], ...]:
    """(contact, state) of what may be slaved in a motion alone: bristles, the velocity of a contact that creeps, both.

    () where a contact has a law with a force for every velocity, but no such bristles: those take implicit steps.
    """
    bristles = slow_bristles(equations)
    stiff = [i for i, contact in enumerate(equations.contacts) if not contact.sticks]
    if stiff != [contact for contact, _ in bristles]:
        return ()
    rates = dict[int, int]()  # contact by state
    for contact, _ in bristles:
        rubbing = equations.contacts[contact]
        decay = derivative(equations.rates[rubbing.state], rubbing.state)
        if (rubbing.is_state or equations.several) and decay.value is None:
            rates.setdefault(rubbing.state, contact)
    return (*bristles, *((contact, state) for state, contact in rates.items()))


def decay_rates(equations: Equations) -> list[Expression]:
    """Rates of which the largest is that of the fastest decay: the trace of the Jacobian, with the other sign.

    It is the sum of all rates, of which that of bristles exceeds all others where it matters; of several bristles of
    one law it is the sum. Bristles of one contact know nothing of those of another but by the velocities of their
    bodies, so that each contact has a trace of its own, without the bristles of all others: as if it were alone.
    Without the tangent of a motion, which decays as the motion does.
    """
    slopes = [derivative(rate, i) for i, rate in enumerate(equations.rates[: equations.base])]
    bristles = [set(contact.internal) for contact in equations.contacts if contact.internal]
    apart = [set().union(*(other for other in bristles if other is not own)) for own in bristles] or [set()]
    kept = [[slope for i, slope in enumerate(slopes) if i not in others] for others in apart]
    return [-functools.reduce(operator.add, contact) for contact in kept]


def record_slopes(equations: Equations) -> None:
    """Record the slopes of all rates in one order: a graph remembers of a product which factor came first."""
    decay_rates(equations)
    for rate in equations.rates:
        for state in range(-1, len(equations.rates)):
            derivative(rate, state)


def place_of_returns(equations: Equations) -> dict[str, float]:
    """Where a motion returns that comes to rest nowhere: a turn, or the largest value of the first coordinate."""
    turns = dict(equations.turns)
    moving = (i for i, rate in enumerate(equations.rates) if i != equations.cyclic_state and rate.value != 0.0)
    place = next(iter(turns), None)
    place = next(moving, 0) if place is None else place
    return {"PLACE": place, "PLACE_TURN": float(turns.get(place, 0.0))}


AT_REST = 1e-10  # base of a power that is zero but for rounding, where parts of a velocity cancel
SLOW = 2.0**-5  # of the two speeds at which an argument is looked at, one twice the other


@dataclasses.dataclass(frozen=True)
class Speed:
    """A velocity of a contact, or an internal state: where its series stands, and whose natural size it has."""

    expression: Expression
    row: str
    state: int
    sticks: bool  # whether it is exactly zero at times


def speeds(equations: Equations) -> list[Speed]:
    """All on which sharp functions may depend: the velocities of the contacts and the states of their laws."""
    contacts, node = equations.contacts, equations.graph.node
    velocities = [Speed(own.velocity, f"VELOCITY_OF[{i}]", own.state, own.sticks) for i, own in enumerate(contacts)]
    internal = [i for contact in contacts for i in contact.internal]
    return velocities + [Speed(node("state", i), f"SERIES + {i} * (ORDER + 1) * LANES", i, False) for i in internal]


def zero_of_base(graph: Graph, base: int) -> float:
    """Size of its base up to which a power has no series: rounding, of which a single state at rest has none."""
    varying = [i for i in reachable(graph, [base]) if graph.nodes[i][0] in ("state", "time")]
    return 0.0 if len(varying) == 1 else AT_REST


def no_series_at_rest(velocity: Expression, expressions: Sequence[Expression]) -> bool:
    """Whether these contain a power of the velocity that is not whole, and so has no series where it vanishes."""
    graph = velocity.graph
    reached = reachable(graph, [expression.index for expression in expressions])
    return velocity.index in reachable(graph, [i for i in reached if graph.nodes[i][0] == "power"])


def gaps(equations: Equations, sharp: Sequence[int]) -> dict[int, tuple[Speed, int]]:
    """The sharp nodes whose argument vanishes at rest like |v|^m, m = 2, 3 ..., the velocity v and this m.

    From v = c t, or c t^2, their series is one in t^m, or t^2m: the last terms may vanish, or no term be left.
    """
    graph, gaps_by_node = equations.graph, {}
    draw = np.random.default_rng(0)
    states = list(draw.uniform(0.1, 0.9, len(equations.rates)))
    values = draw.uniform(0.5, 1.5, len(equations.parameter_paths))
    for node in sharp:
        argument = Expression(graph, graph.nodes[node][-1])
        below = reachable(graph, [argument.index])
        rough = graph.nodes[node][0] in ("log", "power") or any(graph.nodes[i][0] == "power" for i in below)
        for speed in () if rough else speeds(equations):
            if speed.expression.index not in below:
                continue
            states[speed.state], before = 0.0, states[speed.state]
            (shift,) = evaluate([speed.expression], 0.3, states, 1.0, values)
            with np.errstate(all="ignore"):
                near = []
                for v in (0.0, SLOW, 2.0 * SLOW):
                    states[speed.state] = v - shift
                    near.append(evaluate([argument], 0.3, states, 1.0, values)[0])
            states[speed.state] = before
            one, two = abs(near[1] - near[0]), abs(near[2] - near[0])
            if 0.0 < one < two < math.inf and math.log2(two / one) > 1.5:
                gaps_by_node[node] = speed, round(math.log2(two / one))
    return gaps_by_node


@dataclasses.dataclass(frozen=True, kw_only=True)
class Traits:
    """Numbers of states, contacts and guards, and how the laws move."""

    states: int
    parameters: int
    tangent: bool = False  # whether the last states are a tangent
    switches: int = 0  # guards of the branches of law and machine, and bounds
    coefficients: int = 0  # per segment of a drive with corners; 0: it has none
    contacts: int = 1
    held: int = 0  # contacts that can rest, each with two rows: the force that holds it, and its limit
    imposed: int = 0  # contact velocities that are no states
    shifts: int = 0  # of contacts at imposed distances, where one may be stiff: how far each is ahead of their state
    turns: int = 0  # coordinates that turn, of which a mark keeps a second number
    stiff: bool = True  # whether a contact has a law with a force for every velocity
    slow: tuple[tuple[int, int], ...] = ()  # slow manifolds: (contact, state that may be slaved)
    rates: tuple[int, ...] = ()  # of each state the one that is its rate, whose series tells its own, else -1; (): none

    @property
    def several(self) -> bool:
        """Whether there are several contacts."""
        return self.contacts > 1

    @property
    def corners(self) -> bool:
        """Whether the drive has corners."""
        return self.coefficients > 0


def traits(equations: Equations, side_by_side: bool = False) -> Traits:
    """What these equations have; side_by_side: for motions in lanes, where each bristle may be slaved by itself."""
    corners, stiff = equations.corners, equations.maybe_stiff
    return Traits(
        states=len(equations.rates),
        parameters=len(equations.parameter_paths),
        tangent=len(equations.rates) > equations.base,
        switches=len(equations.guards),
        coefficients=0 if corners is None else corners.coefficients,
        contacts=len(equations.contacts),
        held=sum(contact.sticks for contact in equations.contacts),
        imposed=len(equations.imposed),
        shifts=len(equations.shifts) if stiff else 0,
        turns=len(equations.turns),
        stiff=stiff,
        slow=slow_bristles(equations) if side_by_side else slow_states(equations),
        rates=_kept_rates(equations),
    )


def _kept_rates(equations: Equations) -> tuple[int, ...]:
    """Of each state the state that is its rate, if that one is kept whole; none where a series may be damped."""
    kept: list[int] = []
    for state, rate in enumerate(own.state for own in equations.rates):
        follows = rate not in (-1, state) and state not in kept and (rate > state or kept[rate] < 0)
        kept.append(rate if follows and not equations.maybe_stiff else -1)
    return tuple(kept)
