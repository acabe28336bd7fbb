"""Writes the series of motions on a slow manifold: of stiff bristles that have relaxed, see `step/slow_manifold.py`.

An internal state z with z' = r(t, y, z), dr/dz = -rate, forgets where it was within a few 1/rate. Its ordinary series
knows of that decay, and only steps of a few 1/rate can use it. What remains, z as a function of the slow states, has a
series of its own, whose coefficients follow from those of r at the same order:

    (k + 1) z_(k+1) = r_k(z_k) = r_k(0) + (dr/dz)_0 z_k,     so that     z_k = [(k + 1) z^_(k+1) - r_k(0)]/(dr/dz)_0,

where z^ is the series of the sweep before; its coefficients beyond the order are zero. z_0 is one step of Newton's
method from the state. The rate r has the coefficients (k + 1) z^_(k+1) wherever it stands, as in a force with damping.
All this in the lanes that are on the manifold of a contact; the others have their ordinary series.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.codegen.straight_line import ZERO, Code, Formula, Term, literal
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.forms import Forms
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative, reachable
from vibrocap.numerics.kernel.memory_layout import Layout


def slow_states(equations: Equations) -> tuple[int, ...]:
    """Of each contact the internal state that may be slaved to all others, -1 where there is none."""
    forms = Forms(equations.graph, equations.rates)
    found = []
    for each in equations.contacts:
        state = each.internal[0] if each.kind == "kinked" and len(each.internal) == 1 else -1
        if state >= 0:
            rate = equations.rates[state]
            alone = forms.linear(rate.index)[1] == rate.index
            relaxes = derivative(rate, state).value != 0.0
            if not (alone and relaxes) or equations.law_switches:
                state = -1
        found.append(state)
    return tuple(found)


def slow_constants(layout: Layout) -> dict[str, Any]:
    """What a kernel knows of them."""
    states = layout.slow or (-1,) * layout.contacts
    return {"SLOWED": bool(layout.slow), "SLOW_STATE": states, "SLOWS": tuple(int(each >= 0) for each in states)}


def series_writer(equations: Equations, layout: Layout, code: Code) -> JetWriter:
    """The writer of the series of these equations."""
    given = equations.graph, list(equations.rates), code, equations.balance
    if not layout.slow:
        return JetWriter(*given)
    slow = {state: contact for contact, state in enumerate(layout.slow) if state >= 0}
    return SlowWriter(*given, slow, layout.order)


def bounding_decays(equations: Equations, writer: JetWriter, rates: Sequence[Expression]) -> list[Formula]:
    """Of the rates of decay those that bound a step: 0 of bristles on their manifold, whose own rate is kept apart.

    rates: one of each contact with bristles
    """
    found = [writer.coefficient(rate.index, 0) for rate in rates]
    if not isinstance(writer, SlowWriter):
        return found
    contacts = [i for i, each in enumerate(equations.contacts) if each.internal]
    state_of = {contact: state for state, contact in writer.slow.items()}
    for place, contact in enumerate(contacts):
        if contact in state_of:
            writer.code.store(f"OWN_DECAY + {contact} * LANES", found[place])
            masked = writer.chosen(state_of[contact], ZERO, found[place])
            found[place] = writer.code.name(f"bounding_{contact}", masked)
    return found


class SlowWriter(JetWriter):
    """A writer of the series of lanes of which some are on the manifold."""

    def __init__(
        self, graph: Graph, rates: list[Expression], code: Code, balance: Any, slow: Mapping[int, int], order: int
    ):
        """slow: contact by internal state."""
        super().__init__(graph, rates, code, balance)
        self.slow, self.order = slow, order
        self.slow_rates = {rates[state].index: state for state in slow}
        self._trials: dict[tuple[int, int], Trial] = {}

    def trial(self, state: int, k: int) -> "Trial":
        """Coefficients of order k without that of a slow state; of order 0 with the state as it stands."""
        if (state, k) not in self._trials:
            self._trials[state, k] = Trial(self, state, k)
        return self._trials[state, k]

    def chosen(self, state: int, slow: Formula, other: Formula) -> Formula:
        """A value of the lanes on the manifold of a state, another of all others."""
        contact = self.slow[state]
        mask = self.code.name(f"slow_{contact}", Formula(f"load(floats, SLOW + {contact} * LANES) > 0.0"))
        return Formula(f"where({mask.text}, {slow.text}, {other.text})", max(slow.known, other.known) + 4)

    def target(self, state: int, k: int) -> Formula:
        """(k + 1) z^_(k+1)."""
        if k >= self.order:
            return ZERO
        place = self.slow[state] * (self.order + 1) + k + 1
        guess = self.code.entry(f"GUESS + {place} * LANES")
        name = f"target{self.slow[state]}_{k}"
        return self.code.name(name, guess if k == 0 else guess * literal(k + 1.0))

    def _formula(self, index: int, op: str, operands: list, k: int) -> Formula:
        ordinary = super()._formula(index, op, operands, k)
        state = self.slow_rates.get(index)
        return ordinary if state is None else self.chosen(state, self.target(state, k), ordinary)

    def signed_terms(self, index: int, k: int, inner: bool = False) -> list[Term]:
        """As of any node; a slow rate is not taken apart within another sum."""
        if inner and index in self.slow_rates:
            return [(1, self.coefficient(index, k))]
        return super().signed_terms(index, k, inner)

    def _state(self, state: int, k: int) -> Formula:
        ordinary = super()._state(state, k)
        if state not in self.slow:
            return ordinary
        trial, rate = self.trial(state, k), self.rates[state]
        at_start = self.trial(state, 0)
        slope = at_start.coefficient(derivative(rate, state).index, 0)
        inverse = self.code.name(f"relaxation{self.slow[state]}", literal(1.0) / slope)
        found = (self.target(state, k) - trial.coefficient(rate.index, k)) * inverse
        return self.chosen(state, ordinary + found if k == 0 else found, ordinary)

    def _weighted(self, a: int, j: int) -> Formula:
        op, *operands = self.graph.nodes[a]
        if op == "state" and operands[0] in self.slow:  # j times its coefficient is not that of the rate
            value = self.coefficient(a, j)
            return value if j == 1 else self.named("w", value * literal(float(j)), a, j)
        return super()._weighted(a, j)


class Trial(JetWriter):
    """The coefficients of one order as they would be without that of a slow state."""

    def __init__(self, whole: SlowWriter, state: int, k: int):
        super().__init__(whole.graph, whole.rates, whole.code)
        self.whole, self.state, self.k = whole, state, k
        self.forms = whole.forms
        self.own = whole.graph.node("state", state).index
        self._depends: dict[int, bool] = {}

    def depends(self, index: int) -> bool:
        """Whether a node depends on the state."""
        if index not in self._depends:
            self._depends[index] = self.own in reachable(self.graph, [index])
        return self._depends[index]

    def coefficient(self, index: int, k: int) -> Formula:
        """That of the whole, unless it is of this order and depends on the state."""
        if k < self.k or not self.depends(index):
            return self.whole.coefficient(index, k)
        if index == self.own:
            return self.code.entry(f"STATE + {self.state} * LANES") if k == 0 else ZERO
        return super().coefficient(index, k)

    def named(self, kind: str, formula: Formula, index: int, k: int | None = None) -> Formula:
        """A formula under a name of this trial."""
        return self.code.name(
            f"{kind}t{self.state}_{self.k}_{self.whole.number(index)}{'' if k is None else f'_{k}'}", formula
        )
