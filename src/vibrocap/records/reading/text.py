"""Tables of numbers in rows of cells: text with comma, semicolon, tab or space between them, and workbooks."""

import codecs
import contextlib
import csv
import re
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import lacking, shown
from vibrocap.inputs import read_input
from vibrocap.records.reading.arrays import check_plain, check_size
from vibrocap.records.reading.columns import RECORD, WHOLE, Table
from vibrocap.records.reading.units import DIMENSIONS, unit_named
from vibrocap.records.record import RecordError

COMMENTS = ("#", "%", "//", "!")
DELIMITERS = (";", "\t", "|", ",", None)  # None: any white space; a comma may be a decimal one, so it comes late
COMMA, POINT = (re.compile(rf"[+-]?\d*{mark}\d+([eE][+-]?\d+)?") for mark in (",", r"\."))  # numbers with each
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")  # so "1,234" may be, where a comma is also or never a delimiter
RUN = 3  # lines of numbers, one after the other, with which a table begins
MOST_COMPLAINTS = 5
MOST_BYTES = 2**30  # of a text

Row = tuple[int, list[str]]  # number of the line in the file, its cells
Wrong = tuple[int, str]  # number of the line in the file, what is wrong with it


def text_tables(path: Path, record_column: str | int | None = None) -> list[Table]:
    """The tables of a text file: one, or where a column says which record a row belongs to, one for each.

    Before the numbers may stand comments, the settings of an instrument, a header, and a line of units under it. Cells
    beyond the last column with content are left out, and so are rows without any. Columns of one name that differ are
    told apart by their places, "F #1" and "F #3". Lines that are ragged or hold no number in some column are the
    `faults` of a table: they count where that column is used. Raises RecordError where nothing can be read.
    """
    lines = _lines(path)
    comments = [(number, line.lstrip("#%/! ")) for number, line in lines if line.startswith(COMMENTS)]
    lines = [(number, line) for number, line in lines if not line.startswith(COMMENTS)]
    delimiter = _delimiter([line for _, line in lines])
    rows = _pointed(_rows(lines, delimiter), delimiter == ",")
    return _tables(rows, lambda: _rows(comments, delimiter), path, path.stem, record_column)


def workbook_tables(path: Path, record_column: str | int | None = None) -> list[Table]:
    """The tables of an Excel workbook, read as if its cells were those of a text: of each sheet that has one."""
    check_plain(path)
    if advice := lacking("openpyxl"):
        raise RecordError([f"is a workbook, which {advice}, or save it as .csv"], str(path))
    import openpyxl

    try:
        with zipfile.ZipFile(path) as archive:
            check_size(sum(info.file_size for info in archive.infolist()), path)
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = {
            sheet.title: [
                (number, ["" if cell is None else str(cell).strip() for cell in cells])
                for number, cells in enumerate(sheet.iter_rows(values_only=True), start=1)
                if any(cell is not None for cell in cells)
            ]
            for sheet in book.worksheets
        }
        book.close()
    except RecordError:
        raise
    except Exception:  # whatever a reader raises on damage
        raise RecordError(["cannot be read as .xlsx; save it anew, or as .csv"], str(path)) from None
    sheets = {name: rows for name, rows in sheets.items() if rows}
    if not sheets:
        raise RecordError(["is empty; should be a table, a sample in each line"], str(path))
    names = [path.stem] if len(sheets) == 1 else list(sheets)
    tables: list[Table] = []
    refusals: list[RecordError] = []
    for name, rows in zip(names, sheets.values(), strict=True):
        try:
            tables += _tables(_pointed(rows, True), list, path, name, record_column)
        except RecordError as error:
            refusals.append(error)
    if not tables:
        raise refusals[0]
    return tables


