"""Taylor coefficients of recorded equations, as straight-line source code.

For y' = f(t, y), the coefficients c_k of y(t + s) = sum c_k s^k follow from those of f by c_{k+1} = f_k/(k+1), and
those of f by one recurrence per operation (products are convolutions; Jorba and Zou 2005, table 1). The code is written
out for a fixed order.
"""

import functools
import operator
from collections import Counter
from collections.abc import Iterable, Mapping

from vibrocap.numerics.codegen.mechanics_series import MechanicsWriter
from vibrocap.numerics.codegen.straight_line import ONE, ZERO, Code, Formula, Term, combined, literal, total
from vibrocap.numerics.expressions.equations import Equations, Mechanics
from vibrocap.numerics.expressions.graph import LEAST_BASE, Expression, Graph, operands_of, reachable
from vibrocap.numerics.expressions.structure import Forms, zero_of_base

SUMS = ("add", "sub", "neg")
COUNTED = 4  # order up to which operations are counted
TWO = literal(2.0)


class JetWriter:
    """Writes the coefficients of the nodes of one graph, each when first asked for."""

    slow: Mapping[int, int] = {}  # states whose rates are not theirs, see `slow_manifold.py`

    def __init__(
        self, graph: Graph, rates: list[Expression], code: Code | None = None, mechanics: Mechanics | None = None
    ):
        self.graph = graph
        self.rates = rates
        self.code = code or Code()
        self._written: dict[tuple[int, int], Formula] = {}
        self.forms = Forms(graph, rates)
        self._numbers: dict[int, int] = {}
        self.needed = set(reachable(graph, [rate.index for rate in rates]))
        self._uses = Counter(operand for index in self.needed for operand in operands_of(graph, index))
        self.mechanics = None if mechanics is None else MechanicsWriter(self, mechanics)
        if self.mechanics is not None and not self.mechanics.usable:
            self.mechanics = None

    def operations(self) -> int:
        """How many there are in the series of all states up to a low order: it tells which of two texts is shorter."""
        for k in range(COUNTED + 1):
            for i in range(len(self.rates)):
                self.coefficient(self.graph.node("state", i).index, k)
        return self.code.operations

    def coefficient(self, index: int, k: int) -> Formula:
        """Name (or number) of the k-th coefficient of a node; its code is written if it is new."""
        if k > self.forms.degree(index):
            return ZERO
        key = (index, k)
        if key not in self._written:
            op, *operands = self.graph.nodes[index]
            if op == "constant":
                self._written[key] = literal(operands[0]) if operands[0] else ZERO
            else:
                self._written[key] = self.named("n", self._formula(index, op, operands, k), index, k)
        return self._written[key]

    def settled(self, state: int, k: int, value: Expression | None = None) -> Formula:
        """Coefficient k of a state, or of a value that moves one to one with it."""
        return self.coefficient((self.graph.node("state", state) if value is None else value).index, k)

    def named(self, kind: str, formula: Formula, index: int, k: int | None = None) -> Formula:
        """A formula that belongs to a node, and to an order, under a name."""
        return self.code.name(f"{kind}{self.number(index)}{'' if k is None else f'_{k}'}", formula)

    def number(self, index: int) -> int:
        """Number of a node in the text, which must not depend on what else was recorded in the graph."""
        return self._numbers.setdefault(index, len(self._numbers))

    def _scaled_exponential(self, factor: Expression, base: int) -> int | None:
        """The node factor * exp(...), whose series is written in place of that of exp(...) if none else needs that."""
        if self.graph.nodes[base][0] != "exp" or self._uses[base] > 1 or factor.value == 1.0:
            return None
        return (factor * Expression(self.graph, base)).index

    def _formula(self, index: int, op: str, operands: list, k: int) -> Formula:
        c = self.coefficient
        if op == "time":
            return Formula("time") if k == 0 else ONE
        if op == "side":
            return Formula(f"sliding_{operands[0]}")
        if op == "parameter":
            return self.code.entry(f"PARAMETER + {operands[0]} * LANES")
        if op == "state":
            return self._state(operands[0], k)
        if self.mechanics is not None and index in self.mechanics.formulas:
            return self.mechanics.formulas[index](k)
        if k > 0:
            factor, base = self.forms.linear(index)
            scaled = self._scaled_exponential(factor, base)
            if scaled == index:
                return self._slope_series(self.graph.nodes[base][1], index, k)
            if scaled is not None:
                return c(scaled, k)
            if base != index:
                return self._scaled(factor, c(base, k))
        if op in SUMS:
            return total(self.signed_terms(index, k))
        if op == "mul":
            shared = None if self.mechanics is None else self.mechanics.product(index, k)
            return self._product(operands[0], operands[1], k) if shared is None else shared
        if op == "div":
            return self._quotient(index, operands[0], operands[1], k)
        if op == "rate":
            value = c(operands[0], k + 1)
            return value if k == 0 else value * literal(k + 1.0)
        if op == "power":
            return self._power(index, operands[0], c(operands[1], 0), k)
        return self._function(index, op, operands[0], k)

    def signed_terms(self, index: int, k: int, inner: bool = False) -> list[Term]:
        """The k-th coefficient of a node as terms, its sums taken apart.

        inner: of a node within a sum, which is taken apart only if no other node uses it too
        """
        op, *operands = self.graph.nodes[index]
        known = self.mechanics is not None and index in self.mechanics.formulas
        shared = known or (inner and self._uses[index] > 1)
        factor, base = self.forms.linear(index) if k > 0 else (self.graph.constant(1.0), index)
        if base != index and not shared and self._scaled_exponential(factor, base) is None:
            return self._scaled_term(factor, self.coefficient(base, k))
        if op not in SUMS or shared or base != index:
            return [(1, self.coefficient(index, k))]
        return combined(op, [self.signed_terms(i, k, inner=True) for i in operands])

    def _scaled_term(self, factor: Expression, value: Formula) -> list[Term]:
        """A constant times a value, as a term."""
        if factor.value in (1.0, -1.0):
            return [(int(factor.value), value)]
        return [(1, value if value is ZERO else self.coefficient(factor.index, 0) * value)]

    def _scaled(self, factor: Expression, value: Formula) -> Formula:
        return total(self._scaled_term(factor, value))

    def _state(self, state: int, k: int) -> Formula:
        if k == 0:
            return self.code.entry(f"STATE + {state} * LANES")
        if k > 1 and self.mechanics is not None and self.mechanics.is_open(self.rates[state].index):
            return self.mechanics.state(self.rates[state].index, k)
        rate = self.coefficient(self.rates[state].index, k - 1)
        return rate if k == 1 else rate * literal(1.0 / k)

    def products(self, pairs: Iterable[tuple[tuple[int, int], tuple[int, int]]]) -> Formula:
        """Sum of products of coefficients, given as pairs of (node, order)."""
        ordered = sorted(pairs, key=lambda pair: max(pair[0][1], pair[1][1]))
        return total([(1, self.coefficient(*left) * self.coefficient(*right)) for left, right in ordered])

    def _product(self, a: int, b: int, k: int) -> Formula:
        if a != b or k == 0:
            return self.products(((a, i), (b, k - i)) for i in range(k + 1))
        newest = TWO * self.coefficient(a, 0) * self.coefficient(a, k)
        return total([*self._inner_square(a, k), (1, newest)])

    def _inner_square(self, a: int, k: int) -> list[Term]:
        """The coefficient k of a square but for what the newest one adds."""
        middle = self.products([((a, k // 2), (a, k // 2))]) if k % 2 == 0 else ZERO
        half = self.products(((a, i), (a, k - i)) for i in range(1, (k + 1) // 2))
        return [(1, middle), (1, TWO * half)]

    def _quotient(self, index: int, a: int, b: int, k: int) -> Formula:
        """Newest terms with factors of their own, so that little is left to do once they are known."""
        inverse = self.named("i", ONE / self.coefficient(b, 0), b)
        if k == 0:
            return self.coefficient(a, 0) * inverse
        factor, base = self.forms.linear(a)
        numerator, newest = self.coefficient(base, k), self.coefficient(b, k)
        terms = [(-1, self.products(((b, i), (index, k - i)) for i in range(1, k)) * inverse)]
        if numerator is not ZERO:
            terms.append((1, numerator * self.named("g", self._scaled(factor, inverse), index)))
        if newest is not ZERO:
            terms.append((-1, newest * self.named("f", self.coefficient(index, 0) * inverse, index)))
        return total(terms)

    def _power(self, index: int, a: int, exponent: Formula, k: int) -> Formula:
        """From p' a = exponent p a'. At a = 0 it has no series, and is kept for a step in which it is negligible."""
        first = self.coefficient(a, 0)
        if k == 0:
            size = Formula(f"max(abs({first.text}), {LEAST_BASE!r})", first.known)
            return self.code.function("exp", exponent * self.code.function("log", size))
        known = (self._weighted(index, k - j) * self.coefficient(a, j) for j in range(1, k))
        moving = f"where(abs({first.text}) > {zero_of_base(self.graph, a)!r}, {first.text}, math.inf)"
        inverse = self.named("b", ONE / Formula(moving, first.known), index)
        later = functools.reduce(operator.add, known, ZERO) * literal(1.0 / k)
        return (exponent * self._slope_series(a, index, k) - later) * inverse

    def _weighted(self, a: int, j: int) -> Formula:
        """j a_j, written once: the coefficient of the rate before, where a is a state or a multiple of one."""
        op, *operands = self.graph.nodes[a]
        if op == "state":
            return self.coefficient(self.rates[operands[0]].index, j - 1)
        factor, base = self.forms.linear(a)
        if base != a and self.graph.nodes[base][0] == "state":
            return self.named("w", self._scaled(factor, self._weighted(base, j)), a, j)
        value = self.coefficient(base, j)
        if value is ZERO or (base == a and j == 1):
            return value
        weight = literal(float(j))
        if base != a and factor.value is not None:
            weight = literal(j * factor.value)
        elif base != a:
            weight = start = self.coefficient(factor.index, 0)
            for i in range(2, j + 1):
                weight = self.named("m", weight + start, a, i)
        return self.named("w", weight * value, a, j)

    def _slope_series(self, a: int, f: int, k: int, sign: float = 1.0) -> Formula:
        """sign/k times the sum over j = 1..k of j a_j f_(k-j): the coefficient of an integral of f a'.

        The newest coefficient of a has a factor of its own, so that little is left to do once it is known.
        """
        scale = literal(sign / k)
        op, *operands = self.graph.nodes[a]
        if op == "state" and operands[0] not in self.slow:
            product = self.graph.known("mul", f, self.rates[operands[0]].index)
            if product is not None and self._is_early(product):  # of the momentum
                return self.coefficient(product, k - 1) * scale
        order = sorted(range(1, k), key=lambda j: max(j, k - j))
        weighted = [(j, self._weighted(a, j)) for j in order]
        sums = [(1, total((1, w * self.coefficient(f, k - j)) for j, w in weighted if w is not ZERO) * scale)]
        factor, base = self.forms.linear(a)
        newest = self.coefficient(base, k)
        if newest is not ZERO:
            start = self.coefficient(f, 0)
            if sign * (factor.value or 0.0) != 1.0:
                name = f"s{self.number(f)}_{self.number(a)}"
                start = self.code.name(name, self._scaled(sign * factor, start))
            sums.append((1, newest * start))
        return total(sums)

    def _is_early(self, product: int) -> bool:
        """Whether what is made of a rate needs no later coefficient than the state, and is written anyway."""
        return product in self.needed if self.mechanics is None else self.mechanics.level(product) == 1

    def _function(self, index: int, op: str, a: int, k: int) -> Formula:
        if k == 0:
            return self.code.function(op, self.coefficient(a, 0))
        value = Expression(self.graph, index)
        if op in ("sin", "cos") and self.forms.degree(a) == 1 and k > 1:  # of a phase: f'' = -(a')^2 f
            square = self.named("q", self.coefficient(a, 1) * self.coefficient(a, 1), a)
            part = self.named("q", square * literal(-1.0 / (k * (k - 1))), a, k)
            return part * self.coefficient(index, k - 2)
        if op == "exp":
            return self._slope_series(a, index, k)
        if op == "sin":
            return self._slope_series(a, self.graph.node("cos", a).index, k)
        if op == "cos":
            return self._slope_series(a, self.graph.node("sin", a).index, k, -1.0)
        if op == "tanh":  # t' = (1 - t^2) a'
            return self._slope_series(a, (1.0 - value * value).index, k)
        if op == "atan":  # a'/(1 + a^2)
            inner = Expression(self.graph, a)
            return self._slope_series(a, (1.0 / (1.0 + inner * inner)).index, k)
        newest, first = self.coefficient(a, k), self.coefficient(a, 0)
        if op == "log":
            known = (self._weighted(index, j) * self.coefficient(a, k - j) for j in range(1, k))
            inverse = self.named("i", ONE / first, a)
            return (newest - functools.reduce(operator.add, known, ZERO) * literal(1.0 / k)) * inverse
        if op == "sqrt":
            inverse = self.named("r", literal(0.5) / self.coefficient(index, 0), index)
            return total([(1, newest), *((-sign, term) for sign, term in self._inner_square(index, k))]) * inverse
        raise ValueError(f"no Taylor recurrence for {op}")


@functools.lru_cache(maxsize=32)
def shortest(equations: Equations) -> Mechanics | None:
    """The equations of motion as told with which the series take the fewest operations; None: the solved ones do."""
    recorded, told = (equations.graph, list(equations.rates)), equations.mechanics
    if told is None:
        return None
    whole = JetWriter(*recorded, mechanics=told).mechanics
    candidates = [None, *(() if whole is None else (told, whole.reduced()))]
    return min(candidates, key=lambda candidate: JetWriter(*recorded, mechanics=candidate).operations())
