"""Tables and keys of [mechanism]: which there are, and of which type their values are."""

import math
import re
from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import Complaints, is_number, is_whole, listed, shown, suggestion
from vibrocap.case.mechanism import HEAD, KIND, PARTS, TABLES, VERSION
from vibrocap.physics.catalogue import PART_NAME, machines

MOST = 64  # coordinates, bodies and what `repeat` makes of one part
MOST_PRODUCTS = 30_000  # of terms, while equations are derived: of a large mechanism 7,000
WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
EFFORT_WORDS = ("force", "torque", "displacement", "angle")
RANGES = {"> 0": {"gt": 0.0}, ">= 0": {"ge": 0.0}, "any": {}}
REPEATED = re.compile(r"\{i([+-]\d{1,2})?\}")
UNITS = ("scaled", "SI")


def tables(description: Any, complaints: Complaints) -> dict[str, Any]:
    """The tables in order, with what they are said to hold; complaints about keys and types."""
    if not isinstance(description, Mapping):
        complaints.add(KIND, f"should be a section, [{KIND}] with its tables below it, got {shown(description)}")
        return {}
    for key in description:
        if key not in (known := (*HEAD, *TABLES, *PARTS)):
            complaints.add(f"{KIND}.{key[:60]}", f"no such key; {suggestion(key, known)}")
    table: dict[str, Any] = {"version": VERSION, **description}
    description_tables: dict[str, Any] = {key: table[key] for key in HEAD if key in table}
    for key, what in description_tables.items():
        if (wanted := _head_wanted(key, what)) is not None:
            complaints.add(f"{KIND}.{key}", f"should be {wanted}, got {shown(what)}")
    for key in (key for key in (*TABLES, *PARTS) if key in table):
        rows, named = table[key], key in TABLES
        kind: Any = Mapping if named else list
        of_kind = isinstance(rows, kind)
        several = list((rows.values() if named else rows) if of_kind else ())
        form = f"[{KIND}.{key}] with lines NAME = {{ ... }}" if named else f"each begun by [[{KIND}.{key}]]"
        if not of_kind or not all(isinstance(row, Mapping) for row in several):
            complaints.add(f"{KIND}.{key}", f"should be tables, {form}")
        elif len(several) > 4 * MOST:
            most = f"have at most {4 * MOST} rows" if named else f"be at most {4 * MOST}"
            complaints.add(f"{KIND}.{key}", f"should {most}, got {len(several)}")
        elif named:
            for name, row in rows.items():
                _check_values(f"{KIND}.{key}.{name}", row, TABLES[key], complaints)
            description_tables[key] = {name: dict(row) for name, row in rows.items()}
        else:
            for number, row in enumerate(rows, 1):
                where = f"{KIND}.{key}[{number}]"
                _check_values(where, row, (*PARTS[key][1], "repeat"), complaints)
                for lacking in (lacking for lacking in PARTS[key][2] if lacking not in row):
                    complaints.add(f"{where}.{lacking}", "is missing")
            description_tables[key] = [dict(row) for row in rows]
    return description_tables


def _head_wanted(key: str, value: Any) -> str | None:
    """What a key of [mechanism] should be; None where it is."""
    text = value if isinstance(value, str) and len(value) <= 200 else ""
    number = float(value) if isinstance(value, (int, float)) and 0.0 <= value < 1e300 else -1.0
    wanted: dict[str, tuple[bool, str]] = {
        "version": (value == VERSION and is_whole(value), f"{VERSION}, the newest there is"),
        "name": (
            bool(re.fullmatch(PART_NAME, text)) and (text == KIND or text not in machines()),
            'a text of small letters, digits and hyphens such as "my-capsule", and no name of another machine',
        ),
        "source": (bool(text), "a text: a key of the references, or words"),
        "effort": (text in EFFORT_WORDS, f"one of {listed(EFFORT_WORDS)}"),
        "units": (text in UNITS, f"one of {listed(UNITS)}"),
        "gravity": (number >= 0.0, "a number >= 0"),
        "travels": (value is False, "false, for a machine that does not travel, or left out"),
    }
    right, words = wanted[key]
    return None if right else words


def _check_values(where: str, row: Mapping[str, Any], known: tuple[str, ...], complaints: Complaints) -> None:
    """Complaints about keys that are not known and values that are no numbers, texts or lists."""
    for key, value in row.items():
        plain = [value] if not isinstance(value, list) else value if len(value) <= MOST else [None]
        if key not in known:
            other = f"a waveform stands in [drives.{where.rpartition('.')[2]}]" if ".signals." in where else ""
            complaints.add(f"{where}.{key[:60]}", f"no such key; {other or suggestion(key, known)}")
        elif not all(isinstance(item, (str, int, float)) and not isinstance(item, bool) for item in plain):
            complaints.add(f"{where}.{key}", f"should be a number or a text, got {shown(value)}")
        elif any(isinstance(item, (int, float)) and not abs(item) < 1e300 for item in plain):
            complaints.add(f"{where}.{key}", f"should be a finite number, got {shown(value)}")
        elif any(isinstance(item, str) and len(item) > 1000 for item in plain):
            complaints.add(f"{where}.{key}", "should be a text of at most 1000 characters")


# --- ranges of parameters ---------------------------------------------------------------------------------------------


def within(value: Any, limits: Mapping[str, float]) -> bool:
    """Whether a number is in a range, given as pydantic has it."""
    above = value > limits.get("gt", -math.inf) and value >= limits.get("ge", -math.inf)
    return above and value <= limits.get("le", math.inf) and abs(value) < 1e300


def limits_text(limits: Mapping[str, float]) -> str:
    """A range in words."""
    signs = {"gt": ">", "ge": ">=", "le": "<="}
    return " and ".join(f"{signs[key]} {limit:g}" for key, limit in limits.items()) or "of any size"


def number_or_word(limits: Mapping[str, float], words: tuple[str, ...], value: Any) -> Any:
    """A value of a parameter that may be a word; ValueError where it is none."""
    if value in words if isinstance(value, str) else is_number(value) and within(value, limits):
        return value
    raise ValueError(f"should be a number {limits_text(limits)}, or {listed(map(repr, words), ' or ')}")


# --- texts of repeated parts ------------------------------------------------------------------------------------------


def numbered_text(text: Any, i: int) -> Any:
    """A text with i in place of {i}, i + 1 in place of {i+1}."""
    if isinstance(text, list):
        return [numbered_text(item, i) for item in text]
    return REPEATED.sub(lambda match: str(i + int(match[1] or 0)), text) if isinstance(text, str) else text
