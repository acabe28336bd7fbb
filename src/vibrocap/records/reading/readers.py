"""Records from files: CSV, TXT, NPZ and MAT, with columns named and units given, or guessed and said."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import is_positive
from vibrocap.records.checks import RecordError, complaints
from vibrocap.records.reading.arrays import npz_tables
from vibrocap.records.reading.columns import RECORD, Table, choices, notes, setting_complaints, turns, values_in_si
from vibrocap.records.reading.matlab import mat_tables
from vibrocap.records.reading.text import shortened, text_tables
from vibrocap.records.reading.units import base_quantity
from vibrocap.records.record import COLUMNS, Record

READERS: dict[str, Callable[..., list[Table]]] = {".npz": npz_tables, ".mat": mat_tables}
SETTINGS = "the settings for reading"
TEXT = (".csv", ".txt", ".tsv", ".dat", "")
INTERVALS = ("dt", "ts", "sampling_interval")  # names of a sampling interval beside the columns
RATES = ("fs", "sampling_rate", "rate", "sampling_frequency")


def read_records(
    path: str | Path | Sequence[str | Path],
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    *,
    name: str | None = None,
    dt: float | None = None,
    sampling_rate: float | None = None,
    normal_force: float | None = None,
    area: float | None = None,
) -> list[Record]:
    """The measured records in a file, or in several: force with velocity, displacement or both.

    What a column is, `columns` says; else it is guessed from its usual names (t, time_s, F, force [kN], x,
    displacement_mm, v, vel_m_per_s, torque [N m], angle_deg, ...) and each record's `notes` say what was guessed. A
    unit is taken from `units`, else from the heading or a line of units under it; one that cannot be read is refused.
    Where none is said it is SI, and `guessed_units` says so.

    path: .csv, .txt, .tsv, .dat, .npz or .mat, or a list of such
    columns: quantity -> name of its column (or its place, counted from 0), for instance {"force": "F1"}; the quantities
        are time, force, velocity, displacement, acceleration, normal_force, and of a contact that turns torque,
        angular_velocity, angle, angular_acceleration; "record" names the column of a text file that says which record
        a row belongs to
    units: quantity -> unit, for instance {"force": "kN", "displacement": "mm"}
    name: of the record, where there is one [default: the file's name, or the record's name in it]
    dt, sampling_rate: s or Hz, where there is no column of time
    normal_force: N, where there is no such column; a friction coefficient is multiplied by it
    area: m^2, for forces given as stresses

    Several records in one file: text with a column "record"; in NPZ and MAT see `vibrocap.records.reading.arrays`.
    Returns the records in the order of the file. Raises RecordError with every complaint, with lines where the file has
    them; FileNotFoundError. Warns with RecordWarning where a unit looks wrong.
    """
    for field, given in (("columns", columns), ("units", units)):
        if given is not None and not isinstance(given, Mapping):
            wanted = "{'force': 'kN'}" if field == "units" else "{'force': 'F'}"
            raise RecordError([f"{field}: should be a mapping such as {wanted}, got {given!r}"], SETTINGS)
    columns, units = dict(columns or {}), dict(units or {})
    wrong = setting_complaints(columns, units)
    for field, value in (("dt", dt), ("sampling_rate", sampling_rate), ("normal_force", normal_force), ("area", area)):
        if value is not None and not is_positive(value):
            wrong.append(f"{field}: should be a number greater than 0, got {value!r}")
    if dt is not None and sampling_rate is not None:
        wrong.append("dt, sampling_rate: give one of them, got both")
    if wrong:
        raise RecordError(wrong, SETTINGS)
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(each) for each in path]
    if not paths:
        raise RecordError(["path: should be a file or a list of files, got an empty list"], SETTINGS)
    record_column = columns.get(RECORD)
    tables = [table for each in paths for table in _tables(each, record_column)]
    if name is not None and len(tables) > 1:
        found = ", ".join(table.name for table in tables)
        raise RecordError([f"name: is for one record, but there are {len(tables)}: {found}"], _said(paths))
    interval = dt if dt is not None else None if sampling_rate is None else 1.0 / sampling_rate
    read = []
    for table, label in zip(tables, [name] if name is not None else _names(tables), strict=True):
        fields = _fields(table, columns, units, interval, normal_force, area, wrong)
        if fields is not None:
            read.append({"name": label, **fields})
    if wrong:
        raise RecordError(dict.fromkeys(wrong), _said(paths))
    return [Record(**fields) for fields in read]


def _said(paths: Sequence[Path]) -> str:
    return str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"


def _tables(path: Path, record_column: str | int | None) -> list[Table]:
    kind = path.suffix.lower()
    if kind not in (*TEXT, *READERS):
        raise RecordError([f"ends in {path.suffix!r}; should be {', '.join(TEXT[:-1])}, .npz or .mat"], str(path))
    if path.is_dir():
        raise RecordError(["is a folder; give the files in it"], str(path))
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file")
    if kind in TEXT:
        return text_tables(path, record_column)
    if record_column is not None:
        reason = f"columns: record: is for text files; in {kind} each record has arrays of its own"
        raise RecordError([reason], str(path))
    return READERS[kind](path)


def _names(tables: Sequence[Table]) -> list[str]:
    """The name of each record, with its file's name where two would be called the same."""
    names = [table.name for table in tables]
    return [
        name if names.count(name) == 1 else f"{Path(table.source).parent.name}_{Path(table.source).stem}_{name}"
        for table, name in zip(tables, names, strict=True)
    ]


