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

import numpy as np

from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate, sensitivity

POINTS = 5  # at which the balance is compared with the equations


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
        result = self.acceleration.graph.constant(0.0)
        memory: dict = {}
        for i, rate in enumerate(rates):
            slope = sensitivity(rate, self.acceleration.index, memory)
            result = result + derivative(self.momentum, i) * slope
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
