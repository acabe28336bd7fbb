"""The controls of a part: for every parameter what it is, what it may be, and over which range a slider moves it."""

import math
import typing
from typing import Any

from vibrocap.case.text import description_text
from vibrocap.physics.catalogue import laws, wrappers
from vibrocap.physics.dimensions.carry_over import needed
from vibrocap.physics.dimensions.scales import resolved
from vibrocap.physics.dimensions.units import parameter_keys, unit_name
from vibrocap.physics.parameters import Dimension, ParameterInfo, parameter_table

# Roles whose parameters are moved by factors, and how far either way from the default.
FACTORS = {
    **dict.fromkeys(("mass", "smoothing velocity", "reference velocity", "cutoff velocity", "distance"), 50.0),
    **dict.fromkeys(("Stribeck velocity", "fading velocity", "decay rate"), 20.0),
    "frequency": 5.0,
}
SHARES = {"level", "static level", "fraction", "share"}  # moved from 0 to 1
WIDE = 2.5  # times its default, to which any other slider goes
LARGE = 50.0  # a default from which on a positive parameter is moved by factors of LARGE_FACTOR, whatever it does
LARGE_FACTOR = 20.0


def part_record(part: type, effort: str) -> dict[str, Any]:
    """What a page knows of a kind of part: name, first sentence of its description, parameters.

    effort: what the drive exerts on the machine, "force" or "torque"
    """
    doc = (part.__doc__ or "").strip().split("\n\n")[0]
    return {
        "name": part.name,  # type: ignore[attr-defined]
        "about": " ".join(doc.replace("`", "").split()),
        "python": _python(part),
        "parameters": [_parameter(part, info, effort) for info in parameter_table(part)],
        **({"described": description_text(text)} if (text := getattr(part, "description", None)) else {}),
    }


def _python(part: type) -> dict[str, str]:
    """How Python names the class, and from where it is imported where `vibrocap` does not have it."""
    import vibrocap

    if getattr(vibrocap, part.__name__, None) is part:
        return {"name": part.__name__, "module": ""}
    if hasattr(part, "description"):  # of a mechanism only its case has the class
        return {"name": 'read_case("case.toml").system.machine.__class__', "module": ""}
    name = part.name  # type: ignore[attr-defined]
    prefix, _, rest = name.partition("-")
    if prefix in wrappers() and rest in laws():  # made when it is asked for: it has no name in any module
        return {"name": f'laws()["{name}"]', "module": "vibrocap.physics.catalogue", "imported": "laws"}
    return {"name": part.__name__, "module": part.__module__}


def _parameter(part: Any, info: ParameterInfo, effort: str) -> dict[str, Any]:
    bounds = bounds_of(part, info.name)
    least = bounds.get("least")
    low, high, log = slider_range(info, least)
    high = min(high, bounds.get("most", high))
    keys = parameter_keys(part, effort)
    si = [[key.stem, key.unit, key.factor] for key in keys.values() if key.name == info.name]
    return {
        "name": info.name,
        "symbol": info.symbol,
        "meaning": info.meaning,
        **({"inSi": info.in_si} if info.in_si != info.meaning else {}),
        "default": info.default,
        "needed": any(key.name == info.name for key in needed(part)),
        **bounds,
        "low": low,
        "high": high,
        "log": log,
        "unit": "" if info.dimension is None else unit_name(info.dimension, effort),
        "exponents": None if info.dimension is None else exponents(resolved(info.dimension, effort)),
        "si": si[:1],
    }


def exponents(dimension: Dimension) -> list[float]:
    """Of mass, length and time, of a dimension in force, length and time."""
    return [dimension.force, dimension.length + dimension.force, dimension.time - 2 * dimension.force]


def bounds_of(part: Any, name: str) -> dict[str, Any]:
    """The bounds that a parameter has by itself: least and most, above and below where these are excluded."""
    field = part.__pydantic_fields__[name]
    rules = [*field.metadata]
    for inner in typing.get_args(field.annotation):  # a number with bounds, or None
        rules += [rule for info in typing.get_args(inner)[1:] for rule in getattr(info, "metadata", [info])]
    bounds: dict[str, Any] = {}
    for rule in rules:
        for key, kind, excluded in ("gt", "least", "above"), ("lt", "most", "below"):
            if (bound := getattr(rule, key, None)) is not None:
                bounds |= {kind: float(bound), excluded: True}
            elif (bound := getattr(rule, key[0] + "e", None)) is not None:
                bounds[kind] = float(bound)
        check = getattr(rule, "func", None)
        if check is not None and _refused(check, -1.0) and not _refused(check, 0.0):
            bounds["least"] = 0.0
    return bounds


def _refused(check: Any, value: float) -> bool:
    """Whether a parameter's own check refuses a number; one that asks for more than a number is not asked."""
    try:
        check(value)
    except TypeError:
        return False
    except ValueError:
        return True
    return False


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
    return min((1.0, 2.0, 5.0, 10.0), key=lambda factor: abs(math.log(value / (factor * power)))) * power
