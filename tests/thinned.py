"""Values of a parametrised test of which only some are fast: each compiles kernels of its own, and all pass one way."""

from collections.abc import Iterable, Sequence
from typing import Any

import pytest


def slow_but(fast: Iterable[int], values: Sequence[Any]) -> list:
    """The values, all but those at the places `fast` marked slow."""
    kept = set(fast)
    assert kept <= set(range(len(values)))
    return [value if i in kept else _slow(value) for i, value in enumerate(values)]


def _slow(value: Any) -> Any:
    if isinstance(value, type(pytest.param())):  # with marks or a name of its own
        return value._replace(marks=[*value.marks, pytest.mark.slow])
    values = value if isinstance(value, tuple) else (value,)
    return pytest.param(*values, marks=pytest.mark.slow)
