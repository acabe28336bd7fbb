"""Conversion: what is given in SI becomes the parameters of parts without units, or complaints that name the key."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import (
    ArgumentError,
    Complaint,
    Complaints,
    is_number,
    is_positive,
    listed,
    restated,
    suggestion,
)
from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2, TURNING, TURNING_PER_LOAD, Scales
from vibrocap.physics.dimensions.units import (
    UNDECLARED,
    Key,
    Units,
    divided,
    effort_of,
    force_keys,
    keys_of,
    one_way,
    parameter_keys,
    same_without_units,
    state_keys,
    state_units,
    undeclared,
)
from vibrocap.physics.names import number_in, plain_path, split_path
from vibrocap.physics.parameters import COEFFICIENT, FORCE, ParameterError, ParameterInfo, PartInSI, parameter_table
from vibrocap.quantities.declared import AsGiven, Context, Declared, WithUnit


@dataclasses.dataclass(frozen=True)
class WithoutUnits:
    """What was given in SI, without units.

    values: by name. keys: under which key each was given. complaints: about what cannot be converted, field = key.
    """

    values: dict[str, Any]
    keys: dict[str, str]
    complaints: Complaints


def part_without_units(part: Any, values: Mapping[str, Any], units: Units, *, bare: bool = False) -> WithoutUnits:
    """The parameters of a part (a class) whose values are given in SI.

    bare: whether a key without a unit is in SI too, as where a case says units = "SI"
    In SI only a zero, a word and a number without a unit have defaults: any other is that of a certain size of machine.
    Those of friction coefficients are of one contact together: beside one that is given the others have none.
    """
    keys, table = parameter_keys(part, units.effort), parameter_table(part)
    without_units = _without_units({info.name for info in table}, keys, values, units, bare)
    known = {*without_units.keys, *values}
    measured = any(info.name in known for info in table if info.dimension == COEFFICIENT)
    for info in table:
        mixed = measured and info.dimension == COEFFICIENT
        if info.name not in known and (mixed or not _has_default(info, keys)):
            without_units.complaints.add(*_missing(part, info, keys))
    return without_units


def states_without_units(values: Mapping[str, Any], units: Units, *, bare: bool = False) -> WithoutUnits:
    """Initial states by name whose values are given in SI."""
    return _without_units(set(units.states), state_keys(units.states), values, units, bare)


def with_gravity(values: Mapping[str, Any], machine: Any) -> Mapping[str, Any]:
    """What is given in SI of an environment, with gravity on a slope where the machine (a class) does not know it."""
    if machine.gravity is not None or not any(key.startswith("inclination") for key in values):
        return values
    return {"gravity_m_per_s2": STANDARD_GRAVITY_M_PER_S2, **values}


def constant_load(parts: Mapping[str, Any], contact: int, scales: Scales) -> float | None:
    """Load in N on a contact, counted from 1; None where it follows the motion."""
    machine = parts["machine"]
    machine = parts["environment"].placed(machine) if "environment" in parts else machine
    return None if machine.follows_load else float(machine.loads()[contact - 1]) * scales.of(FORCE)


def with_coefficients(values: Mapping[str, Any], law: type, load: float | None, effort: str) -> WithoutUnits:
    """What is given in SI of a law, its forces as coefficients of the load in N; None: that is no constant.

    Forces come from records whose load is not known; under a load that follows the motion they are no coefficients, and
    stiffness and damping are over the load. effort: of the law (`effort_of`)
    """
    without_units = WithoutUnits({}, {}, Complaints())
    keys = parameter_keys(law, effort)
    constant = parameter_keys(law, TURNING if effort == TURNING_PER_LOAD else "force")
    for key, value in values.items():
        info = force_keys(law).get(key)
        if key in constant and key not in keys:
            over_load = one_way(keys, constant[key].name)
            assert over_load is not None
            without_units.values[over_load.key] = value
            words = "is that at a constant load; where the load follows the motion, friction acts per load"
            without_units.complaints.add(key, f"{words}: give {over_load.key}, the value over the load")
            continue
        if info is None:
            without_units.values[key] = value
            continue
        without_units.values[info.name], without_units.keys[info.name] = value, key
        if info.name in values:
            without_units.complaints.add(key, f"is {info.name} once more; give one of them")
        elif load is None or not is_positive(load):
            words = f"is a force, which is no coefficient under a load that follows the motion; give {info.name}"
            without_units.complaints.add(key, f"{words}, as of a record with its normal force, or a constant load")
        elif is_number(value):
            assert info.dimension is not None
            without_units.values[info.name] = value / load**info.dimension.coefficient
    return without_units


INITIAL = "initial."


def path_in_si(path: str, parts: Mapping[str, Any]) -> tuple[str, Key] | None:
    """(path without unit, key) of a path such as "drive.frequency_Hz"; None for one that is none in SI.

    parts: of a system by name, or their classes
    """
    section, name = split_path(plain_path(path, parts["machine"]))
    if path.startswith(INITIAL):
        keys: Mapping[str, Key] = state_keys(state_units(parts))
    else:
        if section not in parts:
            return None
        keys = keys_of(section, parts)
    key = keys.get(name)
    return (f"{section}.{key.name}", key) if key is not None and key.has_unit else None


def paths_in_si(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """Every path of these parts and their initial states that carries its unit."""
    paths: list[str] = []
    for section in parts:
        paths += [f"{section}.{key}" for key, key_in_si in keys_of(section, parts).items() if key_in_si.has_unit]
    states = state_keys(state_units(parts))
    return (*paths, *(INITIAL + key for key, state in states.items() if state.has_unit))


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A parameter or initial state as it is asked for, with or without units.

    path: by which it is asked for. plain: its path without units. scale: one dimensionless unit in its unit.
    """

    path: str
    plain: str
    unit: str = "1"
    scale: float = 1.0


