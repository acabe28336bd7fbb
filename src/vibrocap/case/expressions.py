"""Expressions of a case file: parsed against a list of what they may hold, measured in units, never run as Python.

    e := number | name | e + e | e - e | e * e | e / e | e ** n | -e | f(e) | (e)

n: a whole number from 1 to 8, or 0.5   f: one of `FUNCTIONS`, and `distance(a, b)`, `offset(a, b)` of two bodies
"""

import ast
import math
import re
import warnings
from collections.abc import Callable, Collection, Mapping
from typing import Any

from vibrocap.arguments import shown, suggestion
from vibrocap.physics.dimensions.units import unit_name
from vibrocap.physics.elementary import atan, cos, exp, sin, sqrt, tanh
from vibrocap.physics.mechanics.parts import distance, offset
from vibrocap.physics.parameters import LENGTH, NUMBER, Dimension

FUNCTIONS: dict[str, Callable] = {"sin": sin, "cos": cos, "sqrt": sqrt, "exp": exp, "tanh": tanh, "atan": atan}
BETWEEN: dict[str, Callable] = {"distance": distance, "offset": offset}
OPERATORS: dict[type, tuple[str, Callable]] = {
    ast.Add: ("adds", lambda a, b: a + b),
    ast.Sub: ("subtracts", lambda a, b: a - b),
    ast.Mult: ("multiplies", lambda a, b: a * b),
    ast.Div: ("divides", lambda a, b: a / b),
}
CONSTANTS = {"pi": math.pi}
LONGEST, DEEPEST = 1000, 40  # characters of an expression, and levels
MOST_TERMS = 200  # of an expression multiplied out
LETTERS = re.compile(r"[A-Za-z0-9_ .+\-*/(),'\"\n\t]*")
ALLOWED = f"numbers, names, + - * / **, {', '.join(FUNCTIONS)}"
FREE = None  # the dimension of a bare number, which fits any where the description has no units


class ExpressionError(ValueError):
    """What an expression cannot mean, in words that begin with the expression."""


