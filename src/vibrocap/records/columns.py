"""Which column of a file is which quantity, in which unit: as the user says, else guessed from the usual names."""

import dataclasses
import difflib
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import suggestion
from vibrocap.records.units import QUANTITIES, dimension, factor, fits, si_unit, unit_complaint, unit_named

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
}
COEFFICIENTS = ("frictioncoefficient", "coefficientoffriction", "cof", "mu")
STRESSES = ("shearstress", "normalstress", "sigman", "tau")
RECORD = "record"  # the column that says which record a row belongs to


@dataclasses.dataclass(frozen=True)
class Table:
    """Columns of one record as they stand in a file, before anyone knows what they are.

    name: of the record; source: the file; columns: arrays by the name of the column
    units: unit of a column by its name, where the file has a line of units
    scalars: single numbers beside the columns (a sampling interval, a mass)
    place: how a message names a row, from its index; named: whether the file names its columns
    """

    name: str
    source: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    scalars: Mapping[str, float] = dataclasses.field(default_factory=dict)
    place: Callable[[int], str] = "index {}".format
    named: bool = True


@dataclasses.dataclass(frozen=True)
class Choice:
    """A column taken for a quantity: its name, its unit, and whether the name was guessed."""

    column: str
    unit: str
    guessed: bool


def heading(text: str) -> list[tuple[str, str | None]]:
    """(name in small letters without marks, unit or None) that a column's heading may mean, the likelier first.

    "Force [kN]", "Displ(microns)", "vel_m_per_s" and "x/mm" have a unit; "time_s" may be a time in s or a "times".
    """
    bracketed = re.fullmatch(r"(.*?)[\s_,]*[\[({<]([^\])}>]*)[\])}>]\s*", text)
    if bracketed:
        return [(_plain(bracketed[1]), unit_named(bracketed[2]))]
    readings: list[tuple[str, str | None]] = []
    for mark in re.finditer(r"[\s_./,-]+", text.strip()):
        unit = unit_named(text.strip()[mark.end() :])
        if unit is not None and mark.start() > 0:
            readings.append((_plain(text.strip()[: mark.start()]), unit))
    return [*readings, (_plain(text), None)]


def _plain(text: str) -> str:
    return re.sub(r"[\W_]+", "", text).lower()


def quantity_of(text: str) -> tuple[str, str | None, int] | None:
    """(quantity, unit or None, rank among the usual names) that a heading stands for; None where it is not usual."""
    for name, unit in heading(text):
        for quantity, names in USUAL.items():
            if name in names and (unit is None or fits(unit, quantity)):
                return quantity, unit, names.index(name)
    return None


def choices(table: Table, columns: Mapping[str, Any], units: Mapping[str, str], wrong: list[str]) -> dict[str, Choice]:
    """The column for each quantity that a table has, with its unit; complaints are added to `wrong`."""
    found: dict[str, Choice] = {}
    for quantity, wanted in columns.items():
        if quantity not in QUANTITIES:
            continue
        name = _column_named(wanted, table)
        if name is None:
            wrong.append(f"columns: {quantity}: {missing(wanted, table)}")
        else:
            found[quantity] = Choice(name, _unit(name, quantity, table, units), False)
    taken = {choice.column for choice in found.values()}
    guesses: dict[str, tuple[int, str]] = {}
    for name in table.columns if table.named else ():
        meant = quantity_of(name)
        if meant is None or name in taken:
            continue
        quantity, _, rank = meant
        if quantity not in columns and rank < guesses.get(quantity, (rank + 1, ""))[0]:
            guesses[quantity] = (rank, name)
    _tell_normal(table, columns, taken, guesses)
    for quantity, (_, name) in guesses.items():
        found[quantity] = Choice(name, _unit(name, quantity, table, units), True)
    return found


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
    """The name of the column that is asked for by name or, counted from 0, by place."""
    names = list(table.columns)
    if isinstance(wanted, int) and not isinstance(wanted, bool):
        return names[wanted] if 0 <= wanted < len(names) else None
    if wanted in names:
        return wanted
    alike = [name for name in names if isinstance(wanted, str) and name.lower() == wanted.lower()]
    return alike[0] if len(alike) == 1 else None


