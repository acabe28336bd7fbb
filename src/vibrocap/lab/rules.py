"""Rules between the numbers of a system, for a page: taken from the checks of its parts by running them.

A check runs on numbers that write down what becomes of them. Wherever it asks whether one is less than another, both
answers are followed, so that in the end every way through the check is known, with the questions that lead there and
what is said at its end. No rule is written twice, and a part of one's own brings its own.
"""

import json
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.arguments import ArgumentError, Complaint
from vibrocap.lab.written import HELD, Ways, Written, chosen, condition, text_of
from vibrocap.physics.closed_loop.sampling import SampledReference
from vibrocap.physics.drives.drive import Piecewise
from vibrocap.physics.parameters import complaint_of, parameter_table
from vibrocap.physics.system import System

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
    return "||".join(f"({'||'.join(dict.fromkeys(text))})&&{place}" for place, text in texts.items()) or "null"


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
    return "false" if len(cases) == MOST_CASES else chosen(cases)


def parts_of_period(system: System, paths: tuple[str, ...]) -> str:
    """How many equal parts the period of a drive with corners has, as an expression in JavaScript of the parameters."""
    timed = written_system(system, paths, Ways()).timed_drive
    return text_of(round(timed.parts)) if isinstance(timed, SampledReference) else "1"


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
