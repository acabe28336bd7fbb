"""How fast a function of a machine's time and state grows, by its partial derivatives."""

from collections.abc import Callable
from typing import Any

from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate


def growth_terms(function: Callable, states: int) -> Callable[[float, tuple, Any], list[float]]:
    """The terms of d/dt of a function of time and mechanical state, of (t, state, rates), recorded once.

    The first is the partial derivative by the time, the others those by the states times their rates.
    """
    graph = Graph()
    recorded = graph.expression(function(graph.node("time"), tuple(graph.node("state", i) for i in range(states))))
    partial = [derivative(recorded, i) for i in range(-1, states)]

    def terms(t: float, y: tuple, rates: Any) -> list[float]:
        slopes = evaluate(partial, t, y, 1.0, ())
        return [slope * rate for slope, rate in zip(slopes, (1.0, *rates), strict=True)]

    return terms
