"""The acceleration of the contact from the balance of momentum: few products where the solved equations have many.

Solved for the acceleration a of the contact, the equations of a machine are fractions of products of series. The same
acceleration follows from its momentum p, whose rate is the force from outside less friction,

    (p)_(k+1) (k+1) = F_k - R_k

where all of (p)_(k+1) is known but for a_k, which stands in it with one and the same factor d at every order: that of
the highest derivatives in the rate of p. So a_k = (F_k - R_k - what (p)_(k+1) (k+1) is without a_k)/d, one division per
step. Without R, that numerator is the series of the force that holds a resting contact.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.graph import Expression, derivative, evaluate

POINTS = 5  # at which the balance is compared with the equations
ACCELERATION = -2  # in place of the number of a state: the slope with respect to the acceleration


@dataclasses.dataclass(frozen=True, eq=False)
class Balance:
    """momentum' = outer - slipping friction, and the acceleration of the contact that follows from it.

    friction: while the contact slides; share: 1 where it slides, 0 where it sticks
    """

    momentum: Expression
    outer: Expression
    friction: Expression
    share: Expression
    acceleration: Expression

    def inertia(self, rates: Sequence[Expression]) -> Expression:
        """d, the slope of the rate of momentum with respect to the acceleration."""
        memory = {(self.acceleration.index, ACCELERATION): self.acceleration.graph.constant(1.0)}
        result = self.acceleration.graph.constant(0.0)
        for i, rate in enumerate(rates):
            result = result + derivative(self.momentum, i) * derivative(rate, ACCELERATION, memory)
        return result

    def holds(self, rates: Sequence[Expression], parameters: int) -> bool:
        """Whether the balance agrees with the equations, at a few points drawn at random, while the contact slides."""
        draw = np.random.default_rng(0)
        states, values = draw.uniform(0.1, 0.9, (len(rates), POINTS)), draw.uniform(0.5, 1.5, (parameters, POINTS))
        time = draw.uniform(0.1, 0.9, POINTS)
        found = derivative(self.momentum, -1)
        for i, rate in enumerate(rates):
            found = found + derivative(self.momentum, i) * rate
        wanted = self.outer - self.friction
        with np.errstate(all="ignore"):
            left, right, inertia = evaluate([found, wanted, self.inertia(rates)], time, states, 1.0, values)
        close = np.abs(left - right) <= 1e-9 * (1.0 + np.abs(left) + np.abs(right))
        return bool(np.all(close) and np.all(np.abs(inertia) > 0.0))


class BalanceWriter:
    """Writes the coefficients of the acceleration, on behalf of a `jets.JetWriter`.

    A node has the level 0 if its coefficient k contains a_k, 1 if its coefficient k + 1 is the first that does.
    """

    def __init__(self, writer: Any, balance: Balance):
        self.writer, self.balance = writer, balance
        self._levels: dict[int, int | None] = {}

    def level(self, index: int) -> int | None:
        """0, 1 or None: see above."""
        if index not in self._levels:
            op, *operands = self.writer.graph.nodes[index]
            self._levels[index] = None  # of a state that is met on the way to itself
            if index == self.balance.acceleration.index:
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
        return self.level(self.balance.momentum.index) == 1 and self._simple(self.balance.momentum.index)

    def _simple(self, index: int) -> bool:
        op, *operands = self.writer.graph.nodes[index]
        if self.level(index) is None or index == self.balance.acceleration.index:
            return True
        if op == "state":
            return self._simple(self.writer.rates[operands[0]].index)
        if op == "mul" and self.level(operands[0]) is not None and self.level(operands[1]) is not None:
            return False
        return op in ("add", "sub", "neg", "mul") and all(self._simple(i) for i in operands)

    def formula(self, index: int, op: str, operands: list, k: int) -> str | None:
        """The coefficient k of a node, where it is written in another way than elsewhere."""
        if index == self.balance.acceleration.index:
            return self.acceleration(k)
        if op == "mul" and self.level(index) is not None and operands[0] != operands[1]:
            fixed, open_ = self._sides(index)
            if fixed is None:
                return None
            newest = " + ".join(self.writer.terms([((fixed, 0), (open_, k))]))
            return " + ".join(filter(None, (self._settled(index, k), newest))) or "0.0"
        return None

    def _sides(self, index: int) -> tuple[int | None, int]:
        """The factor of a product that is known first, and the one that contains the acceleration."""
        _, a, b = self.writer.graph.nodes[index]
        level = self.level(index)
        if self.level(a) == level:
            return (None, a) if self.level(b) == level else (b, a)
        return a, b

    def _settled(self, index: int, k: int) -> str:
        """What coefficient k of a product is but for the newest one of the factor that contains the acceleration."""
        fixed, open_ = self._sides(index)
        assert fixed is not None
        terms = self.writer.terms(((fixed, i), (open_, k - i)) for i in range(1, k + 1))
        name = f"o{self.writer.number(index)}_{k}"
        return self.writer.named(("settled", index, k), name, " + ".join(terms)) if terms else ""

    def without(self, index: int, k: int) -> str:
        """The coefficient k of a node of level 0, but for what a_k adds."""
        if self.level(index) is None or self.level(index) == 1:
            return self.writer.coefficient(index, k)
        op, *operands = self.writer.graph.nodes[index]
        if index == self.balance.acceleration.index:
            return "0.0"
        if op == "mul":
            fixed, open_ = self._sides(index)
            assert fixed is not None
            return self._sum(self._settled(index, k), self._times(fixed, self.without(open_, k)))
        return self._combined(op, [self.without(i, k) for i in operands])

    def rate_without(self, index: int, k: int) -> str:
        """k times the coefficient k of a node of level 1, but for what a_(k-1) adds."""
        op, *operands = self.writer.graph.nodes[index]
        if self.level(index) is None:
            value = self.writer.coefficient(index, k)
            return value if value == "0.0" or k == 1 else f"{float(k)!r} * {value}"
        if op == "state":
            return self.without(self.writer.rates[operands[0]].index, k - 1)
        if op == "mul":
            fixed, open_ = self._sides(index)
            assert fixed is not None
            settled = self._settled(index, k)
            if settled and k > 1:
                settled = f"{float(k)!r} * {settled}"
            return self._sum(settled, self._times(fixed, self.rate_without(open_, k)))
        return self._combined(op, [self.rate_without(i, k) for i in operands])

    def _times(self, factor: int, value: str) -> str:
        return "" if value == "0.0" else f"{self.writer.coefficient(factor, 0)} * {self._enclosed(value)}"

    def _enclosed(self, value: str) -> str:
        return value if value.isidentifier() else f"({value})"

    def _sum(self, left: str, right: str) -> str:
        return " + ".join(filter(None, (left, right))) or "0.0"

    def _combined(self, op: str, values: list[str]) -> str:
        if op == "neg":
            return "0.0" if values[0] == "0.0" else f"-{self._enclosed(values[0])}"
        left, right = values
        if right == "0.0":
            return left
        if left == "0.0":
            return right if op == "add" else f"-{self._enclosed(right)}"
        return f"{left} {'+' if op == 'add' else '-'} {self._enclosed(right)}"

    def holding(self, k: int) -> str:
        """Coefficient k of the force that would hold the contact, if it rests."""
        outer = self.writer.coefficient(self.balance.outer.index, k)
        rate = self.rate_without(self.balance.momentum.index, k + 1)
        value = self._combined("sub", [outer, rate])
        return value if value == "0.0" else self.writer.named(("hold", k), f"hold_{k}", value)

    def acceleration(self, k: int) -> str:
        """a_k."""
        writer = self.writer
        inertia = writer.coefficient(self.balance.inertia(writer.rates).index, 0)
        share = writer.coefficient(self.balance.share.index, 0)
        factor = writer.named(("mobility",), "mobility", f"{share} / {inertia}")
        friction = writer.coefficient(self.balance.friction.index, k)
        force = self._combined("sub", [self.holding(k), friction])
        return "0.0" if force == "0.0" else f"{self._enclosed(force)} * {factor}"
