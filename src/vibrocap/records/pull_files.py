"""Files of pulled sliders: a force over time, without the motion that other records have."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.records.checks import RecordError
from vibrocap.records.columns import Table, choices, missing, setting_complaints
from vibrocap.records.published import paper_stick_slip
from vibrocap.records.readers import INTERVALS, RATES, READERS, TEXT
from vibrocap.records.record import Record
from vibrocap.records.text import text_tables
from vibrocap.records.units import si_unit, unit_named

PUBLISHED = "paper_stick_slip.npz"
CONDITIONS = {"stiffness": "stiffness_N_per_m", "mass": "mass_kg", "pulling_speed": "pulling_speed_m_per_s"}


@dataclasses.dataclass(frozen=True, eq=False)
class PulledRecord:
    """A force over time from a file: name, time [n] s, force [n], and what the file says beside it.

    settings: arguments of `stick_slip` by name;  notes: how the columns were understood
    """

    name: str
    time: np.ndarray
    force: np.ndarray
    settings: Mapping[str, Any]
    notes: tuple[str, ...]


def read_pulls(
    path: str | Path,
    record: str | None = None,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    sampling_rate: float | None = None,
) -> list[PulledRecord]:
    """The force records in a file: all of them, or the one that is named.

    path: .csv, .txt, .npz, .mat with columns for time and force, as `read_records` takes them; arrays of forces with
        one `fs` or `dt` for all, each a record named like its array; or the folder of the paper-on-paper records
    columns, units: which column is "time", "force"; in which units. A force in unit 1 is a friction coefficient
    sampling_rate: Hz, where there is no column of time
    Raises RecordError with every complaint; FileNotFoundError.
    """
    path, columns, units = Path(path), dict(columns or {}), dict(units or {})
    wrong = setting_complaints(columns, units)
    wrong += [
        f"columns: {name}: a pulled slider's record has time and force only"
        for name in columns
        if name not in ("time", "force") and not any(f"{name!r}" in complaint for complaint in wrong)
    ]
    if sampling_rate is not None and not 0.0 < sampling_rate < float("inf"):
        wrong.append(f"sampling_rate: should be a number greater than 0, got {sampling_rate!r}")
    if wrong:
        raise RecordError(wrong, "the settings for reading")
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file")
    if path.is_dir() or path.name == PUBLISHED:
        found = [_of(each) for each in paper_stick_slip(path if path.is_dir() else path.parent)]
    else:
        found = [each for table in _tables(path) for each in _pulls(table, columns, units, sampling_rate)]
    if record is None:
        return found
    named = [each for each in found if each.name == record]
    if not named:
        names = ", ".join(repr(each.name) for each in found)
        raise RecordError([f"record: there is no record {record!r}; there is {names}"], str(path))
    return named


def _of(record: Record) -> PulledRecord:
    settings: dict[str, Any] = {field: record.conditions.get(name) for field, name in CONDITIONS.items()}
    load = record.normal_force
    return PulledRecord(
        record.name,
        record.time,
        record.force,
        settings | {"normal_force": None if load is None else float(np.mean(load))},
        record.notes,
    )


def _tables(path: Path) -> list[Table]:
    kind = path.suffix.lower()
    if kind in TEXT:
        return text_tables(path)
    if kind in READERS:
        return READERS[kind](path)
    raise RecordError([f"ends in {path.suffix!r}; should be {', '.join(TEXT[:-1])}, .npz or .mat"], str(path))


def _pulls(
    table: Table, columns: Mapping[str, str | int], units: Mapping[str, str], rate: float | None
) -> list[PulledRecord]:
    """The record in a table of columns, or one for each column where none has a usual name."""
    wrong: list[str] = []
    chosen = choices(table, columns, units, wrong)
    if wrong:
        raise RecordError(wrong, table.source)
    if "time" not in chosen:
        rate = rate or next((v for k, v in table.scalars.items() if k.lower() in RATES and v > 0), None)
        rate = rate or next((1.0 / v for k, v in table.scalars.items() if k.lower() in INTERVALS and v > 0), None)
        if rate is None:
            reason = f"time: {missing('time', table)}; say columns={{'time': ...}}, or sampling_rate="
            raise RecordError([reason], table.source)
    forces = {table.name: chosen["force"].column} if "force" in chosen else {name: name for name in table.columns}
    if "force" not in chosen and ("time" in chosen or not table.named):
        reason = f"force: {missing('force', table)}; say columns={{'force': ...}}"
        raise RecordError([reason], table.source)
    given = unit_named(units["force"]) if "force" in units else None
    unit = chosen["force"].unit if "force" in chosen else given or si_unit("force")
    if unit.dimension not in ("force", "number"):
        reason = f"units: force: should be a force or 1 for a coefficient, got {unit.name}, a {unit.dimension}"
        raise RecordError([reason], table.source)
    settings: dict[str, Any] = {
        field: table.scalars[name] for field, name in CONDITIONS.items() if name in table.scalars
    }
    silent = [q for q, choice in chosen.items() if q in ("time", "force") and choice.unit_guessed]
    silent += ["force"] if "force" not in chosen and given is None else []
    assumed = [f"{', '.join(sorted(silent))}: the unit is nowhere said, taken as SI"] if silent else []
    found = []
    for name, column in forces.items():
        force = np.asarray(table.columns[column], dtype=np.float64) * unit.factor
        if "time" in chosen:
            time = np.asarray(table.columns[chosen["time"].column], dtype=np.float64) * chosen["time"].unit.factor
            how = f"time: column {chosen['time'].column!r} in {chosen['time'].unit.name}"
        else:
            time, how = np.arange(len(force)) / (rate or 1.0), f"time: {rate:.6g} samples a second"
        said = "a friction coefficient" if unit.dimension == "number" else unit.name
        found.append(
            PulledRecord(
                name,
                time,
                force,
                settings | {"coefficient": unit.dimension == "number"},
                (how, f"force: column {column!r} in {said}", *assumed),
            )
        )
    return found
