"""A pulled slider: the force in the spring that pulls it, evenly sampled, and what is known beside it; its files."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.records.published import paper_stick_slip
from vibrocap.records.reading.columns import Table, choices, missing, setting_complaints
from vibrocap.records.reading.readers import INTERVALS, RATES, SETTINGS, tables_in
from vibrocap.records.reading.text import shortened
from vibrocap.records.reading.units import si_unit, unit_named
from vibrocap.records.record import COEFFICIENTS, Record, RecordError, complaints, not_positive

FEWEST_SAMPLES = 64
UNEVEN, GAP = 0.01, 5.0  # samples may be off their places by this share of an interval; a gap is so many intervals
GRAVITY = 9.80665  # m/s^2, the conventional value, where only the mass tells the normal force


@dataclasses.dataclass(frozen=True, eq=False)
class Pull:
    """The force in a spring that is pulled at constant speed, with a slider at its other end.

    time [n] s: evenly spaced;  force [n]: N, or over the normal force where `coefficient` is True
    stiffness: of spring and machine together, N/m;  mass: of the slider, kg;  pulling_speed: m/s;  normal_force: N;
    None where not known
    notes: what was changed or assumed on the way here
    """

    time: np.ndarray
    force: np.ndarray
    stiffness: float | None
    mass: float | None
    pulling_speed: float | None
    normal_force: float | None
    coefficient: bool
    notes: tuple[str, ...]

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def compliance(self) -> float | None:
        """How much longer the spring gets for one unit of the force [m]; None where stiffness or load is not known."""
        newtons = self.normal_force if self.coefficient else 1.0
        return None if self.stiffness is None or newtons is None else newtons / self.stiffness

    @property
    def loading_rate(self) -> float | None:
        """k V, the rate at which the force rises while the slider sticks, units of the force per s."""
        return None if self.compliance is None or self.pulling_speed is None else self.pulling_speed / self.compliance

    @property
    def inertial_period(self) -> float | None:
        """2 pi sqrt(m/k), the period of the slider on its spring [s]."""
        if self.mass is None or self.stiffness is None:
            return None
        return 2.0 * math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def weight(self) -> float | None:
        """What a force is divided by for a friction coefficient: the normal force, 1 where it is one already."""
        return 1.0 if self.coefficient else self.normal_force


def pull(
    time: Any, force: Any, numbers: Mapping[str, Any], coefficient: bool, name: str, further: Sequence[str]
) -> Pull:
    """The checked record of a pulled slider; arguments as in `stick_slip`, and further complaints to raise with others.

    numbers: stiffness, mass, pulling_speed and normal_force, None where not known
    Uneven sampling is interpolated, a force that is negative nearly throughout is turned, both with a note.
    Raises RecordError with every complaint: NaN, a time that runs backwards, a constant force, fewer than 64 samples, a
    gap, numbers that are not positive.
    """
    wrong = _complaints(time, force)
    wrong += not_positive(numbers)
    if not isinstance(coefficient, bool | np.bool_):
        wrong.append(f"coefficient: should be True or False, got {coefficient!r}")
    wrong += further
    if wrong:
        raise RecordError(wrong, f"record {name!r}")
    notes: list[str] = []
    even_time, even_force = _even(np.array(time, dtype=np.float64), np.array(force, dtype=np.float64), notes)
    if np.mean(even_force < 0) > 0.95:
        even_force = -even_force
        notes.append("force: is negative; its sign was turned")
    if coefficient and numbers["normal_force"] is None and numbers["mass"] is not None:
        numbers = {**numbers, "normal_force": numbers["mass"] * GRAVITY}
        notes.append(f"normal_force: not given; m g assumed = {numbers['normal_force']:.4g} N")
    mean = abs(float(even_force.mean())) / (1.0 if coefficient else numbers["normal_force"] or math.inf)
    low, high = COEFFICIENTS
    if mean > 0 and not low <= mean <= high:
        notes.append(
            f"force: implies a friction coefficient of {mean:.3g}, outside {low:g} to {high:g}; "
            "it looks as if its unit, or that of the normal force, were wrong"
        )
    return Pull(even_time, even_force, coefficient=bool(coefficient), notes=tuple(notes), **numbers)


def _complaints(time: Any, force: Any) -> list[str]:
    columns, wrong = {}, []
    for field, value in (("time", time), ("force", force)):
        try:
            columns[field] = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            wrong.append(f"{field}: should be numbers, got {type(value).__name__}")
    if wrong:
        return wrong
    time, force = columns.values()
    if time.shape != force.shape:
        return [f"time, force: should have one force for each time, got time {time.shape}, force {force.shape}"]
    # That the pulled end of the spring moves is known here, and not what is asked.
    if wrong := complaints({**columns, "displacement": np.arange(time.size, dtype=float)}):
        return wrong
    if len(time) < FEWEST_SAMPLES:
        return [f"time: should have at least {FEWEST_SAMPLES} samples, got {len(time)}"]
    steps = np.diff(time)
    at, usual = int(np.argmax(steps)), float(np.median(steps))
    if steps[at] > GAP * usual:
        gap = f"has a gap of {steps[at]:.4g} s after index {at}, {steps[at] / usual:.3g} sampling intervals"
        return [f"time: {gap}; give the pieces before and after it one by one"]
    return []


def _even(time: np.ndarray, force: np.ndarray, notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    even = np.linspace(time[0], time[-1], len(time))
    if np.max(np.abs(time - even)) <= UNEVEN * (even[1] - even[0]):
        return even, force
    count = 1 + max(FEWEST_SAMPLES, round(float((time[-1] - time[0]) / np.median(np.diff(time)))))
    notes.append(f"time: is unevenly spaced; the force was interpolated to {count:,} even samples")
    even = np.linspace(time[0], time[-1], count)
    return even, np.interp(even, time, force)


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
    wrong += not_positive({"sampling_rate": sampling_rate})
    if wrong:
        raise RecordError(wrong, SETTINGS)
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such file")
    if path.is_dir() or path.name == PUBLISHED:
        records = paper_stick_slip(path if path.is_dir() else path.parent)
        pulled_records = [PulledRecord(r.name, r.time, r.force, settings_of(r), r.notes) for r in records]
    else:
        pulled_records = [pull for table in tables_in(path) for pull in _pulls(table, columns, units, sampling_rate)]
    named = [one for one in pulled_records if record in (None, one.name)]
    if record is not None and not named:
        names = ", ".join(repr(one.name) for one in pulled_records)
        raise RecordError([f"record: there is no record {record!r}; there is {names}"], str(path))
    return named


def settings_of(record: Record) -> dict[str, float | None]:
    """What a record says beside its force: arguments of `stick_slip` by name."""
    load = record.normal_force
    known = {field: record.conditions.get(name) for field, name in CONDITIONS.items()}
    return known | {"normal_force": None if load is None else float(np.mean(load))}


def _pulls(
    table: Table, columns: Mapping[str, str | int], units: Mapping[str, str], rate: float | None
) -> list[PulledRecord]:
    """The record in a table of columns, or one for each column where none has a usual name."""
    wrong: list[str] = []
    by_quantity = choices(table, columns, units, wrong)
    clock, only = by_quantity.get("time"), by_quantity.get("force")
    if clock is None:
        rate = rate or next((v for k, v in table.scalars.items() if k.lower() in RATES and v > 0), None)
        rate = rate or next((1.0 / v for k, v in table.scalars.items() if k.lower() in INTERVALS and v > 0), None)
    forces = {name: name for name in table.columns} if only is None else {table.name: only.column}
    stated = unit_named(units["force"]) if "force" in units else None
    unit = stated or si_unit("force") if only is None else only.unit
    if not wrong and clock is None and rate is None:
        wrong = [f"columns: time: {missing('time', table)}; name it, or give sampling_rate"]
    elif not wrong and only is None and (clock is not None or not table.named):
        wrong = [f"columns: force: {missing('force', table)}; name it"]
    elif not wrong and (faults := table.faults_in([*forces.values(), *([clock.column] if clock else [])])):
        wrong = shortened(faults)
    elif not wrong and unit.dimension not in ("force", "number"):
        wrong = [f"units: force: should be a force or 1 for a coefficient, got {unit.name}, a {unit.dimension}"]
    if wrong:
        raise RecordError(wrong, table.source)
    known = ((field, name) for field, name in CONDITIONS.items() if name in table.scalars)
    settings = {field: table.scalars[name] for field, name in known} | {"coefficient": unit.dimension == "number"}
    silent = [q for q, choice in by_quantity.items() if q in ("time", "force") and choice.unit_guessed]
    silent += ["force"] if only is None and stated is None else []
    assumed = [f"{', '.join(sorted(silent))}: no unit given, SI assumed"] if silent else []
    words = "a friction coefficient" if unit.dimension == "number" else unit.name
    pulled_records = []
    for name, column in forces.items():
        force = np.asarray(table.columns[column], dtype=np.float64) * unit.factor
        if clock is not None:
            time = np.asarray(table.columns[clock.column], dtype=np.float64) * clock.unit.factor
            how = f"time: column {clock.column!r} in {clock.unit.name}"
        else:
            time, how = np.arange(len(force)) / (rate or 1.0), f"time: {rate:.6g} samples a second"
        notes = (how, f"force: column {column!r} in {words}", *assumed)
        pulled_records.append(PulledRecord(name, time, force, settings, notes))
    return pulled_records
