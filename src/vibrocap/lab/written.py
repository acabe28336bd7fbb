"""Numbers that write down what becomes of them, in JavaScript, and follow both answers wherever they are compared.

So what the package says of numbers in Python, a rule or a measure, is said in a page too and written only once.
"""

import math
import operator
from collections.abc import Callable, Iterator
from typing import Any

MOST_WAYS = 500  # through one function
HELD = "\x00"  # round an expression in a text


Asked = tuple[tuple[str, bool], ...]


class Ways:
    """The ways through a function that asks; `answer` is what the numbers ask."""

    def __init__(self):
        self.asked: list[tuple[str, bool]] = []
        self._ahead: list[bool] = []

    def answer(self, question: str) -> bool:
        """The answer on this way: as before where it was asked before."""
        if (known := dict(self.asked).get(question)) is not None:
            return known
        answer = self._ahead.pop(0) if self._ahead else True
        self.asked.append((question, answer))
        return answer

    def through(self, function: Callable[[], Any], most: int = MOST_WAYS) -> Iterator[tuple[Asked, Any]]:
        """(questions with answers, value or ValueError) of every way; None where the function cannot be run so far."""
        for _ in range(most):
            self.asked = []
            try:
                value = function()
            except ValueError as error:
                value = error
            except (ArithmeticError, LookupError, TypeError):
                value = None
            yield tuple(self.asked), value
            answers = [answer for _, answer in self.asked]
            while answers and not answers[-1]:
                answers.pop()
            if not answers:
                return
            self._ahead = [*answers[:-1], False]


class Written(float):
    """A number that knows the expression in JavaScript by which it came about, and asks where it is compared."""

    text: str
    ways: Ways

    def __new__(cls, value: float, text: str, ways: Ways):
        """The number of an expression."""
        self = super().__new__(cls, value)
        self.text, self.ways = text, ways
        return self

    def __bool__(self) -> bool:
        return self.ways.answer(f"{self.text}!==0")

    def __format__(self, form: str) -> str:
        return f"{HELD}{self.text}{HELD}"

    __str__ = __repr__ = lambda self: format(self)
    __hash__ = float.__hash__

    def __neg__(self):
        return Written(-float(self), f"(-{self.text})", self.ways)

    def __round__(self, ndigits: Any = None):  # type: ignore[override]
        try:
            value = float(round(float(self)))
        except (OverflowError, ValueError):
            value = float("nan")
        return Written(value, f"Math.round({self.text})", self.ways)

    def __abs__(self):
        return Written(abs(float(self)), f"Math.abs({self.text})", self.ways)

    @staticmethod
    def _on(function: Callable[[float, float], float], sign: str) -> tuple[Callable, Callable]:
        def one(self: "Written", other: Any) -> Any:
            if not isinstance(other, (int, float)):
                return NotImplemented
            try:
                value = function(float(self), float(other))
            except ArithmeticError:
                value = float("nan")
            return Written(value, f"({self.text}{sign}{text_of(other)})", self.ways)

        def mirrored(self: "Written", other: Any) -> Any:
            return one(Written(float(other), text_of(other), self.ways), self)

        return one, mirrored

    @staticmethod
    def _asked(sign: str) -> Callable:
        def asked(self: "Written", other: Any) -> Any:
            if not isinstance(other, (int, float)):
                return NotImplemented
            return self.ways.answer(f"{self.text}{sign}{text_of(other)}")

        return asked


def _of_one(function: Callable[[float], float]) -> Callable[["Written"], "Written"]:
    def one(self: Written) -> Written:
        try:
            value = function(float(self))
        except (ArithmeticError, ValueError):
            value = float("nan")
        return Written(value, f"Math.{function.__name__}({self.text})", self.ways)

    return one


for _function in (math.sin, math.cos, math.exp, math.log, math.sqrt, math.tanh, math.atan):
    setattr(Written, _function.__name__, _of_one(_function))
for _name, _sign in {"add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**"}.items():
    _one, _mirrored = Written._on(getattr(operator, _name), _sign)
    setattr(Written, f"__{_name}__", _one)
    setattr(Written, f"__r{_name}__", _mirrored)
for _name, _sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "===", "ne": "!=="}.items():
    setattr(Written, f"__{_name}__", Written._asked(_sign))


def condition(asked: Asked) -> str:
    """The condition in JavaScript under which a way is taken."""
    return "&&".join(text if answer else f"!({text})" for text, answer in asked)


def chosen(ways: list[tuple[Asked, str]], depth: int = 0) -> str:
    """One expression in JavaScript of those at the ends of all ways, without questions that change nothing."""
    if len({text for _, text in ways}) == 1:
        return ways[0][1]
    question = ways[0][0][depth][0]
    yes, no = (chosen([case for case in ways if case[0][depth][1] is answer], depth + 1) for answer in (True, False))
    return yes if yes == no else f"({question}?{yes}:{no})"


def text_of(value: Any) -> str:
    """A number as JavaScript writes it."""
    if isinstance(value, Written):
        return value.text
    if math.isnan(value) or math.isinf(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "(-Infinity)"
    return f"({float(value)!r})" if value < 0 else repr(float(value))
