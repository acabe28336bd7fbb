"""The event search: the first root of a polynomial, none missed, none made up, to the level of rounding.

A root x of sum a_i s^i is known from rounded coefficients and a rounded evaluation (Horner: 2n roundings; scaling to
the unit interval: n more) to

    |error| <= 3 (n+1) eps sum |a_i| x^i / |p'(x)| + 4 eps x.
"""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.polynomial import polynomial as P

import vibrocap as vc
from plain_kernels import kernel_of

EPSILON = np.finfo(float).eps
KERNEL = kernel_of(vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic()))


def first_root(coefficients, h, sign=1.0, zeros=0):
    """(root, touch) of the polynomial with these coefficients of s^0, s^1, ... on (0, h]."""
    row = KERNEL.series(0)
    row[:] = np.nan  # what lies beyond the degree must not matter
    row[: len(coefficients)] = coefficients
    KERNEL.floats[KERNEL["WORK"] :] = np.nan
    return KERNEL["first_root"](KERNEL.floats, KERNEL["SERIES"], len(coefficients) - 1, sign, zeros, h)


def uncertainty(coefficients, x):
    """How far rounding alone may move a simple root x."""
    size = P.polyval(x, np.abs(coefficients))
    return 3 * len(coefficients) * EPSILON * size / abs(P.polyval(x, P.polyder(coefficients))) + 4 * EPSILON * x


def from_roots(roots, sign=1.0):
    """Polynomial with these roots, of the sign given at s = 0."""
    coefficients = P.polyfromroots(roots)
    return coefficients * (sign if coefficients[0] > 0 else -sign)


@pytest.mark.parametrize(
    ("roots", "h", "first"),
    [
        ((0.3,), 1.0, 0.3),
        ((0.3, 0.6, 0.9), 1.0, 0.3),
        ((-0.2, 0.7, 1.4, 2.0), 1.0, 0.7),
        ((0.5 - 1e-3, 0.5, 0.5 + 1e-3), 2.0, 0.5 - 1e-3),
        ((1e-9, 0.8), 1.0, 1e-9),  # at once after the start
        ((0.5, 0.75), 1.0, 0.5),  # where the interval is halved
        ((0.05, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1), 1.0, 0.05),
        ((0.9, 1.1, 3 + 1j, 3 - 1j, 0.2 + 0.2j, 0.2 - 0.2j), 1.0, 0.9),
    ],
)
def test_simple_roots(roots, h, first):
    coefficients = from_roots(roots).real
    root, touch = first_root(coefficients, h)
    assert abs(root - first) <= uncertainty(coefficients, first)
    assert touch == -1.0


def test_none():
    assert first_root([1.0, -1.0], 0.999) == (-1.0, -1.0)
    assert first_root([1.0, 0.0, 0.0], 1.0) == (-1.0, -1.0)
    assert first_root(from_roots((1.2, 0.4 + 0.05j, 0.4 - 0.05j)).real, 1.0) == (-1.0, -1.0)
    assert first_root([0.0, 0.0, 0.0], 1.0) == (-1.0, -1.0)  # at rest for good


def test_root_at_the_end_of_the_step():
    assert first_root([1.0, -1.0], 1.0)[0] == 1.0
    assert first_root([0.75, 0.0, -3.0], 0.5)[0] == 0.5
    assert first_root([1.0, -1.0], np.nextafter(1.0, 0.0)) == (-1.0, -1.0)


def test_touch_is_no_root_but_is_told():
    root, touch = first_root(from_roots((0.4, 0.4, -1.0)), 1.0)
    assert root == -1.0
    assert touch == pytest.approx(0.4, rel=16 * EPSILON)
    root, touch = first_root(from_roots((0.3, 0.3, 0.7)), 1.0)
    assert root == pytest.approx(0.7, rel=16 * EPSILON)
    assert touch == pytest.approx(0.3, rel=32 * EPSILON)
    root, touch = first_root(from_roots((0.3, 0.3, 0.8, 0.8)), 1.0)
    assert (root, touch) == (-1.0, pytest.approx(0.3, rel=64 * EPSILON))


def test_multiple_roots():
    """A root of multiplicity m is known to the m-th root of rounding."""
    root, touch = first_root([0.4**3, -3 * 0.4**2, 3 * 0.4, -1.0], 1.0)
    assert abs(root - 0.4) <= (8 * EPSILON) ** (1 / 3)
    assert touch == -1.0 or touch == pytest.approx(0.4, abs=(8 * EPSILON) ** (1 / 3))
    quadruple = P.polyfromroots([0.4] * 4)  # rounding decides whether it touches, dips or stays clear
    for found in first_root(quadruple, 1.0):
        assert found == -1.0 or abs(found - 0.4) <= (8 * 16 * EPSILON) ** (1 / 4)


def test_miss_below_rounding_is_a_touch():
    """8 eps times the size of the terms is the noise of the search."""
    root, touch = first_root([0.16 + 1e-16, -0.8, 1.0], 1.0)
    assert root == -1.0
    assert touch == pytest.approx(0.4, rel=1e-12)


