"""Rules between the numbers of a system, for a page: taken from the checks of its parts by running them.

A check runs on numbers that write down what becomes of them. Wherever it asks whether one is less than another, both
answers are followed, so that in the end every way through the check is known, with the questions that lead there and
what is said at its end. No rule is written twice, and a part of one's own brings its own.
"""

import dataclasses
import json
import operator
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.arguments import Complaint
from vibrocap.physics.parameters import complaint_of, parameter_table
from vibrocap.physics.system import System

MOST_WAYS = 500  # through one check
MOST_CASES = 16  # of a property; drives of many pieces ask more than a page should hold
HELD = "\x00"  # round an expression in a text


class Ways:
    """The ways through a function that asks; `answer` is what the numbers ask."""

    def __init__(self):
        self.asked: list[tuple[str, bool]] = []
        self._ahead: list[bool] = []

    def answer(self, question: str) -> bool:
        """The answer on this way: as before where it was asked before."""
        for known, answer in self.asked:
            if known == question:
                return answer
        answer = self._ahead.pop(0) if self._ahead else True
        self.asked.append((question, answer))
        return answer

    def through(self, function: Callable[[], Any], most: int = MOST_WAYS) -> Iterator[tuple[str, Any]]:
        """(condition, value or ValueError) for every way; a function that cannot be run so far has none from there."""
        for _ in range(most):
            self.asked = []
            try:
                value = function()
            except ValueError as error:
                value = error
            except (ArithmeticError, TypeError):
                value = None
            yield "&&".join(text if answer else f"!({text})" for text, answer in self.asked), value
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
            return Written(value, f"({self.text}{sign}{_text(other)})", self.ways)

        def mirrored(self: "Written", other: Any) -> Any:
            return one(Written(float(other), _text(other), self.ways), self)

        return one, mirrored

    @staticmethod
    def _asked(sign: str) -> Callable:
        def asked(self: "Written", other: Any) -> Any:
            if not isinstance(other, (int, float)):
                return NotImplemented
            return self.ways.answer(f"{self.text}{sign}{_text(other)}")

        return asked


for _name, _sign in {"add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**"}.items():
    _one, _mirrored = Written._on(getattr(operator, _name), _sign)
    setattr(Written, f"__{_name}__", _one)
    setattr(Written, f"__r{_name}__", _mirrored)
for _name, _sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "===", "ne": "!=="}.items():
    setattr(Written, f"__{_name}__", Written._asked(_sign))


def _text(value: Any) -> str:
    return value.text if isinstance(value, Written) else f"({float(value)!r})" if value < 0 else repr(float(value))


def written_system(system: System, paths: tuple[str, ...], ways: Ways) -> System:
    """A system whose parameters at the paths are written down, p[0], p[1], ... in the order of the paths; unchecked."""
    made: Any = object.__new__(System)
    for field in dataclasses.fields(system):
        object.__setattr__(made, field.name, getattr(system, field.name))
    for name, record in system.parts.items():
        part: Any = object.__new__(type(record))
        for key, value in vars(record).items():
            path = f"{name}.{key}"
            numbered = Written(value, f"p[{paths.index(path)}]", ways) if path in paths else value
            object.__setattr__(part, key, numbered)
        object.__setattr__(made, name, part)
    return made


def rules(system: System, paths: tuple[str, ...]) -> str:
    """What a form refuses, as an expression in JavaScript of the parameters p: [field, text] of the first complaint.

    paths: of the parameters, in the order of p. In the text numbers stand as f(expression). Bounds of one parameter
    alone are in the records of parts (`controls.py`) where they are plain, here where a check of its own makes them.
    """
    ways = Ways()
    made = written_system(system, paths, ways)
    found: dict[str, list[str]] = {}  # conditions by what is said
    for field, check in _checks(made):
        for condition, value in ways.through(check):
            if isinstance(value, ValueError) and condition:
                found.setdefault(_said(value, field), []).append(condition)
    return "||".join(f"({'||'.join(dict.fromkeys(each))})&&{said}" for said, each in found.items()) or "null"


def mirrored(system: System, paths: tuple[str, ...]) -> str:
    """`System.mirrored` as an expression in JavaScript of the parameters p; "false" where it takes too many words."""
    ways = Ways()
    made = written_system(system, paths, ways)
    found = list(ways.through(lambda: made.mirrored, MOST_CASES))
    if len(found) == MOST_CASES:
        return "false"
    return "||".join(condition or "true" for condition, value in found if value is True) or "false"


def _checks(system: System) -> Iterator[tuple[str, Callable[[], Any]]]:
    """(field, check) of all that the parts and the system check when they are made; field: of a part's, or ""."""
    for name, record in system.parts.items():
        cls: Any = type(record)
        for info in parameter_table(cls):
            value = getattr(record, info.name)
            for each in cls.__pydantic_fields__[info.name].metadata:
                if isinstance(value, Written) and callable(check := getattr(each, "func", None)):
                    yield f"{name}.{info.name}", lambda check=check, value=value: check(value)
        for each in cls.__pydantic_decorators__.model_validators.values():
            if each.info.mode == "after":
                yield f"{name}.", lambda check=each.func, record=record: check(record)
    yield "", system.__post_init__


def _said(error: ValueError, field: str) -> str:
    """[field, text] in JavaScript. field: as `_checks` gives it."""
    known = tuple(getattr(error, "complaints", ()))
    found: Complaint = known[0] if known else complaint_of(str(error))
    if field and not known:
        found = Complaint(field, str(error)) if not field.endswith(".") else found.about(field + found.field)
    parts = found.text.split(HELD)
    text = "".join(f"${{f({each})}}" if i % 2 else _plain(each) for i, each in enumerate(parts))
    return f"[{json.dumps(found.field)},`{text}`]"


def _plain(text: str) -> str:
    return text.replace("\\", "\\\\").replace("`", "\\`").replace("${", "\\${")
