"""Every friction law recorded: the graph is the law, its derivatives are those of its values, its series solve it."""

import math

import mpmath as mp
import numpy as np
import pytest

from law_instances import LAW_NAMES, LAWS
from test_series import Real
from vibrocap.contracts.samples import draws, random_internal, random_motion
from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate
from vibrocap.numerics.kernel.arithmetic.plain_vectors import where

EPSILON = float(np.finfo(float).eps)
each_law = pytest.mark.parametrize("law", LAWS, ids=LAW_NAMES)


def recorded(law, velocity, states, side, load):
    """Everything a law says in one tuple."""
    force, rates = law.force(velocity, states, side, load)
    guards = law.switches(velocity, states, side, load)
    after = [state for i in range(len(guards)) for state in law.after_switch(i, velocity, states, side, load)]
    turned = law.after_reversal(states, side, load)
    return (force, *rates, *guards, *after, *turned, *law.losses(velocity, states, side, load))


@each_law
def test_recorded_law_is_the_law_and_its_derivative_that_of_its_values(law):
    """The graph on numbers = the functions on floats; its partial derivatives = central differences."""
    graph = Graph()
    v, *z = (graph.node("state", i) for i in range(len(law.internal) + 1))
    expressions = [graph.expression(value) for value in recorded(law, v, tuple(z), graph.node("side", 0), 1.3)]
    continuous = [0, *(i + 1 for i, name in enumerate(law.internal) if name not in law.switched)]
    for draw in draws(3):
        _, _, side, _ = random_motion(law, draw)
        velocity = side * draw.uniform(0.05, 0.5)
        internal = random_internal(law, velocity, side, 1.3, draw)
        values = evaluate(expressions, 0.0, (velocity, *internal), side, ())
        expected = recorded(law, velocity, internal, side, 1.3)
        assert np.allclose(values, expected, rtol=64 * EPSILON, atol=64 * EPSILON)
        scales = (0.1, *law.internal_scales(1.3))
        for state in continuous:
            slopes = evaluate([derivative(e, state) for e in expressions], 0.0, (velocity, *internal), side, ())
            step = 1e-5 * scales[state]

            def moved(by, state=state, velocity=velocity, internal=internal, side=side):
                y = [velocity, *internal]
                y[state] += by
                return np.array(recorded(law, y[0], tuple(y[1:]), side, 1.3))

            difference = (8 * (moved(step) - moved(-step)) - (moved(2 * step) - moved(-2 * step))) / (12 * step)
            size = np.abs(expected).max() / scales[state]
            assert np.allclose(slopes, difference, rtol=1e-7, atol=1e-9 * size)


ORDER = 7


@each_law
def test_series_of_a_law_solve_its_equations(law):
    """Along v = v0 + v1 t + v2 t^2 the written series of states, force and guards, against 40-digit derivatives."""
    draw = draws(1, seed=law.name)[0]
    side = draw.choice((1, -1))
    course = [side * draw.uniform(0.1, 0.3), side * 0.2, -side * 0.1]
    internal = random_internal(law, course[0], side, 1.3, draw)
    graph = Graph()
    t = graph.node("time")
    z = tuple(graph.node("state", i) for i in range(len(internal)))
    velocity = course[0] + course[1] * t + course[2] * t * t
    force, rates = law.force(velocity, z, graph.node("side", 0), 1.3)
    followed = [graph.expression(e) for e in (force, *law.switches(velocity, z, graph.node("side", 0), 1.3))]
    writer = JetWriter(graph, [graph.expression(rate) for rate in rates])
    names = {"math": math, "floats": list(internal), "STATE": 0, "LANES": 1, "lane": 0, "time": 0.0, "sliding_0": side}
    names["where"] = where
    wanted = [[writer.coefficient(e.index, k) for k in range(ORDER + 1)] for e in (*z, *followed)]
    exec("\n".join(writer.code.lines), names)
    series = [[eval(value.text, names) for value in row] for row in wanted]
    with mp.workdps(40):

        def said(s):
            v = Real(course[0] + course[1] * s + course[2] * s * s)
            states = tuple(Real(mp.polyval(row[::-1], s)) for row in series[: len(z)])
            force, rates = law.force(v, states, side, 1.3)
            values = (*rates, force, *law.switches(v, states, side, 1.3))
            return [value.value if isinstance(value, Real) else mp.mpf(value) for value in values]

        for i, row in enumerate(series):
            exact = mp.taylor(lambda s, i=i: said(s)[i], 0, ORDER - 1)
            kept = [(k + 1) * row[k + 1] for k in range(ORDER)] if i < len(z) else row[:ORDER]
            first = max(map(abs, exact[:2])) or 1.0
            reach = (
                min((first / abs(c)) ** (1.0 / k) for k, c in enumerate(exact) if k and c) if any(exact[1:]) else 1.0
            )
            for k in range(ORDER):
                assert abs(kept[k] - exact[k]) * reach**k <= 1e-10 * first, (i, k)