def missing(wanted: Any, table: Table) -> str:
    """That a column is not there, the nearest one, and which are."""
    names = list(table.columns)
    small = {name.lower(): name for name in names}
    near = difflib.get_close_matches(str(wanted).lower(), small, n=1, cutoff=0.5)
    if table.named:
        hint = f"did you mean {small[near[0]]!r}? " if near else ""
        return f"{table.source} has no column {wanted!r}; {hint}there is {', '.join(map(repr, names)) or 'none'}"
    return f"{table.source} has no column {wanted!r}; it names none, count them from 0: 0 to {len(names) - 1}"


def _unit(name: str, quantity: str, table: Table, units: Mapping[str, str]) -> str:
    """The unit of a column: as the user says, else as the file says, else of its usual name, else SI."""
    said = unit_named(units[quantity]) if quantity in units else None
    if said is not None and fits(said, quantity):
        return said
    written = unit_named(table.units[name]) if name in table.units else None
    if written is not None and fits(written, quantity):
        return written
    readings = heading(name) if table.named else []
    for _, unit in readings:
        if unit is not None and fits(unit, quantity):
            return unit
    plain = readings[-1][0] if readings else ""
    beside = bool(table.units) or any(unit for other in table.columns for _, unit in heading(other))
    if quantity == "force" and (plain in COEFFICIENTS or (plain == "friction" and beside)):
        return "1"  # friction without a unit, in a file that gives units, is a coefficient
    if plain in STRESSES and fits("Pa", quantity):
        return "Pa"
    return si_unit(quantity)


def setting_complaints(columns: Mapping[str, Any], units: Mapping[str, str]) -> list[str]:
    """What is wrong with the settings themselves, whatever the file."""
    wrong = []
    for field, given, known in (("columns", columns, (*QUANTITIES, RECORD)), ("units", units, tuple(QUANTITIES))):
        for name in given:
            if name not in known:
                wrong.append(f"{field}: {name!r} is no quantity of a record; {suggestion(name, known)}")
    found = (unit_complaint(quantity, text) for quantity, text in units.items() if quantity in QUANTITIES)
    return wrong + [complaint for complaint in found if complaint]


def values_in_si(
    table: Table, chosen: Mapping[str, Choice], area: float | None, normal_force: float | None, wrong: list[str]
) -> dict[str, Any]:
    """The columns in SI units. A stress is turned to a force by the area; a friction coefficient by the normal force.

    A coefficient whose normal force is not known is taken for the force under a load of 1 N.
    """
    values: dict[str, Any] = {} if normal_force is None else {"normal_force": normal_force}
    coefficient = "force" in chosen and dimension(chosen["force"].unit) == "number"
    for quantity, choice in chosen.items():
        scaled = np.asarray(table.columns[choice.column], dtype=np.float64) * factor(choice.unit)
        if dimension(choice.unit) == "stress":
            if area is None and quantity == "normal_force" and coefficient:
                continue  # beside a coefficient, a normal stress is not needed
            if area is None:
                wrong.append(
                    f"area: is missing; {quantity} (column {choice.column!r}) is a stress, in {choice.unit}; "
                    "give the area of contact in m^2"
                )
                continue
            scaled = scaled * area
        values[quantity] = scaled
    if coefficient:
        values.setdefault("normal_force", 1.0)
        if np.ndim(values["normal_force"]) == 0 or len(values["normal_force"]) == len(values["force"]):
            values["force"] = values["force"] * values["normal_force"]
    return values


def notes(chosen: Mapping[str, Choice], values: Mapping[str, Any]) -> Iterable[str]:
    """What was understood, a line for each column."""
    for quantity, choice in chosen.items():
        how = " (guessed from its name)" if choice.guessed else ""
        if np.ndim(values.get(quantity, 0.0)) == 0:  # it was left aside for a single number
            yield f"{quantity}: column {choice.column!r}{how} is not used"
            continue
        unit = "a friction coefficient" if choice.unit == "1" else choice.unit
        yield f"{quantity}: column {choice.column!r} in {unit}{how}"
    if "force" in chosen and dimension(chosen["force"].unit) == "number":
        load = values["normal_force"]
        yield f"force: the coefficient {'times the normal force' if np.ndim(load) else f'for a load of {load:g} N'}"
