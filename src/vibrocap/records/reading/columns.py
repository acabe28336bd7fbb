"""Which column of a file is which quantity, in which unit: as the user says, else guessed from the usual names."""

import dataclasses
import difflib
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import suggestion
from vibrocap.records.reading import units as known_units
from vibrocap.records.reading.units import QUANTITIES, TURNING, Unit, base_quantity, fits, unit_named

# usual names of columns, in small letters and without marks between words, the most telling first
USUAL: dict[str, tuple[str, ...]] = {
    "time": ("time", "t", "timestamp", "elapsedtime", "zeit"),
    "force": (
        *("frictionforce", "friction", "force", "tangentialforce", "shearforce", "ft", "f", "loadcell"),
        *("frictioncoefficient", "coefficientoffriction", "cof", "mu", "shearstress", "tau"),
    ),
    "velocity": ("velocity", "slidingvelocity", "slipvelocity", "vel", "v", "speed", "sliprate", "xdot", "dx", "dxdt"),
    "displacement": ("displacement", "disp", "displ", "slip", "position", "pos", "x", "q", "stroke"),
    "acceleration": ("acceleration", "accel", "acc", "a", "xddot", "ddx"),
    "normal_force": ("normalforce", "normalload", "normal", "fn", "n", "normalstress", "sigman"),
    "torque": ("frictiontorque", "torque", "frictionmoment", "moment", "drehmoment", "tq"),
    "angle": ("angle", "angulardisplacement", "angularposition", "rotation", "theta", "phi"),
    "angular_velocity": ("angularvelocity", "angularspeed", "omega", "rotationalspeed", "rpm"),
    "angular_acceleration": ("angularacceleration", "alpha"),
}
COEFFICIENTS = ("frictioncoefficient", "coefficientoffriction", "cof", "mu")
STRESSES = ("shearstress", "normalstress", "sigman", "tau")
WHOLE = ""  # in place of a column
RECORD = "record"  # the column that says which record a row belongs to


@dataclasses.dataclass(frozen=True)
class Table:
    """Columns of one record as they stand in a file, before anyone knows what they are.

    name: of the record; source: the file; columns: arrays by the name of the column
    units: unit of a column by its name, where the file has a line of units
    scalars: single numbers beside the columns (a sampling interval, a mass)
    place: how a message names a row, from its index; named: whether the file names its columns
    faults: (number of a line, what is wrong with it) by the name of the column, by `WHOLE` of the line as a whole
    """

    name: str
    source: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    scalars: Mapping[str, float] = dataclasses.field(default_factory=dict)
    place: Callable[[int], str] = "index {}".format
    named: bool = True
    faults: Mapping[str, Sequence[tuple[int, str]]] = dataclasses.field(default_factory=dict)

    def faults_in(self, columns: Iterable[str]) -> list[str]:
        """What is wrong with the lines of these columns, in the order of the file."""
        return [text for _, text in sorted(fault for name in (WHOLE, *columns) for fault in self.faults.get(name, ()))]


@dataclasses.dataclass(frozen=True)
class Choice:
    """A column taken for a quantity: its name, its unit, and which of both was guessed.

    A unit is guessed where neither the user nor the file says one: it is then that of SI.
    """

    column: str
    unit: Unit
    guessed: bool
    unit_guessed: bool = False


def heading(text: str) -> list[tuple[str, Unit | None]]:
    """(name in small letters without marks, unit or None) that a column's heading may mean, the likelier first.

    "Force [kN]", "Displ(microns)", "vel_m_per_s" and "x/mm" have a unit; "time_s" may be a time in s or a "times".
    """
    parts = bracketed(text)
    if parts is not None:
        return [(_plain(parts[0]), unit_named(parts[1]))]
    readings: list[tuple[str, Unit | None]] = []
    for mark in re.finditer(r"[\s_./,-]+", text.strip()):
        unit = known_units.suffix_unit(text.strip()[mark.end() :])
        if unit is not None and mark.start() > 0:
            readings.append((_plain(text.strip()[: mark.start()]), unit))
    return [*readings, (_plain(text), None)]


def bracketed(text: str) -> tuple[str, str] | None:
    """(name, what stands in brackets behind it) of a heading; None without brackets, or with nothing in them."""
    match = re.fullmatch(r"(.*?)[\s_,]*[\[({<]([^\])}>]*)[\])}>]\s*", text)
    return (match[1], match[2]) if match and match[2].strip() else None


def _plain(text: str) -> str:
    return re.sub(r"[\W_]+", "", text).lower()


def quantity_of(text: str) -> tuple[str, Unit | None, int] | None:
    """(quantity, unit or None, rank among the usual names) that a heading stands for; None where it is not usual.

    A unit in brackets need not fit the name: that is told when the column is read.
    """
    for name, unit in heading(text):
        for quantity, names in USUAL.items():
            if name in names and (unit is None or fits(unit, quantity) or bracketed(text)):
                return quantity, unit_named("rpm") if name == "rpm" and unit is None else unit, names.index(name)
    return None


