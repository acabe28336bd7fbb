"""Taylor coefficients of recorded equations, as straight-line source code.

For y' = f(t, y), the coefficients c_k of y(t + s) = sum c_k s^k follow from those of f by c_{k+1} = f_k/(k+1), and
those of f by one recurrence per operation (products are convolutions; Jorba and Zou 2005, table 1). The code is written
out for a fixed order, for one lane, or for all at once: every name then stands for the numbers of all lanes, see
`plain_vectors.py`.
"""

from collections import Counter
from collections.abc import Iterable

from vibrocap.numerics.codegen.balance_series import BalanceWriter
from vibrocap.numerics.codegen.latency_order import LatencyOrder, Term, combined
from vibrocap.numerics.expressions.balance import Balance
from vibrocap.numerics.expressions.forms import Forms
from vibrocap.numerics.expressions.graph import Expression, Graph, operands_of, reachable

SUMS = ("add", "sub", "neg")
POLYNOMIALS = {  # of `elementary_polynomials.py`
    "exp": "exponential",
    "log": "logarithm",
    "sqrt": "square_root",
    "tanh": "hyperbolic_tangent",
    "atan": "arc_tangent",
}


class JetWriter:
    """Writes the coefficients of the nodes of one graph, each when first asked for.

    simd: for all lanes at once; polynomials: with the elementary functions of `elementary_polynomials.py`, not of
    the library
    """

    def __init__(
        self,
        graph: Graph,
        rates: list[Expression],
        simd: bool = False,
        balance: Balance | None = None,
        polynomials: bool = False,
    ):
        self.graph = graph
        self.rates = rates
        self.simd, self.polynomials = simd, polynomials
        self.lines: list[str] = []
        self._written: dict[tuple, str] = {}
        self.latency = LatencyOrder()
        self.forms = Forms(graph, rates)
        self._numbers: dict[int, int] = {}
        needed = reachable(graph, [rate.index for rate in rates])
        self._uses = Counter(operand for index in needed for operand in operands_of(graph, index))
        self.balance = None if balance is None else BalanceWriter(self, balance)
        if self.balance is not None and not self.balance.usable:
            self.balance = None

    def entry(self, place: str) -> str:
        """What stands at a place of the memory, for the lane or for all."""
        return f"load(floats, {place})" if self.simd else f"floats[{place} + lane]"

    def coefficient(self, index: int, k: int) -> str:
        """Name (or literal) of the k-th coefficient of a node; its code is written if it is new."""
        if k > self.forms.degree(index):
            return "0.0"
        key = (index, k)
        if key not in self._written:
            op, *operands = self.graph.nodes[index]
            if op == "constant":
                self._written[key] = repr(operands[0])
            else:
                self.named(key, f"n{self.number(index)}_{k}", self._formula(index, op, operands, k))
        return self._written[key]

    def named(self, key: tuple, name: str, formula: str) -> str:
        """The name under which a formula is kept; its line is written if it is new."""
        if key not in self._written:
            self._written[key] = name
            self.lines.append(f"{name} = {formula}")
            self.latency.write(name, formula)
        return self._written[key]

    def number(self, index: int) -> int:
        """Number of a node in the text, which must not depend on what else was recorded in the graph."""
        return self._numbers.setdefault(index, len(self._numbers))

    def _scaled_exponential(self, factor: Expression, base: int) -> int | None:
        """The node factor * exp(...), whose series is written in place of that of exp(...) if none else needs that."""
        if self.graph.nodes[base][0] != "exp" or self._uses[base] > 1 or factor.value == 1.0:
            return None
        return (factor * Expression(self.graph, base)).index

    def _formula(self, index: int, op: str, operands: list, k: int) -> str:
        c = self.coefficient
        if op == "time":
            return "time" if k == 0 else "1.0"
        if op == "side":
            return f"sliding_{operands[0]}" if operands else "sliding"
        if op == "parameter":
            return self.entry(f"PARAMETER + {operands[0]} * LANES")
        if op == "state":
            return self._state(operands[0], k)
        if self._under_its_load(index):
            assert self.balance is not None
            return self.balance.formula(index, op, operands, k) or "0.0"
        if k > 0:
            factor, base = self.forms.linear(index)
            scaled = self._scaled_exponential(factor, base)
            if scaled == index:
                return self._slope_series(self.graph.nodes[base][1], index, k)
            if scaled is not None:
                return c(scaled, k)
            if base != index:
                return self._scaled(factor, c(base, k))
        if self.balance is not None:
            balanced = self.balance.formula(index, op, operands, k)
            if balanced is not None:
                return balanced
        if op in SUMS:
            return self.latency.sum(self.signed_terms(index, k))
        if op == "mul":
            return self._product(operands[0], operands[1], k)
        if op == "div":
            return self._quotient(index, operands[0], operands[1], k)
        return self._function(index, op, operands[0], k)

    def signed_terms(self, index: int, k: int, inner: bool = False) -> list[Term]:
        """The k-th coefficient of a node as terms, its sums taken apart.

        inner: of a node within a sum, which is taken apart only if no other node uses it too
        """
        op, *operands = self.graph.nodes[index]
        shared = inner and (self._uses[index] > 1 or self._under_its_load(index))
        factor, base = self.forms.linear(index) if k > 0 else (self.graph.constant(1.0), index)
        if base != index and not shared and self._scaled_exponential(factor, base) is None:
            return self._scaled_term(factor, self.coefficient(base, k))
        if op not in SUMS or shared or base != index or self.is_acceleration(index):
            text = self.coefficient(index, k)
            return [] if text == "0.0" else [(1, text)]
        return combined(op, [self.signed_terms(i, k, inner=True) for i in operands])

    def _under_its_load(self, index: int) -> bool:
        """Whether a node is the acceleration under a load that it makes: what it is a multiple of contains it too."""
        return self.is_acceleration(index) and self.balance is not None and self.balance.balance.normal is not None

    def is_acceleration(self, index: int) -> bool:
        """Whether a node is the acceleration that the balance of momentum gives."""
        return self.balance is not None and index == self.balance.balance.acceleration.index

    def _scaled_term(self, factor: Expression, value: str) -> list[Term]:
        """A constant times a value, as a term; none where it vanishes."""
        if value == "0.0":
            return []
        if factor.value in (1.0, -1.0):
            return [(int(factor.value), value)]
        return [(1, f"{self.coefficient(factor.index, 0)} * {value}")]

    def _scaled(self, factor: Expression, value: str) -> str:
        return self.latency.sum(self._scaled_term(factor, value))

    def _state(self, state: int, k: int) -> str:
        if k == 0:
            return self.entry(f"STATE + {state} * LANES")
        if k > 1 and self.balance is not None and self.balance.is_open(self.rates[state].index):
            return self.balance.state(self.rates[state].index, k)
        rate = self.coefficient(self.rates[state].index, k - 1)
        return rate if k == 1 else f"{rate} * {1.0 / k!r}"

    def products(self, pairs: Iterable[tuple[tuple[int, int], tuple[int, int]]]) -> str:
        """Sum of products of coefficients, given as pairs of (node, order); empty if all of them vanish."""
        terms = []
        for (a, i), (b, j) in sorted(pairs, key=lambda pair: max(pair[0][1], pair[1][1])):
            left, right = self.coefficient(a, i), self.coefficient(b, j)
            if left != "0.0" and right != "0.0":
                terms.append((1, f"{left} * {right}"))
        return self.latency.sum(terms) if terms else ""

    def _product(self, a: int, b: int, k: int) -> str:
        if a != b or k == 0:
            return self.products(((a, i), (b, k - i)) for i in range(k + 1)) or "0.0"
        middle = self.products([((a, k // 2), (a, k // 2))]) if k % 2 == 0 else ""
        half = self.products(((a, i), (a, k - i)) for i in range(1, (k + 1) // 2))
        newest = self.products([((a, 0), (a, k))])
        terms = [middle, f"2.0 * ({half})" if half else "", f"2.0 * {newest}" if newest else ""]
        return self.latency.sum([(1, term) for term in terms if term])

    def _quotient(self, index: int, a: int, b: int, k: int) -> str:
        """Newest terms with factors of their own, so that little is left to do once they are known."""
        inverse = self.named(("inverse", b), f"i{self.number(b)}", f"1.0 / {self.coefficient(b, 0)}")
        if k == 0:
            numerator = self.coefficient(a, 0)
            return f"{numerator} * {inverse}" if numerator != "0.0" else "0.0"
        factor, base = self.forms.linear(a)
        numerator, newest, terms = self.coefficient(base, k), self.coefficient(b, k), []
        earlier = self.products(((b, i), (index, k - i)) for i in range(1, k))
        if earlier:
            terms.append((-1, f"({earlier}) * {inverse}"))
        if numerator != "0.0":
            scaled = self.named(("scaled", index), f"g{self.number(index)}", self._scaled(factor, inverse))
            terms.append((1, f"{numerator} * {scaled}"))
        if newest != "0.0":
            start = self.named(("over", index), f"f{self.number(index)}", f"{self.coefficient(index, 0)} * {inverse}")
            terms.append((-1, f"{newest} * {start}"))
        return self.latency.sum(terms)

    def _weighted(self, a: int, j: int) -> str:
        """j a_j, written once: the coefficient of the rate before, where a is a state or a multiple of one."""
        op, *operands = self.graph.nodes[a]
        if op == "state":
            return self.coefficient(self.rates[operands[0]].index, j - 1)
        factor, base = self.forms.linear(a)
        number = self.number(a)
        if base != a:
            if self.graph.nodes[base][0] == "state":
                scaled = self._scaled(factor, self._weighted(base, j))
                return scaled if scaled == "0.0" else self.named(("weighted", a, j), f"w{number}_{j}", scaled)
            value = self.coefficient(base, j)
            if value == "0.0":
                return value
            if factor.value is not None:
                return self.named(("weighted", a, j), f"w{number}_{j}", f"{j * factor.value!r} * {value}")
            weight = self.coefficient(factor.index, 0)
            for i in range(2, j + 1):
                weight = self.named(
                    ("weight", a, i), f"m{number}_{i}", f"{weight} + {self.coefficient(factor.index, 0)}"
                )
            return self.named(("weighted", a, j), f"w{number}_{j}", f"{weight} * {value}")
        value = self.coefficient(a, j)
        if j == 1 or value == "0.0":
            return value
        return self.named(("weighted", a, j), f"w{number}_{j}", f"{float(j)!r} * {value}")

    def _slope_series(self, a: int, f: int, k: int, sign: float = 1.0) -> str:
        """sign/k times the sum over j = 1..k of j a_j f_(k-j): the coefficient of an integral of f a'.

        The newest coefficient of a has a factor of its own, so that little is left to do once it is known.
        """
        scale = repr(sign / k)
        op, *operands = self.graph.nodes[a]
        if op == "state" and self.balance is not None:
            product = self.graph.known("mul", f, self.rates[operands[0]].index)
            if product is not None and self.balance.level(product) == 1:  # of the momentum: known already
                return f"{self.coefficient(product, k - 1)} * {scale}"
        terms = []
        for j in sorted(range(1, k), key=lambda j: max(j, k - j)):
            weighted = self._weighted(a, j)
            if weighted != "0.0":
                terms.append((1, f"{weighted} * {self.coefficient(f, k - j)}"))
        sums = [(1, f"({self.latency.sum(terms)}) * {scale}")] if terms else []
        factor, base = self.forms.linear(a)
        newest = self.coefficient(base, k)
        if newest != "0.0":
            start = self.coefficient(f, 0)
            if sign * (factor.value or 0.0) != 1.0:
                name = f"s{self.number(f)}_{self.number(a)}"
                start = self.named(("start", f, a), name, self._scaled(sign * factor, start))
            sums.append((1, f"{newest} * {start}"))
        return self.latency.sum(sums)

    def _start(self, op: str, a: int) -> str:
        """The value of a function, from which its series starts."""
        x = self.coefficient(a, 0)
        if not self.polynomials:
            return f"math.{op}({x})"
        if op in ("sin", "cos"):
            pair = self.named(("pair", a), f"p{self.number(a)}", f"sine_cosine({x})")
            return f"{pair}[{0 if op == 'sin' else 1}]"
        return f"{POLYNOMIALS[op]}({x})"

    def _function(self, index: int, op: str, a: int, k: int) -> str:
        if k == 0:
            return self._start(op, a)
        if op in ("sin", "cos") and self.forms.degree(a) == 1 and k > 1:  # of a phase: f'' = -(a')^2 f
            square = self.named(
                ("square", a), f"q{self.number(a)}", f"{self.coefficient(a, 1)} * {self.coefficient(a, 1)}"
            )
            part = self.named(("share", a, k), f"q{self.number(a)}_{k}", f"{square} * {-1.0 / (k * (k - 1))!r}")
            return f"{part} * {self.coefficient(index, k - 2)}"
        if op == "exp":
            return self._slope_series(a, index, k)
        if op == "sin":
            return self._slope_series(a, self.graph.node("cos", a).index, k)
        if op == "cos":
            return self._slope_series(a, self.graph.node("sin", a).index, k, -1.0)
        if op == "tanh":  # t' = (1 - t^2) a'
            value = Expression(self.graph, index)
            return self._slope_series(a, (1.0 - value * value).index, k)
        if op == "atan":  # a'/(1 + a^2)
            inner = Expression(self.graph, a)
            return self._slope_series(a, (1.0 / (1.0 + inner * inner)).index, k)
        value = self.coefficient(a, k)
        if op == "log":
            known = [(self._weighted(index, j), self.coefficient(a, k - j)) for j in range(1, k)]
            earlier = " + ".join(f"{left} * {right}" for left, right in known if "0.0" not in (left, right))
            rest = f" - ({earlier}) * {1.0 / k!r}" if earlier else ""
            return f"({value}{rest}) / {self.coefficient(a, 0)}"
        if op == "sqrt":
            earlier = self.products(((index, i), (index, k - i)) for i in range(1, k))
            return f"0.5 * ({value} - ({earlier or '0.0'})) / {self.coefficient(index, 0)}"
        raise ValueError(f"no Taylor recurrence for {op}")
