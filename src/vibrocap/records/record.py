"""A measured record: force and motion of one contact over time, in SI units, checked when it is made."""

import dataclasses
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, shown
from vibrocap.records.checks import RecordError, RecordWarning, complaints, doubts

# fields with a value per sample
COLUMNS = ("time", "force", "velocity", "displacement", "acceleration", "normal_force")
EVEN_WITHIN = 0.01  # share of the sampling interval by which a sample of an even record may be off its place


@dataclasses.dataclass(frozen=True, eq=False)
class Record:
    """Friction force and motion of one contact, as measured.

    A friction law answers a motion with a force; a record holds both, so that the law's parameters can be found. The
    signs are those of a law: velocity and displacement count in one direction, and the friction force is positive
    where it resists a motion in that direction (force times velocity is then the power dissipated).

    name: name of the record in results
    time [n] s: strictly increasing; the sampling may be uneven
    force [n] N: friction force
    velocity [n] m/s, displacement [n] m: at least one of them; `prepared` makes the other
    acceleration [n] m/s^2: where it was measured, or made by `prepared`
    normal_force N: a number or [n], not negative; None where it is not known
    source: where the numbers are from
    conditions: further numbers of the experiment by name, with the unit in the name (stiffness_N_per_m)
    notes: guesses, conversions and filters between file and record
    rotary: whether the contact turns: force is then a torque (N m), displacement an angle (rad), velocity and
        acceleration angular (rad/s, rad/s^2)
    guessed_units: unit by quantity, where the file has none and SI is assumed

    The columns are copied to arrays of doubles that cannot be written to.
    Raises RecordError, a ValueError, with every complaint: lengths that differ, fewer than 8 samples, a time that
    repeats or runs backwards, NaN, no motion, a constant column (which determines nothing).
    Warns with RecordWarning of numbers that look as if a unit were wrong by a factor of 1000.
    """

    name: str
    time: np.ndarray
    force: np.ndarray
    velocity: np.ndarray | None = None
    displacement: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    normal_force: np.ndarray | float | None = None
    source: str = ""
    conditions: Mapping[str, float] = dataclasses.field(default_factory=dict)
    notes: tuple[str, ...] = ()
    rotary: bool = False
    guessed_units: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def __post_init__(self):
        self._check()
        for doubt in doubts(self._columns()):
            warnings.warn(f"record {self.name!r}: {doubt}", RecordWarning, stacklevel=3)

    def _check(self) -> None:
        columns: dict[str, Any] = {}
        wrong = []
        for field in COLUMNS:
            value = getattr(self, field)
            try:
                columns[field] = None if value is None else np.array(value, dtype=np.float64)
            except (TypeError, ValueError):
                wrong.append(f"{field}: should be numbers, got {shown(value)}")
        for field in ("time", "force"):
            if columns.get(field, 0) is None:
                wrong.append(f"{field}: is missing; should be one column of numbers")
        if wrong:
            raise RecordError(wrong, f"record {self.name!r}")
        load = columns["normal_force"]
        if load is not None and load.ndim == 0:
            columns["normal_force"] = np.full(columns["time"].shape, load)
        wrong = complaints(columns)
        if wrong:
            raise RecordError(wrong, f"record {self.name!r}")
        if load is not None and load.ndim == 0:
            columns["normal_force"] = float(load)
        for field, values in columns.items():
            if isinstance(values, np.ndarray):
                values.setflags(write=False)
            object.__setattr__(self, field, values)
        object.__setattr__(self, "conditions", {name: float(value) for name, value in self.conditions.items()})
        object.__setattr__(self, "notes", tuple(self.notes))

    def _columns(self) -> dict[str, Any]:
        return {field: getattr(self, field) for field in COLUMNS}

    def replaced(self, **changes: Any) -> "Record":
        """This record with other fields, checked, but not warned of again."""
        record = object.__new__(type(self))
        for field in dataclasses.fields(self):
            object.__setattr__(record, field.name, changes.pop(field.name, getattr(self, field.name)))
        if changes:
            raise TypeError(f"a record has no field {', '.join(map(repr, changes))}")
        record._check()
        return record

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        have = ", ".join(field for field in COLUMNS[1:] if getattr(self, field) is not None)
        rate = f"{self.sampling_rate:.6g} Hz" if self.even else "uneven"
        return f"Record({self.name!r}: {len(self):,} samples in {self.duration:.4g} s, {rate}; {have})"

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def interval(self) -> float:
        """Median time between samples, s."""
        return float(np.median(np.diff(self.time)))

    @property
    def sampling_rate(self) -> float:
        """Samples per second, Hz, from the median interval."""
        return 1.0 / self.interval

    @property
    def even(self) -> bool:
        """Whether the samples are evenly spaced: none is off its place by more than 1 % of the interval."""
        step = self.duration / (len(self) - 1)
        places = self.time[0] + step * np.arange(len(self))
        return bool(np.max(np.abs(self.time - places)) <= EVEN_WITHIN * step)

    def between(self, start: float, stop: float) -> "Record":
        """The samples with start <= time <= stop (s, on the record's own clock)."""
        kept = (self.time >= start) & (self.time <= stop)
        if kept.sum() < 2:
            raise ArgumentError(
                "start, stop",
                f"should hold samples of the record's time, {self.time[0]:g} to {self.time[-1]:g} s, "
                f"got {start:g} to {stop:g}",
            )
        return self._with_samples(kept)

    def thinned(self, every: int) -> "Record":
        """Each `every`-th sample, from the first on; without a filter, so that faster motion aliases."""
        check_whole("every", every, 1)
        return self._with_samples(slice(None, None, int(every)))

    def _with_samples(self, kept: Any) -> "Record":
        columns = {field: values[kept] for field, values in self._columns().items() if isinstance(values, np.ndarray)}
        return self.replaced(**columns)
