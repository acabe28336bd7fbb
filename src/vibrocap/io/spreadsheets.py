"""Results for other programs: NetCDF, CSV with its description beside it, Excel workbooks, MATLAB files."""

import io
import itertools
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vibrocap.arguments import ArgumentError, listed, require
from vibrocap.files import fill_table, no_formula, replacing, write_text
from vibrocap.io.netcdf import write_netcdf
from vibrocap.physics.dimensions.units import suffix

if TYPE_CHECKING:
    import xarray

BESIDE = ".toml"  # behind the whole name of a CSV file: what is known of its table
HEADED = (".csv", ".xlsx")  # what has headings
WITHOUT = ("1", "", "dimensionless")  # what is said of a quantity without a unit
LONGEST_NAME = 63  # of a variable in MATLAB
MATLAB = b"MATLAB 5.0 MAT-file, written by vibrocap".ljust(116)
CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")  # characters that XML does not hold
ROWS, COLUMNS = 1_048_576, 16_384  # of a sheet in Excel


class Export:
    """A result as other programs read it: a table, its description, and its case.

    what, sheet: what it is called, and its rows in a workbook
    units, meanings: by column; scales: the same of what one dimensionless unit is; facts: of the whole, by name
    case: in TOML; size: rows of the longest table
    """

    what: ClassVar[str]
    sheet: ClassVar[str]
    units: Mapping[str, str]
    meanings: Mapping[str, str]
    scales: Mapping[str, float] = MappingProxyType({})
    facts: Mapping[str, str]
    case: str
    size: int

    def parts(self) -> Iterable[Sequence[list]]:
        """The columns of some rows at a time."""
        raise NotImplementedError

    def rows(self) -> Iterable[Sequence[Any]]:
        """In the order of the columns."""
        return itertools.chain.from_iterable(zip(*part, strict=True) for part in self.parts())

    def sheets(self) -> Mapping[str, tuple[Sequence[str], Iterable[Iterable[Any]]]]:
        """Further sheets of a workbook, by name: (headings, rows)."""
        return {}

    def arrays(self) -> dict[str, Any]:
        """Variables and structs of a MATLAB file."""
        raise NotImplementedError

    def dataset(self) -> "xarray.Dataset":
        """Labelled arrays."""
        raise NotImplementedError

    def write(self, path: str | Path, unit_headings: bool) -> Path:
        """Write it to a file ending in .nc, .csv, .xlsx or .mat, whole or not at all.

        Raises ValueError for another ending, WriteError where it cannot be written.
        """
        path = Path(path)
        writers = {".nc": self._netcdf, ".csv": self._csv, ".xlsx": self._workbook, ".mat": self._matlab}
        if path.suffix.lower() not in writers:
            raise ValueError(f"a {self.what} is written to {listed(writers, ' or ')}, not to {str(path)!r}")
        writers[path.suffix.lower()](path, _headed(self.units, path, unit_headings))
        return path

    def _netcdf(self, path: Path, _headings: list[str]) -> None:
        write_netcdf(self.dataset(), path)

    def _csv(self, path: Path, headings: list[str]) -> None:
        """The table, which begins with its headings; what is known of it goes into a file of TOML beside it.

        The table takes its place last: where either cannot be written, the table that is there stays. Nothing goes
        beside a pipe.
        """
        alone = path.exists() and not path.is_file()
        with replacing(path) as temporary:
            parts = (zip(*map(_cells, part), strict=True) for part in self.parts())
            fill_table(temporary, headings, itertools.chain.from_iterable(parts))
            if not alone:
                write_text(beside(path), "".join(f"{line}\n" for line in self._known()))

    def _known(self) -> list[str]:
        """Lines of TOML: the case, and the section [result]."""
        lines = [*self.case.splitlines(), "", "[result]", *(f"{key} = '''{x}'''" for key, x in self.facts.items())]
        lines += ["", "[result.units]", *(f'{_key(name)} = "{unit}"' for name, unit in self.units.items())]
        if self.scales:
            lines += ["", "[result.dimensionless_unit]", *(f"{_key(name)} = {x!r}" for name, x in self.scales.items())]
        return [*lines, "", "[result.meaning]", *(f"{_key(name)} = '''{x}'''" for name, x in self.meanings.items())]

    def _workbook(self, path: Path, headings: list[str]) -> None:
        """Sheets with the table and what else there is, what the columns mean, and the case."""
        known = [(name, unit, self.meanings[name]) for name, unit in self.units.items()]
        known += [(key, "", fact) for key, fact in self.facts.items()]
        sheets = {self.sheet: (headings, self.rows()), **self.sheets(), "columns": (("name", "unit", "meaning"), known)}
        case = ((line,) for line in self.case.splitlines())
        write_workbook(path, {**sheets, "case": (("case",), case)}, self.size)

    def _matlab(self, path: Path, _headings: list[str]) -> None:
        """Its arrays as variables; structs with units, meanings and what is known; the case."""
        about = {"units": self.units, "meaning": self.meanings, "result": self.facts, "case_toml": self.case}
        write_matlab(path, self.arrays() | about)


