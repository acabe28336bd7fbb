"""Records from files: CSV, TXT, Excel, JSON, NPZ and MAT, with columns named and units given, or guessed and said."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import listed
from vibrocap.records.reading.arrays import json_tables, npz_tables
from vibrocap.records.reading.columns import RECORD, Table, choices, notes, setting_complaints, turns, values_in_si
from vibrocap.records.reading.matlab import mat_tables
from vibrocap.records.reading.text import shortened, text_tables, workbook_tables
from vibrocap.records.reading.units import base_quantity
from vibrocap.records.record import (
    COLUMNS,
    FEWEST_SAMPLES,
    Record,
    RecordError,
    RecordWarning,
    complaints,
    not_positive,
)

REGULAR = 0.9  # share of the intervals that are within a tenth of the usual one where samples follow a clock
GAP = 10.0  # usual intervals without a sample of a clock: across shorter ones the motion is nearly a straight line
MOST = 20  # records into which one is cut; each begins with a state of the contact that nobody knows


def whole_stretches(columns: Mapping[str, Any], place: Callable[[int], str]) -> tuple[list[slice], str]:
    """(samples of each usable stretch, what is left out, in words): all samples and "" where nothing is missing.

    A sample is missing where a column has NaN, and where a clock that ticks evenly otherwise skips ten samples.
    Friction remembers its motion, so a record ends where its motion is unknown, and another begins behind.

    columns: arrays of floats by field, time among them; place: names a sample, from its index
    """
    lengths = {len(values) for values in columns.values()}
    everything = [slice(None)]
    if len(lengths) != 1 or "time" not in columns or (count := lengths.pop()) < 2:
        return everything, ""
    there = ~np.any([np.isnan(values) for values in columns.values()], axis=0)
    steps = np.diff(columns["time"])
    usual = float(np.median(steps[there[1:] & there[:-1]])) if there.sum() > 1 else np.nan
    clock = np.mean(np.abs(steps - usual) <= 0.1 * usual) >= REGULAR
    skips = steps >= GAP * usual if clock else np.zeros(count - 1, bool)
    if there.all() and not skips.any():
        return everything, ""
    joined = there[1:] & there[:-1] & ~skips
    starts = np.flatnonzero(there & ~np.concatenate(([False], joined)))
    stops = np.flatnonzero(there & ~np.concatenate((joined, [False]))) + 1
    stretches = [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True) if b - a >= FEWEST_SAMPLES]
    pieces = [{name: values[stretch] for name, values in columns.items()} for stretch in stretches]
    stretches = [stretch for stretch, piece in zip(stretches, pieces, strict=True) if not complaints(piece)]
    if not 0 < len(stretches) <= MOST:
        return everything, ""
    kept, words = np.zeros(count, bool), []
    for stretch in stretches:
        kept[stretch] = True
    if not kept.all():
        first = place(int(np.argmin(kept)))
        words.append(f"{count - kept.sum():,} of {count:,} samples are left out, the first at {first}")
    if skips.any():
        words.append(f"no sample for {steps[skips].max():.4g} s, first behind {place(int(np.argmax(skips)))}")
    if len(stretches) > 1:
        words.append(f"it continues as {len(stretches)} records, each with a start of its own")
    return stretches, "; ".join(words)


READERS: dict[str, Callable[..., list[Table]]] = {".npz": npz_tables, ".mat": mat_tables, ".json": json_tables}
SETTINGS = "the settings for reading"
TEXT = dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ""), text_tables) | {".xlsx": workbook_tables}
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

    `columns` names the quantity of a column; else the usual names give it (t, time_s, F, force [kN], x, v,
    displacement_mm, vel_m_per_s, torque [N m], angle_deg, ...) and each record's `notes` list the guesses. A unit
    comes from `units`, else from the heading or a line of units under it; an unreadable one is refused. Without a unit
    SI is assumed and listed in `guessed_units`.

    path: .csv, .txt, .tsv, .dat, .xlsx, .json, .npz or .mat, or a list of such
    columns: quantity -> name of its column (or its place, counted from 0), for instance {"force": "F1"}; the quantities
        are time, force, velocity, displacement, acceleration, normal_force, and of a contact that turns torque,
        angular_velocity, angle, angular_acceleration; "record" names the column of a text file with the record of a row
    units: quantity -> unit, for instance {"force": "kN"}; with a number the size of a column's unit,
        {"force": "35.15 N"} for a sensor in volts, {"velocity": "-1 m/s"} for a reversed one
    name: of the record, where there is one [default: the file's name, or the record's name in it]
    dt, sampling_rate: s or Hz, where there is no column of time
    normal_force: N, where there is no such column; a friction coefficient is multiplied by it
    area: m^2, for forces given as stresses

    Several records in one file: text with a column "record", a workbook with several sheets; in JSON, NPZ and MAT see
    `vibrocap.records.reading.arrays`. Where samples are missing a record is cut (`whole_stretches`). Raises RecordError
    with every complaint, with lines where the file has them; FileNotFoundError. Warns with RecordWarning where a unit
    looks wrong and where samples are missing.
    """
    for field, mapping, wanted in (("columns", columns, "{'force': 'F'}"), ("units", units, "{'force': 'kN'}")):
        if mapping is not None and not isinstance(mapping, Mapping):
            raise RecordError([f"{field}: should be a mapping such as {wanted}, got {mapping!r}"], SETTINGS)
    columns, units = dict(columns or {}), dict(units or {})
    wrong = setting_complaints(columns, units)
    wrong += not_positive({"dt": dt, "sampling_rate": sampling_rate, "normal_force": normal_force, "area": area})
    if dt is not None and sampling_rate is not None:
        wrong.append("dt, sampling_rate: give one of them, got both")
    if wrong:
        raise RecordError(wrong, SETTINGS)
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(one_path) for one_path in path]
    if not paths:
        raise RecordError(["path: should be a file or a list of files, got an empty list"], SETTINGS)
    record_column = columns.get(RECORD)
    tables = [table for path in paths for table in _measured(tables_in(path, record_column), columns)]
    if name is not None and len(tables) > 1:
        records = ", ".join(table.name for table in tables)
        raise RecordError([f"name: is for one record, but there are {len(tables)}: {records}"], _listed(paths))
    interval = dt if dt is not None else None if sampling_rate is None else 1.0 / sampling_rate
    read = []
    for table, label in zip(tables, [name] if name is not None else _names(tables), strict=True):
        pieces = _pieces(table, columns, units, interval, normal_force, area, wrong)
        ends = [f"_part_{at}" for at in range(1, len(pieces) + 1)] if len(pieces) > 1 else [""]
        read += [{"name": f"{label}{end}", **fields} for end, fields in zip(ends, pieces, strict=False)]
    if wrong:
        raise RecordError(dict.fromkeys(wrong), _listed(paths))
    return [Record(**fields) for fields in read]


