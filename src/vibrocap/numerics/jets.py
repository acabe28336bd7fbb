"""Taylor coefficients of recorded equations, as straight-line source code.

For y' = f(t, y), the coefficients c_k of y(t + s) = sum c_k s^k follow from those of f by c_{k+1} = f_k/(k+1), and
those of f by one recurrence per operation (products are convolutions; Jorba and Zou 2005, table 1). The code is written
out for a fixed order, for one lane, or abreast: every name then stands for the numbers of all lanes (`vectors.py`).
"""

from collections.abc import Iterable

from vibrocap.numerics.graph import Expression, Graph

FREE = 10**9  # degree of a node that is no polynomial in time
ABREAST = {  # functions of all lanes at once
    "exp": "exponential",
    "log": "logarithm",
    "sqrt": "square_root",
    "tanh": "hyperbolic_tangent",
    "atan": "arc_tangent",
}


class JetWriter:
    """Writes the coefficients of the nodes of one graph, each when first asked for."""

    def __init__(self, graph: Graph, rates: list[Expression], abreast: bool = False):
        self.graph = graph
        self.rates = rates
        self.abreast = abreast
        self.lines: list[str] = []
        self._written: dict[tuple[int, int], str] = {}
        self._degrees: dict[int, int] = {}

    def entry(self, place: str) -> str:
        """What stands at a place of the memory, for the lane or abreast."""
        return f"load(real, {place})" if self.abreast else f"real[{place} + lane]"

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

    def coefficient(self, index: int, k: int) -> str:
        """Name (or literal) of the k-th coefficient of a node; its code is written if it is new."""
        if k > self.degree(index):
            return "0.0"
        key = (index, k)
        if key not in self._written:
            op, *operands = self.graph.nodes[index]
            if op == "constant":
                self._written[key] = repr(operands[0])
            else:
                self._named(key, f"n{index}_{k}", self._formula(index, op, operands, k))
        return self._written[key]

    def _named(self, key: tuple[int, int], name: str, formula: str) -> str:
        """The name under which a formula is kept; its line is written if it is new."""
        if key not in self._written:
            self._written[key] = name
            self.lines.append(f"{name} = {formula}")
        return self._written[key]

    def _linear_form(self, index: int) -> tuple[Expression, int]:
        """(factor, base): but for constants the node is factor * base; its coefficients k >= 1 are factor * base_k."""
        op, *operands = self.graph.nodes[index]
        varying = [i for i in operands if self.degree(i) > 0] if op in ("add", "sub", "mul", "neg") else []
        if len(varying) != 1:
            return self.graph.constant(1.0), index
        factor, base = self._linear_form(varying[0])
        if op == "neg" or (op == "sub" and operands[1] == varying[0]):
            factor = -factor
        if op == "mul":
            other = operands[0] if operands[1] == varying[0] else operands[1]
            factor = Expression(self.graph, other) * factor
        return factor, base

    def _formula(self, index: int, op: str, operands: list, k: int) -> str:
        c = self.coefficient
        if op == "time":
            return "time" if k == 0 else "1.0"
        if op == "side":
            return "sliding"
        if op == "parameter":
            return self.entry(f"PARAMETER + {operands[0]} * LANES")
        if op == "state":
            return self._state(operands[0], k)
        if k > 0:
            factor, base = self._linear_form(index)
            if base != index:
                return self._scaled(factor, c(base, k))
        if op in ("add", "sub"):
            left, right = c(operands[0], k), c(operands[1], k)
            if right == "0.0":
                return left
            if left == "0.0":
                return right if op == "add" else f"-{right}"
            return f"{left} {'+' if op == 'add' else '-'} {right}"
        if op == "neg":
            return f"-{c(operands[0], k)}"
        if op == "mul":
            return self._product(operands[0], operands[1], k)
        if op == "div":
            return self._quotient(index, operands[0], operands[1], k)
        return self._function(index, op, operands[0], k)

    def _scaled(self, factor: Expression, value: str) -> str:
        if value == "0.0" or factor.value == 1.0:
            return value
        return f"-{value}" if factor.value == -1.0 else f"{self.coefficient(factor.index, 0)} * {value}"

    def _state(self, state: int, k: int) -> str:
        if k == 0:
            return self.entry(f"STATE + {state} * LANES")
        rate = self.coefficient(self.rates[state].index, k - 1)
        return rate if k == 1 else f"{rate} * {1.0 / k!r}"

    def _terms(self, pairs: Iterable[tuple[tuple[int, int], tuple[int, int]]]) -> list[str]:
        """Products of coefficients, given as pairs of (node, order), those that vanish left out.

        The coefficients known longest come first, so that most of a sum is done before the newest arrive: additions are
        not reassociated, and their latency is what the series of a single motion costs.
        """
        terms = []
        for (a, i), (b, j) in sorted(pairs, key=lambda pair: max(pair[0][1], pair[1][1])):
            left, right = self.coefficient(a, i), self.coefficient(b, j)
            if left != "0.0" and right != "0.0":
                terms.append(f"{left} * {right}")
        return terms

    def _product(self, a: int, b: int, k: int) -> str:
        if a != b or k == 0:
            return " + ".join(self._terms(((a, i), (b, k - i)) for i in range(k + 1))) or "0.0"
        middle = self._terms([((a, k // 2), (a, k // 2))]) if k % 2 == 0 else []
        half = self._terms(((a, i), (a, k - i)) for i in range(1, (k + 1) // 2))
        doubled = [f"2.0 * ({' + '.join(half)})"] if half else []
        newest = self._terms([((a, 0), (a, k))])
        return " + ".join([*doubled, *middle, *(f"2.0 * {term}" for term in newest)]) or "0.0"

    def _quotient(self, index: int, a: int, b: int, k: int) -> str:
        inverse = self._named((b, -1), f"i{b}", f"1.0 / {self.coefficient(b, 0)}")
        earlier = " + ".join(self._terms(((b, i), (index, k - i)) for i in range(1, k + 1)))
        factor, base = self._linear_form(a) if k > 0 else (self.graph.constant(1.0), a)
        numerator = self.coefficient(base, k)
        if factor.value != 1.0:
            scaled = f"{self.coefficient(factor.index, 0)} * {inverse}"
            inverse_of_base = self._named((index, -1), f"f{index}", scaled)
        else:
            inverse_of_base = inverse
        if self.abreast and earlier and numerator != "0.0":  # the fewest operations; one motion waits for the newest
            scaled = numerator if factor.value == 1.0 else f"{self.coefficient(factor.index, 0)} * {numerator}"
            return f"({scaled} - ({earlier})) * {inverse}"
        if not earlier:
            return f"{numerator} * {inverse_of_base}" if numerator != "0.0" else "0.0"
        if numerator == "0.0":
            return f"-({earlier}) * {inverse}"
        return f"{numerator} * {inverse_of_base} - ({earlier}) * {inverse}"

    def _weighted(self, a: int, j: int) -> str:
        """j a_j, written once: the coefficient of the rate before, where a is a state or a multiple of one."""
        op, *operands = self.graph.nodes[a]
        if op == "state":
            return self.coefficient(self.rates[operands[0]].index, j - 1)
        factor, base = self._linear_form(a)
        if base != a:
            value = self._weighted(base, j)
            return value if value == "0.0" else self._named((a, -1 - j), f"w{a}_{j}", self._scaled(factor, value))
        value = self.coefficient(a, j)
        if j == 1 or value == "0.0":
            return value
        return self._named((a, -1 - j), f"w{a}_{j}", f"{float(j)!r} * {value}")

    def _slope_series(self, a: int, f: int, k: int) -> str:
        """1/k times the sum over j = 1..k of j a_j f_(k-j): the coefficient of an integral of f a'."""
        scale = repr(1.0 / k)
        terms = []
        for j in sorted(range(1, k), key=lambda j: max(j, k - j)):
            weighted = self._weighted(a, j)
            if weighted != "0.0":
                terms.append(f"{weighted} * {self.coefficient(f, k - j)}")
        newest = self._weighted(a, k)
        if self.abreast:  # the fewest operations; for one motion the newest term should come last
            if newest != "0.0":
                terms.append(f"{newest} * {self.coefficient(f, 0)}")
            return f"({' + '.join(terms)}) * {scale}" if terms else "0.0"
        sums = [f"({' + '.join(terms)}) * {scale}"] if terms else []
        if newest != "0.0":
            start = self.coefficient(f, 0)
            sums.append(f"{newest} * {self._named((f, -100 - k), f's{f}_{k}', f'{start} * {scale}')}")
        return " + ".join(sums) or "0.0"

    def _start(self, op: str, a: int) -> str:
        """The value of a function, from which its series starts."""
        x = self.coefficient(a, 0)
        if not self.abreast:
            return f"math.{op}({x})"
        if op in ("sin", "cos"):
            pair = self._named((a, -1000), f"p{a}", f"sine_cosine({x})")
            return f"{pair}[{0 if op == 'sin' else 1}]"
        return f"{ABREAST[op]}({x})"

    def _function(self, index: int, op: str, a: int, k: int) -> str:
        if k == 0:
            return self._start(op, a)
        if op == "exp":
            return self._slope_series(a, index, k)
        if op == "sin":
            return self._slope_series(a, self.graph.node("cos", a).index, k)
        if op == "cos":
            return f"-({self._slope_series(a, self.graph.node('sin', a).index, k)})"
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
            earlier = " + ".join(self._terms(((index, i), (index, k - i)) for i in range(1, k)))
            return f"0.5 * ({value} - ({earlier or '0.0'})) / {self.coefficient(index, 0)}"
        raise ValueError(f"no Taylor recurrence for {op}")
