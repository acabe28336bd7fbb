"""Sums of straight-line code wait for their latest term last, and stay the sums that they were."""

import itertools

import pytest

from vibrocap.numerics.codegen.latency_order import CALL, PRODUCT, QUOTIENT, SUM, LatencyOrder


def test_a_name_is_known_when_the_last_of_what_it_needs_is_and_the_operation_is_done():
    latency = LatencyOrder()
    latency.write("late", "sine(x)")
    assert latency.of("x") == 0
    assert latency.of("late") == CALL
    assert latency.of("-late") == CALL
    assert latency.of("1.0 / late") == CALL + QUOTIENT
    assert latency.of("x * late") == CALL + PRODUCT
    assert latency.of("x + late") == CALL + SUM
    assert latency.of("floats[3]") == 0
    assert latency.of("pair(late)[1]") == 2 * CALL


def test_one_product_of_a_sum_is_free():
    """It is one operation with the sum; of two products the left one, as LLVM joins them."""
    latency = LatencyOrder()
    latency.write("late", "sine(x)")
    assert latency.of("x + y * late") == CALL + SUM
    assert latency.of("y * late - x") == CALL + SUM
    assert latency.of("y * late + x * x") == CALL + SUM
    assert latency.of("x * x + y * late") == CALL + PRODUCT + SUM


def known():
    """Names that are known one after another: a first, d last."""
    latency = LatencyOrder()
    for name, before in itertools.pairwise("xabcd"):
        latency.write(before, f"sine({name})")
    return latency


@pytest.mark.parametrize(
    ("terms", "text"),
    [
        ([], "0.0"),
        ([(1, "a")], "a"),
        ([(-1, "a")], "-a"),
        ([(1, "d"), (1, "b"), (1, "a"), (1, "c")], "a + b + c + d"),
        ([(1, "d"), (-1, "a"), (1, "c")], "c - a + d"),
        ([(-1, "d"), (-1, "a")], "-(a + d)"),
        ([(1, "a * x"), (1, "d * x"), (1, "c * x")], "c * x + a * x + d * x"),
        ([(1, "a * x"), (-1, "d * x")], "a * x - d * x"),
    ],
)
def test_a_sum_adds_what_is_known_first(terms, text):
    assert known().sum(terms) == text


def test_a_sum_is_the_same_number_whatever_the_order_and_the_signs():
    values = {"a": 2.0, "b": 3.0, "c": 5.0, "d": 7.0, "x": 11.0}
    texts = ("d", "b * x", "a", "c * x")
    for order in itertools.permutations(texts):
        for signs in itertools.product((1, -1), repeat=len(texts)):
            terms = list(zip(signs, order, strict=True))
            assert eval(known().sum(terms), values) == sum(sign * eval(text, values) for sign, text in terms)
