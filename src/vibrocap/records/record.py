"""A measured record: force and motion of one contact over time, in SI units; what is wrong with one, or looks wrong."""

import dataclasses
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaint, check_whole, is_positive, shown

FEWEST_SAMPLES = 8
ROUNDING = 1e-12  # relative; a column that varies less is constant
MOTIONS = ("velocity", "displacement")
COEFFICIENTS = (0.001, 10.0)  # friction coefficients outside are taken for a slip in the units
AGREEMENT = 3.0  # velocity and the derivative of displacement may differ by noise and offset, but not by this factor
CORRELATION = 0.7  # below it, velocity and displacement tell different motions, and no factor relates them

# (unit meant for the displacement, unit meant for the velocity) where displacement / integral of velocity is about key
SLIPS = {
    1e3: "displacement looks as if it were in mm, not m",
    1e6: "displacement looks as if it were in um, not m",
    1e-3: "velocity looks as if it were in mm/s, not m/s, or time as if it were in ms, not s",
    1e-6: "velocity looks as if it were in um/s, not m/s, or time as if it were in us, not s",
}


class RecordError(ValueError):
    """A record that cannot be used: `complaints` holds every one, each naming the field and what would be right."""

    def __init__(self, complaints: Iterable[str], source: str = "the record"):
        self.complaints = tuple(Complaint.read(complaint) for complaint in complaints)
        self.source = source
        super().__init__(f"{source} cannot be used:\n" + "\n".join(f"  {complaint}" for complaint in self.complaints))

    def __reduce__(self):
        return type(self), (self.complaints, self.source)


class RecordWarning(UserWarning):
    """A record that can be used, but whose numbers look as if a unit were wrong."""


def not_positive(numbers: Mapping[str, Any]) -> list[str]:
    """Complaints about numbers, None where one is not given, that should be greater than 0."""
    wrong = {field: value for field, value in numbers.items() if value is not None and not is_positive(value)}
    return [f"{field}: should be a number greater than 0, got {value!r}" for field, value in wrong.items()]


def complaints(columns: Mapping[str, Any], place: Callable[[int], str] = "index {}".format) -> list[str]:
    """Everything that makes a record unusable.

    columns: the columns of the record by field, 1-D arrays of floats; None where it has none
    place: how a message names a sample, from its index; a line of a file for instance
    """
    there = {field: values for field, values in columns.items() if values is not None}
    texts = []
    for field, values in there.items():
        if values.ndim != 1:
            shape = f"an array of shape {values.shape}" if values.ndim else "a single number"
            texts.append(f"{field}: should be one column of numbers, got {shape}")
    if not any(field in there for field in MOTIONS):
        texts.append("velocity, displacement: neither is given; at least one should be, a friction law is driven by it")
    if texts:
        return texts
    samples = {field: len(values) for field, values in there.items()}
    if len(set(samples.values())) > 1:
        lengths = ", ".join(f"{field} {count:,}" for field, count in samples.items())
        return [f"{', '.join(samples)}: should have one value for each time, got {lengths}"]
    if samples["time"] < FEWEST_SAMPLES:
        count = samples["time"]
        return [f"time: should have at least {FEWEST_SAMPLES} samples, got {count} sample{'s' * (count != 1)}"]
    for field, values in there.items():
        texts += _not_finite(field, values, place)
    if texts:
        return texts
    texts += _not_increasing(there["time"], place)
    for field, values in there.items():
        if field in ("force", *MOTIONS, "acceleration") and np.ptp(values) <= ROUNDING * np.max(np.abs(values)):
            texts.append(
                f"{field}: is {values[0]:g} at all {len(values):,} samples; a constant {field} determines nothing, "
                "give one that varies"
            )
    load = there.get("normal_force")
    if load is not None and np.any(load < 0.0):
        worst = int(np.argmin(load))
        least = f"{load[worst]:g} at {place(worst)}"
        texts.append(f"normal_force: should be at least 0 (pressing counts positive), got {least}")
    elif load is not None and not np.any(load):
        texts.append("normal_force: should be greater than 0 somewhere, got 0 at all samples; leave it out if unknown")
    return texts


def _not_finite(field: str, values: np.ndarray, place: Callable[[int], str]) -> list[str]:
    bad = ~np.isfinite(values)
    if not bad.any():
        return []
    counts = ((int(np.isnan(values).sum()), "NaN"), (int(np.isinf(values).sum()), "infinite"))
    kinds = " and ".join(f"{count:,} {kind}" for count, kind in counts if count)
    first = place(int(np.argmax(bad)))
    return [
        f"{field}: {kinds} of {len(values):,} values, the first at {first}; "
        "should be finite: cut these samples out or fill them before"
    ]


