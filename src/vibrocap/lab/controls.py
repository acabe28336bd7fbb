"""The controls of a part: for every parameter what it is, what it may be, and over which range a slider moves it."""

import math
from typing import Any

from vibrocap.physics.catalogue import laws, wrappers
from vibrocap.physics.parameters import ParameterError, ParameterInfo, parameter_table
from vibrocap.physics.roles import Dimension
from vibrocap.physics.scales import EFFORTS
from vibrocap.physics.units import parameter_keys, unit_name

# Roles whose parameters are moved by factors, and how far either way from the default.
FACTORS = {
    "mass": 50.0,
    "Stribeck velocity": 20.0,
    "fading velocity": 20.0,
    "smoothing velocity": 50.0,
    "reference velocity": 50.0,
    "cutoff velocity": 50.0,
    "decay rate": 20.0,
    "distance": 50.0,
    "frequency": 5.0,
}
LEVELS = "coulomb_coefficient", "static_coefficient"
SHARES = {"level", "static level", "fraction", "share"}  # moved from 0 to 1
WIDE = 2.5  # times its default, to which any other slider goes
LARGE = 50.0  # a default from which on a positive parameter is moved by factors of LARGE_FACTOR, whatever it does
LARGE_FACTOR = 20.0


def part_record(part: type, effort: str) -> dict[str, Any]:
    """What a page knows of a kind of part: name, first sentence of its description, parameters, order of its levels.

    effort: what the drive exerts on the machine, "force" or "torque"
    """
    doc = (part.__doc__ or "").strip().split("\n\n")[0]
    return {
        "name": part.name,  # type: ignore[attr-defined]
        "about": " ".join(doc.replace("`", "").split()),
        "python": _python(part),
        "ordered": list(LEVELS) if _orders_levels(part) else [],
        "parameters": [_parameter(part, info, effort) for info in parameter_table(part)],
    }


def _python(part: type) -> dict[str, str]:
    """How Python names the class, and from where it is imported where `vibrocap` does not have it."""
    import vibrocap

    if getattr(vibrocap, part.__name__, None) is part:
        return {"name": part.__name__, "module": ""}
    name = part.name  # type: ignore[attr-defined]
    prefix, _, rest = name.partition("-")
    if prefix in wrappers() and rest in laws():  # made when it is asked for: it has no name in any module
        return {"name": f'laws()["{name}"]', "module": "vibrocap.physics.catalogue", "imported": "laws"}
    return {"name": part.__name__, "module": part.__module__}


def _orders_levels(part: Any) -> bool:
    """Whether the law refuses a static coefficient below the Coulomb coefficient: it is asked."""
    if not set(LEVELS) <= {info.name for info in parameter_table(part)}:
        return False
    try:
        part(**dict(zip(LEVELS, (0.2, 0.1), strict=True)))
    except ParameterError:
        return True
    return False


def _parameter(part: Any, info: ParameterInfo, effort: str) -> dict[str, Any]:
    least, open_end = _bound(part, info.name)
    low, high, log = slider_range(info, least)
    keys = parameter_keys(part, effort)
    si = [[each.stem, each.unit, each.factor] for each in keys.values() if each.name == info.name]
    return {
        "name": info.name,
        "symbol": info.symbol,
        "meaning": info.meaning,
        "default": info.default,
        "least": least,
        "open": open_end,
        "low": low,
        "high": high,
        "log": log,
        "unit": "" if info.dimension is None else unit_name(info.dimension, effort),
        "exponents": None if info.dimension is None else exponents(info.dimension.resolved(EFFORTS[effort])),
        "si": si[:1],
    }


def exponents(dimension: Dimension) -> list[float]:
    """Of mass, length and time, of a dimension in force, length and time."""
    return [dimension.force, dimension.length + dimension.force, dimension.time - 2 * dimension.force]


def _bound(part: Any, name: str) -> tuple[float | None, bool]:
    """(least value that a parameter may have, whether that itself is excluded); None: any number."""
    least, excluded = None, False
    for rule in part.__pydantic_fields__[name].metadata:
        if getattr(rule, "gt", None) is not None:
            least, excluded = float(rule.gt), True
        elif getattr(rule, "ge", None) is not None:
            least, excluded = float(rule.ge), False
    if least is None and name == "normal_load":  # a number or a word, checked by the machine itself
        least = 0.0
    return least, excluded


def slider_range(info: ParameterInfo, least: float | None) -> tuple[float, float, bool]:
    """(low, high, by factors) of the slider of a parameter; the box beside it takes whatever the part takes."""
    default = float(info.default) if isinstance(info.default, (int, float)) else 1.0
    size = abs(default) or 1.0
    if info.role in FACTORS and default > 0.0:
        factor = FACTORS[info.role]
        return _rounded(default / factor), _rounded(default * factor), True
    if info.role in SHARES:
        return 0.0, max(1.0, _rounded(2.0 * size)), False
    if info.role == "phase":
        return -3.15, 3.15, False
    if info.role == "exponent":
        return 0.5, max(4.0, 2.0 * size), False
    if least is not None and size >= LARGE:
        return _rounded(size / LARGE_FACTOR), _rounded(size * LARGE_FACTOR), True
    high = _rounded(max(WIDE * size, 1.0))
    if info.role in ("effort", "effort rate"):
        return 0.0, high, False
    return (-high if least is None else 0.0), high, False


def _rounded(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return min((1.0, 2.0, 5.0, 10.0), key=lambda each: abs(math.log(value / (each * power)))) * power
