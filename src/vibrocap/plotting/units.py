"""Units in pictures: labels of quantities with their SI unit, and a case in brief in SI."""

from collections.abc import Mapping
from typing import Any

from vibrocap.case.case import KEYS, Case
from vibrocap.physics.conversion import path_in_si
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.roles import NUMBER
from vibrocap.physics.scales import Scales
from vibrocap.physics.system import System
from vibrocap.physics.units import parameter_keys, suffix, unit_name, written_in_si
from vibrocap.plotting.labels import EQUALS, LETTERS_PER_INCH, filled, law_words

IN_SI = "In SI units."
KIND_PATHS = {name: f"{name}.{key}" for name, key in KEYS.items()}  # such as "friction.law"


def with_unit(label: str, name: str, system: System) -> str:
    """A label with the SI unit of a quantity, of a system that knows its scales."""
    unit = "1" if system.units is None else system.si.unit(name)
    return label if unit == "1" else f"{label} [{unit}]"


def scale(name: str, system: System) -> float:
    """By what values of a quantity are multiplied for a picture: to SI, of a system that knows its scales."""
    return 1.0 if system.units is None else system.si.factor(name)


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
        path = KIND_PATHS.get(name, "")
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
            found.append(
                f"{each.stem.replace('_', ' ')}{EQUALS}{number:.4g} {each.unit}".replace("-", "\N{MINUS SIGN}")
            )
    return found
