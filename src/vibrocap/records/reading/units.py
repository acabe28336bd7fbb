"""Units of measured quantities: what a unit measures and its factor to SI.

A unit is a product of named units, their powers and prefixes, such as "kN*mm/s**2". A turning contact has a torque, an
angle and an angular velocity in the places of force, displacement and velocity.
"""

import ast
import dataclasses
import functools
import re
from fractions import Fraction

from vibrocap.arguments import suggestion

PI = Fraction("3.14159265358979323846264338327950288")
# names of a unit: its size in units before it; one without is a base unit. Radians count as a unit of their own
UNITS: dict[str, tuple[str | Fraction, str] | None] = {
    **dict.fromkeys(("m meter metre", "kg", "s sec second", "rad radian", "A amp ampere", "K kelvin degC celsius")),
    "percent": ("0.01", "1"),
    "g gram gramme": ("0.001", "kg"),
    "min minute": ("60", "s"),
    "h hr hour": ("3600", "s"),
    "day": ("86400", "s"),
    "Hz hertz": ("1", "1/s"),
    "deg degree": (PI / 180, "rad"),
    "turn rev revolution": (2 * PI, "rad"),
    "rpm": (PI / 30, "rad/s"),
    "inch inches": ("0.0254", "m"),
    "ft foot feet": ("0.3048", "m"),
    "yd yard": ("0.9144", "m"),
    "mi mile": ("1609.344", "m"),
    "mil thou": ("2.54e-5", "m"),
    "micron": ("1e-6", "m"),
    "mph": ("1", "mi/h"),
    "kph": ("1", "km/h"),
    "knot": (Fraction(1852, 3600), "m/s"),
    "g_0": ("9.80665", "m/s**2"),
    "lb lbs pound": ("0.45359237", "kg"),
    "oz ounce": ("0.028349523125", "kg"),
    "N newton": ("1", "kg*m/s**2"),
    "dyn dyne": ("1e-5", "N"),
    "kgf kp": ("9.80665", "N"),
    "lbf": ("4.4482216152605", "N"),
    "ozf": ("0.27801385095378125", "N"),
    "kip": ("4448.2216152605", "N"),
    "Pa pascal": ("1", "N/m**2"),
    "bar": ("1e5", "Pa"),
    "atm": ("101325", "Pa"),
    "psi": ("1", "lbf/inch**2"),
    "J joule Nm": ("1", "N*m"),
    "W watt": ("1", "J/s"),
    "V volt": ("1", "W/A"),
    "ohm": ("1", "V/A"),
}
PREFIXES = {"G giga": 9, "M mega": 6, "k kilo": 3, "c centi": -2, "m milli": -3, "u micro": -6, "n nano": -9}
_KNOWN = {name: names for names in UNITS for name in names.split()}
_POWERS = {prefix: Fraction(10) ** power for names, power in PREFIXES.items() for prefix in names.split()}
LARGEST_POWER = 9

Size = tuple[Fraction, dict[str, int]]


@functools.cache
def unit_size(text: str) -> tuple[float, tuple[tuple[str, int], ...]] | None:
    """(factor, base units with exponents) of a text; None where it is no unit."""
    text = re.sub(r"(?<=[\w)%])(\s+|\.)(?=[A-Za-z(%])", "*", text.strip()).replace("%", "percent").replace("^", "**")
    try:
        factor, powers = _size(ast.parse(re.sub(r"\bin\b", "inch", text), mode="eval").body)
    except (SyntaxError, ValueError):
        return None
    return float(factor), tuple(sorted((name, power) for name, power in powers.items() if power))


def _size(node: ast.expr) -> Size:
    match node:
        case ast.Constant(value=1):
            return Fraction(1), {}
        case ast.Name(id=name):
            return _named(name)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            power = ast.literal_eval(right)
            if type(power) is int and abs(power) <= LARGEST_POWER:
                factor, powers = _size(left)
                return factor**power, {name: own * power for name, own in powers.items()}
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            (factor, powers), (other, others) = _size(left), _size(right)
            sign = 1 if isinstance(op, ast.Mult) else -1
            names = {*powers, *others}
            return factor * other**sign, {name: powers.get(name, 0) + sign * others.get(name, 0) for name in names}
    raise ValueError("no unit")


def _named(name: str) -> Size:
    """A unit by its name, in the plural or with a prefix, too."""
    candidates = (name, name.removesuffix("s")) if len(name) > 3 else (name,)
    for candidate in candidates:
        if candidate in _KNOWN:
            size = UNITS[_KNOWN[candidate]]
            if size is None:
                return Fraction(1), {_KNOWN[candidate].split()[0]: 1}
            factor, powers = _size(ast.parse(size[1], mode="eval").body)
            return Fraction(size[0]) * factor, powers
    for candidate in candidates:
        for prefix, power in _POWERS.items():
            if candidate.startswith(prefix) and candidate.removeprefix(prefix) in _KNOWN:
                factor, powers = _named(candidate.removeprefix(prefix))
                return power * factor, powers
    raise ValueError("no unit")


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
    text = text.translate(str.maketrans("⁻¹²³", "-123"))
    text = re.sub(r"(?<=[A-Za-z])\s*(?:\^|\*\*)?\s*(-?[123])(?![0-9])", r"**\1", text)
    between = r"(?<=m)[ _](?=s)(?!s\*\*-)|(?<=rad|deg)_(?=s)(?!s\*\*-)|(?<=km)_(?=h)"
    text = re.sub(between, "/", text, flags=re.IGNORECASE)
    text = re.sub(r"[\s_.]*\*\*-([123])", r"**-\1", text)
    turns = re.fullmatch(rf"({_FORCE}){_BETWEEN}({_ARM})", text) or re.fullmatch(rf"({_ARM})-({_FORCE})", text)
    if turns and turns[0] != "nm":
        force, arm = sorted(turns.groups(), key=lambda part: re.fullmatch(_FORCE, part) is None)
        return f"{ {'lb': 'lbf', 'oz': 'ozf'}.get(force, force) }*{arm}"
    return re.sub(r"\brev\b", "turn", text).replace("·", "*").replace("⋅", "*")


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