def _listed(paths: Sequence[Path]) -> str:
    return str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"


def tables_in(path: Path, record_column: str | int | None = None) -> list[Table]:
    """The tables of a file, by the end of its name."""
    kind = path.suffix.lower()
    if kind not in (*TEXT, *READERS):
        raise RecordError([f"ends in {path.suffix!r}; should be {listed(filter(None, (*TEXT, *READERS)))}"], str(path))
    if path.is_dir():
        raise RecordError(["is a folder; give the files in it"], str(path))
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file")
    if kind in TEXT:
        return TEXT[kind](path, record_column)
    if record_column is not None:
        reason = f"columns: record: is for text files; in {kind} each record has arrays of its own"
        raise RecordError([reason], str(path))
    return READERS[kind](path)


def _measured(tables: list[Table], columns: Mapping[str, Any]) -> list[Table]:
    """The tables of a file that have some column of a record, all where none has; warns of the others."""
    measured = [table for table in tables if choices(table, columns, {}, [])]
    for table in tables if measured else ():
        if table not in measured:
            text = f"{table.source}: {table.name!r} has no column of a record and is left out"
            warnings.warn(text, RecordWarning, stacklevel=3)
    return measured or tables


def _names(tables: Sequence[Table]) -> list[str]:
    """The name of each record, with its file's name where two would be called the same."""
    names = [table.name for table in tables]
    return [
        name if names.count(name) == 1 else f"{Path(table.source).parent.name}_{Path(table.source).stem}_{name}"
        for table, name in zip(tables, names, strict=True)
    ]


