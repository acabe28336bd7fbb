"""Units of measured quantities: what a unit measures and its factor to SI.

A turning contact has a torque, an angle and an angular velocity in the places of force, displacement and velocity.
"""

import dataclasses
import functools
import re

from vibrocap.arguments import suggestion
from vibrocap.records.reading.unit_sizes import unit_size

# dimension: the usual units, the SI one first
DIMENSIONS: dict[str, tuple[str, ...]] = {
    "time": ("s", "ms", "us", "min", "h"),
    "force": ("N", "kN", "mN", "uN", "MN", "lbf", "kip", "kgf"),
    "torque": ("N m", "kN m", "mN m", "N mm", "lbf ft", "lbf in"),
    "length": ("m", "cm", "mm", "um", "nm", "in", "ft"),
    "angle": ("rad", "mrad", "deg", "turn"),
    "speed": ("m/s", "cm/s", "mm/s", "um/s", "nm/s", "km/h", "in/s", "ft/s", "mph"),
    "angular speed": ("rad/s", "deg/s", "rpm", "turn/s"),
    "acceleration": ("m/s^2", "cm/s^2", "mm/s^2", "g", "in/s^2", "ft/s^2"),
    "angular acceleration": ("rad/s^2", "deg/s^2"),
    "stress": ("Pa", "kPa", "MPa", "GPa", "psi", "bar"),
    "number": ("1", "%"),
}
# quantity: the dimensions in which it may be given, that of a straight motion first
QUANTITIES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "force": ("force", "torque", "stress", "number"),
    "velocity": ("speed", "angular speed"),
    "displacement": ("length", "angle"),
    "acceleration": ("acceleration", "angular acceleration"),
    "normal_force": ("force", "stress"),
}
# another name of a quantity, for a contact that turns: the quantity
TURNING = {
    "torque": "force",
    "angle": "displacement",
    "angular_velocity": "velocity",
    "angular_acceleration": "acceleration",
}
ROTARY = ("torque", "angle", "angular speed", "angular acceleration")
LINEAR = ("force", "length", "speed", "acceleration", "stress", "number")

# other spellings, and those that would mean what no record holds (gram)
SPELLINGS = {
    "-": "1",
    "none": "1",
    "g": "g_0",  # standard gravity
    "mps": "m/s",
    "mmps": "mm/s",
    "umps": "um/s",
    "ips": "in/s",
    "kmh": "km/h",
    "rev": "turn",
    "revs": "turn",
    "rps": "turn/s",
    "kips": "kip",
    "msec": "ms",
    "secs": "s",
}
UNDERSTOOD = re.compile(r"[A-Za-zµμ°%/*^.·⋅ _()²³¹⁻0-9-]{1,40}")
_FORCE, _ARM = r"(?:[kMmcu]?N|lbf?|ozf?|kgf|kip)", r"(?:[kcmdu]?m|ft|in|inch|feet)"
_BETWEEN = r"\s*[ ._*·⋅-]?\s*"


@dataclasses.dataclass(frozen=True)
class Unit:
    """A unit: its name, what it measures (a key of DIMENSIONS, or something else), its factor to SI."""

    name: str
    dimension: str
    factor: float

    @property
    def turns(self) -> bool:
        """Whether it is of a turning motion."""
        return self.dimension in ROTARY


@functools.cache
def _dimensions() -> dict[tuple, str]:
    """The name of a dimension by its SI base units."""
    named = {name: units[0] for name, units in DIMENSIONS.items()} | {"mass": "kg", "frequency": "Hz"}
    return {size[1]: name for name, unit in named.items() if (size := unit_size(unit))}


def _spelt(text: str) -> str:
    """A text as `unit_size` reads it: micro, division, powers and torques as instruments write them."""
    text = text.strip().replace("µ", "u").replace("μ", "u").replace("°", "deg")
    if text in SPELLINGS or text.lower() in SPELLINGS:
        return SPELLINGS.get(text, SPELLINGS.get(text.lower(), text))
    text = re.sub(r"\s*(?:[_ ]per[_ ]|/)\s*", "/", text)
    text = re.sub(r"(?<=[A-Za-z])\s*(?:\^|\*\*)?\s*([-⁻]?)([1¹2²3³])(?![0-9])", _power, text)
    between = r"(?<=m)[ _](?=s)(?!s\*\*-)|(?<=rad|deg)_(?=s)(?!s\*\*-)|(?<=km)_(?=h)"
    text = re.sub(between, "/", text, flags=re.IGNORECASE)
    text = re.sub(r"[\s_.]*\*\*-([123])", r"**-\1", text)
    turns = re.fullmatch(rf"({_FORCE}){_BETWEEN}({_ARM})", text) or re.fullmatch(rf"({_ARM})-({_FORCE})", text)
    if turns and turns[0] != "nm":
        force, arm = sorted(turns.groups(), key=lambda part: re.fullmatch(_FORCE, part) is None)
        return f"{ {'lb': 'lbf', 'oz': 'ozf'}.get(force, force) }*{arm}"
    return re.sub(r"\brev\b", "turn", text).replace("·", "*").replace("⋅", "*")


