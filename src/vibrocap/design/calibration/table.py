"""Measured tables: conditions and measures of settled motions, as a laboratory writes them down."""

import csv
import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, shown
from vibrocap.design.search.goal import twice
from vibrocap.inputs import read_input
from vibrocap.measures.during_run import measure_table, near_measure
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import path_complaints

ERROR = "_error"  # behind the name of a measure: the column of its standard errors
LARGEST = 2**26  # bytes of a file


@dataclasses.dataclass(frozen=True, eq=False)
class MeasuredTable:
    """A table of settled motions, a row each.

    conditions: columns [rows] by path; targets: measured values by name of the measure; errors: their standard errors,
    where none are given one that is the same for all rows; with_errors: whether they were given
    """

    conditions: dict[str, np.ndarray]
    targets: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]
    with_errors: bool

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.targets.values())))

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures."""
        return tuple(self.targets)

    def column(self, name: str) -> np.ndarray:
        """A condition or a target by name."""
        return self.conditions[name] if name in self.conditions else self.targets[name]


def read_table(given: Any, system: System, complaints: Complaints) -> MeasuredTable | None:
    """The table in a CSV file, a data frame or a mapping of columns; None where complaints are added."""
    begun = len(complaints)
    columns = _columns(given, complaints)
    if len(complaints) > begun:
        return None
    known = measure_table(system)
    conditions: dict[str, np.ndarray] = {}
    targets: dict[str, np.ndarray] = {}
    errors: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        if name in known:
            targets[name] = values
        elif name.endswith(ERROR) and name.removesuffix(ERROR) in known:
            errors[name.removesuffix(ERROR)] = values
            if not np.all(values > 0.0):
                row = int(np.argmax(~(values > 0.0)))
                complaints.add(name, f"should be positive standard errors, got {values[row]:g} in row {row + 1}")
        elif "." in name:
            conditions[name] = values
        else:
            complaints.add(name, f"is no parameter and no measure of this case; {near_measure(name, known)}")
    complaints += path_complaints(conditions, [system.parts], system.units)
    complaints += [Complaint(path, "a start is no condition; give it by `initial`") for path in conditions
                   if path.startswith("initial.")]  # fmt: skip
    for name in errors:
        if name not in targets:
            complaints.add(name + ERROR, f"has no column {name} beside it")
    if not targets:
        complaints.add("table", "should have a column of a measure, such as mean_velocity")
    elif any(getattr(known[name].how, "text", False) for name in targets):
        complaints.add("table", "measures should be numbers; leave out 'mode_sequence'")
    if len(complaints) == begun and conditions and (again := twice([*conditions], system)):
        complaints.add(again, "is the same quantity as another column; give it once")
    if len(complaints) > begun:
        return None
    with_errors = set(errors) == set(targets)
    for name, values in targets.items():
        errors.setdefault(name, np.full(len(values), float(np.std(values)) or 1.0))
    return MeasuredTable(conditions, targets, errors, with_errors)


def _columns(given: Any, complaints: Complaints) -> dict[str, np.ndarray]:
    """Columns of finite numbers by name."""
    if isinstance(given, (str, Path)):
        try:
            text = read_input(Path(given), LARGEST).decode("utf-8-sig")
            rows = list(csv.reader(line for line in text.splitlines() if line.strip() and not line.startswith("#")))
        except (OSError, ValueError, csv.Error) as error:
            complaints.add("table", f"{str(given)!r} cannot be read ({error})")
            return {}
        if len(rows) < 2:
            complaints.add("table", f"{str(given)!r} should have a line of headings and a line for each row")
            return {}
        headings = [each.strip() for each in rows[0]]
        uneven = [k for k, row in enumerate(rows[1:], start=2) if len(row) != len(headings)]
        if uneven:
            complaints.add(
                "table", f"line {uneven[0]} has {len(rows[uneven[0] - 1])} values, the headings are {len(headings)}"
            )
            return {}
        raw: Mapping[str, Any] = {name: [row[i] for row in rows[1:]] for i, name in enumerate(headings)}
        if len(raw) < len(headings):
            complaints.add("table", f"has a heading twice: {', '.join(headings)}")
    elif isinstance(given, Mapping) or hasattr(given, "columns"):
        names = given if isinstance(given, Mapping) else given.columns
        raw = {str(name): np.asarray(given[name]).tolist() for name in names}
    else:
        complaints.add("table", f"should be a CSV file, a data frame or a mapping of columns, got {shown(given)}")
        return {}
    found: dict[str, np.ndarray] = {}
    for name, values in raw.items():
        numbers = []
        for k, value in enumerate(values, start=1):
            try:
                number = float(value)
            except (TypeError, ValueError):
                number = math.nan
            if not math.isfinite(number):
                complaints.add(name, f"should be finite numbers, got {shown(value)} in row {k}")
                break
            numbers.append(number)
        found[name] = np.array(numbers)
    lengths = {len(values) for values in found.values()}
    if len(lengths) > 1 and not len(complaints):
        complaints.add("table", f"should have columns of one length, got {', '.join(map(str, sorted(lengths)))}")
    return found
