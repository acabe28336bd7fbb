"""A table of cases as a CSV file: a row of paths, then a row of values for each run."""

import csv
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints
from vibrocap.case.case import CaseError
from vibrocap.inputs import read_input

LARGEST = 2**28  # bytes


@dataclasses.dataclass(frozen=True)
class CaseTable:
    """The cases of a table, {path: value} each, and the line in which each stands."""

    rows: tuple[Mapping[str, Any], ...]
    lines: tuple[int, ...]


def read_cases(path: Path) -> CaseTable:
    """The cases of a table: paths in its first row, then a case in each; what is empty is as usual.

    Lines that begin with # are passed over. Raises CaseError with every complaint at once.
    """
    try:
        raw = read_input(path, LARGEST + 1)
        text = raw.decode("utf-8-sig") if len(raw) <= LARGEST else ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not a text file in UTF-8"
        raise CaseError([f"--cases: {path}: {reason}"], str(path)) from None
    if len(raw) > LARGEST:
        raise CaseError([f"--cases: {path}: should be at most {LARGEST // 2**20} MB"], str(path))
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    cells, reader = [], csv.reader(line for _, line in numbered)
    try:
        cells += [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        line = numbered[reader.line_num - 1][0]
        raise CaseError([f"--cases: {path}, line {line}: is no row of a table ({error})"], str(path)) from None
    complaints = Complaints()
    if len(cells) != len(numbered):
        raise CaseError([f"--cases: {path}: a quotation mark is not closed in its line"], str(path))
    if len(cells) < 2:
        wanted = "a row of paths, such as machine.mass_ratio, and a row for each case"
        raise CaseError([f"--cases: {path}: should hold {wanted}"], str(path))
    paths = cells[0]
    for name in dict.fromkeys(name for name in paths if paths.count(name) > 1):
        complaints.add("--cases", f"{path}: {name} heads two columns")
    cases, lines = [], []
    for (number, _), row in zip(numbered[1:], cells[1:], strict=True):
        if len(row) != len(paths):
            complaints.add("--cases", f"{path}, line {number}: has {len(row)} values under {len(paths)} paths")
        elif not any(row):
            complaints.add("--cases", f"{path}, line {number}: gives no value")
        else:
            cases.append({name: _number_or_word(cell) for name, cell in zip(paths, row, strict=True) if cell})
            lines.append(number)
    if complaints:
        raise CaseError(complaints, str(path))
    return CaseTable(tuple(cases), tuple(lines))


def _number_or_word(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
