"""Recorded formulas: powers and numpy's functions are taken; of what is no formula it is said what to write instead."""

import math

import numpy as np
import pytest

from vibrocap.numerics.expressions.graph import Graph, evaluate
from vibrocap.numerics.expressions.refusals import UFUNCS, RecordingError
from vibrocap.physics.elementary import power


def recorded(function, *values):
    """The value of a function that was recorded, at some numbers."""
    graph = Graph()
    found = function(*(graph.node("state", i) for i in range(len(values))))
    return float(np.asarray(evaluate([graph.expression(found)], 0.0, values, 1.0, ())[0]))


@pytest.mark.parametrize("exponent", [-3, -1, 0, 1, 2, 3.0, 7, 8, np.int64(2), np.float64(3.0)])
@pytest.mark.parametrize("x", [1.7, -1.7])
def test_whole_powers_are_products_with_their_sign(x, exponent):
    assert recorded(lambda v: v**exponent, x) == pytest.approx(x ** float(exponent), rel=8 * np.finfo(float).eps)


@pytest.mark.parametrize("exponent", [1, 2, 3, 8, 0.5, 1.5, -0.3, 9, 20, -9])
def test_powers_are_recorded_as_the_elementary_function_does(exponent):
    graph = Graph()
    v = graph.node("state", 0)
    assert (v**exponent).index == power(v, exponent).index
    assert recorded(lambda v: v**exponent, 1.3) == pytest.approx(1.3**exponent, rel=1e-13)


def test_exponents_and_bases_may_be_recorded_too():
    assert recorded(lambda v, a: v**a, 1.3, 2.5) == pytest.approx(1.3**2.5, rel=1e-13)
    assert recorded(lambda a: 2.0**a, 2.5) == pytest.approx(2.0**2.5, rel=1e-13)
    graph = Graph()
    assert (graph.constant(3.0) ** 2).value == 9.0


@pytest.mark.parametrize("name", sorted(UFUNCS))
def test_functions_of_numpy_are_recorded(name):
    ufunc = getattr(np, name)
    values = (0.7, 0.4)[: ufunc.nin]
    assert recorded(ufunc, *values) == pytest.approx(float(ufunc(*values)), rel=1e-14)


def test_numbers_of_numpy_count_as_numbers():
    assert recorded(lambda v: np.float64(2.0) * v + np.int64(1) - v / np.float32(0.5), 0.7) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        (lambda v, w: abs(v), r"cannot hold a kink: write side \* velocity for \|velocity\|"),
        (lambda v, w: np.abs(v), r"cannot hold a kink: write side \* velocity"),
        (lambda v, w: max(v, w), r"cannot branch on a value \(if, max, min, a comparison\): write `side`"),
        (lambda v, w: min(v, 0.0), "cannot branch on a value"),
        (lambda v, w: 1.0 if v else 0.0, "cannot branch on a value"),
        (lambda v, w: 1.0 if v > 0 else 0.0, "cannot branch on a value"),
        (lambda v, w: 1.0 if v >= 0 else 0.0, "cannot branch on a value"),
        (lambda v, w: 1.0 if v == w else 0.0, "cannot branch on a value"),
        (lambda v, w: v and w, "cannot branch on a value"),
        (lambda v, w: np.maximum(v, w), "cannot branch on a value"),
        (lambda v, w: np.sign(v), "cannot branch on a value"),
        (lambda v, w: np.where(v > 0, v, w), "cannot branch on a value"),
        (lambda v, w: math.sin(v), "no functions of `math`.*write sin, cos, exp, log, sqrt, tanh, atan or power"),
        (lambda v, w: math.copysign(1.0, v), "no functions of `math`"),
        (lambda v, w: float(v), r"nor float\(\)"),
        (lambda v, w: int(v), r"nor float\(\)"),
        (lambda v, w: v % 1.0, "cannot hold a jump"),
        (lambda v, w: v // 1.0, "cannot hold a jump"),
        (lambda v, w: math.floor(v), "cannot hold a jump"),
        (lambda v, w: round(v), "cannot hold a jump"),
        (lambda v, w: np.arcsinh(v), "does not know numpy's arcsinh: of numpy's functions there are add, .*tanh"),
        (lambda v, w: np.array([1.0, 2.0]) * v, "takes single numbers, no arrays"),
    ],
)
def test_what_is_no_formula_is_refused_with_the_line_and_what_to_write(formula, said):
    graph = Graph()
    with pytest.raises(RecordingError, match=said) as error:
        formula(graph.node("state", 0), graph.node("state", 1))
    assert str(error.value).startswith(
        f"test_recording.py, line {formula.__code__.co_firstlineno}: a recorded formula "
    )


def test_a_function_is_named_beside_its_line():
    def force(velocity):
        return abs(velocity)

    with pytest.raises(RecordingError, match=r"^test_recording\.py, line \d+, in force: a recorded formula"):
        force(Graph().node("state", 0))
