"""Writes the series of motions on a slow manifold: of stiff bristles that have relaxed, see `step/slow_manifold.py`.

An internal state z with z' = r(t, y, z), dr/dz = -rate, forgets where it was within a few 1/rate. Its ordinary series
knows of that decay, and only steps of a few 1/rate can use it. What remains, z as a function of the slow states, has a
series of its own, whose coefficients follow from those of r at the same order:

    (k + 1) z_(k+1) = r_k(z_k) = r_k(0) + (dr/dz)_0 z_k,     so that     z_k = [(k + 1) z^_(k+1) - r_k(0)]/(dr/dz)_0,

where z^ is the series of the sweep before; its coefficients beyond the order are zero. z_0 is one step of Newton's
method from the state. The rate r has the coefficients (k + 1) z^_(k+1) wherever it stands, as in a force with damping.
There is a function for ordinary series and another for those on a manifold, of which lanes that are on none keep the
former. Of several contacts any may be on theirs in one function, which in lanes makes all series. A motion alone of one
contact has one for each manifold, and one for both where it creeps: two states z then, and at each order two such
equations with the Jacobian of both.
"""

from collections.abc import Sequence

from vibrocap.numerics.codegen.jets import JetWriter, shortest
from vibrocap.numerics.codegen.straight_line import ZERO, Code, Formula, Term, literal
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, reachable, sensitivity
from vibrocap.numerics.kernel.memory_layout import Layout


def bounding_decays(
    equations: Equations, layout: Layout, writer: JetWriter, rates: Sequence[Expression]
) -> list[Formula]:
    """Of the rates of decay those that bound a step: without those of what is on a manifold, which are kept apart.

    rates: one of each contact with bristles, or one of all
    """
    formulas = [writer.coefficient(rate.index, 0) for rate in rates]
    contacts = [i for i, contact in enumerate(equations.contacts) if contact.internal]
    if not isinstance(writer, SlowWriter):
        if layout.lanes > 1:
            for number, (contact, _) in enumerate(layout.slow):
                writer.code.store(f"OWN_DECAY + {number} * LANES", formulas[contacts.index(contact)])
        return formulas
    if writer.alone:
        for number in set(range(len(layout.slow))) - set(writer.slow.values()):
            writer.code.store(f"OWN_DECAY + {number} * LANES", ZERO)
    if writer.alone and len(writer.slow) > 1:
        (one, first), (two, second) = writer.slow.items()
        (a, b), (c, d) = ([writer.slope(i, j) for j in (one, two)] for i in (one, two))
        trace = writer.code.name("pair_trace", ZERO - (a + d))
        # at most the rate of the slower of the two, or that at which their oscillation decays
        own = Formula(f"min({((a * d - b * c) / trace).text}, 0.5 * {trace.text})")
        place = contacts.index(layout.slow[first][0])
        for number in (first, second):
            writer.code.store(f"OWN_DECAY + {number} * LANES", writer.code.name("pair_decay", own))
        formulas[place] = ZERO
        return formulas
    for state, number in writer.slow.items():
        contact = layout.slow[number][0]
        creeps = state not in equations.contacts[contact].internal
        places = range(len(formulas)) if creeps else [contacts.index(contact)]
        own = formulas[places[0]]
        if layout.lanes == 1:
            own = writer.coefficient((-derivative(equations.rates[state], state)).index, 0)
        writer.code.store(f"OWN_DECAY + {number} * LANES", own)
        for place in places:
            rest = ZERO if layout.lanes > 1 or writer.alone else formulas[place] - own
            bounding = writer.conditional(state, rest, formulas[place])
            formulas[place] = writer.code.name(f"bounding_{number}_{place}", bounding)
    return formulas


def store_reach(writer: JetWriter) -> None:
    """Keep what an error of a slaved state does to all others, over their natural sizes: per time, and as it decays."""
    if not isinstance(writer, SlowWriter):
        return
    code = writer.code
    for slow, number in writer.slow.items():
        lasting, passing, together = [], [], writer.together(slow)
        for state, other in enumerate(writer.rates):
            slope = derivative(other, slow)
            if state not in together and slope.value != 0.0:
                lasting_slope = slope
                for member in together:
                    lasting_slope = lasting_slope - writer.push(other, member) * derivative(writer.rates[member], slow)
                for values, value in ((lasting, lasting_slope), (passing, slope)):
                    size = Formula(f"abs({writer.coefficient(value.index, 0).text})")
                    values.append(size / code.entry(f"SCALE + {state} * LANES"))
        for name, values in (("DRIFT", lasting), ("KICK", passing)):
            largest = ZERO
            for i, value in enumerate(values):
                own = code.name(f"{name.lower()}{number}_{i}", value)
                largest = own if i == 0 else code.larger(f"most_{name.lower()}{number}_{i}", largest, own)
            code.store(f"{name} + {number} * LANES", largest)


