"""Units: in which SI unit each parameter, state and result stands, and the keys that carry them.

The dimension of a parameter is declared with it, by its role or its unit; here it becomes a unit with a name, and a key
such as "bristle_stiffness_N_per_m". What a motion can be asked for has its unit in `QUANTITIES`.
"""

import dataclasses
import functools
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from vibrocap.arguments import ArgumentError, is_number
from vibrocap.physics.dimensions.scales import PER_LOAD, TURNING, TURNING_PER_LOAD, Scales, resolved
from vibrocap.physics.names import (
    OUTPUT,
    SIGNAL,
    laws_by_state,
    laws_of,
    name_and_number,
    number_in,
    numbered,
    state_names,
)
from vibrocap.physics.parameters import (
    EFFORT,
    LENGTH,
    MASS,
    NUMBER,
    Dimension,
    ParameterInfo,
    dimension_of_unit,
    given_parameters,
    parameter_table,
)

# role: the units in which it may be given, with what one of them is in SI; the first is that of results
ROLE_UNITS: dict[str, dict[str, float]] = {
    "torsional stiffness": {"N m/rad": 1.0},
    "torsional damping": {"N m s/rad": 1.0},
    "frequency": {"Hz": 2.0 * math.pi, "rad/s": 1.0},
    "phase": {"rad": 1.0, "deg": math.pi / 180.0},
    "quadratic damping": {"kg/m": 1.0},
}
OTHER_UNITS = {"rad": {"deg": math.pi / 180.0}}  # unit of a state: others in which it may be given

QUANTITY_NAMES = {  # of what a motion can be asked for, by SI unit; the rate of a state has its unit over s
    "s": "time",
    "rad": "angle",
    "rad/s": "angle_rate",
    "m": "displacement approach position bristle observed_bristle gap_position",
    "m/s": "displacement_rate approach_rate velocity sliding_velocity contact_velocity",
    "N": "element_force_1 element_force_2 element_force_3 element_force_4 friction holding_force reaction "
    "holding_limit holding_centre outer_force actuator_force",
    "J": "energy contact_energy",
    "N s": "momentum impulse",
    "N m": "actuator_torque",
}
QUANTITIES = {name: unit for unit, names in QUANTITY_NAMES.items() for name in names.split()}  # all others have none
TURNED = {"kg": "kg m^2", "N": "N m", "m": "rad"}
UNDECLARED = (
    'declares neither a role nor a unit, so cannot stand in SI; declare a pure number by parameter(..., unit="1")'
)
DRIVE_UNITS = {"force": "N", "torque": "N m", "displacement": "m", "speed": "m/s", "angle": "rad", "number": "1"}


@dataclasses.dataclass(frozen=True)
class Key:
    """One way to give a parameter or state, by name, in SI: its key with its unit, and what one such unit is in SI."""

    name: str
    key: str
    unit: str
    factor: float
    dimension: Dimension

    @property
    def has_unit(self) -> bool:
        """Whether the key says its unit; if not, the number is the same with units and without."""
        return self.unit != "1" and self.key.endswith(suffix(self.unit))

    @property
    def stem(self) -> str:
        return self.key.removesuffix(suffix(self.unit)) if self.has_unit else self.key

    def scale(self, scales: Scales, effort: str) -> float:
        """What one dimensionless unit is in the unit of this key."""
        return scales.of(self.dimension, effort) / self.factor


def suffix(unit: str) -> str:
    """How a unit stands at the end of a key: "N m/rad" as "_N_m_per_rad"."""
    above, _, below = unit.replace("^", "").partition("/")
    words = ([] if above == "1" else above.split()) + (["per", *below.split()] if below else [])
    return "".join(f"_{word}" for word in words)


def undeclared(part: Any) -> list[str]:
    """The numbers among the parameters of a part that declare no dimension, and so cannot stand in SI."""
    table = parameter_table(part)
    return [info.name for info in table if info.dimension is None and not isinstance(info.default, str)]


def unit_name(dimension: Dimension, effort: str = "force") -> str:
    """The SI unit of a dimension, "kg" of a mass, "kg m^2" of what turns, "N s/m" of a damper."""
    if effort in (TURNING, TURNING_PER_LOAD):
        return turned(unit_name(dimension, "force" if effort == TURNING else PER_LOAD))
    own = resolved(dimension, effort)
    return {MASS: "kg", MASS * LENGTH**2: "kg m^2"}.get(own) or own.unit()