def choices(table: Table, columns: Mapping[str, Any], units: Mapping[str, str], wrong: list[str]) -> dict[str, Choice]:
    """The column for each quantity that a table has, with its unit; complaints are added to `wrong`.

    A quantity of a turning contact stands at that of a straight one: a torque at "force", an angle at "displacement".
    """
    named: dict[str, str] = {}  # column by the quantity as it was called
    for quantity in (called for called in columns if called in QUANTITIES or called in TURNING):
        name = _column_named(columns[quantity], table)
        if name is None:
            wrong.append(f"columns: {quantity}: {missing(columns[quantity], table)}")
        elif base_quantity(quantity) in map(base_quantity, named):
            wrong.append(f"columns: {quantity}: {base_quantity(quantity)} is given, too; name one of them")
        else:
            named[quantity] = name
    taken = set(named.values())
    asked = {base_quantity(quantity) for quantity in columns}
    guesses: dict[str, tuple[int, str]] = {}
    for name in table.columns if table.named else ():
        meant = quantity_of(name)
        if meant is None or name in taken:
            continue
        quantity, _, rank = meant
        if base_quantity(quantity) not in asked and rank < guesses.get(quantity, (rank + 1, ""))[0]:
            guesses[quantity] = (rank, name)
    _tell_normal(table, columns, taken, guesses)
    _one_motion(named, guesses)
    calls = named | {quantity: name for quantity, (_, name) in guesses.items()}
    written = {quantity: _written_unit(name, quantity, table, units, wrong) for quantity, name in calls.items()}
    turning = any(name in TURNING or (unit is not None and unit.turns) for name, unit in written.items())
    by_quantity: dict[str, Choice] = {}
    for quantity, name in calls.items():
        unit = written[quantity] or _usual_unit(name, quantity, table, turning)
        by_quantity[base_quantity(quantity)] = Choice(name, unit, quantity in guesses, written[quantity] is None)
    return by_quantity


def _one_motion(named: Mapping[str, str], guesses: dict[str, tuple[int, str]]) -> None:
    """Where a file has columns of both motions, keep those of one: the named ones, else the straight ones if whole."""
    both = [turning for turning, straight in TURNING.items() if turning in guesses and straight in guesses]
    if not both:
        return
    whole = "force" in {*named, *guesses} and bool({"velocity", "displacement"} & {*named, *guesses})
    turned = "torque" in guesses and bool({"angle", "angular_velocity"} & {*guesses})
    straight = not any(quantity in TURNING for quantity in named) and (whole or not turned)
    for turning in both:
        guesses.pop(turning if straight else TURNING[turning])
    if straight and whole:
        for turning in TURNING:
            guesses.pop(turning, None)


def _tell_normal(
    table: Table, columns: Mapping[str, Any], taken: set[str], guesses: dict[str, tuple[int, str]]
) -> None:
    """Take a column "F_N" for the normal force where another one is the friction; alone, its N is newton."""
    column = next((name for name in table.columns if name.lower() == "f_n" and name not in taken), None)
    if column is None or "normal_force" in columns or "normal_force" in guesses:
        return
    means = {name: quantity_of(name) for name in table.columns if name != column and name not in taken}
    others = [(meant[2], name) for name, meant in means.items() if meant is not None and meant[0] == "force"]
    if "force" in columns or others:
        guesses["normal_force"] = (0, column)
        guesses.pop("force", None)
        if others and "force" not in columns:
            guesses["force"] = min(others)


def _column_named(wanted: Any, table: Table) -> str | None:
    """The name of the column that is asked for by name, with its unit or without, or by place, counted from 0."""
    names = list(table.columns)
    if isinstance(wanted, int) and not isinstance(wanted, bool):
        return names[wanted] if 0 <= wanted < len(names) else None
    if wanted in names:
        return wanted
    for known in (names, [re.split(r"\s*[\[(]", name)[0] for name in names]):
        alike = [name for name, as_known in zip(names, known, strict=True) if as_known.lower() == str(wanted).lower()]
        if alike:
            return alike[0] if len(alike) == 1 else None
    return None


def missing(wanted: Any, table: Table) -> str:
    """That a column is not there, the nearest one, and which are."""
    small, none = {name.lower(): name for name in table.columns}, f"{table.source} has no column {wanted!r};"
    near = difflib.get_close_matches(str(wanted).lower(), small, n=1, cutoff=0.5)
    if not table.named:
        return f"{none} it names none, count them from 0: 0 to {len(table.columns) - 1}"
    hint = f"did you mean {small[near[0]]!r}? " if near else ""
    return f"{none} {hint}there is {', '.join(map(repr, table.columns)) or 'none'}"


