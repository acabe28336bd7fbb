"""Parameters and states as they are said: with their units in SI, for tables and for heads of pictures."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from vibrocap.physics.dimensions.units import Key, parameter_keys, suffix, unit_name, written_in_si
from vibrocap.physics.parameters import NUMBER, given_parameters, parameter_table


class Stated(NamedTuple):
    """A parameter or a state as SI has it: its key there and its name without units, the words of the key, its unit."""

    key: str
    name: str
    stem: str
    value: Any
    unit: str


def stated(values: Mapping[str, Any], keys: Mapping[str, Key]) -> list[Stated]:
    """Values by key; of words, which have no key, the unit is "1"."""
    entries = ((key, x, keys.get(key) or Key(key, key, "1", 1.0, NUMBER)) for key, x in values.items())
    return [Stated(key, key_in_si.name, key_in_si.stem, x, key_in_si.unit) for key, x, key_in_si in entries]


def parameters_stated(part: str, system: Any) -> list[Stated]:
    """The parameters of a part in SI, to rounding; of a machine those of its scales too."""
    record, units = system.parts[part], system.si.of_part(part)
    values = written_in_si(record, units, exactly=False) or {}
    scales = parameter_table(system.units) if part == "machine" else ()
    measured = ((info.name, unit_name(info.dimension or NUMBER), getattr(system.units, info.name)) for info in scales)
    return stated(values, parameter_keys(type(record), units.effort)) + [
        Stated(name, name, name.removesuffix(suffix(unit)), value, unit)
        for name, unit, value in measured
        if value is not None
    ]


def described(record: Any, digits: int = 6) -> str:
    """A record in a line: its name, and the values of its parameters to so many digits."""
    values = given_parameters(record).items()
    return f"{record.name}: {', '.join(f'{name} {brief(value, digits)}' for name, value in values)}"


def brief(value: Any, digits: int) -> str:
    """A value of a parameter in words: a word, a number to so many digits, or of a table how many they are."""
    if isinstance(value, (tuple, list)):
        return f"{len(value)} numbers"
    return value if isinstance(value, str) else f"{value:.{digits}g}"
