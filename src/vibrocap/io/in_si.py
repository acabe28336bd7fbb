"""Results in SI: the record of a motion with units, and a part in a line."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from vibrocap.physics.parameters import described, given_parameters, parameter_table
from vibrocap.physics.system import System
from vibrocap.physics.units import parameter_keys, suffix, unit_name, written_in_si

# unit of what the record of a motion holds, by the path in it; what is not here has none
RECORD_UNITS = {
    "time": "s",
    "drift": "m",
    "cost_of_transport": "J/m",
    "least_reaction": "N",
    "mean_velocity.value": "m/s",
    "mean_velocity.window": "s",
    "energy.window": "s",
    "energy.periods": "1",
}


def record_units(record: Mapping[str, Any], system: System) -> dict[str, Any]:
    """Unit of every number of a motion's record that has one, in the form of the record."""
    found: dict[str, Any] = {"state": {name: system.si.unit(name) for name in record["state"]}}
    for path in ("time", "drift", "cost_of_transport", "least_reaction"):
        if path in record:
            found[path] = RECORD_UNITS[path]
    for section in ("mean_velocity", "energy"):
        usual = "J" if section == "energy" else "1"
        units = {name: RECORD_UNITS.get(f"{section}.{name}", usual) for name in record[section] or ()}
        found[section] = {name: unit for name, unit in units.items() if unit != "1"}
    return found


def record_in_si(record: Mapping[str, Any], system: System) -> dict[str, Any]:
    """The record of a motion in SI, see `in_si`.

    The certificate stays as it is: it is of the motion as it was computed.
    """
    return in_si(record, record_units(record, system), system)


def in_si(record: Mapping[str, Any], units: Mapping[str, Any], system: System) -> dict[str, Any]:
    """A record in SI: its values, their `units`, and those without units in `dimensionless`.

    units: by name of what has one, in the form of the record; of a list those of each of its elements
    """
    plain = {name: record[name] for name in units}
    return {**record, **_converted(plain, units, system), "units": units, "dimensionless": plain}


def orbit_units(record: Mapping[str, Any], system: System) -> dict[str, Any]:
    """Unit of every number of the record of a steady motion that has one, in the form of the record."""
    states = {name: system.si.unit(name) for name in system.state_names}
    travel = {"drift": "m", "state": states}
    motion = {"period": "s", "mean_velocity": "m/s", **travel, "twin": travel}
    whole = {**motion, "unstable_orbit": {**travel, "gives_way_to": motion}, "class": {"drift": "m"}}
    return {name: unit for name, unit in whole.items() if record.get(name) is not None}


# unit of what the limits of friction are, by name; what is not here has none
LIMIT_UNITS = {
    "load": "N",
    "breakaway_force": "N",
    "coulomb_force": "N",
    "deflection_limit": "m",
    "boundary_velocity": "m/s",
    "curve": {"velocity": "m/s", "friction": "N", "slope": "N s/m"},
    "offset": {
        "lower": "m/s",
        "upper": "m/s",
        "greatest_viscous_damping": "N s/m",
        "printed_lower": "m/s",
        "printed_upper": {"value": "m/s"},
        "corrected_upper": {"value": "m/s"},
    },
}


def limits_in_si(limits: Any, system: System) -> Any:
    """The limits of a law's friction with all their values in SI; the reason in words stays as it was computed."""
    found = _converted(limits, LIMIT_UNITS, system)
    if found.offset is None or not found.offset.ratio:
        return found
    reason = f"{found.offset.reason} (these numbers are dimensionless)"
    return dataclasses.replace(found, offset=dataclasses.replace(found.offset, reason=reason))


def _converted(value: Any, unit: Any, system: System) -> Any:
    if isinstance(value, dict):
        return {name: _converted(each, unit.get(name, "1"), system) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_converted(each, unit, system) for each in value)
    if value is None or isinstance(value, (bool, str)) or unit == "1":
        return value
    if hasattr(value, "__dataclass_fields__"):
        fields = {name: _converted(getattr(value, name), each, system) for name, each in unit.items()}
        return dataclasses.replace(value, **fields)
    return value * system.si.factor_of(unit)


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


def _keys(part: Any, system: System) -> dict[str, tuple[str, str]]:
    """(name without unit, unit) by the keys of a part in SI, for a machine those of its scales too."""
    keys = {
        key: (each.stem, each.unit)
        for key, each in parameter_keys(type(part), system.si.effort).items()
        if each.has_unit
    }
    if part is system.machine and system.units is not None:
        for info in parameter_table(system.units):
            assert info.dimension is not None
            unit = unit_name(info.dimension)
            keys[info.name] = (info.name.removesuffix(suffix(unit)), unit)
    return keys


def _values(part: Any, system: System) -> dict[str, Any]:
    """Values of a part by keys in SI, for a machine those of its scales too."""
    scales = given_parameters(system.units) if part is system.machine else {}
    return (written_in_si(part, system.si, exactly=False) or {}) | scales
