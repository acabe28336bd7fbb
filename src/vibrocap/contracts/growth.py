"""How fast functions of a machine's time and state grow, by their partial derivatives, and to what rounding."""

import sys
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate

EPSILON = sys.float_info.epsilon
SHARE = 1e-3  # of an argument, by which it is changed to see the terms inside a formula
OPERATIONS = 64  # roundings that may add up in one formula


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


def rounding(terms: Callable[..., Sequence[float]], *numbers: float) -> float:
    """What a sum of terms of some numbers may be off by in floating-point arithmetic.

    A term may itself be the difference of larger ones: how much it changes with each number, over the share by which
    that was changed, tells their size.
    """
    values = terms(*numbers)
    size = sum(map(abs, values))
    for i, number in enumerate(numbers):
        moved = terms(*numbers[:i], number * (1.0 + SHARE), *numbers[i + 1 :])
        size += sum(abs(b - a) for a, b in zip(values, moved, strict=True)) / SHARE
    return OPERATIONS * EPSILON * float(size)


def balance(growth: Callable, flows: Callable, machine: Any, *at: Any) -> tuple[float, float, float]:
    """(how fast what is stored grows, what flows in, by how much rounding lets them differ) at (t, y, drive, R)."""

    def grows(*now: Any) -> list[float]:
        return growth(*now[:2], machine.rates(*now))

    bound = rounding_of_machine(lambda *now: [*grows(*now), *flows(*now)], *at)
    return sum(grows(*at)), sum(flows(*at)), bound


def rounding_of_machine(terms: Callable, t: float, y: tuple, drive: float, frictions: tuple[float, ...]) -> float:
    """`rounding` of terms of (t, y, drive, R)."""
    end = 1 + len(y)
    return rounding(lambda *x: terms(x[0], x[1:end], x[end], x[end + 1 :]), t, *y, drive, *frictions)


def explicit_rates(functions: Callable, t: float, y: tuple) -> list[float]:
    """Partial derivatives by the time of functions of time and state."""
    graph = Graph()
    recorded = map(graph.expression, functions(graph.node("time"), y))
    return list(map(float, evaluate([derivative(each, -1) for each in recorded], t, y, 1.0, ())))
