"""Measured tables: conditions and measures of settled motions, as a laboratory writes them down."""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, listed, shown
from vibrocap.design.search.problem import measure_unit
from vibrocap.design.search.variables import twice
from vibrocap.measures.during_run import measure_table, near_measure
from vibrocap.measures.measure import Measure
from vibrocap.physics.dimensions.conversion import path_in_si, paths_in_si, quantity, quantity_in_si
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System
from vibrocap.records.reading.columns import bracketed
from vibrocap.records.reading.text import text_tables
from vibrocap.records.reading.units import suffix_unit, unit_named
from vibrocap.records.record import RecordError
from vibrocap.studies.plan.variation import path_complaints

ERROR = "_error"  # behind the name of a measure: the column of its standard errors
PERIOD, FREQUENCY = ".period", ".frequency"  # of a drive: a table may give either


@dataclasses.dataclass(frozen=True, eq=False)
class MeasuredTable:
    """A table of settled motions, a row each.

    conditions: columns [rows] by path; targets: measured values by name of the measure; errors: their standard errors,
    where none are given one that is the same for all rows: that of repeated rows, else the deviation of the column
    with_errors: whether they were given; alike: [rows] the first row of the same conditions
    """

    conditions: dict[str, np.ndarray]
    targets: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]
    with_errors: bool
    alike: np.ndarray

    @property
    def rows(self) -> int:
        return len(next(iter(self.targets.values())))

    @property
    def measures(self) -> tuple[str, ...]:
        return tuple(self.targets)

    def column(self, name: str) -> np.ndarray:
        """A condition or a target by name."""
        return self.conditions[name] if name in self.conditions else self.targets[name]

    def scatter(self, rows: np.ndarray) -> tuple[float, int]:
        """(sum of the squares, in standard errors, by which repeated rows differ from their mean, their freedom)."""
        places = [np.flatnonzero(self.alike[rows] == first) for first in np.unique(self.alike[rows])]
        ratios = [(self.targets[name] / self.errors[name])[rows] for name in self.targets]
        squares = sum(float(np.sum((ratio[k] - np.mean(ratio[k])) ** 2)) for ratio in ratios for k in places)
        return squares, (len(rows) - len(places)) * len(ratios)


def read_table(table: Any, system: System, complaints: Complaints) -> MeasuredTable | None:
    """The table in a CSV file, a data frame or a mapping of columns; None where complaints are added."""
    begun = len(complaints)
    known = measure_table(system)
    columns = _columns(table, system, known, complaints)
    if len(complaints) > begun:
        return None
    conditions, targets, errors = (dict[str, np.ndarray]() for _ in range(3))
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
    for path in conditions if len(complaints) == begun else ():
        known_in_si = quantity_in_si(path, system)
        if known_in_si.scale != 1.0 and quantity(path, system).unit == "1":
            complaints.add(path, f"has no unit in a case in SI; give {known_in_si.path}")
    starts = [path for path in conditions if path.startswith("initial.")]
    complaints += [Complaint(path, "a start is no condition; give it by `initial`") for path in starts]
    for name in errors:
        if name not in targets:
            complaints.add(name + ERROR, f"has no column {name} beside it")
    if not targets:
        complaints.add("table", "should have a column of a measure, such as mean_velocity")
    elif any(getattr(known[name].how, "text", False) for name in targets):
        complaints.add("table", "measures should be numbers; leave out 'mode_sequence'")
    if len(complaints) == begun and conditions and (again := twice([*conditions], system)):
        complaints.add(again[0], "is the same quantity as another column; give it once")
    if len(complaints) > begun:
        return None
    with_errors = set(errors) == set(targets)
    values = np.stack([*conditions.values(), np.zeros(len(next(iter(targets.values()))))], axis=1)
    _, first, group = np.unique(values, axis=0, return_index=True, return_inverse=True)
    group, spare = group.ravel(), len(values) - len(first)
    for name, column in targets.items():
        mean = np.bincount(group, column) / np.bincount(group)
        own = math.sqrt(float(np.sum((column - mean[group]) ** 2)) / spare) if spare else 0.0
        errors.setdefault(name, np.full(len(column), own or float(np.std(column)) or 1.0))
    return MeasuredTable(conditions, targets, errors, with_errors, first[group])