def _power(match: re.Match) -> str:
    digit = {"¹": "1", "²": "2", "³": "3"}.get(match[2], match[2])
    return f"**{'-' if match[1] else ''}{digit}"


@functools.cache
def unit_named(text: str) -> Unit | None:
    """The unit that a text means; None where it is no unit.

    Understood is what `unit_size` knows, and other spellings of micro, of division, of powers and of torques: "µm",
    "m_per_s", "m_s", "m s-1", "mm/sec", "Nm", "N-m", "lb-ft". Capital letters count (mN, MN; nm, Nm), unless only one
    of the usual units is spelt so: "MM/S" is mm/s.
    """
    text = text.strip()
    if not UNDERSTOOD.fullmatch(text) or re.search(r"\d{2}|(\*\*|\^).*(\*\*|\^).*(\*\*|\^)", text):
        return None
    usual = _usual()
    if text in usual:
        return _unit(text, usual[text])
    small = [name for name in usual if name.lower() == text.lower()]
    tried = [_spelt(text), usual[small[0]] if len(small) == 1 else "", text.lower() if len(text) > 3 else ""]
    if small:  # "KN" is kN; "NM" may be nm or N m, and is neither
        tried = [tried[1]] if text != "Nm" and len(small) == 1 else tried[:1] if _spelt(text) != text else []
    return next(filter(None, (_unit(text, spelling) for spelling in tried if spelling)), None)


@functools.cache
def _usual() -> dict[str, str]:
    """The spelling of each usual unit."""
    spellings = {name: SPELLINGS.get(name, name.replace(" ", "*")) for names in DIMENSIONS.values() for name in names}
    return spellings | {name.replace("*", ""): name for name in spellings.values() if re.search(r"N\*m+$", name)}


def _unit(text: str, spelling: str) -> Unit | None:
    parsed = unit_size(spelling)
    if parsed is None:
        return None
    factor, base = parsed
    dimension = _dimensions().get(base, "something else")
    usual = [name for name in DIMENSIONS.get(dimension, ()) if unit_size(_usual()[name]) == parsed]
    same = [name for name in usual if _usual()[name] == spelling]
    return Unit([*same, *usual, text.replace("µ", "u")][0], dimension, factor)


def suffix_unit(text: str) -> Unit | None:
    """The unit that the end of a heading without brackets may mean ("time_s"): a usual one only, for "v_c" is none."""
    unit = unit_named(text)
    return unit if unit is not None and unit.name in _usual() else None


def column_unit(text: object) -> Unit | None:
    """The unit of a column as a user gives it: a unit, or so much of one, "35.15 N" (of a sensor in volts), "-1 mm"."""
    if not isinstance(text, str):
        return None
    counted = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*\*?\s*([^\d\s].*)", text, re.IGNORECASE)
    unit = unit_named(text)
    if unit is not None or counted is None:
        return unit
    number, unit = float(counted[1]), unit_named(counted[2])
    return None if unit is None or number == 0.0 else Unit(text.strip(), unit.dimension, number * unit.factor)


def base_quantity(quantity: str) -> str:
    """The quantity of a record that a name stands for: force for a torque."""
    return TURNING.get(quantity, quantity)


def dimensions_of(quantity: str) -> tuple[str, ...]:
    """The dimensions in which a quantity may be given; those of turning alone for one that is named so."""
    dimensions = QUANTITIES[base_quantity(quantity)]
    return tuple(dimension for dimension in dimensions if dimension in ROTARY) if quantity in TURNING else dimensions


def si_unit(quantity: str, rotary: bool = False) -> Unit:
    """The SI unit of a quantity: N of a force, N m of a torque."""
    dimensions = dimensions_of(quantity)
    dimension = next((d for d in dimensions if d in ROTARY), dimensions[0]) if rotary else dimensions[0]
    return Unit(DIMENSIONS[dimension][0], dimension, 1.0)


def fits(unit: Unit, quantity: str) -> bool:
    """Whether a quantity may be given in a unit."""
    return unit.dimension in dimensions_of(quantity)


def unit_complaint(quantity: str, text: object) -> str | None:
    """Why a text is no unit for a quantity; None where it is one."""
    unit = column_unit(text)
    if unit is not None and fits(unit, quantity):
        return None
    allowed = [name for dimension in dimensions_of(quantity) for name in DIMENSIONS[dimension]]
    what = "no unit that is known here" if unit is None else f"a unit of {unit.dimension}"
    hint = suggestion(text, allowed, 0.6 if unit is None else 1.0, "should be", " or ")
    return f"units: {quantity}: {text!r} is {what}; {hint}"