def _fields(
    table: Table,
    columns: Mapping[str, Any],
    units: Mapping[str, str],
    interval: float | None,
    normal_force: float | None,
    area: float | None,
    wrong: list[str],
) -> dict[str, Any] | None:
    """The fields of a record but its name, or None with complaints."""
    found: list[str] = []
    chosen = choices(table, columns, units, found)
    if interval is not None and "time" in columns:
        found.append("dt, sampling_rate: are for files without a column of time; columns names one")
    if interval is not None:
        chosen.pop("time", None)
    if normal_force is not None:
        chosen.pop("normal_force", None)
    for quantity in sorted(called for called in units if base_quantity(called) not in chosen):
        found.append(f"units: {quantity}: is given, but there is no such column; {_there_is(table)}")
    rotary = turns(chosen, found)
    if faults := table.faults_in(choice.column for choice in chosen.values()):
        raise RecordError(shortened([*found, *faults]), table.source)
    if found:
        wrong += found
        return None
    values = values_in_si(table, chosen, area, normal_force, found)
    said = list(notes(chosen, values))
    if "time" not in chosen:
        step, how = (interval, "as given") if interval is not None else _interval(table)
        if step is None:
            found.append(f"columns: time: no column has a usual name; name it, or give dt; {_there_is(table)}")
        else:
            values["time"] = step * np.arange(max(map(len, table.columns.values()), default=0))
            said.append(f"time: {step:.10g} s between samples, {how}")
    if "force" not in chosen:
        found.append(f"columns: force: no column has a usual name; name it; {_there_is(table)}")
    if "velocity" not in chosen and "displacement" not in chosen:
        found.append(f"columns: velocity, displacement: no column has a usual name; name one; {_there_is(table)}")
    if not found:
        arrays = {field: np.asarray(values[field]) for field in COLUMNS if field in values}
        if "normal_force" in arrays and arrays["normal_force"].ndim == 0:
            arrays["normal_force"] = np.full(arrays["time"].shape, arrays["normal_force"])
        found = [f"{_of(table)}{complaint}" for complaint in complaints(arrays, table.place)]
    if found:
        wrong += found
        return None
    others = {key: value for key, value in table.scalars.items() if key.lower() not in (*INTERVALS, *RATES)}
    guessed = {quantity: choice.unit.name for quantity, choice in chosen.items() if choice.unit_guessed}
    settings = {"rotary": rotary, "guessed_units": guessed, "notes": tuple(said)}
    return {**values, "source": table.source, "conditions": others, **settings}


def _of(table: Table) -> str:
    return "" if table.name == Path(table.source).stem else f"record {table.name!r}: "


def _there_is(table: Table) -> str:
    names = ", ".join(map(repr, table.columns))
    if table.named:
        return f"there is {names}"
    return f"the file has no header; its columns are counted from 0 to {len(table.columns) - 1}"


def _interval(table: Table) -> tuple[float | None, str]:
    for name, value in table.scalars.items():
        if name.lower() in INTERVALS and value > 0.0:
            return value, f"from {name!r}"
        if name.lower() in RATES and value > 0.0:
            return 1.0 / value, f"from {name!r}"
    return None, ""