def turned(unit: str) -> str:
    """The unit where a contact turns: N s/m is N m s/rad there."""
    return unit if "N m" in unit else re.sub(r"kg|N|m", lambda match: TURNED[match[0]], unit)


def parameter_units(info: ParameterInfo, effort: str) -> dict[str, float]:
    """The units in which a parameter may be given, with what one is in SI; a declared unit keeps its radians."""
    assert info.dimension is not None
    own = info.unit if "rad" in info.unit else unit_name(info.dimension, effort)
    if info.dimension == EFFORT and effort in ("angle", "rad"):
        return ROLE_UNITS["phase"]
    of_law = effort in (TURNING, PER_LOAD, TURNING_PER_LOAD) and info.dimension.force
    return {own: 1.0} if of_law else ROLE_UNITS.get(info.role) or {own: 1.0}


@functools.cache
def parameter_keys(part: type, effort: str) -> Mapping[str, Key]:
    """Every key under which a parameter of a part may be given in SI; the first of each parameter is that of results.

    Numbers without a unit and words stand under their own name; a parameter that declares no dimension is left out.
    effort: what the drive exerts on the machine, "force" or "torque"; of a law see `effort_of`
    """
    by_parameter = {}
    names: Mapping[str, str] = getattr(part, "si_names", {})
    for info in parameter_table(part):
        if info.dimension is not None:
            stem = names.get(info.name, info.name)
            keys = _keys(info.name, stem, parameter_units(info, effort), info.dimension)
        elif isinstance(info.default, str):
            keys = iter([Key(info.name, info.name, "1", 1.0, NUMBER)])
        else:
            continue
        by_parameter |= {key.key: key for key in keys}
    return by_parameter


def force_keys(part: type) -> Mapping[str, ParameterInfo]:
    """The keys under which coefficients of a law are forces, as of records without a load: coulomb_force_N."""
    known = [info for info in parameter_table(part) if info.dimension is not None and info.dimension.coefficient]
    units = [info.dimension.unit(known_load=False) for info in known if info.dimension is not None]
    return {info.name.replace("coefficient", "force") + suffix(u): info for info, u in zip(known, units, strict=True)}


def state_keys(units: Mapping[str, str]) -> dict[str, Key]:
    """Every key under which a state may be given in SI; units: of the states by name, "1" where they have none."""
    keys = {}
    for name, unit in units.items():
        factors = {unit: 1.0} | OTHER_UNITS.get(unit, {})
        keys |= {key.key: key for key in _keys(name, name, factors, dimension_of_unit(unit))}
    return keys


def _keys(name: str, stem: str, units: Mapping[str, float], dimension: Dimension) -> Iterator[Key]:
    for unit, factor in units.items():
        if factor == 1.0 and unit in ("1", "rad"):  # the same number with units and without
            yield Key(name, stem, unit, factor, dimension)
        if unit != "1":
            yield Key(name, stem + suffix(unit), unit, factor, dimension)


def one_way(keys: Mapping[str, Key], name: str) -> Key | None:
    """The first key of a parameter or state."""
    return next((key for key in keys.values() if key.name == name), None)


def same_without_units(keys: Mapping[str, Key], name: str) -> bool:
    """Whether a quantity has the same number with units and without: a coefficient, a phase, a word."""
    return name in keys and keys[name].name == name and not keys[name].has_unit


