"""The choice of what a fit searches: free parameters, their bounds and a start that the data suggest."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, listed, suggestion
from vibrocap.identification.problem.coordinates import COARSE_STEP, RATIOS, Coordinate, Space
from vibrocap.identification.problem.data_scales import DataScales
from vibrocap.identification.problem.parameter_roles import UNKNOWN, Role, role, with_role
from vibrocap.physics import catalogue
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import COEFFICIENT, NUMBER, ParameterError, parameter_table

STIFFEST = 1000.0  # a bristle that yields a thousandth of the least displacement between samples is rigid for the data


@dataclasses.dataclass(frozen=True, eq=False)
class Parametrisation:
    """What a fit searches.

    template: a law with the fixed values and the start; space: the free parameters as coordinates; start [p]:
    coordinates from the data; own_start [p] or None: those of the law that was given as an instance.
    """

    template: Law
    space: Space
    start: np.ndarray
    own_start: np.ndarray | None


def with_values(law: Any, values: Mapping[str, float]) -> Any:
    """The law with other parameters."""
    return dataclasses.replace(law, **{name: float(value) for name, value in values.items()})


def law_class(law: Any) -> type[Law]:
    """The class of a law given as an instance, a class or a name."""
    if isinstance(law, str):
        try:
            return catalogue.law(law)
        except KeyError:
            raise ArgumentError("law", f"no law is called {law!r}; {suggestion(law, catalogue.laws())}") from None
    cls = law if isinstance(law, type) else type(law)
    if not issubclass(cls, Law):
        raise ArgumentError("law", f"should be a friction law, its class or its name, got {law!r}")
    return cls


def parametrisation(
    law: Any,
    scales: DataScales,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> Parametrisation:
    """The free parameters of a law, their bounds and their start.

    free: names; None: all numbers but those that choose the law's formula and those that are conventions. fixed: values
    that are held. bounds: (low, high) by name in place of those that physics and the data set.
    Raises ValueError: unknown names (with the nearest), bounds reversed, a start outside them, nothing free.
    """
    cls = law_class(law)
    is_instance = isinstance(law, Law)
    template = law if is_instance else cls()
    fixed, bounds = dict(fixed or {}), dict(bounds or {})
    names = [info.name for info in parameter_table(cls) if _is_number(getattr(template, info.name))]
    free_names = _free_names(template, names, free, fixed, bounds)
    limits = {name: _limits(cls, name) for name in names}
    kinds = {name: role(cls, name) for name in names}
    leaders = {high: low for high, low in leading_levels(cls).items() if low in names and high in names}
    partners = {low: high for high, low in leaders.items()}
    own = {name: float(getattr(template, name)) for name in names}
    if not is_instance:  # a convention of a law without numbers of its own: a size that suits the data
        sized = [name for name in with_role(cls, "reference velocity", "cutoff velocity") if name in names]
        own |= {name: kinds[name].share * scales.natural(kinds[name].dimension) for name in sized}
    start = {**own, **{name: float(value) for name, value in fixed.items()}}
    forward = bool(with_role(cls, "back ratio"))
    guessed = {name: _guess(kinds[name], own[name], scales, forward) for name in free_names}
    springs = [name for name in free_names if kinds[name].name == "stiffness"]
    for name in springs:  # springs in parallel share the stiffness in the proportions that the law has
        guessed[name] *= own[name] / sum(own[spring] for spring in springs)
    for name in free_names:  # a static level is guessed over its Coulomb level
        partner = leaders.get(name)
        if partner:
            guessed[name] = guessed.get(partner, start[partner]) * min(max(scales.peak, 1.05), 3.0)
    coordinates, constants = [], {}
    coarse = any(kind.name == "gap" for kind in kinds.values())
    for name in sorted(free_names, key=lambda name: name in leaders):  # each partner before what depends on it
        partner, led = leaders.get(name), partners.get(name)
        coordinate = _coordinate(name, kinds[name], limits[name], guessed[name], scales, bounds.get(name))
        if name in bounds:
            changes: dict[str, Any] = {"whose": ("given", "given")}
        elif partner:
            changes = {"form": "above", "partner": partner, "low": 0.0, "high": math.inf, "whose": RATIOS}
            constants[partner] = start[partner]
        elif led and led not in free_names:
            changes = {"form": "below", "partner": led, "whose": RATIOS}
            constants[led] = start[led]
        else:
            ends = zip((coordinate.low, coordinate.high), limits[name], strict=False)
            changes = {"whose": tuple("law" if end == limit else "search" for end, limit in ends)}
        coordinate = dataclasses.replace(coordinate, **changes)
        if coarse:
            coordinate = dataclasses.replace(coordinate, step=COARSE_STEP, jumps=kinds[name].name == "gap")
        coordinates.append(coordinate)
    shares = tuple(name for name in with_role(cls, "share") if name in names)
    constants |= {name: start[name] for name in shares}
    space = Space(tuple(coordinates), {k: v for k, v in constants.items() if k not in free_names}, shares)
    for coordinate in coordinates if is_instance else ():
        name, low, high = coordinate.name, coordinate.low, coordinate.high
        if name in bounds and not low <= own[name] <= high:
            outside = f"{name} starts at {own[name]:g}, outside its bounds {low:g} to {high:g}"
            raise ArgumentError("bounds", f"{outside}; start the law within them")
    own_start = space.of({**start, **{name: own[name] for name in free_names}}) if is_instance else None
    u = space.of({**start, **guessed})
    values = space.named(u)
    held = {name: start[name] for name in names if name not in values and isinstance(getattr(template, name), float)}
    try:
        template = with_values(template, {**held, **{k: _not_whole(template, k, v) for k, v in values.items()}})
    except ParameterError as error:  # values that are good each alone: a static level below the Coulomb level
        complaints = "; ".join(f"{complaint.field} {complaint.text}" for complaint in error.complaints)
        raise ArgumentError("fixed", complaints) from None
    return Parametrisation(template, space, u, own_start)


def require_values(law: Any, free: Iterable[str] | None, fixed: Mapping[str, float] | None) -> None:
    """ArgumentError where a size of a law that is given by its name or class is neither searched nor known.

    The law's own numbers are those of a dimensionless model: 0.45 is no static force in newtons.
    """
    if free is None or isinstance(law, Law):
        return
    cls, known = law_class(law), {*free, *(fixed or {})}
    sizes = [info for info in parameter_table(cls) if role(cls, info.name).dimension != NUMBER and info.default]
    if unknown := [info.name for info in sizes if info.name not in known and role(cls, info.name).fitted]:
        either = "free it or give it in fixed" if len(unknown) == 1 else "free them or give them in fixed"
        raise ArgumentError("free", f"leaves {listed(unknown, ' and ')} of {cls.name} without a value: {either}")


def leading_levels(law: Any) -> dict[str, str]:
    """The level below each static level of a law, by name, where there are as many of both."""
    low, high = with_role(law, "level"), with_role(law, "static level")
    return dict(zip(high, low, strict=True)) if len(low) == len(high) else {}


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _free_names(template: Any, names: list[str], free: Any, fixed: Mapping, bounds: Mapping) -> list[str]:
    for argument, own in (("free", free or ()), ("fixed", fixed), ("bounds", bounds)):
        for name in own:
            if name not in names:
                raise ArgumentError(argument, f"{template.name} has no parameter {name!r}; {suggestion(name, names)}")
    for name, value in fixed.items():
        if not (_is_number(value) and math.isfinite(value)):
            raise ArgumentError("fixed", f"{name} should be a finite number, got {value!r}")
        low, high, inclusive = _limits(type(template), name)
        if not (low < value <= high or (inclusive and value == low)):
            least = "" if low == -math.inf else f" {'at least' if inclusive else 'greater than'} {low:g}"
            most = "" if high == math.inf else f" at most {high:g}"
            raise ArgumentError("fixed", f"{name} should be{' and'.join(filter(None, (least, most)))}, got {value!r}")
    for name, pair in bounds.items():
        low, high = pair
        if not low < high:
            raise ArgumentError("bounds", f"{name} should have its lower bound first, got {low!r} and {high!r}")
    if free is None:
        shapes = [name for name in template.shape_parameters if getattr(template, name) == int(getattr(template, name))]
        free_names = [name for name in names if name not in fixed and name not in shapes]
        free_names = [
            name for name in free_names if isinstance(getattr(template, name), float) and role(template, name).fitted
        ]
    else:
        free_names = [name for name in names if name in set(free)]
        both = [name for name in free_names if name in fixed]
        if both:
            raise ArgumentError("free", f"{both[0]} is also in fixed; name it in one of them")
    if not free_names:
        raise ArgumentError("free", f"no parameter of {template.name} is free; there are {', '.join(names)}")
    return free_names


def _limits(cls: Any, name: str) -> tuple[float, float, bool]:
    """Limits that the law's own checks set: (low, high, whether low itself is allowed)."""
    low, high, inclusive = -math.inf, math.inf, True
    for constraint in cls.__pydantic_fields__[name].metadata:
        for field in ("gt", "ge"):
            if getattr(constraint, field, None) is not None:
                low, inclusive = float(getattr(constraint, field)), field == "ge"
        for field in ("lt", "le"):
            if getattr(constraint, field, None) is not None:
                high = float(getattr(constraint, field))
    return low, high, inclusive