def _key(name: str) -> str:
    return f'"{name}"' if "." in name else name


def _cells(column: list) -> list:
    if {int, float}.issuperset(map(type, column)):
        return column
    return [str(value).lower() if isinstance(value, bool) else no_formula(value) for value in column]


def _headed(units: Mapping[str, str], path: Path, with_units: bool) -> list[str]:
    """The headings of a table: names, with their units behind them where that is asked for ("position [m]").

    A path such as drive.frequency_Hz has its unit already.
    Raises ArgumentError for a file without headings.
    """
    if with_units and path.suffix.lower() not in HEADED:
        there = f"in a {path.suffix} file the units are there anyway"
        raise ArgumentError("unit_headings", f"is for tables with headings ({' and '.join(HEADED)}); {there}")
    plain = {name for name, unit in units.items() if unit in WITHOUT or name.endswith(suffix(unit))}
    return [f"{name} [{unit}]" if with_units and name not in plain else name for name, unit in units.items()]


def beside(path: Path) -> Path:
    """Where the case and the meaning of the columns of a CSV file are."""
    return path.with_name(path.name + BESIDE)


def write_workbook(
    path: Path, sheets: Mapping[str, tuple[Sequence[str], Iterable[Iterable[Any]]]], longest: int
) -> None:
    """An Excel workbook; sheets: by name, (headings, rows), of which none has more rows than `longest`.

    Raises ValueError for more rows than a sheet holds.
    """
    require("a workbook", "openpyxl")
    widest = max(len(headings) for headings, _ in sheets.values())
    if longest >= ROWS or widest > COLUMNS:
        limits = f"{ROWS:,} rows and {COLUMNS:,} columns"
        raise ValueError(f"{str(path)!r}: a sheet of Excel has at most {limits}; write a .csv or .nc")
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    for name, (headings, rows) in sheets.items():
        sheet = book.create_sheet(name)
        sheet.freeze_panes = "A2"
        sheet.append([_cell(heading) for heading in headings])
        for row in rows:
            sheet.append([_cell(value) for value in row])
    memory = io.BytesIO()
    book.save(memory)
    with replacing(path) as temporary, zipfile.ZipFile(memory) as dated, zipfile.ZipFile(temporary, "w") as file:
        for name in dated.namelist():  # without the times at which it was written: the same results give the same bytes
            content = re.sub(rb"(<dcterms:\w+[^>]*>)[^<]*", rb"\g<1>1980-01-01T00:00:00Z", dated.read(name))
            file.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)


def write_matlab(path: Path, variables: Mapping[str, Any]) -> None:
    """A MATLAB file (level 5). Dots and other signs in names become underscores; text becomes char or cell arrays."""
    from scipy.io import savemat  # takes long to load

    memory = io.BytesIO()
    arrays = {_name(name): _matlab(value) for name, value in variables.items()}
    savemat(memory, arrays, long_field_names=True, do_compression=True, oned_as="column")
    data = memory.getbuffer()
    data[: len(MATLAB)] = MATLAB  # in place of the date: the same results give the same bytes
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def _matlab(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {_name(name): _matlab(element) for name, element in value.items()}
    array = np.asarray(value)
    return array.astype(object) if array.dtype.kind in "UO" and array.ndim else array


def _name(name: str) -> str:
    word = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)
    return (word if word[:1].isalpha() else f"x{word}")[:LONGEST_NAME]


def _cell(value: Any) -> Any:
    """A value as Excel takes it: no NaN or infinity, which it has not; no formula, and no sign that XML has not."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str):
        return CONTROL.sub(lambda match: match[0].encode("unicode_escape").decode(), no_formula(value))
    return None if isinstance(value, float) and value != value else str(value) if value in (np.inf, -np.inf) else value
