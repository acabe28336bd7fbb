"""Checks of arguments: complaints name the field and a correct value, and suggest the nearest known name."""

import contextlib
import difflib
import importlib.util
import math
import numbers
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


class Complaint(str):
    """What is wrong with one field.

    It reads "field: text" and keeps the two apart, so that whoever passes it on can give the field the name under which
    the user knows it: a parameter of Python, a key of a case file, an option of a command.
    """

    field: str
    text: str

    def __new__(cls, field: str, text: str) -> "Complaint":
        """The complaint as one line."""
        self = super().__new__(cls, f"{field}: {text}")
        self.field, self.text = field, text
        return self

    def __reduce__(self):
        return type(self), (self.field, self.text)

    @staticmethod
    def read(text: str) -> str:
        """The complaint of a text "field: ...", whose field is a name or names; any other text as it is."""
        field, colon, rest = text.partition(": ")
        names = [part.strip() for part in field.split(",")]
        return Complaint(field, rest) if colon and all(map(str.isidentifier, names)) else text

    def about(self, field: str) -> "Complaint":
        """The same under another name of the field."""
        return Complaint(field, self.text)


class Complaints(list[str]):
    """Complaints, collected for one message."""

    def add(self, field: str, text: str) -> None:
        """One more complaint."""
        self.append(Complaint(field, text))

    @contextlib.contextmanager
    def collected(self) -> Iterator[None]:
        """What the `with` block raises with `complaints`, as all refusals of this package do, is collected too."""
        try:
            yield
        except ValueError as error:
            if not (complaints := getattr(error, "complaints", ())):
                raise
            self.extend(complaints)


class Refusal(ValueError):
    """Input that cannot be used: each complaint names a field, such as an option of a command, and a correct value."""

    def __init__(self, *complaints: str):
        super().__init__("\n".join(complaints))
        self.complaints = complaints


def by_option(complaints: Iterable[str], options: Mapping[str, str]) -> list[str]:
    """The same complaints, with options in place of the fields that they set; options: their names by field."""
    known = ((text, options.get(text.field) if isinstance(text, Complaint) else None) for text in complaints)
    return [text.about(name) if name is not None and isinstance(text, Complaint) else text for text, name in known]


class ArgumentError(ValueError):
    """An argument that cannot be used; `complaint` has its name and the reason."""

    def __init__(self, field: str, text: str):
        super().__init__(f"{field} {text}" if text.startswith("should") else f"{field}: {text}")
        self.complaint = Complaint(field, text)
        self.complaints = (self.complaint,)

    def __reduce__(self):
        return type(self), (self.complaint.field, self.complaint.text)


@contextlib.contextmanager
def complaints_of(originals: Mapping[str, Any], checked: Mapping[str, Any]) -> Iterator[None]:
    """What the `with` block says of arguments that were converted, with their originals; both by name."""
    try:
        yield
    except ArgumentError as error:
        name, complaint = re.split(r"\W", error.complaint.field)[0], error.complaint
        text = restated(complaint.text, checked.get(name), originals.get(name))
        if text == complaint.text:
            raise
        raise type(error)(complaint.field, text) from error


class SettingError(ArgumentError):
    """An environment variable that cannot be used."""


def suggestion(
    name: object, known: Iterable[object], cutoff: float = 0.6, there_is: str = "there is", last: str = ", "
) -> str:
    """The nearest known name, or all of them where none is as near as `cutoff` asks (0: one always is)."""
    names = [str(name) for name in known]
    near = difflib.get_close_matches(str(name), names, n=1, cutoff=cutoff)
    return f"did you mean {near[0]!r}?" if near else f"{there_is} {listed(names, last) or 'none'}"


def listed(names: Iterable[object], last: str = ", ") -> str:
    """Names with commas between, and `last`, such as " or ", before the last one."""
    *first, end = ["", *map(str, names)]
    return last.join(filter(None, (", ".join(first[1:]), end)))


def shown(value: object) -> str:
    """A value as it stands in a complaint, not longer than a line can hold."""
    try:
        text = repr(value)
    except RecursionError:  # sections in sections in sections
        return f"{type(value).__name__} nested too deeply to be shown"
    return text if len(text) <= 60 else f"{text[:40]}...{text[-15:]}"


