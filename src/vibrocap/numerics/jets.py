"""Taylor coefficients of recorded equations, as straight-line source code.

For y' = f(t, y), the coefficients c_k of y(t + s) = sum c_k s^k follow from those of f by c_{k+1} = f_k/(k+1), and those of
f by one recurrence per operation (products are convolutions; Jorba and Zou 2005, table 1). The code is written out for
a fixed order, over `LANES` trajectories side by side: the loop over lanes is the only loop, so that compilers vectorise it.
"""

from vibrocap.numerics.graph import Expression, Graph

FREE = 10**9  # degree of a node that is no polynomial in time


class JetWriter:
    """Writes the coefficients of the nodes of one graph, each when first asked for."""

    def __init__(self, graph: Graph, rates: list[Expression]):
        self.graph = graph
        self.rates = rates
        self.lines: list[str] = []
        self._written: dict[tuple[int, int], str] = {}
        self._degrees: dict[int, int] = {}

    def degree(self, index: int) -> int:
        """Degree in time of a node if it is a polynomial for every motion, else FREE. Higher coefficients vanish."""
        if index not in self._degrees:
            op, *operands = self.graph.nodes[index]
            if op == "time":
                degree = 1
            elif self.graph.is_constant_in_time(index):
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
                formula = self._formula(index, op, operands, k)
                self._written[key] = f"n{index}_{k}"
                self.lines.append(f"n{index}_{k} = {formula}")
        return self._written[key]

    def _formula(self, index: int, op: str, operands: list, k: int) -> str:
        c = self.coefficient
        if op == "time":
            return "time" if k == 0 else "1.0"
        if op == "side":
            return "sliding"
        if op == "parameter":
            return f"real[PARAMETER + {operands[0]} * LANES + lane]"
        if op == "state":
            return self._state(operands[0], k)
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

    def _state(self, state: int, k: int) -> str:
        if k == 0:
            return f"real[STATE + {state} * LANES + lane]"
        rate = self.coefficient(self.rates[state].index, k - 1)
        return rate if k == 1 else f"{rate} * {1.0 / k!r}"

    def _terms(self, pairs) -> str:
        """Sum of products of coefficients: pairs of (node, order), those that vanish left out."""
        terms = []
        for (a, i), (b, j) in pairs:
            left, right = self.coefficient(a, i), self.coefficient(b, j)
            if left != "0.0" and right != "0.0":
                terms.append(f"{left} * {right}")
        return " + ".join(terms) if terms else "0.0"

    def _product(self, a: int, b: int, k: int) -> str:
        if a == b and self.degree(a) > 0:
            half = self._terms(((a, i), (a, k - i)) for i in range((k + 1) // 2))
            middle = self._terms([((a, k // 2), (a, k // 2))]) if k % 2 == 0 else "0.0"
            if half == "0.0":
                return middle
            return f"2.0 * ({half})" if middle == "0.0" else f"2.0 * ({half}) + {middle}"
        return self._terms(((a, i), (b, k - i)) for i in range(k + 1))

    def _quotient(self, index: int, a: int, b: int, k: int) -> str:
        inverse = f"i{b}"
        if (b, -1) not in self._written:
            divisor = self.coefficient(b, 0)
            self._written[(b, -1)] = inverse
            self.lines.append(f"{inverse} = 1.0 / {divisor}")
        earlier = self._terms(((b, i), (index, k - i)) for i in range(1, k + 1))
        numerator = self.coefficient(a, k)
        if earlier == "0.0":
            return f"{numerator} * {inverse}"
        return f"({numerator} - ({earlier})) * {inverse}"

    def _weighted(self, a: int, j: int) -> str:
        """j a_j, written once."""
        value = self.coefficient(a, j)
        if j == 1 or value == "0.0":
            return value
        key = (a, -1 - j)
        if key not in self._written:
            self._written[key] = f"w{a}_{j}"
            self.lines.append(f"w{a}_{j} = {float(j)!r} * {value}")
        return self._written[key]

    def _slope_terms(self, a: int, f: int, k: int) -> str:
        """sum over j = 1..k of j a_j f_(k-j): k times the coefficient of an integral of f a'."""
        terms = []
        for j in range(1, k + 1):
            left = self._weighted(a, j)
            if left != "0.0":
                terms.append(f"{left} * {self.coefficient(f, k - j)}")
        return " + ".join(terms) if terms else "0.0"

    def _function(self, index: int, op: str, a: int, k: int) -> str:
        if k == 0:
            return f"math.{op}({self.coefficient(a, 0)})"
        scale = repr(1.0 / k)
        if op == "exp":
            return f"({self._slope_terms(a, index, k)}) * {scale}"
        if op == "sin":
            return f"({self._slope_terms(a, self.graph.node('cos', a).index, k)}) * {scale}"
        if op == "cos":
            return f"-({self._slope_terms(a, self.graph.node('sin', a).index, k)}) * {scale}"
        if op == "log":
            earlier = [f"{self._weighted(index, j)} * {self.coefficient(a, k - j)}" for j in range(1, k)]
            earlier = [t for t in earlier if not t.endswith("* 0.0")]
            rest = f" - ({' + '.join(earlier)}) * {scale}" if earlier else ""
            return f"({self.coefficient(a, k)}{rest}) / {self.coefficient(a, 0)}"
        if op == "sqrt":
            earlier = self._terms(((index, i), (index, k - i)) for i in range(1, k))
            return f"0.5 * ({self.coefficient(a, k)} - ({earlier})) / {self.coefficient(index, 0)}"
        raise ValueError(f"no Taylor recurrence for {op}")
