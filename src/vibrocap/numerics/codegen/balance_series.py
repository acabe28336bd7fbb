"""Writes the series of the contact's acceleration from the balance of momentum, see `Balance`.

It leaves few products where the solved equations have many.
"""

from typing import Any

from vibrocap.numerics.codegen.straight_line import ZERO, Formula, Term, combined, literal, total
from vibrocap.numerics.expressions.equations import Balance
from vibrocap.numerics.expressions.graph import Expression, sensitivity


class BalanceWriter:
    """Writes the coefficients of the acceleration, on behalf of a `jets.JetWriter`.

    A node has the level 0 if its coefficient k contains a_k, 1 if its coefficient k + 1 is the first that does.
    """

    def __init__(self, writer: Any, balance: Balance):
        self.writer, self.balance = writer, balance
        self._levels: dict[int, int | None] = {}
        self._simples: dict[int, bool] = {}
        normal = balance.normal
        self.loads = (-1, -1) if normal is None else (normal.moving.index, normal.at_rest.index)

    def level(self, index: int) -> int | None:
        """0, 1 or None: see above."""
        if index not in self._levels:
            op, *operands = self.writer.graph.nodes[index]
            self._levels[index] = None  # of a state that is met on the way to itself
            if index in (self.balance.acceleration.index, self.loads[0]):
                level = 0
            elif op == "state":
                level = 1 if self.level(self.writer.rates[operands[0]].index) == 0 else None
            elif op in ("constant", "time", "side", "parameter"):
                level = None
            else:
                levels = [self.level(i) for i in operands]
                level = min((found for found in levels if found is not None), default=None)
            self._levels[index] = level
        return self._levels[index]

    @property
    def usable(self) -> bool:
        """Whether momentum is made of states whose rates contain the acceleration by sums and products only."""
        momenta = [self.balance.momentum]
        if self.balance.normal is not None:
            momenta.append(self.balance.normal.momentum)
            if not self.is_open(self.balance.friction.index):
                return False
        return all(self.level(momentum.index) == 1 and self._simple(momentum.index) for momentum in momenta)

    def _simple(self, index: int) -> bool:
        """Whether a node contains the acceleration, if at all, by sums and products only."""
        if index not in self._simples:
            self._simples[index] = True  # of a state that is met on the way to itself
            self._simples[index] = self._made_simply(index)
        return self._simples[index]

    def _made_simply(self, index: int) -> bool:
        op, *operands = self.writer.graph.nodes[index]
        if self.level(index) is None or index in (self.balance.acceleration.index, self.loads[0]):
            return True
        if op == "state":
            return self._simple(self.writer.rates[operands[0]].index)
        if op == "mul":
            a, b = (self.level(i) for i in operands)
            if a is not None and b is not None:  # of the levels 0 and 1: the other factor is known before a_k
                return a + b == 1 and self._simple(operands[0 if a == 0 else 1])
        return op in ("add", "sub", "neg", "mul") and all(self._simple(i) for i in operands)

    def formula(self, index: int, op: str, operands: list, k: int) -> Formula | None:
        """The coefficient k of a node, where it is written in another way than elsewhere."""
        if index == self.balance.acceleration.index:
            return self.acceleration(k)
        if index in self.loads:
            return self._load(index, k)
        if op == "mul" and self.level(index) is not None and operands[0] != operands[1]:
            fixed, open_ = self._sides(index)
            if fixed is None:
                return None
            return self._settled(index, k) + self.writer.products([((fixed, 0), (open_, k))])
        return None

    def is_open(self, index: int) -> bool:
        """Whether coefficient k of a node is c + d a_k, with one and the same d at every order."""
        return self.level(index) == 0 and self._simple(index)

    def _slope(self, index: int) -> Formula:
        """The factor d of the acceleration in an open node."""
        graph, acceleration = self.writer.graph, self.balance.acceleration
        slope = sensitivity(Expression(graph, index), acceleration.index)
        return self.writer.coefficient(slope.index, 0)

    def _sides(self, index: int) -> tuple[int | None, int]:
        """The factor of a product that is known first, and the one that contains the acceleration."""
        _, a, b = self.writer.graph.nodes[index]
        level = self.level(index)
        if self.level(a) == level:
            return (None, a) if self.level(b) == level else (b, a)
        return a, b

    def _settled(self, index: int, k: int) -> Formula:
        """What coefficient k of a product is but for the newest one of the factor that contains the acceleration."""
        fixed, open_ = self._sides(index)
        assert fixed is not None
        known = self.writer.products(((fixed, i), (open_, k - i)) for i in range(1, k + 1))
        return self.writer.named("o", known, index, k)

    def without(self, index: int, k: int) -> list[Term]:
        """The coefficient k of a node of level 0, but for what a_k adds."""
        if self.level(index) is None or self.level(index) == 1:
            return self.writer.signed_terms(index, k, inner=True)
        op, *operands = self.writer.graph.nodes[index]
        if index == self.balance.acceleration.index:
            return []
        if index == self.loads[0]:
            return [(1, self.writer.coefficient(self.loads[1], k))]
        if op == "mul":
            fixed, open_ = self._sides(index)
            assert fixed is not None
            return [(1, self._settled(index, k)), *self._times(fixed, self.without(open_, k))]
        return combined(op, [self.without(i, k) for i in operands])

    def rate_without(self, index: int, k: int) -> list[Term]:
        """k times the coefficient k of a node of level 1, but for what a_(k-1) adds."""
        op, *operands = self.writer.graph.nodes[index]
        if self.level(index) is None:
            return [(1, _multiple(k, self.writer.coefficient(index, k)))]
        if op == "state":
            return self._rate(self.writer.rates[operands[0]].index, k - 1)
        if op == "mul":
            fixed, open_ = self._sides(index)
            assert fixed is not None
            return [(1, _multiple(k, self._settled(index, k))), *self._times(fixed, self.rate_without(open_, k))]
        return combined(op, [self.rate_without(i, k) for i in operands])

    def _times(self, factor: int, terms: list[Term]) -> list[Term]:
        """Terms times the first coefficient of a factor: each, or their sum where some are products already."""
        start, terms = self.writer.coefficient(factor, 0), [term for term in terms if term[1] is not ZERO]
        if all(size.is_name for _, size in terms):
            return [(sign, start * size) for sign, size in terms]
        return [(1, start * total(terms))]

    def _holding(self, k: int) -> list[Term]:
        outer = self.writer.signed_terms(self.balance.outer.index, k, inner=True)
        return combined("sub", [outer, self.rate_without(self.balance.momentum.index, k + 1)])

    def holding(self, k: int) -> Formula:
        """Coefficient k of the force that would hold the contact, if it rests."""
        return self.writer.code.name(f"hold_{k}", total(self._holding(k)))

    def hold(self, k: int) -> Formula:
        """The same over the middle of what the contact can hold, which moves with the load."""
        middle = self.balance.middle
        return self.holding(k) - (ZERO if middle is None else self.writer.coefficient(middle.index, k))

    def _load(self, index: int, k: int) -> Formula:
        """Coefficient k of the normal load while the contact slides, or but for what a_k adds."""
        writer, normal = self.writer, self.balance.normal
        assert normal is not None
        if index == self.loads[1]:
            mean = [(1, writer.coefficient(normal.mean.index, 0))] if k == 0 else []
            return total([*mean, *self.rate_without(normal.momentum.index, k + 1)])
        slope = writer.coefficient(self.balance.slope(normal.momentum, writer.rates).index, 0)
        return writer.coefficient(self.loads[1], k) + slope * writer.coefficient(self.balance.acceleration.index, k)

    def acceleration(self, k: int) -> Formula:
        """a_k."""
        return self._force(k) * self._mobility()

    def _force(self, k: int) -> Formula:
        """What a_k is but for one over the inertia."""
        writer = self.writer
        # Where the contact cannot rest the force that holds is not asked for itself.
        held = self._holding(k) if self.balance.share.value == 1.0 else [(1, self.holding(k))]
        friction = self.balance.friction.index
        friction = writer.signed_terms(friction, k) if self.level(friction) is None else self.without(friction, k)
        return writer.code.name(f"force_{k}", total(combined("sub", [held, friction])))

    def _mobility(self, k: int = 1) -> Formula:
        """One over k times the inertia."""
        writer = self.writer
        if k > 1:
            return writer.code.name(f"mobility_{k}", self._mobility() * literal(1.0 / k))
        inertia = writer.coefficient(self.balance.inertia(writer.rates).index, 0)
        share = writer.coefficient(self.balance.share.index, 0)
        return writer.code.name("mobility", share / inertia)

    def state(self, rate: int, k: int) -> Formula:
        """Coefficient k of a state whose rate is an open node, without waiting for a_(k-1) itself."""
        terms = [(sign, size * literal(1.0 / k)) for sign, size in self._rate(rate, k - 1)]
        force, slope, factor = self._force(k - 1), self._slope(rate), self._mobility(k)
        if slope.number != 1.0:
            factor = self.writer.named("mobility_", factor * slope, rate, k)
        return total([*terms, (1, force * factor)])

    def _rate(self, index: int, k: int) -> list[Term]:
        """`without` of a rate, as one name if it has several terms, as state and momentum both need it."""
        terms = [term for term in self.without(index, k) if term[1] is not ZERO]
        return terms if len(terms) < 2 else [(1, self.writer.named("e", total(terms), index, k))]


def _multiple(k: int, value: Formula) -> Formula:
    return value if k == 1 else literal(float(k)) * value
