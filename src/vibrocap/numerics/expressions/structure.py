"""What recorded equations tell before any number is known.

Degrees in time and constant factors; which states relax faster than the motion, so that they may be slaved to all
others, and their decay; where a motion returns that comes to rest nowhere.
"""

import functools
import operator
from collections.abc import Sequence

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative

FREE = 10**9  # degree of a node that is no polynomial in time


class Forms:
    """Degrees and factors of the nodes of one graph, along motions with these rates."""

    def __init__(self, graph: Graph, rates: Sequence[Expression]):
        self.graph = graph
        self.rates = rates
        self._degrees: dict[int, int] = {}
        self._multiples: dict[int, tuple[Expression, int]] = {}
        self._linear: dict[int, tuple[Expression, int]] = {}

    def degree(self, index: int) -> int:
        """Degree in time of a node if it is a polynomial for every motion, else FREE. Higher coefficients vanish."""
        if index not in self._degrees:
            op, *operands = self.graph.nodes[index]
            if op == "time":
                degree = 1
            elif self.graph.is_constant_in_time(index) or self._is_switched(op, operands):
                degree = 0
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

    def _is_switched(self, op: str, operands: list) -> bool:
        """Whether a node is a state that changes at events only."""
        return op == "state" and self.rates[operands[0]].value == 0.0

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