@dataclasses.dataclass(frozen=True)
class Units:
    """Factor and unit of every quantity of a system.

    scales: what one unit of mass, length and time is. effort: what the drive exerts. states: units of the states.
    reference: what kind of quantity the drive is where a controller compares it; "": there is no controller.
    turning: numbers of the contacts whose sliding velocity is that of an angle, so that friction and load are torques.
    efforts: of the parts by name, see `effort_of`.
    """

    scales: Scales
    effort: str
    states: Mapping[str, str]
    reference: str = ""
    turning: frozenset[int] = frozenset()
    efforts: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def of_contact(self, unit: str) -> str:
        """A unit, as it is where the first contact turns."""
        return turned(unit) if 1 in self.turning else unit

    def unit(self, name: str) -> str:
        """SI unit of a quantity of a motion, "1" where it has none."""
        if name in self.states:
            return self.states[name]
        if (known := quantity_unit(name)) is not None:
            return turned(known) if name_and_number(name)[1] in self.turning else known
        if name in ("drive", "command"):
            return DRIVE_UNITS[self.effort]
        if name == "reference" and self.reference:
            return DRIVE_UNITS[self.reference]
        if name.endswith(("_work", "_power")):
            return "J" if name.endswith("_work") else "W"
        stem, number = name_and_number(name)
        if (state := numbered(stem.removesuffix("_rate"), number)) in self.states:
            return over_seconds(self.states[state])
        return "1"

    def factor(self, name: str) -> float:
        """What one dimensionless unit of a quantity of a motion is in its SI unit."""
        return self.factor_of(self.unit(name))

    def factor_of(self, unit: str) -> float:
        """What one dimensionless unit of that dimension is in a unit such as "N s/m"."""
        return self.scales.of(dimension_of_unit(unit), self.effort)

    def states_of(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values by state, numbers or (low, high), those under keys with a unit ("angle_deg") without units."""
        keys = {name: key for name, key in state_keys(self.states).items() if key.has_unit and name not in self.states}
        states: dict[str, Any] = {}
        for name, value in values.items():
            key = keys.get(name)
            if key is not None and key.name in {*values, *states}:
                raise ArgumentError(name, "is given in two ways; give one of them")
            states[name if key is None else key.name] = value if key is None else divided(value, self.per_key(key))
        return states

    def of_part(self, section: str) -> "Units":
        """The same for the parameters of a part, which count in an effort of their own."""
        return dataclasses.replace(self, effort=self.efforts.get(section, self.effort))

    def per_key(self, key: Key) -> float:
        """What one dimensionless unit is in the unit of a key."""
        return key.scale(self.scales, self.effort)


class NoUnits:
    """The units of results that have none."""

    states: ClassVar[Mapping[str, str]] = {}

    def of_contact(self, unit: str) -> str:
        return unit

    def unit(self, name: str) -> str:
        return "1"

    def factor(self, name: str) -> float:
        return 1.0


def divided(value: Any, scale: float) -> Any:
    """A number, an array of numbers, or each number of a list, over a scale; what is none of them as it is."""
    if isinstance(value, (tuple, list)):
        return type(value)(divided(number, scale) for number in value)
    numbers = isinstance(value, np.ndarray) and value.dtype.kind in "iuf"
    return value / scale if numbers or is_number(value) else value


def over_seconds(unit: str) -> str:
    """The unit of the rate of a quantity."""
    above, _, below = unit.partition("/")
    return f"{above}/{below} s" if below else f"{above}/s"


def effort_of(section: str, parts: Mapping[str, Any]) -> str:
    """What the parameters of a part mean by an effort: what the drive exerts on the machine; of a drive that is the
    reference of a controller, what that measures; of a signal its unit; of a law `TURNING` where its contact turns,
    `PER_LOAD` where the load follows the motion.
    parts: of a system by name, or their classes; the load on a class of machines is that of its defaults
    """
    machine = parts["machine"]
    if section.startswith(SIGNAL):
        return machine.signals[section.removeprefix(SIGNAL)].unit
    if contact := number_in(section, "friction"):
        moves = machine.kind().whole.moving_loads if isinstance(machine, type) else machine.follows_load
        if contact in turning(machine):
            return TURNING_PER_LOAD if moves else TURNING
        return PER_LOAD if moves else "force"
    controller = parts.get("controller")
    return machine.effort if controller is None or section != "drive" else controller.reference


def keys_of(section: str, parts: Mapping[str, Any]) -> Mapping[str, Key]:
    """Every key in SI of a part, by its section; of a law under a class of machines for both kinds of load."""
    part, effort = parts[section], effort_of(section, parts)
    kind = part if isinstance(part, type) else type(part)
    if not (isinstance(parts["machine"], type) and number_in(section, "friction")):
        return parameter_keys(kind, effort)
    others = {TURNING: TURNING_PER_LOAD, TURNING_PER_LOAD: TURNING, PER_LOAD: "force"}
    return {**parameter_keys(kind, effort), **parameter_keys(kind, others.get(effort, PER_LOAD))}


def units_of(parts: Mapping[str, Any], scales: Scales) -> Units:
    """Factor and unit of every quantity of the parts of a system by name, or of their classes."""
    controller = parts.get("controller")
    reference = "" if controller is None else controller.reference
    machine = parts["machine"]
    efforts = {name: effort_of(name, parts) for name in parts}
    return Units(scales, machine.effort, state_units(parts), reference, turning(machine), efforts)


def turning(machine: Any) -> frozenset[int]:
    """Numbers of the contacts of a machine, or of its class, that turn."""
    states, units = machine.contact_states, machine.state_units
    return frozenset(i for i, name in enumerate(states, start=1) if units.get(name) == "rad/s")


def state_units(parts: Mapping[str, Any]) -> dict[str, str]:
    """SI unit of every state of the parts of a system by name, or of their classes: "1" where there is none."""
    own: dict[str, str] = {OUTPUT: DRIVE_UNITS[parts["machine"].effort]}
    if (controller := parts.get("controller")) is not None:
        own |= dict.fromkeys(controller.effort_states, DRIVE_UNITS[parts["machine"].effort])
    for part in (*laws_of(parts)[1:], parts["friction"], parts["machine"]):
        own |= part.state_units
    units = {name: quantity_unit(name, own) or "1" for name in state_names(parts)}
    for i, law in laws_by_state(parts):
        if (effort := effort_of(numbered("friction", i), parts)) != "force":  # the states count as its parameters do
            names = [numbered(name, i) for name in law.internal]
            units |= {name: unit_name(dimension_of_unit(units[name]), effort) for name in names}
    return units


def quantity_unit(name: str, own: Mapping[str, str] = {}) -> str | None:
    """SI unit of a quantity of a motion; one of a further contact, "velocity_2", has that of the first."""
    unit = own.get(name) or QUANTITIES.get(name)
    stem, _, number = name.rpartition("_")
    return quantity_unit(stem, own) if unit is None and number.isdecimal() else unit


def shortest(value: float, factor: float) -> float | None:
    """The number with the fewest digits that divided by the factor is exactly this value; None if there is none."""
    product = value * factor
    for digits in range(1, 18):
        rounded = float(f"{product:.{digits}g}")
        if rounded / factor == value:
            return rounded
    for direction in (math.inf, -math.inf):
        rounded = product
        for _ in range(4):
            rounded = math.nextafter(rounded, direction)
            if rounded / factor == value:
                return rounded
    return None


def written_in_si(part: Any, units: Units, exactly: bool = True) -> dict[str, Any] | None:
    """A part's parameters by keys in SI, with the fewest digits that give the part back exactly.

    exactly: None where there are no such numbers; if not asked for, these are to rounding. ValueError for a parameter
    that declares no dimension.
    """
    return written(given_parameters(part), parameter_keys(type(part), units.effort), units, exactly)


def written(
    values: Mapping[str, Any], keys: Mapping[str, Key], units: Units, exactly: bool = True
) -> dict[str, Any] | None:
    """Values by name as values by keys in SI, see `written_in_si`."""
    numbers_in_si: dict[str, Any] = {}
    for name, value in values.items():
        own_keys = [key for key in keys.values() if key.name == name]
        if isinstance(value, str):
            numbers_in_si[name] = value
            continue
        if not own_keys:
            raise ValueError(f"{name}: {UNDECLARED}")
        if not own_keys[0].has_unit:
            numbers_in_si[own_keys[0].key] = value
            continue
        several = isinstance(value, tuple)
        numbers = [float(number) for number in (value if several else (value,))]
        shortest_by_key = {
            key: [shortest(number, units.per_key(key)) for number in numbers]
            for key in (own_keys[:1] if several else own_keys)
        }
        exact = [key for key, short in shortest_by_key.items() if None not in short]
        if exactly and not exact:
            return None
        key = min(exact, key=lambda key: len(repr(shortest_by_key[key])), default=own_keys[0])
        pairs = zip(shortest_by_key[key], numbers, strict=True)
        shown = [number * units.per_key(key) if short is None else short for short, number in pairs]
        numbers_in_si[key.key] = shown if several else shown[0]
    return numbers_in_si