def _coordinate(
    name: str,
    kind: Role,
    limits: tuple[float, float, bool],
    guess: float,
    scales: DataScales,
    own: tuple[float, float] | None,
) -> Coordinate:
    """The form and the bounds of one parameter; own: bounds that were given."""
    natural = _natural(kind, guess, scales)
    low, high, inclusive = limits
    if low < 0 and kind.name == "softening":
        return Coordinate(name, "linear", *(own or (kind.low, kind.high)), scale=0.5)
    if low < 0:
        reach = max(abs(guess) * 10, natural)
        ends = own or (max(low, -reach), min(high, reach))
        return Coordinate(name, "linear", *ends, scale=max(abs(guess), 0.1 * natural))
    upper = kind.high * natural
    if kind.name == "stiffness":
        upper = max(STIFFEST * scales.level / scales.step, 10 * guess)
    if not math.isfinite(min(upper, high)):
        upper = 1e4 * max(abs(guess), natural)
    upper = min(upper, high)
    spread = kind.decades * math.log(10)
    if inclusive and low == 0 and kind.dimension != COEFFICIENT:
        foot = natural * (kind.low or 1e-4)
        return Coordinate(name, "foot", *(own or (0.0, upper)), scale=foot, spread=spread)
    lower = max(low, kind.low * natural, 1e-12 * guess)
    if own:
        lower, upper = max(own[0], 1e-12 * max(abs(own[1]), 1e-300)), own[1]
    return Coordinate(name, "log", lower, max(upper, lower * 1.001), spread=spread)