def _tables(
    rows: list[Row], comments: Callable[[], list[Row]], path: Path, whole: str, record_column: str | int | None
) -> list[Table]:
    """The tables in rows of cells; `whole` is the name of one that no column divides."""
    rows, usual, numeric = _shape(rows)

    def is_data(cells: Sequence[str]) -> bool:  # all are numbers, or half of those in columns of numbers
        if len(cells) != usual:
            return all(map(_is_number, cells))
        return 2 * sum(_is_number(cells[at]) for at in numeric) >= max(len(numeric), 1)

    data = [is_data(cells) for _, cells in rows]
    start = next((at for at in range(len(rows)) if all(data[at : at + RUN])), None)
    if start is None:
        reason = "there is no line of numbers in the file; should be a table, a sample in each line"
        raise RecordError([reason], str(path))
    body = rows[start:]
    while len(body[-1][1]) != usual and not any(map(_is_number, body[-1][1])):  # the words behind a table
        body.pop()
    head = rows[:start] or [row for row in comments() if row[0] < body[0][0]]
    names, units = _header(head, len(body[0][1]), numeric, bool(rows[:start]))
    count = len(names) if names else max(set(lengths := [len(cells) for _, cells in body]), key=lengths.count)
    narrow = [(number, len(cells)) for number, cells in body if len(cells) != count]
    ragged = [(number, f"line {number}: has {cells} cells; should have {count}") for number, cells in narrow]
    body = [row for row in body if len(row[1]) == count]
    if not body:
        raise RecordError(shortened([text for _, text in ragged]), str(path))
    order = [number for number, _ in body]
    columns = list(zip(*(row for _, row in body), strict=True))
    labels = _told_apart(names, columns) if names else list(map(str, range(len(columns))))
    cells = dict(zip(labels, columns, strict=True))
    of_record = _column_of_records(list(cells), record_column, path)
    which = np.array(cells.pop(of_record)) if of_record is not None else np.full(len(order), whole)
    arrays, strange = _numbers(cells, order)
    tables, faults = [], {WHOLE: ragged} | strange
    for name in dict.fromkeys(which.tolist()):
        own = np.flatnonzero(which == name)
        own_columns = {column: values[own] for column, values in arrays.items()}
        how = {"units": units, "place": lambda at, own=own: f"line {order[own[at]]}", "named": names is not None}
        tables.append(Table(str(name).strip(), str(path), own_columns, **how, faults=faults))
    return tables


def _column_of_records(names: list[str], wanted: str | int | None, path: Path) -> str | None:
    """The column that says which record a row belongs to: the one that is asked for, else one called "record"."""
    if isinstance(wanted, int) and 0 <= wanted < len(names):
        return names[wanted]
    column = next((name for name in names if name.lower() == str(RECORD if wanted is None else wanted).lower()), None)
    if column is None and wanted is not None:
        raise RecordError([f"columns: record: no column {wanted!r}; there is {', '.join(map(repr, names))}"], str(path))
    return column


def _lines(path: Path) -> list[tuple[int, str]]:
    """Lines that are not blank, stripped, with their numbers from 1."""
    try:
        raw = read_input(path, MOST_BYTES + 1)
    except TimeoutError as error:
        raise RecordError([str(error.strerror)], str(path)) from None
    if len(raw) > MOST_BYTES:
        raise RecordError([f"has more than {MOST_BYTES // 2**20} MB; give the records in several files"], str(path))
    wide = raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    if b"\x00" in raw[:4096] and not wide:
        raise RecordError(["is not a text file; should be .csv or .txt, .npz or .mat"], str(path))
    try:
        text = raw.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", errors="replace")  # the micro sign of older instruments
    if "\n" not in text:
        text = text.replace("\r", "\n")
    lines = [(number, line.strip(" \r\n")) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]
    if not lines:
        raise RecordError(["is empty; should be a table, a sample in each line"], str(path))
    return lines


def _delimiter(lines: Sequence[str]) -> str | None:
    """What separates cells: the first candidate with the same count, not 0, in nearly all lines of the end.

    A comma within numbers that white space separates is a decimal one.
    """
    last = lines[-50:]
    spaced = [cells for cells in map(str.split, last) if len(cells) > 1 and any(map(COMMA.fullmatch, cells))]
    if sum(all(_is_number(cell.replace(",", ".")) for cell in cells) for cells in spaced) >= 0.6 * len(last):
        return None
    for candidate in DELIMITERS[:-1]:
        counts = [line.count(candidate) for line in last]
        usual = max(set(counts), key=counts.count) if counts else 0
        if usual > 0 and counts.count(usual) >= 0.6 * len(counts):
            return candidate
    return None


def _rows(lines: Sequence[tuple[int, str]], delimiter: str | None) -> list[Row]:
    if delimiter is None:  # a unit in brackets belongs to the word before it
        return [(number, re.sub(r"(?<=\w)\s+(?=[\[({])", "", line).split()) for number, line in lines]
    cells = csv.reader((line for _, line in lines), delimiter=delimiter, skipinitialspace=True)
    try:
        split = [[cell.strip() for cell in row] for row in cells]
    except csv.Error:  # a carriage return within a line, or a cell without end
        split = []
    if len(split) != len(lines):  # or a quotation mark that is not closed runs over the end of its line
        split = [[cell.strip() for cell in line.split(delimiter)] for _, line in lines]
    return [(number, row) for (number, _), row in zip(lines, split, strict=True)]


