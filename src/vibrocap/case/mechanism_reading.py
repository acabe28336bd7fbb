"""Reading [mechanism]: its tables become the class of a machine, or complaints, each with the path of its key."""

import contextlib
import difflib
import functools
import json
import keyword
import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from vibrocap.arguments import Complaints, is_number, is_whole, listed, shown, suggestion
from vibrocap.case.expressions import Expression, ExpressionError, in_words
from vibrocap.case.mechanism import (
    BODIES,
    BODY,
    KIND,
    LOADS,
    NAME,
    PARTS,
    STRETCH,
    TABLES,
    Mechanism,
    MechanismError,
    Planned,
    placed,
)
from vibrocap.case.mechanism_tables import (
    MOST,
    MOST_PRODUCTS,
    RANGES,
    UNITS,
    WORD,
    limits_text,
    number_or_word,
    numbered_text,
    tables,
    within,
)
from vibrocap.physics.dimensions.scales import EFFORTS, STANDARD_GRAVITY_M_PER_S2, FreeScales, SIScales
from vibrocap.physics.dimensions.units import unit_name
from vibrocap.physics.drives.loadings import Constant
from vibrocap.physics.machines.machine import IMPOSED
from vibrocap.physics.mechanics.forms import whole_pattern
from vibrocap.physics.mechanics.parts import Coordinate, Signal
from vibrocap.physics.mechanics.sums import bounded
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import (
    FORCE,
    MASS,
    NUMBER,
    ROLES,
    TIME,
    TORQUE,
    Dimension,
    dimension_of_role,
    dimension_of_unit,
    parameter,
    parameters,
)
from vibrocap.physics.symbols import OF_LAWS, QUANTITIES

RESERVED = {"time", "drive", "pi", "ground", "kind", *LOADS, *QUANTITIES, *OF_LAWS}


def mechanism(description: Any) -> type[Mechanism]:
    """The machine of a description, the tables of [mechanism]; the same class for the same tables.

    Raises MechanismError with every complaint.
    """
    complaints = Complaints()
    rows = tables(description, complaints)
    if complaints:
        raise MechanismError(complaints)
    return made(json.dumps(rows))


@functools.cache
def made(text: str) -> type[Mechanism]:
    """The class of a description; MechanismError with every complaint."""
    reading = Reading(json.loads(text))
    if reading.complaints:
        raise MechanismError(reading.complaints)
    kind = reading.kind()
    with placed(KIND), bounded(MOST_PRODUCTS):  # all that follows from it but its numbers
        form = kind.form(whole_pattern(kind))
        for name in ("rates", "contacts", "energy"):
            form.program(name)
    reading.judge_use()
    if reading.complaints:
        raise MechanismError(reading.complaints)
    return kind


def _reduced(machine: Mechanism) -> tuple:
    """How a machine is made again in another process, from its description."""
    return _blank, (json.dumps(machine.description),), vars(machine)


def _blank(text: str) -> Mechanism:
    """A machine of a description, without its values."""
    return object.__new__(made(text))


