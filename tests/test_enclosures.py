"""Enclosures of recorded expressions: whatever values the leaves take, the value lies within."""

import math

import numpy as np
import pytest

from vibrocap.numerics.codegen.enclosures import Enclosures, Lines
from vibrocap.numerics.expressions.graph import Graph, evaluate
from vibrocap.numerics.kernel.arithmetic import elementary_polynomials, one_number

OPERATIONS = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "negative": lambda a, b: -(a * b),
    "product": lambda a, b: a * b,
    "square": lambda a, b: (a - b) * (a - b),
    "quotient": lambda a, b: a / (2.5 + b),
    "exp": lambda a, b: (a * b - a).exp(),
    "log": lambda a, b: (a * a + 0.01).log() * b,
    "sqrt": lambda a, b: (b * b + a * a).sqrt(),
    "tanh": lambda a, b: (3.0 * a - b).tanh(),
    "atan": lambda a, b: (a - 2.0 * b).atan(),
    "sin": lambda a, b: (5.0 * a).sin() * b,
    "cos": lambda a, b: a - (4.0 * b).cos(),
}
SIDE = 0.7  # any number will do


def enclosed(expression, low: np.ndarray, high: np.ndarray) -> tuple[float, float]:
    """Least and largest value of an expression of two states, by the code that is written for one lane."""
    graph, text = expression.graph, Lines(polynomials=True)

    def leaf(index: int):
        op, *operands = graph.nodes[index]
        return (repr(low[operands[0]]), repr(high[operands[0]])) if op == "state" else None

    least, most = Enclosures(graph, text, leaf).of(expression.index)
    names = {**vars(elementary_polynomials), **vars(one_number), "math": math}
    source = "\n".join(["def run(side):", *(f"    {line}" for line in text.lines), f"    return {least}, {most}"])
    with pytest.MonkeyPatch.context() as patch:
        for name in ("where", "floor", "exponent", "mantissa", "power_of_two"):  # of one number, not of all lanes
            patch.setattr(elementary_polynomials, name, getattr(one_number, name))
        exec(compile(source, "<enclosure>", "exec"), names)
        return names["run"](SIDE)


@pytest.mark.parametrize("operation", OPERATIONS)
def test_values_lie_within(operation):
    """And the enclosure is not idle: it is less than ten times as wide as the values that are found."""
    draw = np.random.default_rng(1)
    widths = []
    for _ in range(60):
        graph = Graph()
        a, b = graph.node("state", 0), graph.node("state", 1)
        expression = OPERATIONS[operation](a, b)
        middle, half = draw.uniform(-1.0, 1.0, 2), 10.0 ** draw.uniform(-4.0, 0.0, 2)
        low, high = (middle - half).tolist(), (middle + half).tolist()
        points = draw.uniform(np.array(low)[:, None], np.array(high)[:, None], (2, 400))
        points[:, :4] = [[low[0], low[0], high[0], high[0]], [low[1], high[1], low[1], high[1]]]
        (values,) = evaluate([expression], 0.0, points, SIDE, [])
        least, most = enclosed(expression, low, high)
        slack = 1e-12 * (1.0 + abs(least) + abs(most))
        assert least - slack <= values.min()
        assert values.max() <= most + slack
        widths.append((most - least) / (values.max() - values.min()))
    assert np.median(widths) < 10.0


def test_an_inverse_of_what_may_vanish_is_anything():
    graph = Graph()
    a, b = graph.node("state", 0), graph.node("state", 1)
    least, most = enclosed(1.0 / (a - b), [0.0, 0.5], [1.0, 0.6])
    assert least <= -1e300
    assert most >= 1e300


def test_the_enclosure_of_a_number_is_that_number():
    graph = Graph()
    a = graph.node("state", 0)
    assert enclosed(graph.constant(2.0) * (a - a + 3.0), [0.0, 0.0], [1.0, 1.0]) == (6.0, 6.0)


def test_sine_and_cosine_of_a_parameter_are_single_values():
    graph = Graph()
    parameter = graph.node("parameter", 0)
    for function, place in ((parameter.sin(), 0), (parameter.cos(), 1)):
        text = Lines(polynomials=True)
        least, most = Enclosures(graph, text, lambda index: None).of(function.index)
        assert least == most
        assert text.lines[-1] == f"{least} = e1[{place}]"


def test_a_determinant_of_turning_bodies_stays_apart_over_a_short_step():
    """Of two pendulums in a row it holds squares of cosines that cancel where each is known no better than to 1."""
    graph = Graph()
    a, b = graph.node("state", 0), graph.node("state", 1)
    inverse = 1.0 / (1.1 - (a - b).cos() * (a - b).cos() - 0.5 * a.sin() * a.sin())
    least, most = enclosed(inverse, [0.4 - 1e-6, 1.1 - 1e-6], [0.4 + 1e-6, 1.1 + 1e-6])
    assert 0.0 < most - least < 1e-4 * least