def quantity(path: str, system: Any) -> Quantity:
    """The quantity of a path such as "machine.mass_ratio" or, in SI, "drive.frequency_Hz".

    Raises ArgumentError for a path in SI of a system that does not know its scales.
    """
    place = path_in_si(path, system.parts)
    if place is None:
        return Quantity(path, plain_path(path, system.machine))
    if system.units is None:
        raise ArgumentError(path, f"the case does not give its units; add {place[0]}, or a case in SI")
    return Quantity(path, place[0], place[1].unit, system.si.per_key(place[1]))


def quantity_in_si(plain: str, system: Any) -> Quantity:
    """The quantity of a path without units, in SI where the system knows its scales and the quantity has a unit."""
    if system.units is not None:
        for path in paths_in_si(system.parts):
            place = path_in_si(path, system.parts)
            if place is not None and place[0] == plain and place[1].has_unit:
                return quantity(path, system)
    return Quantity(plain, plain)


def value_in_words(path: str, value: float, system: Any, digits: int = 6) -> str:
    """A value of a parameter or an initial state, in SI where the system knows its scales, with its unit."""
    known = quantity_in_si(path, system)
    return f"{value * known.scale:.{digits}g}" + ("" if known.unit == "1" else f" {known.unit}")


class Along(Declared):
    """A parameter along which something is known: of a number its value, of a path the path that says its unit.

    The path is what the record or the call around has as `over`. One that is given without its unit ("drive.frequency")
    takes numbers without units; what is shown is in SI.
    """

    def _shown(self, context: Context) -> Quantity:
        paths = [path for path in context.known("over") if isinstance(path, str)]
        quantities = (quantity(path, context.system) for path in paths)
        in_si = next((quantity for quantity in quantities if quantity.path != quantity.plain), None)
        return quantity_in_si(paths[0], context.system) if in_si is None else in_si

    def unit(self, context: Context) -> str:
        return self._shown(context).unit

    def scale(self, context: Context) -> float:
        return self._shown(context).scale

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        call = context.around[0] if context.around and isinstance(context.around[0], Mapping) else {}
        if isinstance(value, str):
            return quantity(value, context.system).plain if back else self._shown(context).path
        if back and "over" in call:
            asked = quantity(call["over"], context.system)
            return value if asked.path == asked.plain else super().converted(value, context, back)
        return super().converted(value, context, back)

    def seen(self, value: Any, context: Context) -> Any:
        shown = isinstance(value, str) and context.system is not None
        return self.converted(value, context) if shown else super().seen(value, context)


