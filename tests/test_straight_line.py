"""Formulas of straight-line code know when they are known, and sums wait for their latest term last."""

import itertools

import pytest

from vibrocap.numerics.codegen.straight_line import (
    CALLING,
    ZERO,
    Code,
    Formula,
    total,
)

# Known one after another: a first, d last.
KNOWN = {name: Formula(name, place * CALLING) for place, name in enumerate("xabcd")}


def formula(text: str) -> Formula:
    return eval(text, dict(KNOWN))


def test_a_sum_is_the_same_number_whatever_the_order_and_the_signs():
    values = {"a": 2.0, "b": 3.0, "c": 5.0, "d": 7.0, "x": 11.0}
    texts = ("d", "b * x", "a", "c * x")
    for order in itertools.permutations(texts):
        for signs in itertools.product((1, -1), repeat=len(texts)):
            terms = list(zip(signs, order, strict=True))
            written = total([(sign, formula(size)) for sign, size in terms]).text
            assert eval(written, values) == sum(sign * eval(text, values) for sign, text in terms)


@pytest.mark.parametrize(
    "text",
    [
        "a - (b - c)",
        "a - (b + c) * d",
        "a / (b * c)",
        "a / b * c",
        "-(a - b) * c",
        "a - -b",
        "-(a * b) - c",
        "(a + b) / -c",
    ],
)
def test_brackets_keep_the_value(text):
    values = {"a": 2.0, "b": 3.0, "c": 5.0, "d": 7.0}
    assert eval(formula(text).text, values) == eval(text, values)


def test_what_vanishes_leaves_no_trace():
    a = KNOWN["a"]
    assert (a + ZERO, ZERO + a, a - ZERO) == (a, a, a)
    assert (ZERO - a).text == "-a"
    assert a * ZERO is ZERO * a is ZERO / a is -ZERO is total([(1, ZERO), (-1, ZERO)]) is ZERO
    code = Code()
    assert code.name("n0_1", ZERO) is ZERO
    assert code.lines == []