def _not_increasing(time: np.ndarray, place: Callable[[int], str]) -> list[str]:
    steps = np.diff(time)
    if np.all(steps > 0.0):
        return []
    at = int(np.argmax(steps <= 0.0)) + 1
    what = "repeats" if steps[at - 1] == 0.0 else "runs backwards"
    count = int((steps <= 0.0).sum())
    also = f" ({count:,} such places)" if count > 1 else ""
    return [
        f"time: {what} at {place(at)}{also}: {time[at]:.10g} after {time[at - 1]:.10g}; should increase strictly: "
        "sort the samples, drop repeated ones, split records that follow each other, or give the sampling rate of a "
        "clock that is too coarse"
    ]


def doubts(columns: Mapping[str, Any]) -> list[str]:
    """What looks as if a unit were wrong, by a factor of 1000 for instance.

    Two comparisons need no knowledge of the machine: displacement with the integral of velocity (which unlike a
    derivative does not amplify noise), and force with normal force (a friction coefficient outside 0.001 to 10).
    """
    texts = []
    velocity, displacement, normal = (columns.get(name) for name in ("velocity", "displacement", "normal_force"))
    if velocity is not None and displacement is not None:
        texts += _different_motions(columns["time"], velocity, displacement)
    if normal is not None:
        coefficient = float(np.sqrt(np.mean(np.square(columns["force"]))) / np.mean(normal))
        low, high = COEFFICIENTS
        if not low <= coefficient <= high:
            texts.append(
                f"force, normal_force: imply a friction coefficient of {coefficient:.3g} (root mean square), outside "
                f"{low:g} to {high:g}; one of them looks as if it were in other units, N and kN for instance"
            )
    return texts


def _different_motions(time: np.ndarray, velocity: np.ndarray, displacement: np.ndarray) -> list[str]:
    travelled = integral(time, velocity)
    travelled -= travelled.mean()
    moved = displacement - displacement.mean()
    size, other = float(travelled @ travelled), float(moved @ moved)
    if size == 0.0 or abs(float(moved @ travelled)) < CORRELATION * np.sqrt(size * other):
        return []
    factor = float(moved @ travelled) / size
    power = float(10.0 ** (3 * np.round(np.log10(abs(factor)) / 3)))
    if 1.0 / AGREEMENT <= factor <= AGREEMENT:
        return []
    text = f"velocity, displacement: displacement is {factor:.3g} times the integral of velocity"
    text += "; they count in opposite directions" if factor < 0.0 else ""
    near = 1.0 / AGREEMENT <= abs(factor) / power <= AGREEMENT
    return [f"{text}; {SLIPS[power] if near and power in SLIPS else 'check their units and that of time'}"]


def integral(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Integral of samples over time by the trapezoidal rule, 0 at the first sample; the sampling may be uneven."""
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    return np.concatenate(([0.0], np.cumsum(steps)))


# fields with a value per sample
COLUMNS = ("time", "force", "velocity", "displacement", "acceleration", "normal_force")
EVEN_WITHIN = 0.01  # share of the sampling interval by which a sample of an even record may be off its place


@dataclasses.dataclass(frozen=True, eq=False)
class Record:
    """Friction force and motion of one contact, as measured, with the signs of a law.

    Velocity and displacement count in one direction, and the friction force is positive where it resists a motion in
    that direction (force times velocity is then the power dissipated).

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
            known = f"the record's time, {self.time[0]:g} to {self.time[-1]:g} s"
            raise ArgumentError("start, stop", f"should hold samples of {known}, got {start:g} to {stop:g}")
        return self._with_samples(kept)

    def thinned(self, every: int) -> "Record":
        """Each `every`-th sample, from the first on; without a filter, so that faster motion aliases."""
        check_whole("every", every, 1)
        return self._with_samples(slice(None, None, int(every)))

    def _with_samples(self, kept: Any) -> "Record":
        columns = {field: values[kept] for field, values in self._columns().items() if isinstance(values, np.ndarray)}
        return self.replaced(**columns)


def listed_records(records: Any, *kinds: type) -> list[Any]:
    """One record or several as a list, or ArgumentError for what is none; kinds: what serves as one, too."""
    several = isinstance(records, Iterable) and not isinstance(records, str)
    listed = list(records) if several else [records]
    for record in listed:
        if not isinstance(record, (Record, *kinds)):
            raise ArgumentError("records", f"should be vc.Record(...) or of read_records(...), got {shown(record)}")
    return listed