def _natural(kind: Role, guess: float, scales: DataScales) -> float:
    if kind is UNKNOWN:
        return abs(guess) or 1.0
    return scales.natural(kind.dimension)


def _guess(kind: Role, own: float, scales: DataScales, forward: bool) -> float:
    """Where the data suggest to start; forward: whether the law's levels are those of sliding forward."""
    if kind.name in (UNKNOWN.name, "share", "fraction", "convention", "softening"):
        return own
    level = scales.forward if forward else scales.level
    guesses = {"level": level / scales.load, "back ratio": scales.backward / scales.forward}
    if scales.stiffness is not None:
        lag = math.sqrt(scales.interval * scales.length / scales.speed) / 3
        # between the slopes sigma_0 (from rest) and 2 sigma_0 (after a reversal)
        guesses |= {"stiffness": scales.stiffness / 1.5, "bristle damping": scales.stiffness * lag}
    if scales.drop_speed is not None:
        guesses |= {"Stribeck velocity": scales.drop_speed, "decay rate": 0.7 / scales.drop_speed}
    return guesses.get(kind.name, kind.share * _natural(kind, own, scales))


def _not_whole(law: Any, name: str, value: float) -> float:
    """A searched exponent starts off whole numbers, which would choose the formula of a product of powers."""
    return value * 0.97 if name in law.shape_parameters and value == int(value) else value
