"""A part in a line, with its units."""

from typing import Any

from vibrocap.physics.dimensions.units import Units, parameter_keys, suffix, unit_name, written_in_si
from vibrocap.physics.parameters import described, given_parameters, parameter_table
from vibrocap.physics.system import System


def in_words(part: Any, system: System, digits: int = 6) -> str:
    """A part in a line, in SI where the system knows its scales: its name, and each parameter with its unit."""
    if system.units is None:
        return described(part, digits)
    own = _keys(part, system)
    words = []
    for key, value in _values(part, system).items():
        name, unit = own.get(key, (key, "1"))
        number = value if isinstance(value, str) else f"{value:.{digits}g}"
        words.append(" ".join((name, number) if unit == "1" else (name, number, unit)))
    return f"{part.name}: {', '.join(words)}"


def _units(part: Any, system: System) -> Units:
    return system.si.of_part("drive" if part is system.drive else "")


def _keys(part: Any, system: System) -> dict[str, tuple[str, str]]:
    """(name without unit, unit) by the keys of a part in SI, for a machine those of its scales too."""
    known = parameter_keys(type(part), _units(part, system).effort)
    keys = {key: (each.stem, each.unit) for key, each in known.items()}
    if part is system.machine and system.units is not None:
        for info in parameter_table(system.units):
            assert info.dimension is not None
            unit = unit_name(info.dimension)
            keys[info.name] = (info.name.removesuffix(suffix(unit)), unit)
    return keys


def _values(part: Any, system: System) -> dict[str, Any]:
    """Values of a part by keys in SI, for a machine those of its scales too."""
    scales = given_parameters(system.units) if part is system.machine else {}
    return (written_in_si(part, _units(part, system), exactly=False) or {}) | scales
