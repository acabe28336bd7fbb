"""The acceleration of the contact from the balance of momentum: few products where the solved equations have many.

Solved for the acceleration a of the contact, the equations of a machine are fractions of products of series. The same
acceleration follows from its momentum p, whose rate is the force from outside less friction,

    (p)_(k+1) (k+1) = F_k - R_k

where all of (p)_(k+1) is known but for a_k, which stands in it with one and the same factor d at every order: that of
the highest derivatives in the rate of p. So a_k = (F_k - R_k - what (p)_(k+1) (k+1) is without a_k)/d, one division per
step. Without R, that numerator is the series of the force that holds a resting contact.

A normal load that the motion makes follows likewise from the momentum q normal to the ground, N = mean + q'. Its
coefficient N_k contains a_k with a factor e, and so does R_k with r e, r the slope of R by N: the divisor is d + r e.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import Expression, Graph, derivative, evaluate, sensitivity

POINTS = 5  # at which the balance is compared with the equations


@dataclasses.dataclass(frozen=True, eq=False)
class NormalBalance:
    """load = mean + momentum', normal to the ground.

    moving, at_rest: the load as a function of the state, while the contact slides and where it rests
    """

    momentum: Expression
    mean: Expression
    moving: Expression
    at_rest: Expression


@dataclasses.dataclass(frozen=True, eq=False)
class Balance:
    """momentum' = outer - slipping friction, and the acceleration of the contact that follows from it.

    friction: while the contact slides; share: 1 where it slides, 0 where it sticks; middle: of the forces that the
    contact can hold at rest, None where it is a number; normal: of a load that the motion makes, or None
    """

    momentum: Expression
    outer: Expression
    friction: Expression
    share: Expression
    middle: Expression | None
    acceleration: Expression
    normal: NormalBalance | None = None

    def inertia(self, rates: Sequence[Expression]) -> Expression:
        """d + r e: see above."""
        result = self.slope(self.momentum, rates)
        if self.normal is not None:
            share = sensitivity(self.friction, self.normal.moving.index)
            result = result + share * self.slope(self.normal.momentum, rates)
        return result

    def slope(self, momentum: Expression, rates: Sequence[Expression]) -> Expression:
        """Slope of the rate of a momentum with respect to the acceleration."""
        result = self.acceleration.graph.constant(0.0)
        for i, rate in enumerate(rates):
            result = result + derivative(momentum, i) * sensitivity(rate, self.acceleration.index)
        return result

    def on(self, graph: Graph) -> "Balance":
        """The same on a graph that begins with the nodes of this one's."""

        def moved(balance: Any) -> Any:
            given = {field.name: getattr(balance, field.name) for field in dataclasses.fields(balance)}
            found = {
                name: Expression(graph, value.index) if isinstance(value, Expression) else value and moved(value)
                for name, value in given.items()
            }
            return dataclasses.replace(balance, **found)

        return moved(self)

    def holds(self, rates: Sequence[Expression], parameters: int) -> bool:
        """Whether the balance agrees with the equations, at a few points drawn at random, while the contact slides."""
        draw = np.random.default_rng(0)
        states, values = draw.uniform(0.1, 0.9, (len(rates), POINTS)), draw.uniform(0.5, 1.5, (parameters, POINTS))
        time = draw.uniform(0.1, 0.9, POINTS)
        pairs = [(rate_of(self.momentum, rates), self.outer - self.friction)]
        if self.normal is not None:
            pairs.append((self.normal.mean + rate_of(self.normal.momentum, rates), self.normal.moving))
        sides = [side for pair in pairs for side in pair]
        with np.errstate(all="ignore"):
            *values, inertia = evaluate([*sides, self.inertia(rates)], time, states, 1.0, values)
        close = all(
            np.all(np.abs(left - right) <= 1e-9 * (1.0 + np.abs(left) + np.abs(right)))
            for left, right in zip(values[::2], values[1::2], strict=True)
        )
        return bool(close and np.all(np.abs(inertia) > 0.0))


def rate_of(momentum: Expression, rates: Sequence[Expression]) -> Expression:
    """Rate of a function of time and state."""
    found = derivative(momentum, -1)
    for i, rate in enumerate(rates):
        found = found + derivative(momentum, i) * rate
    return found