Path = Annotated[str, Along()]
Parameter = Annotated[float, Along()]
Parameters = Annotated[np.ndarray, Along()]


class AtPath(AsGiven):
    """A number in the unit of the parameter that its record names `path`."""

    def seen(self, value: Any, context: Context) -> Any:
        return self.at(value, context.known("path")[0], context)

    @staticmethod
    def at(value: Any, path: str, context: Context) -> Any:
        """A number in the unit of a parameter."""
        if context.system is None or isinstance(value, str):
            return value
        known = quantity(path.partition("[")[0], context.system)  # of one record: "machine.mass_kg[fast]"
        return value if known.unit == "1" else WithUnit(value, known.unit, value / known.scale)


class ByPath(AtPath):
    """Values by the paths of parameters, which say their units: {"drive.frequency_Hz": 1.0}."""

    def seen(self, value: Any, context: Context) -> Any:
        return value if value is None else {path: self.at(number, path, context) for path, number in value.items()}


NumberAtPath = Annotated[float, AtPath()]
Design = Annotated[dict[str, Any], ByPath()]


def values_without_units(values: Mapping[str, Any], scales: Scales | None, parts: Mapping[str, Any]) -> dict[str, Any]:
    """Values by path, numbers or arrays, without units; what is not in SI, and all where no scales are known, stays.

    parts: of the system by name
    Raises ArgumentError for a quantity that is given in two ways.
    """
    units: dict[str, Any] = {}
    for path, value in values.items():
        place = path_in_si(path, parts) if scales is not None else None
        plain = plain_path(path, parts["machine"]) if place is None else place[0]
        if plain in units:
            raise ArgumentError(path, "is given in two ways; give one of them")
        if place is None or scales is None or isinstance(value, str):
            units[plain] = value
        else:
            units[plain] = value / place[1].scale(scales, effort_of(split_path(plain)[0], parts))
    return units


def _without_units(
    names: Iterable[str], keys: Mapping[str, Key], values: Mapping[str, Any], units: Units, bare: bool
) -> WithoutUnits:
    without_units = WithoutUnits({}, {}, Complaints())
    for key, value in values.items():
        known = keys.get(key) or _named(key, value, names, keys, bare)
        if isinstance(known, str):
            without_units.complaints.add(key, known)
        elif known.name in without_units.keys:
            without_units.complaints.add(key, f"is {without_units.keys[known.name]} once more; give one of them")
        else:
            without_units.keys[known.name] = key
            has_unit = known.has_unit or known.key != key
            without_units.values[known.name] = divided(value, units.per_key(known)) if has_unit else value
    return without_units


def _named(key: str, value: Any, names: Iterable[str], keys: Mapping[str, Key], bare: bool) -> Key | str:
    """What a key without a unit stands for, or what is wrong with it."""
    stems = {key.stem: key.name for key in keys.values()}
    name = key if key in names else stems.get(key)
    first = one_way(keys, name) if name else None
    if first is None:
        if key in names:
            return UNDECLARED
        return f"no such key in SI; {suggestion(key, keys)}"
    if value is None or isinstance(value, str):
        return first
    united = [key.key for key in keys.values() if key.name == name and key.has_unit]
    if bare and len(united) == 1 and key in stems:
        return first
    return f"has no unit in a case in SI; give {listed(united, ' or ')}"


def _has_default(info: ParameterInfo, keys: Mapping[str, Key]) -> bool:
    return info.default in (None, 0.0) or same_without_units(keys, info.name) or one_way(keys, info.name) is None


def _missing(part: Any, info: ParameterInfo, keys: Mapping[str, Key]) -> tuple[str, str]:
    united = [key.key for key in keys.values() if key.name == info.name and key.has_unit] or [info.name]
    text = "is missing; it has no default in SI"
    if info.name == "normal_load" and part.si_load:
        text = f"is missing; give the load on the contact in {keys[united[0]].unit}, or {part.si_load}"
    elif len(united) > 1:
        text += f" (or {listed(united[1:], ' or ')})"
    return united[0], text