def _pointed(rows: list[Row], ambiguous: bool) -> list[Row]:
    """Rows with points in place of decimal commas, where the end of a file has such and no points.

    A point elsewhere is then no decimal one. ambiguous: whether "1,234" may also be a thousand, so that commas are
    decimal ones only where others show it.
    """
    last = [cell for _, cells in rows[-50:] for cell in cells]
    commas = [cell for cell in last if COMMA.fullmatch(cell)]
    if any(map(POINT.fullmatch, last)) or (ambiguous and all(map(THOUSANDS.fullmatch, commas))):
        return rows

    def pointed(cell: str) -> str:
        if commas and POINT.fullmatch(cell):
            return f"{cell} among decimal commas"
        return cell.replace(",", ".") if COMMA.fullmatch(cell) else cell

    return [(number, [pointed(cell) for cell in cells]) for number, cells in rows]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _shape(rows: Sequence[Row]) -> tuple[list[Row], int, list[int]]:
    """(rows that are not empty, without the cells behind their last column; their usual width; columns of numbers).

    Told by the end of the file, where no instrument has written its settings.
    """
    rows = [(number, cells) for number, cells in rows if any(cells)]
    widths = [len(cells) for _, cells in rows[-50:]]
    wide = max(set(widths), key=widths.count) if widths else 0
    last = [cells for _, cells in rows[-50:] if len(cells) == wide]
    usual = max((at + 1 for cells in last for at, cell in enumerate(cells) if cell), default=0)
    trimmed = [
        (number, cells[:usual] if len(cells) == wide or not any(cells[usual:]) else cells) for number, cells in rows
    ]
    filled = [[_is_number(cells[at]) for cells in last if cells[at]] for at in range(usual)]
    return trimmed, usual, [at for at, numbers in enumerate(filled) if 2 * sum(numbers) >= max(len(numbers), 1)]


def _header(
    head: Sequence[Row], count: int, numeric: Sequence[int], written: bool
) -> tuple[list[str] | None, dict[str, str]]:
    """(names of the columns or None, unit by name) from the lines above the numbers; the nearest line counts."""
    wide = [
        cells
        for _, cells in head
        if len(cells) == count and (all(cells[at] for at in numeric if 0 < at < count) or _are_units(cells))
    ]
    if not wide or (not written and head[-1][1] != wide[-1]):
        return None, {}
    names, units = wide[-1], []
    if len(wide) > 1 and _are_units(wide[-1]):
        names, units = wide[-2], [re.sub(r"^[\[({<]|[\])}>]$", "", cell) for cell in wide[-1]]
    names = [name.strip("\"'") or f"column {at}" for at, name in enumerate(names)]
    return names, {name: unit for name, unit in zip(names, units, strict=False) if unit}


def _told_apart(names: Sequence[str], columns: Sequence[tuple[str, ...]]) -> list[str]:
    """The names; of columns that have one name but the first with the same cells, with their places."""
    labels: list[str] = []
    for at, name in enumerate(names):
        alike = [place for place, other in enumerate(names) if other == name]
        same = all(columns[place] == columns[at] for place in alike)
        labels.append(name if at == alike[0] and same else f"{name} #{at}" if len(alike) > 1 else name)
    return labels


def _are_units(cells: Sequence[str]) -> bool:
    """Whether all cells that are not empty are units, one at least of a quantity that a record has."""
    units = [unit_named(re.sub(r"^[\[({<]|[\])}>]$", "", cell)) for cell in cells if cell]
    return None not in units and any(unit.dimension in DIMENSIONS for unit in units if unit is not None)


def _numbers(cells: dict[str, tuple[str, ...]], order: Sequence[int]) -> tuple[dict[str, Any], dict[str, list[Wrong]]]:
    """The columns as numbers, nan where a cell is none or empty, and the cells that are no numbers by column."""
    columns, wrong = {}, {}
    for name, column in cells.items():
        with contextlib.suppress(ValueError):
            columns[name] = np.array(column).astype(np.float64)
        if name not in columns or "_" in "".join(column):  # Python takes 1_000 for a number
            columns[name] = np.array([float(cell) if _is_number(cell) else np.nan for cell in column])
            wrong[name] = [
                (number, f"line {number}, column {name!r}: {shown(cell)} is no number; should be one, nan or empty")
                for number, cell in zip(order, column, strict=True)
                if cell and not _is_number(cell)
            ]
    return columns, wrong


def shortened(complaints: Sequence[str]) -> list[str]:
    """So many complaints, and how many more there are."""
    more = len(complaints) - MOST_COMPLAINTS
    return [*complaints[:MOST_COMPLAINTS], *([f"and {more:,} more like these"] if more > 0 else [])]
