"""Numbers that write down what becomes of them, in JavaScript, and follow both answers wherever they are compared.

So what the package says of numbers in Python, a rule or a measure, is said in a page too and written only once. The
rules between the numbers of a system are taken from the checks of its parts by running them: wherever a check asks
whether one number is less than another, both answers are followed, so that in the end every way through it is known,
with the questions that lead there and what is said at its end. A part of one's own brings its own.
"""

import json
import math
import operator
import re
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.arguments import ArgumentError, Complaint
from vibrocap.physics.closed_loop.sampling import SampledReference
from vibrocap.physics.drives.drive import Piecewise
from vibrocap.physics.parameters import complaint_of, parameter_table
from vibrocap.physics.system import System

MOST_WAYS = 500  # through one function
LONG = 60  # letters: longer expressions have a name, so that what stands in several of them is written once
NAME = re.compile(r"\b_\d+\b")
HELD = "\x00"  # round an expression in a text


Asked = tuple[tuple[str, bool], ...]


class Ways:
    """The ways through a function that asks; `answer` is what the numbers ask."""

    def __init__(self):
        self.asked: list[tuple[str, bool]] = []
        self._ahead: list[bool] = []
        self._names: dict[str, str] = {}  # of long expressions, each after those in it

    def name(self, text: str) -> str:
        """An expression in JavaScript, or the name of a long one."""
        return text if len(text) <= LONG else self._names.setdefault(text, f"_{len(self._names)}")

    def whole(self, text: str) -> str:
        """An expression in JavaScript with what its names stand for."""
        texts, lines = {name: each for each, name in self._names.items()}, []
        wanted = set(NAME.findall(text))
        for name in reversed(texts):
            if name in wanted:
                wanted.update(NAME.findall(texts[name]))
                lines.append(f"{name}={texts[name]}")
        return f"(()=>{{const {','.join(reversed(lines))};return {text};}})()" if lines else text

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
        self.text, self.ways = ways.name(text), ways
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


MOST_CASES = 64  # of a property: a part of one's own may ask without end


def written_system(system: System, paths: tuple[str, ...], ways: Ways) -> System:
    """A system whose parameters at the paths are written down, p[0], p[1], ... in the order of the paths; unchecked."""
    parts: dict[str, Any] = {}
    for name, record in system.parts.items():
        part: Any = object.__new__(type(record))
        for key, value in vars(record).items():
            path = f"{name}.{key}"
            numbered = Written(value, f"p[{paths.index(path)}]", ways) if path in paths else value
            object.__setattr__(part, key, numbered)
        parts[name] = part
    return System.unchecked(parts)


def rules(system: System, paths: tuple[str, ...]) -> str:
    """What a form refuses, as an expression in JavaScript of the parameters p: [field, text] of the first complaint.

    paths: of the parameters, in the order of p. In the text numbers stand as f(expression). Bounds of one parameter
    alone are in the records of parts (`controls.py`) where they are plain, here where a check of its own makes them.
    """
    ways = Ways()
    variant = written_system(system, paths, ways)
    texts: dict[str, list[str]] = {}  # conditions by what is said
    for field, check in (*_checks(variant), ("", lambda: _place_stays_free(system, variant))):
        for asked, value in ways.through(check):
            if isinstance(value, ValueError) and asked:
                texts.setdefault(_said(value, field), []).append(condition(asked))
    broken = (f"({'||'.join(dict.fromkeys(text))})&&{place}" for place, text in texts.items())
    return ways.whole("||".join(broken) or "null")


def mirrored(system: System, paths: tuple[str, ...]) -> str:
    """`System.mirrored` as an expression in JavaScript of the parameters p and of odd(), which is asked where it must.

    odd: says whether the shape of a drive of many pieces is odd under half a period. That follows from where its
    corners lie, of which every order would be a way of its own; a page has the numbers of the pieces, and looks.
    """
    ways = Ways()
    variant = written_system(system, paths, ways)
    if isinstance(variant.drive, Piecewise) and type(variant.drive).odd is Piecewise.odd:
        asking: Any = object.__new__(type("Asking", (_AskedShape, type(variant.drive)), {"ways": ways}))
        vars(asking).update(vars(variant.drive))
        object.__setattr__(variant, "drive", asking)
    ends = ways.through(lambda: variant.mirrored, MOST_CASES)
    cases = [(asked, "true" if value is True else "false") for asked, value in ends]
    return "false" if len(cases) == MOST_CASES else ways.whole(chosen(cases))


def parts_of_period(system: System, paths: tuple[str, ...]) -> str:
    """How many equal parts the period of a drive with corners has, as an expression in JavaScript of the parameters."""
    ways = Ways()
    timed = written_system(system, paths, ways).timed_drive
    return ways.whole(text_of(round(timed.parts))) if isinstance(timed, SampledReference) else "1"


class _AskedShape:
    """A drive of many pieces of whose shape is asked."""

    ways: Ways
    size: Callable[[], float]

    @property
    def odd(self) -> bool:
        """`Piecewise.odd`."""
        return self.size() == 0.0 or self.ways.answer("odd()")


def _checks(system: System) -> Iterator[tuple[str, Callable[[], Any]]]:
    """(field, check) of all that the parts and the system check when they are made; field: of a part's, or ""."""
    for name, record in system.parts.items():
        cls: Any = type(record)
        for info in parameter_table(cls):
            value = getattr(record, info.name)
            for constraint in cls.__pydantic_fields__[info.name].metadata:
                if isinstance(value, Written) and callable(check := getattr(constraint, "func", None)):
                    yield f"{name}.{info.name}", lambda check=check, value=value: check(value)
        for model_validator in cls.__pydantic_decorators__.model_validators.values():
            if model_validator.info.mode == "after":
                yield f"{name}.", lambda check=model_validator.func, record=record: check(record)
    yield "", system.__post_init__


def _place_stays_free(system: System, changed: System) -> None:
    """Refuse a spring, say, where the kernels of the form look at a place on which nothing depends."""
    if system.cyclic is not None and changed.cyclic is None:
        raise ArgumentError(system.cyclic, "should stay free in this page: open another page of a case where it is not")


def _said(error: ValueError, field: str) -> str:
    """[field, text] in JavaScript. field: as `_checks` gives it."""
    known = tuple(getattr(error, "complaints", ()))
    complaint: Complaint = known[0] if known else complaint_of(str(error))
    if field and not known:
        whole = not field.endswith(".")
        complaint = Complaint(field, str(error)) if whole else complaint.about(field + complaint.field)
    text = ""
    for i, part in enumerate(complaint.text.split(HELD)):
        plain = part.replace("\\", "\\\\").replace("`", "\\`").replace("${", "\\${")
        text += f"${{f({part})}}" if i % 2 else plain
    return f"[{json.dumps(complaint.field)},`{text}`]"
