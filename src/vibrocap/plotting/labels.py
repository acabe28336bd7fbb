"""Words of pictures: symbols as they are set in print, units, and the parameters of a system in a few lines."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.case.case import Case
from vibrocap.case.sections import kind_path
from vibrocap.physics.conversion import path_in_si
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.roles import NUMBER
from vibrocap.physics.scales import Scales
from vibrocap.physics.symbols import GREEK, printed
from vibrocap.physics.system import System
from vibrocap.physics.units import parameter_keys, suffix, unit_name, written_in_si

LETTERS_PER_INCH = 14.5  # of the type of a title, roughly
EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


def symbol_text(symbol: str) -> str:
    """A symbol for a picture: "eta_c" and "delta0" with Greek letters and subscripts, as mathematics."""
    found = re.fullmatch(r"([A-Za-z]+)_?([A-Za-z0-9]*)('*)", symbol)
    if found is None:
        return printed(symbol)
    name, below, primes = found.groups()
    letter = rf"\{name}" if name in GREEK else name if len(name) == 1 else rf"\mathrm{{{name}}}"
    upright = below if len(below) < 2 or below.isdigit() else rf"\mathrm{{{below}}}"
    return f"${letter}{f'_{{{upright}}}' if below else ''}{primes}$"


def part_items(record: Any, digits: int = 4, without: str = "") -> list[str]:
    """A machine, law or drive by its name, then "symbol = value" for each of its parameters, but for one of them."""
    items = [f"{law_words(record.name)}:"]
    for info in parameter_table(record):
        value = getattr(record, info.name)
        if value is not None and info.name != without:
            shown = value if isinstance(value, str) else f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")
            items.append(f"{symbol_text(info.symbol or info.name)}{EQUALS}{shown},")
    items[-1] = items[-1].rstrip(",:")
    return items


def filled(text: str, letters: int, indent: str = "") -> str:
    """A text in lines of at most so many letters, as they are seen; lines after the first are set in.

    It is broken at spaces, and not within mathematics.
    """
    lines, used = [""], 0
    for word in re.findall(r"(?:\$[^$]*\$|[^ $\n])+", text):
        length = len(re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"\\[A-Za-z]+|[_{}]", "", found[1]) + "x", word))
        if lines[-1] and used + 1 + length > letters:
            lines.append(indent)
            used = len(indent)
        gap = "" if not lines[-1].strip() else " "
        lines[-1] += gap + word
        used += len(gap) + length
    return "\n".join(lines)


def parts_title(parts: Iterable[Any], width: float, more: str = "", without: str = "") -> str:
    """The parameters of some parts, each on lines of its own, for the head of a picture of that width in inches.

    more: what else is said at the end; without: the name of a parameter that is left out, as it varies
    """
    given = [part_items(part, without=without) for part in parts]
    if more:
        given[-1][-1] += ";"
        given[-1].append(more)
    return "\n".join(filled(" ".join(items), round(LETTERS_PER_INCH * width), "    ") for items in given)


def percent(share: float) -> str:
    """A share in percent, to a tenth."""
    return f"{100.0 * share:.1f} %"


def law_words(name: str) -> str:
    """The name of a part in words, as a title begins: "Maxwell slip", "LuGre"."""
    words = re.sub(r"\blugre\b", "LuGre", name.replace("-", " "))
    return words[0].upper() + words[1:]


IN_SI = "In SI units."


def with_unit(label: str, name: str, system: System) -> str:
    """A label with the SI unit of a quantity, of a system that knows its scales."""
    unit = system.result_units.unit(name)
    return label if unit == "1" else f"{label} [{unit}]"


def scale(name: str, system: System) -> float:
    """By what values of a quantity are multiplied for a picture: to SI, of a system that knows its scales."""
    return system.result_units.factor(name)


def parts_in_si(system: System, width: float, without: str = "") -> str:
    """The parts of a system in SI, each on lines of its own, for the head of a picture of that width in inches.

    without: the path (without units) of a parameter that is left out, as it varies
    """
    lines = []
    for name, part in system.parts.items():
        numbers = _quantities(name, part, system, {without}, {}, all_of_it=True)
        if name == "machine" and system.units is not None:
            numbers += _scales(system.units)
        text = f"{law_words(part.name)}: {', '.join(numbers)}".rstrip(": ")
        lines.append(filled(text, round(0.85 * LETTERS_PER_INCH * width), "    "))
    return "\n".join(lines)


def _scales(scales: Scales) -> list[str]:
    """What the units of a machine are, in words."""
    found = []
    for info in parameter_table(scales):
        unit = unit_name(info.dimension or NUMBER)
        stem = info.name.removesuffix(suffix(unit)).replace("_", " ")
        number = f"{getattr(scales, info.name):.4g}"
        found.append(f"{stem}{EQUALS}{number}\N{NO-BREAK SPACE}{unit}")
    return found


def case_in_si(case: Case, varied: set[str], fixed: Mapping[str, str]) -> str:
    """The kinds of the parts of a case in SI, and the quantities with a unit that a study left as they are.

    varied: paths that vary. fixed: values of paths at which a picture is fixed
    """
    system = case.system
    parts = system.parts
    plain = {place[0] for path in varied if (place := path_in_si(path, parts)) is not None}
    kinds, numbers = [], []
    for name, part in parts.items():
        path = kind_path(name)
        kind = fixed.get(path, part.name)
        if path and path not in varied:
            kinds.append(kind if name == "machine" else f"{kind} {name}")
        if kind == part.name:
            numbers += _quantities(name, part, system, varied | plain, fixed)
    return f"{', '.join(kinds)}; {', '.join(numbers)}"


def _quantities(
    name: str, part: Any, system: System, varied: set[str], fixed: Mapping[str, str], all_of_it: bool = False
) -> list[str]:
    """The quantities of a part with a unit, in words; all_of_it: those without a unit as well, but for zeros."""
    keys = parameter_keys(type(part), system.si.effort)
    found = []
    for key, value in (written_in_si(part, system.si, exactly=False) or {}).items():
        each = keys.get(key)
        if all_of_it and (each is None or not each.has_unit) and f"{name}.{key}" not in varied and value:
            number = value if isinstance(value, str) else f"{value:.4g}".replace("-", "\N{MINUS SIGN}")
            found.append(f"{key.replace('_', ' ')}{EQUALS}{number}")
        if each is not None and each.has_unit and f"{name}.{each.name}" not in varied and value:
            number = float(fixed.get(f"{name}.{key}", value))
            words = f"{each.stem.replace('_', ' ')}{EQUALS}{number:.4g} {each.unit}"
            found.append(words.replace("-", "\N{MINUS SIGN}"))
    return found
