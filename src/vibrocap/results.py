"""What results have in common: equal by value, short in a line, a small page in a notebook, at hand as tables.

A result is what the package gives back: a motion, an orbit, a branch, a fit. It is a frozen record. What rooms above
its own make of it (a picture, labelled arrays) are public functions; the methods here ask for them by name in
`vibrocap/__init__.py` when they are called. So no room imports one above it.
"""

import dataclasses
import enum
import html
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from vibrocap.quantities.declared import without_unit
from vibrocap.quantities.dimensional import Dimensional, view

if TYPE_CHECKING:
    import pandas
    import xarray

Record = TypeVar("Record", covariant=True)
MOST_ROWS = 20  # of a table in a notebook


def same(a: Any, b: Any) -> bool:
    """Whether two values of any type are equal: records, arrays, dictionaries, numbers.

    Arrays are equal element by element, with their shape; NaN equals NaN; fields of records that say `compare=False`
    do not count.
    """
    if a is b:
        return True
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        a, b = np.asarray(a), np.asarray(b)
        return np.array_equal(a, b, equal_nan=a.dtype.kind in "fc" and b.dtype.kind in "fc")
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        return len(a) == len(b) and all(map(same, a, b))
    if dataclasses.is_dataclass(a) and not isinstance(a, type) and type(a).__eq__ in (object.__eq__, Result.__eq__):
        return type(a) is type(b) and all(
            same(getattr(a, field.name), getattr(b, field.name)) for field in dataclasses.fields(a) if field.compare
        )
    return bool(a == b) or (isinstance(a, float) and isinstance(b, float) and a != a and b != b)


class Result(Dimensional):
    """A frozen record that is equal to another by value (see `same`) and shows itself in a few words.

    Make a subclass a dataclass with `eq=False, repr=False`; give it a `heading` and `facts` of its own where its
    members do not say best what it is.
    rows: name of the member whose elements are the rows of its table
    """

    rows: ClassVar[str] = ""

    @property
    def heading(self) -> str:
        """What it is, in a line."""
        return re.sub(r"(?<!^)(?=[A-Z])", " ", type(self).__name__).lower()

    @property
    def facts(self) -> dict[str, str]:
        """What matters most about it: a few words by name."""
        return {name: text for name, value in view(self).items() if (text := _in_words(name, value))}

    def table(self) -> list[dict[str, Any]]:
        """A dictionary for each row."""
        if not self.rows:
            raise TypeError(f"{self.heading}: has no rows")
        return Rows(getattr(self, self.rows)).table()

    def __eq__(self, other: object) -> bool:
        return same(self, other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        """Of the plain fields that count, so that equal results have one hash."""
        plain = (str, int, bool, enum.Enum, type(None))
        values = (getattr(self, field.name) for field in dataclasses.fields(self) if field.compare)  # type: ignore[arg-type]
        return hash((type(self).__qualname__, *(value for value in values if isinstance(value, plain))))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.heading}; {', '.join(self.facts.values())}>"

    def _repr_html_(self) -> str:
        """A heading, a small table and, where matplotlib is installed, a small picture: what a notebook shows."""
        import vibrocap

        left, rows = 'style="text-align:left"', ""
        for name, text in self.facts.items():
            rows += f"<tr><th {left}>{html.escape(name)}</th><td {left}>{html.escape(text)}</td></tr>"
        try:
            picture = vibrocap.thumbnail(self)
        except ImportError:  # matplotlib is not installed: the table alone
            picture = ""
        return f"<div><strong>{html.escape(self.heading)}</strong><table>{rows}</table>{picture}</div>"

    def to_xarray(self) -> "xarray.Dataset":
        """As labelled arrays, see `vibrocap.to_xarray`."""
        import vibrocap

        return vibrocap.to_xarray(self)

    def to_pandas(self) -> "pandas.DataFrame":
        """As a table, see `vibrocap.to_pandas`."""
        import vibrocap

        return vibrocap.to_pandas(self)


class Explained(enum.Enum):
    """What something is: each member is given as its value and its `meaning` in words."""

    _value_: str
    meaning: str

    def __new__(cls, value: str, meaning: str):
        """The member of that value."""
        member = object.__new__(cls)
        member._value_, member.meaning = value, meaning
        return member


class Advised(Explained):
    """The end of a computation; `advice` gives its meaning and the next step."""

    @property
    def advice(self) -> str:
        """Its meaning, and the next step."""
        return self.meaning


class Rows(tuple[Record, ...]):
    """Records of one kind, such as the events of a motion: a tuple that can be had as a table."""

    def table(self) -> list[dict[str, Any]]:
        """A dictionary for each record; values that it holds by name have columns of their own."""
        return [_flat(row) for row in self]

    def to_pandas(self) -> "pandas.DataFrame":
        """As a table, a row for each record, see `vibrocap.to_pandas`."""
        import vibrocap

        return vibrocap.to_pandas(self)

    def _repr_html_(self) -> str:
        rows = self.table()[:MOST_ROWS]
        names = list(rows[0]) if rows else []
        first: Any = self[0] if self else None
        units = {name: first.unit_of(name) if isinstance(first, Dimensional) else "1" for name in names}
        titles = (name if unit == "1" else f"{name} [{unit}]" for name, unit in units.items())
        head = "".join(f"<th>{html.escape(title)}</th>" for title in titles)
        body = "".join("<tr>" + "".join(f"<td>{_cell(row[name])}</td>" for name in names) + "</tr>" for row in rows)
        more = f"<p>and {len(self) - len(rows)} more</p>" if len(self) > len(rows) else ""
        return f"<table><tr>{head}</tr>{body}</table>{more}" if rows else "<p>none</p>"


def _flat(record: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    for name, member in view(record).items():
        for key, value in member.items() if isinstance(member, Mapping) else [(name, member)]:
            columns[key if key not in columns else f"{name}_{key}"] = without_unit(value)
    return columns | ({"unit": unit} if isinstance(unit := getattr(record, "unit", None), str) else {})


def _in_words(name: str, value: Any) -> str:
    """A number, a quantity or a word with its name, of a list how many; empty for what is more than that."""
    words = name.replace("_", " ")
    if isinstance(value, list):
        return f"{len(value)} {words}"
    plain = without_unit(value)
    return f"{words} {value:.8g}" if isinstance(plain, float) else f"{words} {value}" if isinstance(plain, str) else ""


def _cell(value: Any) -> str:
    return html.escape(f"{value:.8g}" if isinstance(value, float) else str(value))