def parts_without_units(parts: Mapping[str, Any], scales: Scales | None) -> tuple[dict[str, Any], Scales]:
    """(the parts without units, the scales of the machine), of parts some of which are in SI.

    scales: those of a machine that is not given in SI
    Raises ArgumentError for parts of which some are in SI and others not, ParameterError for values that do not serve.
    """
    machine = parts["machine"]
    if not isinstance(machine, PartInSI):
        if scales is None:
            kind = type(machine).__name__
            raise ArgumentError("machine", f"should be in SI like the other parts, {kind}.in_si(...), got {machine!r}")
        in_si = {name: part for name, part in parts.items() if isinstance(part, PartInSI)}
        return {**parts, **_parts_in_turn(in_si, scales, machine)}, scales
    fields = [info.name for info in parameter_table(machine.part.si_scales)]
    try:
        own: Scales = machine.part.si_scales(**{name: x for name, x in machine.values.items() if name in fields})
    except ParameterError as error:
        raise error.within("machine") from None
    rest = PartInSI(machine.part, {name: value for name, value in machine.values.items() if name not in fields})
    return _parts_in_turn({**parts, "machine": rest}, own, machine.part), own


def _parts_in_turn(originals: Mapping[str, Any], scales: Scales, machine: Any) -> dict[str, Any]:
    """The parts without units; ParameterError with every complaint, named by the keys that were given.

    machine: its class, or itself where it is not among them
    """
    parts: dict[str, Any] = {}
    kinds = {name: part.part if isinstance(part, PartInSI) else type(part) for name, part in originals.items()}
    kinds["machine"] = machine if isinstance(machine, type) else type(machine)
    complaints: list[Complaint] = []
    for name in sorted(originals, key=lambda section: section not in ("machine", "environment")):
        part, kind, effort = originals[name], kinds[name], effort_of(name, {**kinds, "machine": machine, **parts})
        in_si = part.values if isinstance(part, PartInSI) else ()  # what is said of these comes with their conversion
        complaints += [Complaint(f"{name}.{field}", UNDECLARED) for field in undeclared(kind) if field not in in_si]
        if not isinstance(part, PartInSI):
            keys = parameter_keys(kind, effort)
            if complaints:
                continue
            if not all(same_without_units(keys, info.name) for info in parameter_table(part)):
                call = f"{kind.__name__}.in_si(...)"
                raise ArgumentError(name, f"should be in SI like the machine, {call}, got {part!r}")
            parts[name] = part
            continue
        values, asked = part.values, {}
        if name == "environment":
            values = with_gravity(values, kinds["machine"])
        if contact := number_in(name, "friction"):
            load = 1.0 if complaints else constant_load({"machine": machine, **parts}, contact, scales)
            known = with_coefficients(values, kind, load, effort)
            values, asked = known.values, known.keys
            complaints += [complaint.about(f"{name}.{complaint.field}") for complaint in known.complaints]  # type: ignore[attr-defined]
        plain = part_without_units(part.part, values, Units(scales, effort, {}))
        complaints += [complaint.about(f"{name}.{complaint.field}") for complaint in plain.complaints]  # type: ignore[attr-defined]
        try:
            parts[name] = part.part(**plain.values)
        except ParameterError as error:
            keys = {own: asked.get(key, key) for own, key in plain.keys.items()}
            complaints += [
                _as_given(complaint, name, {**values, **part.values}, plain.values, keys)
                for complaint in error.complaints
            ]
    if complaints:
        raise ParameterError("the system", complaints)
    return {name: parts[name] for name in originals}


def _as_given(
    complaint: Complaint, part: str, values: Mapping[str, Any], plain: Mapping[str, Any], keys: Mapping[str, str]
) -> Complaint:
    """A complaint about a value without units, about what was given."""
    name = complaint.field
    if name not in keys:
        return complaint.about(f"{part}.{name}")
    return Complaint(f"{part}.{keys[name]}", restated(complaint.text, plain[name], values[keys[name]]))
