"""Recorded formulas: what the mechanics of a machine is as a function of its state, its parameters and its inputs.

A formula is recorded once; a `Program` evaluates it, with numbers or with whatever else behaves like them.
"""

import operator
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from vibrocap.physics import elementary

FUNCTIONS = ("sin", "cos", "exp", "log", "sqrt", "tanh", "atan")
OPERATIONS: dict[str, Callable] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    **{name: getattr(elementary, name) for name in FUNCTIONS},
}


class Formula:
    """An input, or an operation on formulas and numbers; `Tape` makes them, equal ones once."""

    __slots__ = ("index", "op", "operands", "tape")

    def __init__(self, tape: "Tape", op: str, operands: tuple, index: int):
        self.tape, self.op, self.operands, self.index = tape, op, operands, index

    def __lt__(self, other: "Formula") -> bool:
        return self.index < other.index

    def __neg__(self):
        return self.operands[0] if self.op == "neg" else self.tape.formula("neg", self)


def _function(name: str) -> Callable:
    def recorded(self: Formula) -> Formula:
        return self.tape.formula(name, self)

    return recorded


for _name in FUNCTIONS:
    setattr(Formula, _name, _function(_name))


def is_number(x: Any, number: float) -> bool:
    """Whether x is this number exactly."""
    return isinstance(x, (int, float)) and x == number


def _binary(op: str, a: Any, b: Any) -> Any:
    tape = a.tape if isinstance(a, Formula) else getattr(b, "tape", None)
    return OPERATIONS[op](a, b) if tape is None else tape.formula(op, a, b)


def add(a: Any, b: Any) -> Any:
    """a + b; nothing is recorded for an exact zero."""
    if isinstance(a, Formula) and a.op == "neg":
        return sub(b, a.operands[0])
    return b if is_number(a, 0) else a if is_number(b, 0) else _binary("add", a, b)


def sub(a: Any, b: Any) -> Any:
    """a - b; nothing is recorded for an exact zero."""
    if isinstance(b, Formula) and b.op == "neg":
        return add(b.operands[0], a)
    return a if is_number(b, 0) else -b if is_number(a, 0) else _binary("sub", a, b)


def mul(a: Any, b: Any) -> Any:
    """a b; nothing is recorded for exact zeros and ones."""
    if is_number(a, 0) or is_number(b, 0):
        return 0.0
    if is_number(a, 1) or is_number(b, 1):
        return b if is_number(a, 1) else a
    return -b if is_number(a, -1) else -a if is_number(b, -1) else _binary("mul", a, b)


def div(a: Any, b: Any) -> Any:
    """a/b; nothing is recorded for a zero over it and for a one under it."""
    return 0.0 if is_number(a, 0) else a if is_number(b, 1) else _binary("div", a, b)


SCALARS = (Formula, int, float)


def _operator(function: Callable, turned: bool) -> Callable:
    def of(self: Formula, other: Any) -> Any:
        if not isinstance(other, SCALARS):
            return NotImplemented
        return function(other, self) if turned else function(self, other)

    return of


for _name, _own in (("add", add), ("sub", sub), ("mul", mul), ("truediv", div)):
    setattr(Formula, f"__{_name}__", _operator(_own, False))
    setattr(Formula, f"__r{_name}__", _operator(_own, True))


class Tape:
    """Formulas in the order in which they were recorded, each after its operands."""

    def __init__(self) -> None:
        self._known: dict[tuple, Formula] = {}

    def input(self, number: int) -> Formula:
        """The formula that is input `number` of a program."""
        return self.formula("input", number)

    def formula(self, op: str, *operands: Any) -> Formula:
        """An operation, recorded now if it is new."""
        key = (op, *(x if isinstance(x, Formula) else float(x) for x in operands))
        if key not in self._known:
            self._known[key] = Formula(self, op, operands, len(self._known))
        return self._known[key]


def affine(x: Any, among: Sequence[Formula]) -> tuple:
    """(x without some inputs, its slope by each of them), of a number or a formula that is affine in them.

    Exact, and of no more than they must depend on: as differences they would be rounded, and in interval arithmetic so
    wide that steps could no longer be proved to see a sharp law (`resolution.py`). TypeError where it is not affine.
    """
    known: dict[Any, tuple] = {one: (0.0, *(float(one is other) for other in among)) for one in among}

    def parts(x: Any) -> tuple:
        if x not in known:
            own = [parts(operand) for operand in x.operands] if isinstance(x, Formula) and x.op != "input" else []
            free = [any(slopes) for _, *slopes in own]
            if not any(free):
                known[x] = x, *(0.0 for _ in among)
            elif x.op in ("add", "sub", "neg"):
                known[x] = tuple(map({"add": add, "sub": sub, "neg": operator.neg}[x.op], *own))
            elif (x.op == "mul" and not all(free)) or (x.op == "div" and not free[1]):
                function, at = (mul, free.index(False)) if x.op == "mul" else (div, 1)
                known[x] = tuple(function(one, x.operands[at]) for one in own[1 - at])
            else:
                raise TypeError("is not linear in drive and friction forces")
        return known[x]

    return parts(x)


class Program:
    """Evaluates formulas in a straight line.

    results: formulas and constants such as numbers, words and None, in tuples of tuples   inputs: how many there are
    """

    def __init__(self, results: Any, inputs: int):
        self.reached: dict[Formula, int] = {}  # place of the value of each formula
        constants: list[float] = []
        code: list[tuple[Callable, int, int]] = []
        formulas = sorted(_reached(results), key=lambda formula: formula.index)
        numbers = dict.fromkeys(
            float(x)
            for formula in formulas
            if formula.op != "input"
            for x in formula.operands
            if not isinstance(x, Formula)
        )
        constants = list(numbers)
        places = {number: inputs + i for i, number in enumerate(constants)}
        start = inputs + len(constants)
        for formula in formulas:
            if formula.op == "input":
                self.reached[formula] = formula.operands[0]
                continue
            at = [self.reached[x] if isinstance(x, Formula) else places[float(x)] for x in formula.operands]
            self.reached[formula] = start + len(code)
            code.append((OPERATIONS[formula.op], at[0], at[1] if len(at) > 1 else -1))
        self.inputs = frozenset(formula.operands[0] for formula in formulas if formula.op == "input")
        self._constants, self._code, self.results = constants, code, results

    def __len__(self) -> int:
        return len(self._code)

    def __call__(self, inputs: Sequence[Any]) -> Any:
        """The results, in the form in which they were given."""
        values = [*inputs, *self._constants]
        for operation, a, b in self._code:
            values.append(operation(values[a]) if b < 0 else operation(values[a], values[b]))
        return self._put_in(self.results, values)

    def _put_in(self, results: Any, values: list) -> Any:
        if isinstance(results, tuple):
            return tuple(self._put_in(result, values) for result in results)
        return values[self.reached[results]] if isinstance(results, Formula) else results


def _reached(results: Any) -> set[Formula]:
    formulas: set[Formula] = set()
    waiting = [results]
    while waiting:
        formula = waiting.pop()
        if isinstance(formula, tuple):
            waiting += formula
        elif isinstance(formula, Formula) and formula not in formulas:
            formulas.add(formula)
            waiting += formula.operands
    return formulas


def numbers_in(nested: Any) -> Iterator[float]:
    """All numbers in tuples of tuples."""
    if isinstance(nested, (tuple, list)):
        for element in nested:
            yield from numbers_in(element)
    elif nested is not None:
        yield float(nested)
