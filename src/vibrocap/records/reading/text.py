"""Tables of numbers in text files: comma, semicolon, tab or space between cells, with or without a header."""

import contextlib
import csv
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vibrocap.arguments import shown
from vibrocap.inputs import read_input
from vibrocap.records.checks import RecordError
from vibrocap.records.reading.columns import RECORD, Table
from vibrocap.records.reading.units import DIMENSIONS, unit_named

COMMENTS = ("#", "%", "//", "!")
DELIMITERS = (";", "\t", ",", None)  # None: any white space; a comma may be a decimal one, so it comes late
MOST_COMPLAINTS = 5
MOST_BYTES = 2**30  # of a text

Row = tuple[int, list[str]]  # number of the line in the file, its cells
Wrong = tuple[int, str]  # number of the line in the file, what is wrong with it


def text_tables(path: Path, record_column: str | int | None = None) -> list[Table]:
    """The tables of a text file: one, or where a column says which record a row belongs to, one for each.

    Before the numbers may stand comments, other lines, a header, and a line of units under it.
    Raises RecordError with the lines that are wrong: ragged, without a number, or text where a number should be.
    """
    lines = _lines(path)
    comments = [(number, line.lstrip("#%/! ")) for number, line in lines if line.startswith(COMMENTS)]
    lines = [(number, line) for number, line in lines if not line.startswith(COMMENTS)]
    delimiter = _delimiter([line for _, line in lines])
    decimal_comma = delimiter in (";", "\t") and not any(re.search(r"\d\.\d", line) for _, line in lines[-20:])
    rows = _rows(lines, delimiter)
    if decimal_comma:
        rows = [(number, [_pointed(cell) for cell in cells]) for number, cells in rows]
    widths = [len(cells) for _, cells in rows[-50:]]
    usual = max(set(widths), key=widths.count) if widths else 0
    start = next((at for at, (_, cells) in enumerate(rows) if _is_data(cells, usual)), None)
    if start is None:
        reason = "there is no line of numbers in the file; should be a table, a sample in each line"
        raise RecordError([reason], str(path))
    body = rows[start:]
    head = rows[:start] or _rows([row for row in comments if row[0] < body[0][0]], delimiter)
    names, units = _header(head, len(body[0][1]), bool(rows[:start]))
    twice = sorted({name for name in names or () if (names or []).count(name) > 1})
    if twice:
        found = f"the header names {', '.join(map(repr, twice))} more than once; should name each column differently"
        raise RecordError([found], str(path))
    body, ragged = _of_one_width(body, names)
    if not body:
        raise RecordError(_shortened([text for _, text in ragged]), str(path))
    order = [number for number, _ in body]
    columns = zip(*(row for _, row in body), strict=True)
    cells = dict(zip(names or map(str, range(len(body[0][1]))), columns, strict=True))
    of_record = _column_of_records(list(cells), record_column, path)
    which = np.array(cells.pop(of_record)) if of_record is not None else np.full(len(order), path.stem)
    columns, strange = _numbers(cells, order)
    if ragged or strange:
        raise RecordError(_shortened([text for _, text in sorted([*ragged, *strange])]), str(path))
    tables = []
    for name in dict.fromkeys(which.tolist()):
        rows_of = np.flatnonzero(which == name)
        tables.append(
            Table(
                name=str(name).strip(),
                source=str(path),
                columns={column: values[rows_of] for column, values in columns.items()},
                units=units,
                place=lambda at, rows_of=rows_of: f"line {order[rows_of[at]]}",
                named=names is not None,
            )
        )
    return tables


def _column_of_records(names: list[str], wanted: str | int | None, path: Path) -> str | None:
    """The column that says which record a row belongs to: the one that is asked for, else one called "record"."""
    if isinstance(wanted, int) and 0 <= wanted < len(names):
        return names[wanted]
    found = next((name for name in names if name.lower() == str(RECORD if wanted is None else wanted).lower()), None)
    if found is None and wanted is not None:
        raise RecordError([f"columns: record: no column {wanted!r}; there is {', '.join(map(repr, names))}"], str(path))
    return found


def _lines(path: Path) -> list[tuple[int, str]]:
    """Lines that are not blank, stripped, with their numbers from 1."""
    try:
        raw = read_input(path, MOST_BYTES + 1)
    except TimeoutError as error:
        raise RecordError([str(error.strerror)], str(path)) from None
    if len(raw) > MOST_BYTES:
        raise RecordError([f"has more than {MOST_BYTES // 2**20} MB; give the records in several files"], str(path))
    if b"\x00" in raw[:4096]:
        raise RecordError(["is not a text file; should be .csv or .txt, .npz or .mat"], str(path))
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", errors="replace")  # the micro sign of older instruments
    lines = [(number, line.strip(" \r\n")) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]
    if not lines:
        raise RecordError(["is empty; should be a table, a sample in each line"], str(path))
    return lines