def _written_unit(name: str, quantity: str, table: Table, units: Mapping[str, str], wrong: list[str]) -> Unit | None:
    """The unit of a column as the user says, else as the file says; None where neither does.

    A unit that is said and cannot be read, or is none of this quantity, is complained of: it is never left aside.
    """
    own = next((unit for called, unit in units.items() if base_quantity(called) == base_quantity(quantity)), None)
    if own is not None:
        return known_units.column_unit(own)  # checked among the settings
    parts = bracketed(name) if table.named else None
    written = table.units.get(name, "").strip() or (parts[1].strip() if parts else "")
    if written:
        unit = unit_named(written)
        if unit is None or not fits(unit, quantity):
            complaint = (known_units.unit_complaint(quantity, written) or "").replace("units: ", "", 1)
            wrong.append(f"{complaint} (column {name!r}); say units={{'{quantity}': ...}}")
        return unit
    for _, unit in heading(name) if table.named else ():
        if unit is not None and fits(unit, quantity):
            return unit
    return unit_named("rpm") if table.named and _plain(name) == "rpm" else None


def _usual_unit(name: str, quantity: str, table: Table, turning: bool) -> Unit:
    """The unit of a column of which nothing is said: of its usual name, else that of SI."""
    readings = heading(name) if table.named else []
    plain = readings[-1][0] if readings else ""
    beside = bool(table.units) or any(unit for other in table.columns for _, unit in heading(other))
    if quantity == "force" and (plain in COEFFICIENTS or (plain == "friction" and beside)):
        return Unit("1", "number", 1.0)  # friction without a unit, in a file that gives units, is a coefficient
    if plain in STRESSES and "stress" in known_units.dimensions_of(quantity):
        return Unit("Pa", "stress", 1.0)
    return known_units.si_unit(quantity, turning)


def turns(by_quantity: Mapping[str, Choice], wrong: list[str]) -> bool:
    """Whether the columns are those of a contact that turns; a complaint where they are of both kinds."""
    units = {quantity: choice.unit for quantity, choice in by_quantity.items() if quantity != "normal_force"}
    turning = [quantity for quantity, unit in units.items() if unit.turns]
    straight = [quantity for quantity, unit in units.items() if unit.dimension in known_units.LINEAR]
    if turning and straight:
        parts = [f"{q} (column {by_quantity[q].column!r}) is in {units[q].name}" for q in (*straight, *turning)]
        wrong.append(
            f"{', '.join((*straight, *turning))}: {', '.join(parts)}; should be a force over a straight motion, or a "
            "torque over a turning one: say the units, or multiply by the lever arm before"
        )
    return bool(turning)


def setting_complaints(columns: Mapping[str, Any], units: Mapping[str, str]) -> list[str]:
    """What is wrong with the settings themselves, whatever the file."""
    wrong, called = [], (*QUANTITIES, *TURNING)
    for field, names, known in (("columns", columns, (*called, RECORD)), ("units", units, called)):
        strange = (name for name in names if name not in known)
        wrong += [f"{field}: {name!r} is no quantity of a record; {suggestion(name, known)}" for name in strange]
    complaints = (known_units.unit_complaint(quantity, text) for quantity, text in units.items() if quantity in called)
    return [*wrong, *filter(None, complaints)]


def values_in_si(
    table: Table, by_quantity: Mapping[str, Choice], area: float | None, normal_force: float | None, wrong: list[str]
) -> dict[str, Any]:
    """The columns in SI units. A stress is turned to a force by the area; a friction coefficient by the normal force.

    A coefficient whose normal force is not known is taken for the force under a load of 1 N.
    """
    values: dict[str, Any] = {} if normal_force is None else {"normal_force": normal_force}
    coefficient = "force" in by_quantity and by_quantity["force"].unit.dimension == "number"
    for quantity, choice in by_quantity.items():
        scaled = np.asarray(table.columns[choice.column], dtype=np.float64) * choice.unit.factor
        if choice.unit.dimension == "stress":
            if area is None and quantity == "normal_force" and coefficient:
                continue  # beside a coefficient, a normal stress is not needed
            if area is None:
                stress = f"{quantity} (column {choice.column!r}) is a stress, in {choice.unit.name}"
                wrong.append(f"area: is missing; {stress}; give the area of contact in m^2")
                continue
            scaled = scaled * area
        values[quantity] = scaled
    if coefficient:
        values.setdefault("normal_force", 1.0)
        if np.ndim(values["normal_force"]) == 0 or len(values["normal_force"]) == len(values["force"]):
            values["force"] = values["force"] * values["normal_force"]
    return values


def notes(by_quantity: Mapping[str, Choice], values: Mapping[str, Any]) -> Iterable[str]:
    """What was understood, a line for each column."""
    for quantity, choice in by_quantity.items():
        how = " (guessed from its name)" if choice.guessed else ""
        if np.ndim(values.get(quantity, 0.0)) == 0:  # it was left aside for a single number
            yield f"{quantity}: column {choice.column!r}{how} is not used"
            continue
        unit = "a friction coefficient" if choice.unit.name == "1" else choice.unit.name
        assumed = "; no unit given, SI assumed" if choice.unit_guessed else ""
        yield f"{quantity}: column {choice.column!r} in {unit}{how}{assumed}"
    if "force" in by_quantity and by_quantity["force"].unit.dimension == "number":
        load = values["normal_force"]
        yield f"force: the coefficient {'times the normal force' if np.ndim(load) else f'for a load of {load:g} N'}"
