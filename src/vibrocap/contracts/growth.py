"""How fast functions of a machine's time and state grow: by their partial derivatives, recorded once."""

from collections.abc import Callable
from typing import Any

from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate


def along(function: Callable, states: int) -> Callable[[float, tuple, Any], float]:
    """d/dt of a function of time and mechanical state, of (t, state, rates): by partial derivatives, recorded once."""
    graph = Graph()
    recorded = graph.expression(function(graph.node("time"), tuple(graph.node("state", i) for i in range(states))))
    partial = [derivative(recorded, i) for i in range(-1, states)]  # by the time first

    def growth(t: float, y: tuple, rates: Any) -> float:
        slopes = evaluate(partial, t, y, 1.0, ())
        return sum(slope * rate for slope, rate in zip(slopes, (1.0, *rates), strict=True))

    return growth


def explicit_rates(functions: Callable, t: float, y: tuple) -> list[float]:
    """Partial derivatives by the time of functions of time and state."""
    graph = Graph()
    recorded = map(graph.expression, functions(graph.node("time"), y))
    return list(map(float, evaluate([derivative(each, -1) for each in recorded], t, y, 1.0, ())))