def _delimiter(lines: Sequence[str]) -> str | None:
    """What separates cells: the first candidate with the same count, not 0, in nearly all lines of the end."""
    last = lines[-50:]
    for candidate in DELIMITERS[:-1]:
        counts = [line.count(candidate) for line in last]
        usual = max(set(counts), key=counts.count) if counts else 0
        if usual > 0 and counts.count(usual) >= 0.6 * len(counts):
            return candidate
    return None


def _rows(lines: Sequence[tuple[int, str]], delimiter: str | None) -> list[Row]:
    if delimiter is None:
        return [(number, line.split()) for number, line in lines]
    cells = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True)
    try:
        split = [[cell.strip() for cell in row] for row in cells]
    except csv.Error:  # a carriage return within a line, or a cell without end
        split = []
    if len(split) != len(lines):  # or a quotation mark that is not closed runs over the end of its line
        split = [[cell.strip() for cell in line.split(delimiter)] for _, line in lines]
    if all(row and row[-1] == "" for row in split):
        split = [row[:-1] for row in split]  # a delimiter at the end of each line
    return [(number, row) for (number, _), row in zip(lines, split, strict=True)]


def _pointed(cell: str) -> str:
    return cell.replace(",", ".") if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) else cell


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _is_data(cells: Sequence[str], usual: int) -> bool:
    """Whether a line belongs to the numbers: all of its cells are, or half of as many as lines usually have."""
    found = sum(map(_is_number, cells))
    return found == len(cells) > 0 or (len(cells) == usual and 2 * found >= usual)


def _header(head: Sequence[Row], count: int, written: bool) -> tuple[list[str] | None, dict[str, str]]:
    """(names of the columns or None, unit by name) from the lines above the numbers; the nearest line counts."""
    wide = [cells for _, cells in head if len(cells) == count and (all(cells) or _are_units(cells))]
    if not wide or (not written and head[-1][1] != wide[-1]):
        return None, {}
    names, units = wide[-1], []
    if len(wide) > 1 and _are_units(wide[-1]):
        names, units = wide[-2], [re.sub(r"^[\[({<]|[\])}>]$", "", cell) for cell in wide[-1]]
    names = [name.strip("\"'") for name in names]
    return names, {name: unit for name, unit in zip(names, units, strict=False) if unit}


def _are_units(cells: Sequence[str]) -> bool:
    """Whether all cells that are not empty are units, one at least of a quantity that a record has."""
    units = [unit_named(re.sub(r"^[\[({<]|[\])}>]$", "", cell)) for cell in cells if cell]
    return None not in units and any(unit.dimension in DIMENSIONS for unit in units if unit is not None)


def _of_one_width(body: Sequence[Row], names: list[str] | None) -> tuple[list[Row], list[Wrong]]:
    """The rows with as many cells as the table has columns, and what is wrong with the others."""
    count = len(names) if names else max(set(lengths := [len(cells) for _, cells in body]), key=lengths.count)
    wrong = [
        (number, f"line {number}: has {len(cells)} cells; should have {count}")
        for number, cells in body
        if len(cells) != count
    ]
    return [row for row in body if len(row[1]) == count], wrong


def _numbers(cells: dict[str, tuple[str, ...]], order: Sequence[int]) -> tuple[dict[str, np.ndarray], list[Wrong]]:
    """The columns as numbers, and the cells that are none."""
    columns, wrong = {}, []
    for name, column in cells.items():
        with contextlib.suppress(ValueError):
            columns[name] = np.array(column).astype(np.float64)
        if name not in columns or "_" in "".join(column):  # Python takes 1_000 for a number
            bad = [(number, cell) for number, cell in zip(order, column, strict=True) if not _is_number(cell)]
            for number, cell in bad:
                what = f"{shown(cell)} is no number" if cell else "the cell is empty"
                wrong.append((number, f"line {number}, column {name!r}: {what}; should be a number, or nan"))
    return columns, wrong


def _shortened(found: Sequence[str]) -> list[str]:
    more = len(found) - MOST_COMPLAINTS
    return [*found[:MOST_COMPLAINTS], f"and {more:,} more like these"] if more > 0 else list(found)
