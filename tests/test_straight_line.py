"""Formulas of straight-line code know when they are known, and sums wait for their latest term last."""

import itertools

import pytest

from vibrocap.numerics.codegen.straight_line import (
    ADDING,
    CALLING,
    DIVIDING,
    MULTIPLYING,
    ZERO,
    Code,
    Formula,
    literal,
    total,
)

X, Y, LATE = Formula("x"), Formula("y"), Formula("late", CALLING)


def test_a_formula_is_known_when_the_last_of_what_it_needs_is_and_the_operation_is_done():
    code = Code()
    assert X.known == 0
    assert code.function("sin", LATE).known == 2 * CALLING
    assert (-LATE).known == CALLING
    assert (literal(1.0) / LATE).known == CALLING + DIVIDING
    assert (X * LATE).known == CALLING + MULTIPLYING
    assert (X + LATE).known == CALLING + ADDING
    assert code.entry("3").known == 0
    assert code.name("kept", X * LATE).known == CALLING + MULTIPLYING


def test_one_product_of_a_sum_is_free():
    """It is one operation with the sum; of two products the left one, as LLVM joins them."""
    assert (X + Y * LATE).known == CALLING + ADDING
    assert (Y * LATE - X).known == CALLING + ADDING
    assert (Y * LATE + X * X).known == CALLING + ADDING
    assert (X * X + Y * LATE).known == CALLING + MULTIPLYING + ADDING


# Known one after another: a first, d last.
KNOWN = {name: Formula(name, place * CALLING) for place, name in enumerate("xabcd")}


def formula(text: str) -> Formula:
    return eval(text, dict(KNOWN))


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
    assert total([(sign, formula(size)) for sign, size in terms]).text == text


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