def test_leading_zeros_are_deflated():
    """s^2 (0.3 - s): the two coefficients known to vanish carry dirt that would fake a root."""
    for dirt in (0.0, 1e-17, -1e-17):
        root, touch = first_root([dirt, -3 * dirt, 0.3, -1.0], 1.0, zeros=2)
        assert root == pytest.approx(0.3, rel=4 * EPSILON)
        assert touch == -1.0
    assert first_root([0.0, -1e-17, 0.3, 1.0], 1.0, zeros=2) == (-1.0, -1.0)
    assert first_root([0.0, 0.3, -1.0], 1.0, zeros=1)[0] == pytest.approx(0.3, rel=4 * EPSILON)


def test_sign_mirrors():
    coefficients = from_roots((0.3, 0.5), sign=-1.0)
    assert first_root(coefficients, 1.0, sign=-1.0)[0] == first_root(-coefficients, 1.0)[0]


def test_time_scale_does_not_matter():
    """p(s) on (0, h] and p(s/1e-6) on (0, 1e-6 h]."""
    coefficients = from_roots((0.3, 0.31, 0.9))
    shrunk = coefficients / 1e-6 ** np.arange(4)
    assert first_root(shrunk, 1e-6)[0] == pytest.approx(1e-6 * first_root(coefficients, 1.0)[0], rel=1e-13)


def test_not_a_number_ends_the_search():
    assert first_root([math.nan, 1.0, 1.0], 1.0)[0] == -1.0


@settings(max_examples=30, deadline=None)
@given(
    coefficients=st.lists(st.floats(-1, 1).map(lambda x: round(x, 3)), min_size=2, max_size=13),
    start=st.floats(1e-3, 1.0),
    h=st.floats(0.05, 3.0),
)
def test_random_polynomials_against_numpy(coefficients, start, h):
    """The first root is that of numpy.roots wherever that one is not ambiguous."""
    coefficients = np.array([start, *coefficients[1:]])
    while len(coefficients) > 1 and coefficients[-1] == 0.0:
        coefficients = coefficients[:-1]
    assume(len(coefficients) > 1)
    roots = P.polyroots(coefficients)
    candidates = [r for r in roots if -1e-3 < r.real < h + 1e-3 and abs(r.imag) < 1e-3]
    assume(all(r.imag == 0.0 for r in candidates))  # no pair that rounding may have made or split
    assume(all(abs(r.real - end) > 1e-6 for r in candidates for end in (0.0, h)))
    real_roots = sorted(r.real for r in candidates if 0.0 < r.real < h)
    assume(all(b - a > 1e-4 for a, b in itertools.pairwise(real_roots)))
    root, touch = first_root(coefficients, h)
    assert touch == -1.0
    if not real_roots:
        assert root == -1.0
    else:
        polished = real_roots[0]
        for _ in range(3):  # numpy's eigenvalues are less exact than the search
            polished -= P.polyval(polished, coefficients) / P.polyval(polished, P.polyder(coefficients))
        assert abs(root - polished) <= 2 * uncertainty(coefficients, polished)


@settings(max_examples=60, deadline=None)
@given(
    middle=st.floats(0.05, 0.95),
    log_gap=st.floats(-12, -2),
    others=st.lists(st.floats(1.2, 3.0), max_size=4),
    below=st.booleans(),
)
def test_random_near_misses(middle, log_gap, others, below):
    """A dip to +-gap inside the step, times a polynomial that stays positive."""
    gap = 10.0**log_gap
    dip = [middle**2 + (-gap if below else gap), -2 * middle, 1.0]
    assume(dip[0] > 1e-3)
    coefficients = P.polymul(dip, from_roots(others)) if others else np.array(dip)
    noise = 64 * EPSILON * np.sum(np.abs(coefficients)) / abs(P.polyval(middle, from_roots(others or [2.0])))
    assume(gap > noise)
    root, _ = first_root(coefficients, 1.0)
    first = middle - math.sqrt(gap)
    if not below:
        assert root == -1.0
    else:
        assert abs(root - first) <= 2 * uncertainty(coefficients, first)


@pytest.mark.slow
def test_the_search_has_the_memory_that_it_needs_at_most():
    """Touches next to the start, of the full degree: all 38 intervals are in use, and not one number is left over."""
    random, used = np.random.default_rng(0), 0
    for _ in range(400):
        near, coefficients = 2.0 ** -random.uniform(30, 45), np.ones(1)
        for _ in range(6):
            place = near * random.uniform(0.5, 2.0)
            apart = 1.0 + 10.0 ** -random.uniform(1, 17)
            coefficients = P.polymul(coefficients, [place * place * apart, -2.0 * place, 1.0])
        first_root(coefficients / coefficients[0], 1.0)
        used = max(used, np.flatnonzero(~np.isnan(KERNEL.floats[KERNEL["WORK"] :]))[-1] + 1)
    assert used == KERNEL.layout.event_work_size == len(KERNEL.floats) - KERNEL["WORK"]