class Reading:
    """A description as it is read: names with their dimensions, fields of the class, its parts in order."""

    def __init__(self, tables: dict[str, Any]):
        self.tables, self.complaints = tables, Complaints()
        self.scaled = tables.get("units", UNITS[0]) == UNITS[0]
        self.effort = tables.get("effort", "force")
        self.sizes: dict[str, Dimension] = {"time": TIME}
        if self.effort in IMPOSED:
            self.sizes["drive"] = EFFORTS[self.effort]
        self.words: set[str] = set()  # parameters that may be a word
        self.used: set[str] = set()  # names that stand in expressions
        self.required: list[str] = []  # parameters without a default
        self.space: dict[str, Any] = {"__annotations__": {}}
        for table, read in zip(TABLES, (self._parameter, self._coordinate, self._signal), strict=True):
            for name, row in tables.get(table, {}).items():
                read(name, row)
        coordinates = [quantity for quantity in self.space.values() if isinstance(quantity, Coordinate)]
        if (several := sum(coordinate.count or 1 for coordinate in coordinates)) > MOST:
            self.complaints.add(f"{KIND}.coordinates", f"should be at most {MOST}, got {several}")
        self.planned = () if self.complaints else self._in_order(self._plan())

    def kind(self) -> type[Mechanism]:
        name = self.tables.get("name", KIND)
        gravity = self.tables.get("gravity", 1.0 if self.scaled else STANDARD_GRAVITY_M_PER_S2)
        self.space |= {
            "__module__": __name__,
            "__doc__": f"{name}, a mechanism of a case.",
            "name": name,
            "source": self.tables.get("source", "the case in which it is described"),
            "effort": self.effort,
            "si_scales": FreeScales if self.scaled else SIScales,
            "description": self.tables,
            "planned": self.planned,
            "required": tuple(self.required),
            "weight": float(gravity),
            "weighs": "gravity" in self.tables or bool(self.words),
            "__reduce__": _reduced,
            **({"cyclic": None} if "travels" in self.tables else {}),
        }
        with placed(KIND):
            return parameters(type(name.title().replace("-", ""), (Mechanism,), self.space))

    def judge_use(self) -> None:
        """A complaint for each parameter and signal that no part uses."""
        for table in ("parameters", "signals"):
            for name in self.tables.get(table, {}):
                if name not in self.used:
                    self.complaints.add(f"{KIND}.{table}.{name}", "no part uses it")

    # --- names -------------------------------------------------------------------------------------------------------

    def _named(self, where: str, name: str, dimension: Dimension | None) -> bool:
        """Whether a name is free; then it is taken."""
        if not WORD.fullmatch(name) or keyword.iskeyword(name):
            self.complaints.add(where, f"should be named by letters, digits and _, got {shown(name)}")
        elif name in RESERVED or name in dir(Mechanism):
            self.complaints.add(where, f"{name!r} has a meaning already; choose another name")
        elif name in self.sizes or name in self.space:
            self.complaints.add(where, f"{name!r} is there already")
        elif dimension is None:
            self.space[name] = None
            return True
        else:
            self.sizes[name] = dimension
            return True
        return False

    def _dimension(self, where: str, row: Mapping[str, Any], units: tuple[str, ...] = ()) -> Dimension | None:
        """The dimension of a parameter, coordinate or signal, by its role or its unit."""
        key = "role" if "role" in row and not units else "unit"
        text, wanted = row.get(key), f"one of {listed(units)}" if units else 'a unit such as "N s/m", "1" of a number'
        if "role" in row and "unit" in row:
            self.complaints.add(f"{where}.unit", "should be left out: the role has its unit already")
        elif key == "role" and str(text) not in ROLES:
            near = suggestion(text, ROLES) if difflib.get_close_matches(str(text), ROLES, 1) else "give a unit instead"
            self.complaints.add(f"{where}.role", f"there is no role {shown(text)}; {near}")
        elif key == "role":
            return dimension_of_role(text).resolved(EFFORTS[self.effort])
        elif isinstance(text, str) and (not units or text in units):
            with contextlib.suppress(ValueError):
                return dimension_of_unit(text)
            self.complaints.add(f"{where}.unit", f"should be {wanted}, got {shown(text)}")
        else:
            more = "" if units else ", or in place of it a role"
            self.complaints.add(f"{where}.unit", f"should be {wanted}{more}, got {shown(text)}")
        return None

    def _texts(self, where: str, name: str, row: Mapping[str, Any]) -> tuple[str, str]:
        """(symbol, meaning)."""
        texts = row.get("symbol", name), row.get("meaning", name.replace("_", " "))
        for key, text in zip(("symbol", "meaning"), texts, strict=True):
            if not isinstance(text, str) or not 1 <= len(text) <= 200:
                self.complaints.add(f"{where}.{key}", f"should be a text of at most 200 characters, got {shown(text)}")
        return texts

    def _parameter(self, name: str, row: Mapping[str, Any]) -> None:
        where, count = f"{KIND}.parameters.{name}", len(self.complaints)
        dimension, texts = self._dimension(where, row), self._texts(where, name, row)
        limits, words = self._limits(f"{where}.range", row.get("range", "> 0")), row.get("words", [])
        if not isinstance(words, list) or not all(word in LOADS for word in words):
            self.complaints.add(f"{where}.words", f"should be a list of {listed(LOADS)}, got {shown(words)}")
            words = []
        if "default" not in row and not self.scaled:
            self.required.append(name)
        default = row.get("default", None if self.scaled else 1.0)
        if default not in words and not (is_number(default) and within(default, limits)):
            wanted = listed([limits_text(limits), *map(repr, words)], " or ")
            self.complaints.add(f"{where}.default", f"should be a number {wanted}, got {shown(default)}")
        if len(self.complaints) > count or not self._named(where, name, dimension):
            return
        own = {"role": row["role"]} if "role" in row else {"unit": row["unit"]}
        self._field(name, default, texts, own, limits, tuple(words))

    def _field(self, name: str, default: Any, texts: Any, own: Any, limits: Any, words: tuple[str, ...] = ()) -> None:
        number: Any = Annotated[float, Field(strict=True, allow_inf_nan=False, **limits)]
        if words:
            self.words.add(name)
            number = Annotated[Any, BeforeValidator(functools.partial(number_or_word, limits, words))]
        self.space["__annotations__"][name] = number
        self.space[name] = parameter(default if isinstance(default, str) else float(default), *texts, **own)

    def _limits(self, where: str, value: Any) -> dict[str, float]:
        """Between which values a parameter is, as pydantic says it."""
        if isinstance(value, str) and value in RANGES:
            return dict(RANGES[value])
        pair = isinstance(value, list) and len(value) == 2 and all(map(is_number, value))
        if pair and -1e300 < float(value[0]) < float(value[1]) < 1e300:
            return {"ge": float(value[0]), "le": float(value[1])}
        self.complaints.add(where, f"should be one of {listed(RANGES)}, or [least, most], got {shown(value)}")
        return {}

    def _coordinate(self, name: str, row: Mapping[str, Any]) -> None:
        where, count = f"{KIND}.coordinates.{name}", len(self.complaints)
        dimension, texts = self._dimension(where, row, ("m", "rad")), self._texts(where, name, row)
        several, rate = row.get("repeat"), row.get("rate")
        repeats: Any = row.get("repeats")
        if several is not None and not self._repeats(where, several):
            several = None
        if repeats is not None:
            try:
                turn = repeats = float(Expression(repeats, ())({}, {}))
                if not 0.0 < turn < math.inf:
                    raise ExpressionError(f"should be above 0, got {turn:g}")
            except (ExpressionError, ArithmeticError, ValueError) as error:
                self.complaints.add(f"{where}.repeats", str(error))
        if rate is not None and not (isinstance(rate, str) and self._named(f"{where}.rate", rate, None)):
            self.complaints.add(f"{where}.rate", f"should be a name, got {shown(rate)}")
        names = [numbered(name, i) for i in range(1, (several or 1) + 1)]
        if all(self._named(where, name, dimension or NUMBER) for name in names) and len(self.complaints) == count:
            if several:
                self.sizes[f"{name}_1"] = self.sizes[name]
            self.space[name] = Coordinate(*texts, row["unit"], rate, repeats, several)

    def _repeats(self, where: str, several: Any) -> bool:
        if not (right := is_whole(several, 1, MOST)):
            self.complaints.add(f"{where}.repeat", f"should be a whole number from 1 to {MOST}, got {shown(several)}")
        return right

    def _signal(self, name: str, row: Mapping[str, Any]) -> None:
        where, count = f"{KIND}.signals.{name}", len(self.complaints)
        dimension, texts = self._dimension(where, row), self._texts(where, name, row)
        if len(self.complaints) == count and self._named(where, name, dimension or NUMBER):
            self.space[name] = Signal(*texts, row["unit"], Constant())

    # --- parts -------------------------------------------------------------------------------------------------------

    def _plan(self) -> list[Planned]:
        rows = [(part, i, row) for part in PARTS for i, row in enumerate(self.tables.get(part, []), 1)]
        planned: list[tuple[str, str, dict[str, Any]]] = []
        for part, number, row in rows:
            where, several = f"{KIND}.{part}[{number}]", row.get("repeat", 1)
            if not self._repeats(where, several):
                continue
            plain = {key: value for key, value in row.items() if key != "repeat"}
            for i in range(1, several + 1):
                place = f"{where}, i = {i}" if "repeat" in row else where
                planned.append((part, place, {key: numbered_text(value, i) for key, value in plain.items()}))
        self.bodies: dict[str, str] = {}
        for part, where, row in planned:
            if PARTS[part][1].get("name") == NAME:
                name = row["name"]
                if not isinstance(name, str) or not 1 <= len(name) <= 64 or name in ("ground", *self.bodies):
                    self.complaints.add(f"{where}.name", f"should be a name of its own, got {shown(name)}")
                else:
                    self.bodies[name] = part
        if len(planned) > 4 * MOST or len(self.bodies) > MOST:
            self.complaints.add(KIND, f"should have at most {MOST} bodies and {4 * MOST} parts")
        plans: list[Planned] = []
        for part, where, row in [] if self.complaints else planned:
            fields = (str(complaint).partition(", i = ")[0] for complaint in self.complaints)
            if where.partition(", i = ")[0] not in fields:  # of a part that is repeated the first fault
                plans.append(self._planned(part, where, row))
        return plans

    def _planned(self, part: str, where: str, row: Mapping[str, Any]) -> Planned:
        make, keys, _ = PARTS[part]
        fields: dict[str, Any] = {}
        sizes: dict[str, Dimension | None] = {}
        for key, value in row.items():
            try:
                fields[key] = self._value(f"{where}.{key}", key, keys[key], value)
                if isinstance(fields[key], Expression):
                    sizes[key] = fields[key].dimension(self.sizes, self.scaled)
            except ExpressionError as error:
                self.complaints.add(f"{where}.{key}", str(error))
        if len(fields) < len(row):
            return Planned(where, make, {})
        if part == "stop" and ("stretch" in fields) == ("between" in fields):
            self.complaints.add(f"{where}.stretch", "should be given, or in place of it between = [BODY, BODY]")
        along = sizes.get("stretch", sizes.get("path", dimension_of_unit("m")))
        if part == "contact" and "path" not in fields and self.bodies.get(fields["body"]) == "inertia":
            along = NUMBER
        for key, own in sizes.items():
            self._check_size(f"{where}.{key}", row[key], own, self._wanted(keys[key], along))
        return Planned(where, make, fields)

    def _value(self, where: str, key: str, wanted: str, value: Any) -> Any:
        if wanted == NAME:
            if not isinstance(value, str) or (key == "speed" and not WORD.fullmatch(value)):
                raise ExpressionError(f"should be a name, got {shown(value)}")
            return value
        bodies = {"ground": "support", **self.bodies}
        if wanted in (BODY, BODIES):
            names = [value] if wanted == BODY else value
            if not isinstance(names, list) or len(names) != (1 if wanted == BODY else 2):
                raise ExpressionError(f"should be a list of two bodies, got {shown(value)}")
            for name in names:
                if not isinstance(name, str) or name not in bodies:
                    raise ExpressionError(f"there is no body {shown(name)}; {suggestion(name, bodies)}")
            return value if wanted == BODY else tuple(value)
        if key == "load" and value in LOADS:
            return value
        expression = Expression(value, self.sizes, self.bodies)
        self.used |= expression.names_in
        if (inside := self.words & expression.names_in) and not (key == "load" and expression.is_name):
            raise ExpressionError(f"{shown(value)}: {min(inside)!r} may be a word, so it stands alone, as a load")
        return expression

    def _wanted(self, unit: str, along: Dimension | None) -> tuple[Dimension, ...]:
        """The dimensions that a key may have; none: any."""
        if unit == STRETCH:
            return dimension_of_unit("m"), NUMBER
        if unit == "J/drive":
            return (TORQUE / EFFORTS[self.effort],)
        if "stretch" not in unit:
            return (dimension_of_unit(unit),)
        if along is None:
            return ()
        dimensions = {
            "stretch": along,
            "stretch/s": along / TIME,
            "J/stretch": TORQUE / along,
            "J/stretch^2": TORQUE / along**2,
            "J s/stretch^2": TORQUE * TIME / along**2,
            "J s^2/stretch^3": TORQUE * TIME**2 / along**3,
        }[unit]
        return (dimensions, MASS) if unit == "J/stretch" and self.scaled and dimensions == FORCE else (dimensions,)

    def _check_size(self, where: str, text: Any, own: Dimension | None, wanted: tuple[Dimension, ...]) -> None:
        if own is not None and wanted and own not in wanted:
            units = listed((unit_name(size) if size != NUMBER else "rad or 1" for size in wanted), " or ")
            cure = f": multiply it by a parameter in {units}" if own == NUMBER else ""
            self.complaints.add(where, f"{shown(text)} is {in_words(own)}, should be in {units}{cure}")

    def _in_order(self, parts: list[Planned]) -> tuple[Planned, ...]:
        """Each body after those that it names, then all other parts as they stand, by which contacts are counted."""
        ordered, left, known = [], [part for part in parts if "name" in part.fields], set()
        others = [part for part in parts if part not in left]
        while left and not self.complaints:
            ready = [part for part in left if known.issuperset(part.needs)]
            if not ready:
                self.complaints.add(f"{left[0].where}.on", "stands on itself, by way of other bodies")
            ordered += ready
            known |= {part.fields["name"] for part in ready}
            left = [part for part in left if part not in ready]
        return *ordered, *others