class SlowWriter(JetWriter):
    """A writer of the series of lanes of which some are on the manifold."""

    def __init__(self, equations: Equations, layout: Layout, code: Code, numbers: Sequence[int]):
        self.slow = {layout.slow[number][1]: number for number in numbers}  # number of its manifold by state
        velocities = {contact.state for contact in equations.contacts}
        self.creeping = frozenset(velocities.intersection(self.slow))
        mechanics = None if self.creeping else shortest(equations)  # which gives no rate that is slaved
        super().__init__(equations.graph, list(equations.rates), code, mechanics)
        self.order = layout.order
        self.alone = layout.contacts == 1  # whatever is on a manifold is on all that are given of the one contact
        self.slow_rates = {self.rates[state].index: state for state in self.slow}
        self._trials: dict[tuple[tuple[int, ...], int], Trial] = {}

    def trial(self, states: tuple[int, ...], k: int) -> "Trial":
        """Coefficients of order k without those of slow states; of order 0 with these as they stand."""
        if (states, k) not in self._trials:
            self._trials[states, k] = Trial(self, states, k)
        return self._trials[states, k]

    def together(self, state: int) -> tuple[int, ...]:
        """The slow states that are solved for with one: of one contact all, else it alone."""
        return tuple(self.slow) if self.alone else (state,)

    def slope(self, state: int, other: int) -> Formula:
        """Of the rate of a state, by another state, where the step starts."""
        return self.coefficient(derivative(self.rates[state], other).index, 0)

    def push(self, value: Expression, state: int) -> Expression:
        """What a value changes by with the rate of a slow state, those of what is solved for with it given."""
        change, rate = sensitivity(value, self.rates[state].index), self.rates[state].index
        for other in self.together(state):
            if other != state:
                through = self.rates[other]
                change = change - sensitivity(value, through.index) * sensitivity(through, rate)
        return change

    def settled(self, state: int, k: int, value: Expression | None = None) -> Formula:
        """The same without the first error of the sweep: a force that contains z' was given that of the sweep before.

        And a state y with it: y_k + dy'/dz' (z_k - z^_k) is as exact as z_k.
        """
        coefficient = super().settled(state, k, value)
        for slow in self.slow if k > 0 else ():
            push = self.push(self.rates[state], slow)
            if state not in self.together(slow) and push.value != 0.0:
                own = self.coefficient(self.graph.node("state", slow).index, k)
                change = self.conditional(slow, own - self.target(slow, k - 1) * literal(1.0 / k), ZERO)
                coefficient = coefficient + self.coefficient(push.index, 0) * change
        return coefficient

    def conditional(self, state: int, slow: Formula, other: Formula) -> Formula:
        """A value of the lanes on the manifold of a state, another of all others."""
        if self.alone:
            return slow
        number = self.slow[state]
        mask = self.code.name(f"slow_{number}", Formula(f"{self.code.entry(f'SLOW + {number} * LANES').text} > 0.0"))
        return Formula(f"where({mask.text}, {slow.text}, {other.text})", max(slow.known, other.known) + 4)

    def guess(self, state: int, k: int) -> Formula:
        """z^_k."""
        return self.code.entry(f"GUESS + {self.slow[state] * (self.order + 1) + k} * LANES")

    def target(self, state: int, k: int) -> Formula:
        """(k + 1) z^_(k+1)."""
        if k >= self.order:
            return ZERO
        guess = self.guess(state, k + 1)
        name = f"target{self.slow[state]}_{k}"
        return self.code.name(name, guess if k == 0 else guess * literal(k + 1.0))

    def _formula(self, index: int, op: str, operands: list, k: int) -> Formula:
        ordinary = super()._formula(index, op, operands, k)
        state = self.slow_rates.get(index)
        return ordinary if state is None else self.conditional(state, self.target(state, k), ordinary)

    def signed_terms(self, index: int, k: int, inner: bool = False) -> list[Term]:
        """As of any node; a slow rate is not taken apart within another sum."""
        if inner and index in self.slow_rates:
            return [(1, self.coefficient(index, k))]
        return super().signed_terms(index, k, inner)

    def _state(self, state: int, k: int) -> Formula:
        ordinary = super()._state(state, k)
        if state not in self.slow:
            return ordinary
        solved = self.solution(state, k)
        return self.conditional(state, ordinary + solved if k == 0 else solved, ordinary)

    def solution(self, state: int, k: int) -> Formula:
        """Coefficient k of a slow state; of order 0 what Newton's method adds to it. A pair is solved for together."""
        together = self.together(state)
        trial, at_start = self.trial(together, k), self.trial(together, 0)

        def left(own_state: int) -> Formula:
            return self.target(own_state, k) - trial.coefficient(self.rates[own_state].index, k)

        def slope(own_state: int, other: int) -> Formula:
            return at_start.coefficient(derivative(self.rates[own_state], other).index, 0)

        number = self.slow[state]
        if len(together) == 1:
            own_slope = slope(state, state)
            for other_state in at_start.others:
                other_rate = self.rates[other_state]
                through = sensitivity(self.rates[state], other_rate.index) * derivative(other_rate, state)
                if through.value != 0.0:
                    own_slope = own_slope - self.conditional(other_state, at_start.coefficient(through.index, 0), ZERO)
            return left(state) * self.code.name(f"relaxation{number}", literal(1.0) / own_slope)
        (other,) = (member for member in together if member != state)
        determinant = slope(state, state) * slope(other, other) - slope(state, other) * slope(other, state)
        inverse = self.code.name("relaxation_pair", literal(1.0) / determinant)
        own, its = (self.code.name(f"left{self.slow[member]}_{k}", left(member)) for member in (state, other))
        return (slope(other, other) * own - slope(state, other) * its) * inverse

    def _weighted(self, a: int, j: int) -> Formula:
        op, *operands = self.graph.nodes[a]
        if op == "state" and operands[0] in self.slow:  # j times its coefficient is not that of the rate
            value = self.coefficient(a, j)
            return value if j == 1 else self.named("w", value * literal(float(j)), a, j)
        return super()._weighted(a, j)


