"""Units of measured quantities: what a unit is called, what it measures, and its factor to SI."""

import re

from vibrocap.arguments import suggestion

# unit: (dimension, factor to SI)
UNITS: dict[str, tuple[str, float]] = {
    "s": ("time", 1.0),
    "ms": ("time", 1e-3),
    "us": ("time", 1e-6),
    "min": ("time", 60.0),
    "N": ("force", 1.0),
    "kN": ("force", 1e3),
    "mN": ("force", 1e-3),
    "uN": ("force", 1e-6),
    "MN": ("force", 1e6),
    "m": ("length", 1.0),
    "cm": ("length", 1e-2),
    "mm": ("length", 1e-3),
    "um": ("length", 1e-6),
    "nm": ("length", 1e-9),
    "m/s": ("speed", 1.0),
    "cm/s": ("speed", 1e-2),
    "mm/s": ("speed", 1e-3),
    "um/s": ("speed", 1e-6),
    "nm/s": ("speed", 1e-9),
    "m/s^2": ("acceleration", 1.0),
    "mm/s^2": ("acceleration", 1e-3),
    "g": ("acceleration", 9.80665),  # standard gravity, CGPM 1901
    "Pa": ("stress", 1.0),
    "kPa": ("stress", 1e3),
    "MPa": ("stress", 1e6),
    "GPa": ("stress", 1e9),
    "1": ("number", 1.0),
    "%": ("number", 1e-2),
}

# other spellings, in small letters
SPELLINGS = {
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "newton": "N",
    "newtons": "N",
    "micron": "um",
    "microns": "um",
    "micrometer": "um",
    "micrometers": "um",
    "mps": "m/s",
    "mmps": "mm/s",
    "umps": "um/s",
    "-": "1",
    "none": "1",
    "dimensionless": "1",
}

# quantity: the dimensions in which it may be given, the SI one first
QUANTITIES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "force": ("force", "stress", "number"),
    "velocity": ("speed",),
    "displacement": ("length",),
    "acceleration": ("acceleration",),
    "normal_force": ("force", "stress"),
}
_SI = {dimension: unit for unit, (dimension, factor) in reversed(UNITS.items()) if factor == 1.0}


def unit_named(text: str) -> str | None:
    """The unit that a text means, as UNITS spells it; None where it is no unit.

    Understood are other spellings of micro, of division and of powers: "µm", "m_per_s", "m_s", "m s-1", "mm/sec".
    Capital letters count (mN, MN), unless no unit is spelt so: "MM/S" is mm/s.
    """
    text = text.strip().replace("µ", "u").replace("μ", "u")
    text = re.sub(r"\s*(?:[_ ]per[_ ]|p(?=s$)|/)\s*", "/", text)
    text = re.sub(r"[\s._*·]*s(ec)?\^?[-⁻][1¹]$", "/s", text)
    text = re.sub(r"[\s._*·]*s(ec)?\^?[-⁻][2²]$", "/s^2", text)
    text = re.sub(r"(?<=m)[ _](?=s)", "/", text, flags=re.IGNORECASE)
    text = re.sub(r"/s(?:ec)?(?:\^|\*\*)?[2²]$", "/s^2", text)
    text = re.sub(r"/sec(?:onds?)?$", "/s", text)
    if text in UNITS:
        return text
    small = text.lower()
    if small in SPELLINGS:
        return SPELLINGS[small]
    alike = [unit for unit in UNITS if unit.lower() == small]
    return alike[0] if len(alike) == 1 else None


def si_unit(quantity: str) -> str:
    """The SI unit of a quantity: N of a force."""
    return _SI[QUANTITIES[quantity][0]]


def dimension(unit: str) -> str:
    """What a unit of UNITS measures."""
    return UNITS[unit][0]


def factor(unit: str) -> float:
    """What one such unit is in SI units."""
    return UNITS[unit][1]


def fits(unit: str, quantity: str) -> bool:
    """Whether a quantity may be given in a unit."""
    return UNITS[unit][0] in QUANTITIES[quantity]


def unit_complaint(quantity: str, text: object) -> str | None:
    """Why a text is no unit for a quantity; None where it is one."""
    allowed = [unit for unit in UNITS if fits(unit, quantity)]
    unit = unit_named(text) if isinstance(text, str) else None
    if unit is not None and fits(unit, quantity):
        return None
    what = "no unit that is known here" if unit is None else f"a unit of {dimension(unit)}"
    hint = suggestion(text, allowed, 0.6 if unit is None else 1.0, "should be", " or ")
    return f"units: {quantity}: {text!r} is {what}; {hint}"
