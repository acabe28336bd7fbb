"""Elementary functions of all lanes at once and in recorded physics: tanh and arc tangent, at every size."""

import math

import mpmath as mp
import numpy as np
import pytest

from vibrocap.numerics.compiler import compiled
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate
from vibrocap.numerics.kernel.arithmetic import elementary_polynomials, plain_vectors
from vibrocap.numerics.linker import kernel_source, plain_kernel
from vibrocap.physics.elementary import atan, tanh

MODULES = ("arithmetic.one_number", "arithmetic.elementary_polynomials")


def points():
    """All sizes from the smallest normal number to 1e9, both signs; the ranges where the formula changes; the ends."""
    draw = np.random.default_rng(5)
    sizes = 10.0 ** np.concatenate((draw.uniform(-307, 9, 1500), draw.uniform(-3, 2, 3000)))
    borders = np.array(
        [0.17328679513998632, 0.5198603854199589, 0.66, 1.0, 2.414213562373095, 20.0]
    )  # ln 2/4, 3 ln 2/4
    near = np.concatenate([np.nextafter(borders, side) for side in (0.0, np.inf)])
    both = np.concatenate((sizes, borders, near))
    return np.concatenate((both, -both, [0.0, -0.0, 1e300, -1e300]))


DRAW = np.random.default_rng(6)
ANGLES = np.concatenate((DRAW.uniform(-1000.0, 1000.0, 2000), 10.0 ** DRAW.uniform(-18, 0, 500)))
RANGE = np.concatenate((DRAW.uniform(-707.9, 709.7, 2000), DRAW.uniform(-1.0, 1.0, 2000), ANGLES[2000:]))
SIZES = np.concatenate((10.0 ** DRAW.uniform(-300, 300, 2000), DRAW.uniform(0.5, 2.0, 2000)))


@pytest.mark.parametrize(
    ("simd", "exact", "x", "ulps", "odd"),
    [
        (elementary_polynomials.hyperbolic_tangent, mp.tanh, points(), 3.0, True),
        (elementary_polynomials.arc_tangent, mp.atan, points(), 3.0, True),
        (lambda x: elementary_polynomials.sine_cosine(x)[0], mp.sin, ANGLES, 2.0, False),
        (lambda x: elementary_polynomials.sine_cosine(x)[1], mp.cos, ANGLES, 2.0, False),
        (elementary_polynomials.exponential, mp.exp, RANGE, 2.0, False),
        (elementary_polynomials.logarithm, mp.log, SIZES, 2.0, False),
    ],
    ids=["tanh", "atan", "sin", "cos", "exp", "log"],
)
def test_functions_are_right_to_ulps_and_odd(simd, exact, x, ulps, odd):
    values = simd(x)
    with mp.workdps(40):
        errors = [float(abs(mp.mpf(y) - exact(mp.mpf(v)))) for y, v in zip(values.tolist(), x.tolist(), strict=True)]
    assert np.all(np.array(errors) <= ulps * np.spacing(np.abs(values)))
    assert not odd or np.array_equal(simd(-x), -values)


def test_exp_reaches_both_ends():
    x = np.array([-1e5, -708.1, 709.782712893384, 710.0, 1e5])
    with np.errstate(over="ignore"):
        exponential = elementary_polynomials.exponential(x)
    assert np.array_equal(exponential[[0, 1, 3, 4]], [0.0, 0.0, np.inf, np.inf])
    assert exponential[2] == pytest.approx(math.exp(x[2]), rel=1e-15)


BITS = """
from vibrocap.numerics.kernel.arithmetic.plain_vectors import exponent, load, mantissa, power_of_two, store

def entry(floats, ints, trace, width):
    store(trace, 0, exponent(load(floats, 0)))
    store(trace, width, mantissa(load(floats, 0)))
    store(trace, 2 * width, power_of_two(load(floats, width)))
"""


def test_compiled_bits_of_all_lanes_are_those_of_numpy():
    width = plain_vectors.lane_count()
    x = np.resize([1.0, 2.0**-1022, 1.5 * 2.0**1023, 3.0, 0.75, 7e-310 + 2.0**-1000], width)
    k = np.resize([-1022.0, 1023.0, 0.0, -1.0, 700.0], width)
    values = np.zeros(3 * width)
    compiled(BITS, "entry")(np.concatenate((x, k)), np.zeros(1, dtype=np.int64), values, width)
    wanted = (plain_vectors.exponent(x), plain_vectors.mantissa(x), plain_vectors.power_of_two(k))
    assert np.array_equal(values, np.concatenate(wanted))


def test_tanh_keeps_its_end():
    assert np.array_equal(elementary_polynomials.hyperbolic_tangent(np.array([20.1, 1e9, -1e9])), [1.0, 1.0, -1.0])


@pytest.mark.parametrize("name", ["sine_cosine", "exponential", "logarithm", "hyperbolic_tangent", "arc_tangent"])
def test_one_number_alone_gives_the_bits_of_many(name):
    """The names of `one_number.py` mean what those of the lanes mean: normal numbers, zero, and where exp runs over."""
    kernel = plain_kernel("\n\n".join(["import math, numpy as np", *map(kernel_source, MODULES)]))
    draw = np.random.default_rng(8)
    x = np.concatenate((10.0 ** draw.uniform(-300, 3, 1000), draw.uniform(0.0, 10.0, 1000), [0.0, 708.5, 710.0]))
    if name != "logarithm":
        x = np.concatenate((x, -x))
    with np.errstate(divide="ignore", over="ignore"):
        many = np.array(getattr(elementary_polynomials, name)(x))
        alone = np.array([kernel[name](float(value)) for value in x])
    assert np.array_equal(many, alone.T)


@pytest.mark.parametrize(("function", "plain"), [(tanh, math.tanh), (atan, math.atan)])
@pytest.mark.parametrize("x", [-1.3, 0.0, 0.4, 1e9])
def test_functions_and_their_derivatives_in_recorded_physics(function, plain, x):
    """f(2 y) on floats, on a graph and, twice differentiated, in closed form."""
    graph = Graph()
    recorded = function(2.0 * graph.node("state", 0))
    slope = derivative(recorded, 0)
    value, first, second = evaluate([recorded, slope, derivative(slope, 0)], 0.0, [np.float64(x)], 1.0, ())
    f, z = plain(2.0 * x), 2.0 * x
    assert function(2.0 * x) == f
    assert value == pytest.approx(f, rel=1e-15)
    if function is tanh:
        expected = 2.0 * (1 - f * f), -8.0 * f * (1 - f * f)
    else:
        expected = 2.0 / (1 + z * z), -8.0 * z / (1 + z * z) ** 2
    assert (first, second) == pytest.approx(expected, rel=1e-14, abs=1e-300)
    assert function(graph.constant(z)).value == f