class Expression:
    """A number or an expression of names.

    names: those that are known   bodies: those that `distance` and `offset` may name
    Raises ExpressionError for anything else, with the column.
    """

    def __init__(self, text: Any, names: Collection[str], bodies: Collection[str] = ()):
        self.text, self.names, self.bodies = str(text), names, bodies
        self.bodies_named: list[str] = []
        if isinstance(text, str):
            if len(text) > LONGEST:
                raise ExpressionError(f"should be an expression of at most {LONGEST} characters, got {len(text)}")
            self.tree = self._parsed(text)
            self._check(self.tree, DEEPEST)
            if (terms := _terms(self.tree)) > MOST_TERMS:
                raise ExpressionError(f"{shown(text)}: multiplied out has {terms:.3g} terms, more than {MOST_TERMS}")
        elif isinstance(text, (int, float)) and not isinstance(text, bool) and abs(text) < 1e300:
            self.tree = ast.Constant(float(text))
        else:
            raise ExpressionError(f"should be a finite number or an expression, got {shown(text)}")

    def _parsed(self, text: str) -> ast.expr:
        if (end := LETTERS.match(text).end()) < len(text):  # type: ignore[union-attr]
            raise ExpressionError(f"{shown(text)}: {text[end]!r} (column {end + 1}) should be made of {ALLOWED}")
        plain = " ".join(text.split())
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # about numbers that run into words
                return ast.parse(plain, mode="eval").body
        except SyntaxError as error:
            place = f" (column {error.offset})" if error.offset else ""
            raise ExpressionError(f"{shown(text)} is no expression: {error.msg}{place}") from None
        except (ValueError, RecursionError, MemoryError):
            raise ExpressionError(f"{shown(text)} is no expression: it is nested too deeply") from None

    def _check(self, node: ast.expr, levels: int) -> None:
        """ExpressionError for whatever is not in the list."""
        if levels == 0:
            raise ExpressionError(f"{shown(self.text)}: is nested more than {DEEPEST} levels deep")
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool) and value < 1e300:
                node.value = float(value)
            case ast.Name(id=name):
                if name not in self.names and name not in CONSTANTS:
                    known = [*self.names, *CONSTANTS]
                    raise self._error(node, f"there is no {name!r}; {suggestion(name, known)}")
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                self._check(inner, levels - 1)
            case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=int() | float() as n)):
                if isinstance(n, bool) or not (n == 0.5 or (n == n // 1 and 1 <= n <= 8)):
                    raise self._error(node.right, f"an exponent should be a whole number from 1 to 8 or 0.5, got {n}")
                self._check(left, levels - 1)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
                self._check(left, levels - 1)
                self._check(right, levels - 1)
            case ast.Call(func=ast.Name(id=name), args=[inner], keywords=[]) if name in FUNCTIONS:
                self._check(inner, levels - 1)
            case ast.Call(func=ast.Name(id=name), args=[a, b], keywords=[]) if name in BETWEEN:
                for operand in (a, b):
                    if (body := _body(operand)) not in self.bodies:
                        raise self._error(operand, f"there is no body {body!r}; {suggestion(body, self.bodies)}")
                    self.bodies_named.append(body)
            case _:
                raise self._error(node, f"{ast.unparse(node)[:40]!r} should be made of {ALLOWED}")

    def _error(self, node: ast.expr, what: str) -> ExpressionError:
        return ExpressionError(f"{shown(self.text)}: {what} (column {node.col_offset + 1})")

    @property
    def names_in(self) -> set[str]:
        return {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}

    @property
    def is_name(self) -> bool:
        return isinstance(self.tree, ast.Name)

    # --- units -------------------------------------------------------------------------------------------------------

    def dimension(self, known: Mapping[str, Dimension], scaled: bool) -> Dimension | None:
        """Its dimension; FREE of a bare number where the description is without units, and of zero.

        Raises ExpressionError where quantities of different dimensions are added, or a function takes no number.
        """
        return self._measured(self.tree, known, FREE if scaled else NUMBER)

    def _measured(self, node: ast.expr, known: Mapping[str, Dimension], bare: Dimension | None) -> Dimension | None:
        match node:
            case ast.Constant(value=value):
                return FREE if value == 0.0 else bare
            case ast.Name(id=name):
                return known.get(name, bare)
            case ast.UnaryOp(operand=inner):
                return self._measured(inner, known, bare)
            case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=n)):
                own = self._measured(left, known, bare)
                return FREE if own is FREE else own**n  # type: ignore[operator]
            case ast.BinOp(left=left, op=op, right=right):
                a, b = (self._measured(operand, known, bare) for operand in (left, right))
                if isinstance(op, (ast.Mult, ast.Div)):
                    return FREE if a is FREE and b is FREE else OPERATORS[type(op)][1](a or NUMBER, b or NUMBER)
                if a is not FREE and b is not FREE and a != b:
                    words = OPERATORS[type(op)][0]
                    terms = [f"{ast.unparse(side)!r} ({in_words(own)})" for side, own in ((left, a), (right, b))]
                    raise self._error(right, f"{words} {' and '.join(terms)}")
                return b if a is FREE else a
            case ast.Call(func=ast.Name(id=name), args=[inner]):
                own = self._measured(inner, known, bare)
                if name == "sqrt":
                    return FREE if own is FREE else own**0.5  # type: ignore[operator]
                if own not in (FREE, NUMBER):
                    raise self._error(inner, f"{name} takes a number, got {ast.unparse(inner)!r} ({in_words(own)})")
                return bare
        return LENGTH  # between two bodies

    # --- values ------------------------------------------------------------------------------------------------------

    def __call__(self, at: Mapping[str, Any], bodies: Mapping[str, Any]) -> Any:
        return self._value(self.tree, at, bodies)

    def _value(self, node: ast.expr, at: Mapping[str, Any], bodies: Mapping[str, Any]) -> Any:
        match node:
            case ast.Constant(value=value):
                return value
            case ast.Name(id=name):
                return at[name] if name in at else CONSTANTS[name]
            case ast.UnaryOp(operand=inner):
                return -self._value(inner, at, bodies)
            case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=n)):
                return self._value(left, at, bodies) ** (n if n == 0.5 else int(n))  # type: ignore[arg-type]
            case ast.BinOp(left=left, op=op, right=right):
                return OPERATORS[type(op)][1](self._value(left, at, bodies), self._value(right, at, bodies))
            case ast.Call(func=ast.Name(id=name), args=[inner]):
                return FUNCTIONS[name](self._value(inner, at, bodies))
            case ast.Call(func=ast.Name(id=name), args=[a, b]):
                return BETWEEN[name](bodies[_body(a)], bodies[_body(b)])
        raise AssertionError(ast.dump(node))


def in_words(dimension: Dimension | None) -> str:
    """A dimension in words: "m", "a number"."""
    return "a number" if dimension in (FREE, NUMBER) else f"in {unit_name(dimension)}"


def _body(node: ast.expr) -> str:
    """The body that an argument names, as a word or as a text where its name has spaces."""
    match node:
        case ast.Name(id=name) | ast.Constant(value=str() as name):
            return name
    return ast.unparse(node)[:40]


def _terms(node: ast.expr) -> float:
    """How many terms an expression has where it is multiplied out."""
    match node:
        case ast.UnaryOp(operand=inner):
            return _terms(inner)
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=n)) if n != 0.5:
            count = _terms(left)
            return math.inf if count > MOST_TERMS else math.comb(int(count) + int(n) - 1, int(n))  # type: ignore[arg-type]
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            return _terms(left) + _terms(right)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _terms(left) * _terms(right)
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return max(_terms(left), _terms(right))
        case ast.Call(args=[inner]):
            return inside if (inside := _terms(inner)) > MOST_TERMS else 1.0  # one atom
    return 1.0