class Trial(JetWriter):
    """The coefficients of one order as they would be without those of slow states."""

    def __init__(self, whole: SlowWriter, states: tuple[int, ...], k: int):
        super().__init__(whole.graph, whole.rates, whole.code)
        self.whole, self.k, self.label = whole, k, "_".join(map(str, states))
        self.forms, self.slow = whole.forms, whole.slow
        self.own = {whole.graph.node("state", state).index: state for state in states}
        # A velocity that is slaved may depend on what else is: that is as the sweep before found it.
        creeps = not whole.creeping.isdisjoint(states)
        self.others = [other for other in whole.slow if other not in states] if creeps else []
        self._given = {*self.own, *(whole.graph.node("state", other).index for other in self.others)}
        self._depends: dict[int, bool] = {}

    def depends(self, index: int) -> bool:
        """Whether a node depends on any of the states, or on what else is slaved."""
        if index not in self._depends:
            self._depends[index] = not self._given.isdisjoint(reachable(self.graph, [index]))
        return self._depends[index]

    def coefficient(self, index: int, k: int) -> Formula:
        """That of the whole, unless it is of this order and depends on the states."""
        if k < self.k or not self.depends(index):
            return self.whole.coefficient(index, k)
        if index in self.own:
            return self.code.entry(f"STATE + {self.own[index]} * LANES") if k == 0 else ZERO
        return super().coefficient(index, k)

    def _state(self, state: int, k: int) -> Formula:
        ordinary = JetWriter._state(self.whole, state, k)
        return ordinary if k == 0 else self.whole.conditional(state, self.whole.guess(state, k), ordinary)

    def _formula(self, index: int, op: str, operands: list, k: int) -> Formula:
        ordinary = super()._formula(index, op, operands, k)
        state = self.whole.slow_rates.get(index)
        return (
            ordinary
            if state not in self.others
            else self.whole.conditional(state, self.whole.target(state, k), ordinary)
        )

    def named(self, kind: str, formula: Formula, index: int, k: int | None = None) -> Formula:
        """A formula under a name of this trial."""
        name = f"{kind}t{self.label}_{self.k}_{self.whole.number(index)}"
        return self.code.name(name if k is None else f"{name}_{k}", formula)
