"""Sizes of units in SI: products, quotients and powers of named units and their prefixes, such as "kN*mm/s**2"."""

import ast
import functools
import re
from fractions import Fraction

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
