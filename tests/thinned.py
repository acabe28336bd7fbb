"""Values of a parametrised test of which only some are run each time: each costs much, and all pass one way."""

from collections.abc import Iterable, Sequence
from typing import Any

import pytest


def slow_but(fast: Iterable[int], values: Sequence[Any]) -> list:
    """The values, all but those at the places `fast` marked slow."""
    return _marked(pytest.mark.slow, fast, values)


def exhaustive_but(kept: Iterable[int], values: Sequence[Any]) -> list:
    """The values, all but those at the places `kept` marked exhaustive: run before a release."""
    return _marked(pytest.mark.exhaustive, kept, values)


def covering(rows: Sequence[tuple]) -> list[int]:
    """Places of few rows in which every value of every column stands: of its column, the next row has most new ones."""
    unseen = {(column, value) for row in rows for column, value in enumerate(row)}
    places = []
    while unseen:
        places.append(max(range(len(rows)), key=lambda i: len(unseen.intersection(enumerate(rows[i])))))
        unseen -= set(enumerate(rows[places[-1]]))
    return sorted(places)


def _marked(mark: pytest.MarkDecorator, without: Iterable[int], values: Sequence[Any]) -> list:
    places = set(without)
    assert places <= set(range(len(values)))
    return [value if i in places else _with(mark, value) for i, value in enumerate(values)]


def _with(mark: pytest.MarkDecorator, value: Any) -> Any:
    if isinstance(value, type(pytest.param())):  # with marks or a name of its own
        return value._replace(marks=[*value.marks, mark])
    values = value if isinstance(value, tuple) else (value,)
    return pytest.param(*values, marks=mark)
