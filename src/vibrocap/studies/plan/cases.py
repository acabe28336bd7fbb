"""Lists of cases: each run with values of its own."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, shown, suggestion
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.physics.names import split_path
from vibrocap.studies.plan.runs import Block, Column, ListedRuns


@dataclasses.dataclass(frozen=True)
class CaseList(ListedRuns):
    """A list of cases, along the dimension "case"; where one has no value, the study's own case speaks."""

    columns: tuple[Column, ...]

    kind = "cases"
    listed = "columns"
    dim = "case"

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.columns[0].values),)

    def values(self, block: Block) -> dict[str, np.ndarray]:
        return {column.path: column.array[block[0]] for column in self.columns}

    def case(self, index: int) -> dict[str, float | str]:
        """What one case gives."""
        pairs = ((column.path, column.values[index]) for column in self.columns)
        return {path: value for path, value in pairs if value is not None}


def case_list(cases: Iterable[Any]) -> tuple[CaseList, list[str]]:
    """The list of such cases as {path: value, ...}, and what is wrong with it (whatever the paths stand for)."""
    rows: list[Mapping[str, Any]] = []
    complaints = Complaints()
    for number, case in enumerate(cases):
        if not isinstance(case, Mapping) or not case:
            complaints.add(f"cases[{number}]", f"should be {{path: value, ...}}, got {shown(case)}")
            continue
        row = {path: value.item() if isinstance(value, np.generic) else value for path, value in case.items()}
        rows.append(row)
        for path, value in row.items():
            if complaint := _complaint(path, value):
                complaints.add(f"cases[{number}]", f"{path}: {complaint}")
    if not rows and not complaints:
        complaints.add("cases", "there are none")
    if complaints:
        return CaseList(()), complaints
    paths = dict.fromkeys(path for row in rows for path in row)
    return CaseList(tuple(Column(path, tuple(_plain(row.get(path)) for row in rows)) for path in paths)), []


def _plain(value: Any) -> float | str | None:
    return value if value is None or isinstance(value, str) else float(value) + 0.0


def _complaint(path: Any, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return f"should be a number or a word, got {shown(value)}"
    if not isinstance(value, str) and not abs(value) < math.inf:
        return f"should be a finite number, got {value}"
    if is_kind(path) and value not in (known := list(kinds_of(split_path(path)[0]))):
        return f"there is no {shown(value)}; {suggestion(value, known)}"
    if str(path).startswith(INITIAL) and isinstance(value, str):
        return f"should be a number, got {shown(value)}"
    return ""