def _columns(table: Any, system: System, known: Mapping[str, Measure], complaints: Complaints) -> dict[str, np.ndarray]:
    """Columns of finite numbers by name, in the units of the case."""
    raw: Mapping[str, Any] = {}
    units: Mapping[str, str] = {}
    if isinstance(table, (str, Path)):
        name = repr(str(table))
        try:
            whole, *others = text_tables(Path(table))
            raw, units = whole.columns, whole.units
            wrong = [f"{name}: {fault}" for fault in whole.faults_in(raw)]
            if others or not whole.named:
                wrong = [f"{name} should be one table with a line of headings"]
        except RecordError as error:
            wrong = [f"{name}: {complaint}" for complaint in error.complaints]
        except (OSError, ValueError) as error:
            wrong = [f"{name} cannot be read ({error})"]
        if wrong:
            complaints += [Complaint("table", text) for text in wrong]
            return {}
    elif isinstance(table, Mapping) or hasattr(table, "columns"):
        names = table if isinstance(table, Mapping) else table.columns
        raw = {str(name): np.asarray(table[name]).tolist() for name in names}
    else:
        complaints.add("table", f"should be a CSV file, a data frame or a mapping of columns, got {shown(table)}")
        return {}
    columns: dict[str, np.ndarray] = {}
    for heading, values in raw.items():
        numbers = []
        for k, value in enumerate(values, start=1):
            try:
                number = float(value)
            except (TypeError, ValueError):
                number = math.nan
            if not math.isfinite(number):
                complaints.add(heading, f"should be finite numbers, got {shown(value)} in row {k}")
                break
            numbers.append(number)
        name, column = _in_units_of_case(heading, units.get(heading, ""), np.array(numbers), system, known, complaints)
        if name in columns:
            complaints.add(heading, f"is {name} once more; give it once")
        columns[name] = column
    lengths = {len(values) for values in columns.values()}
    if len(lengths) > 1 and not len(complaints):
        complaints.add("table", f"should have columns of one length, got {', '.join(map(str, sorted(lengths)))}")
    return columns


def _in_units_of_case(
    heading: str, unit: str, values: np.ndarray, system: System, known: Mapping[str, Measure], complaints: Complaints
) -> tuple[str, np.ndarray]:
    """(name, values) of a column as the case has it: from another unit in its heading or below it, from a period."""
    if system.units is None and heading.endswith(PERIOD) and np.all(values > 0.0):
        return heading.removesuffix(PERIOD) + FREQUENCY, 2.0 * math.pi / values
    parts = bracketed(heading) or ("", "")
    readings = [(heading, unit_named(unit)), (parts[0], unit_named(parts[1]))]
    readings += [(heading[:k], suffix_unit(heading[k + 1 :])) for k, mark in enumerate(heading) if mark == "_"]
    for stem, stated in ((stem, stated) for stem, stated in readings if stated is not None):
        names = list(_quantities(stem, system, known))
        for name, own, power in names:
            wanted = unit_named(own)
            if power < 0 and stated.dimension == "time" and np.all(values > 0.0):
                return name, 1.0 / (stated.factor * values)
            if power > 0 and wanted is not None and wanted.dimension == stated.dimension != "something else":
                return name, (stated.factor / wanted.factor) * values
        if names and heading not in [name for name, *_ in names]:
            complaints.add(heading, f"should be in {listed((own for _, own, _ in names), ' or ')}, got {stated.name}")
            return heading, values
    if heading.endswith(PERIOD):
        complaints.add(heading, "should be positive, and in SI have its unit, as drive.period_ms")
    return heading, values


def _quantities(stem: str, system: System, known: Mapping[str, Measure]) -> Iterator[tuple[str, str, int]]:
    """(name, unit, power) of what a heading without its unit may mean in a case; for a period, the frequency."""
    measure = stem.removesuffix(ERROR)
    if measure in known:
        yield stem, measure_unit(system, measure)[0], 1
    for path in paths_in_si(system.parts) if system.units is not None else ():
        plain, key = path_in_si(path, system.parts) or ("", None)
        section = split_path(path)[0]
        if key is not None and stem in (path, plain, f"{section}.{key.stem}"):
            yield path, key.unit, 1
        elif key is not None and plain == section + FREQUENCY and stem == section + PERIOD and key.unit == "Hz":
            yield path, "s", -1