def restated(text: str, checked: Any, original: Any) -> str:
    """A complaint that ends with the value, or one of several, that was checked: with the original in its place."""
    before, got, _ = text.rpartition(f", got {shown(checked)}")
    if got:
        return f"{before}, got {shown(original)}"
    pair = [list(value.values()) if isinstance(value, Mapping) else value for value in (checked, original)]
    if all(isinstance(value, (list, tuple)) for value in pair):
        for values in zip(*pair, strict=False):
            text = restated(text, *values)
    return text


def is_number(value: Any) -> bool:
    """Whether a value is a real number, of Python or of NumPy, and no truth value."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def is_whole(value: Any, least: float = -math.inf, most: float = math.inf) -> bool:
    """Whether a value is a whole number within limits, by its type and not only by its size."""
    return isinstance(value, numbers.Integral) and not isinstance(value, bool) and least <= int(value) <= most


def check_whole(field: str, value: Any, least: int, most: float = math.inf, of: str = "") -> None:
    """ArgumentError for a value that is no whole number within limits. of: the counted objects, as " of periods"."""
    if not is_whole(value, least, most):
        limits = f">= {least}" if most >= 2**62 - 1 else f"from {least} to {most}"
        raise ArgumentError(field, f"should be a whole number{of} {limits}, got {shown(value)}")


def is_positive(value: Any) -> bool:
    """Whether a value is a finite number above zero."""
    return is_number(value) and 0.0 < value < math.inf


def check_mapping(field: str, value: Any, such_as: str) -> None:
    """ArgumentError for a value that has no names and values."""
    if not isinstance(value, Mapping):
        raise ArgumentError(field, f"should be a mapping such as {such_as}, got {shown(value)}")


def check_one_of(field: str, value: Any, known: Iterable[str]) -> None:
    """ArgumentError for an unknown word."""
    if value not in (names := tuple(known)):
        raise ArgumentError(field, f"should be one of {listed(names)}, got {shown(value)}")


def check_choice(field: str, value: Any) -> None:
    """ArgumentError for a value that is neither True nor False."""
    if not isinstance(value, bool):
        raise ArgumentError(field, f"should be True or False, got {shown(value)}")


def check_threshold(field: str, value: Any) -> None:
    """ArgumentError for a value that is neither None nor a threshold of settling."""
    if value is not None and not is_positive(value):
        raise ArgumentError(field, f"should be None or a positive threshold such as 1e-6, got {shown(value)}")


def lacking(*packages: str) -> str:
    """A message for missing packages, with the command that installs them; empty where none is missing."""
    missing = [package for package in packages if importlib.util.find_spec(package) is None]
    if not missing:
        return ""
    python = f'"{sys.executable}"' if " " in sys.executable else sys.executable or "python"
    return f"needs {listed(missing, ' and ')}; install with: {python} -m pip install {_installed_by(missing)}"


def _installed_by(missing: list[str]) -> str:
    """What pip installs for packages: the smallest extras of this package that bring them, else their own names."""
    from importlib.metadata import requires

    extras: dict[str, set[str]] = {}
    for line in requires("vibrocap") or ():
        if brought := re.match(r"""([\w.-]+).*extra == ['"](.+)['"]""", line):
            extras.setdefault(brought[2], set()).add(brought[1])
    by_size, installed, rest = sorted(extras, key=lambda extra: len(extras[extra])), [], set(missing)
    smallest = {next((extra for extra in by_size if package in extras[extra]), "") for package in missing} - {""}
    for extra in sorted(smallest, key=by_size.index, reverse=True):  # a large one may bring what a small one would
        if extras[extra] & rest:
            installed, rest = [*installed, extra], rest - extras[extra]
    return " ".join([*([f'"vibrocap[{",".join(sorted(installed))}]"'] if installed else []), *sorted(rest)])


def require(what: str, *packages: str) -> None:
    """ModuleNotFoundError with the command that installs them, where packages are missing that `what` needs."""
    if refusal := lacking(*packages):
        raise ModuleNotFoundError(f"{what} {refusal}")