def _pieces(
    table: Table,
    columns: Mapping[str, Any],
    units: Mapping[str, str],
    interval: float | None,
    normal_force: float | None,
    area: float | None,
    wrong: list[str],
) -> list[dict[str, Any]]:
    """The fields of each record but its name: one, or one for each stretch that is whole; none with complaints."""
    parts: list[str] = []
    by_quantity = choices(table, columns, units, parts)
    there_is = f"the file has no header; its columns are counted from 0 to {len(table.columns) - 1}"
    if table.named:
        there_is = f"there is {', '.join(map(repr, table.columns))}"
    if interval is not None:
        if "time" in columns:
            parts.append("dt, sampling_rate: are for files without a column of time; columns names one")
        by_quantity.pop("time", None)
    if normal_force is not None:
        by_quantity.pop("normal_force", None)
    for quantity in sorted(called for called in units if base_quantity(called) not in by_quantity):
        parts.append(f"units: {quantity}: is given, but there is no such column; {there_is}")
    rotary = turns(by_quantity, parts)
    if faults := table.faults_in(choice.column for choice in by_quantity.values()):
        raise RecordError(shortened([*parts, *faults]), table.source)
    if parts:
        wrong += parts
        return []
    values = values_in_si(table, by_quantity, area, normal_force, parts)
    remarks = list(notes(by_quantity, values))
    if "time" not in by_quantity:
        step, how = (interval, "as given") if interval is not None else _interval(table)
        if step is None:
            advice = "name it, or give dt (any, for a law that knows no rate, such as dahl)"
            parts.append(f"columns: time: no column has a usual name; {advice}; {there_is}")
        else:
            values["time"] = step * np.arange(max(map(len, table.columns.values()), default=0))
            remarks.append(f"time: {step:.10g} s between samples, {how}")
    if "force" not in by_quantity:
        parts.append(f"columns: force: no column has a usual name; name it; {there_is}")
    if "velocity" not in by_quantity and "displacement" not in by_quantity:
        parts.append(f"columns: velocity, displacement: no column has a usual name; name one; {there_is}")
    of_table = "" if table.name == Path(table.source).stem else f"record {table.name!r}: "
    pieces = [slice(None)]
    if not parts:
        arrays = {field: np.asarray(values[field]) for field in COLUMNS if np.ndim(values.get(field, 0.0))}
        pieces, cut = whole_stretches(arrays, table.place)
        if cut:
            remarks.append(cut)
            warnings.warn(f"{table.source}: {of_table}{cut}", RecordWarning, stacklevel=3)
        if np.ndim(values.get("normal_force", arrays["time"])) == 0:
            arrays["normal_force"] = np.full(arrays["time"].shape, values["normal_force"])
        whole = {field: column[pieces[0]] for field, column in arrays.items()}
        parts = [f"{of_table}{complaint}" for complaint in complaints(whole, table.place)]
    if parts:
        wrong += parts
        return []
    others = {key: value for key, value in table.scalars.items() if key.lower() not in (*INTERVALS, *RATES)}
    guessed = {quantity: choice.unit.name for quantity, choice in by_quantity.items() if choice.unit_guessed}
    settings = {"rotary": rotary, "guessed_units": guessed, "notes": tuple(remarks)}
    settings |= {"source": table.source, "conditions": others}
    return [
        {field: value[piece] if np.ndim(value) else value for field, value in values.items()} | settings
        for piece in pieces
    ]


def _interval(table: Table) -> tuple[float | None, str]:
    """(s between samples, where it is from), as a number beside the columns tells it; None where none does."""
    for name, value in table.scalars.items():
        if name.lower() in INTERVALS and value > 0.0:
            return value, f"from {name!r}"
        if name.lower() in RATES and value > 0.0:
            return 1.0 / value, f"from {name!r}"
    return None, ""
