"""The choice of what a fit searches: free parameters, their bounds and a start that the data suggest.

A parameter declares its role with its value (`vibrocap.physics.parameters`); the role says its likely size, its range
and what would determine it. One without a role, or with one that no fit knows, is fitted from the value that the law
starts with.
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, listed, suggestion
from vibrocap.identification.problem.coordinates import COARSE_STEP, RATIOS, Coordinate, Space
from vibrocap.identification.problem.samples import DataScales
from vibrocap.physics import catalogue
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import (
    COEFFICIENT,
    NUMBER,
    ROLES,
    Dimension,
    ParameterError,
    ParameterInfo,
    parameter_table,
)


@dataclasses.dataclass(frozen=True)
class Role:
    """What a parameter does.

    share: the likely value over the natural size, the product of the data's scales that has the role's dimension.
    decades: how many powers of ten a start may be away from it.
    low, high: range over the natural size beyond which nothing is measurable; a parameter that may be zero is searched
        down to zero, and on a linear scale below `low`.
    experiment: what determines the parameter, in words that follow "... would determine it".
    fitted: whether it is free unless asked for otherwise.
    """

    name: str
    share: float
    decades: float
    low: float
    high: float
    experiment: str
    fitted: bool = True

    @property
    def dimension(self) -> Dimension:
        """The dimension of the role."""
        return ROLES.get(self.name, NUMBER)


SWEEP = "a slow sweep of velocity through the range where friction drops"
LOOPS = "presliding loops: reversals with strokes below the breakaway distance, sampled many times within them,"
STEPS = "steps of the sliding velocity, sampled many times over the critical distance and lasting several of it,"
BOTH = "steady sliding in both directions"
CONVENTION = "nothing: it is a convention, choose it"
# fmt: off
EXPECTED = {role.name: role for role in (  # name, share, decades, low, high, experiment
    Role("reference velocity", 1.0, 0.0, 0.0, math.inf, CONVENTION, fitted=False),
    Role("convention", 1.0, 0.0, 0.0, math.inf, CONVENTION, fitted=False),
    Role("cutoff velocity", 1e-3, 0.5, 1e-9, 1.0, "sliding at very low speeds", fitted=False),
    Role("softening", 0.5, 0.2, -0.45, 20.0, LOOPS),
    Role("exponent", 2.0, 0.2, 0.1, 12.0, SWEEP + ", and loops through the knee at breakaway,"),
    Role("static level", 1.2, 0.15, 1e-4, 20.0,
         "repeated slow break-aways from rest, or a sweep down to speeds far below the Stribeck velocity,"),
    Role("back ratio", 1.0, 0.1, 0.02, 50.0, BOTH),
    Role("direct effect", 0.015, 0.5, 3.5e-3, 1.0, STEPS),
    Role("evolution effect", 0.015, 0.5, 1e-6, 1.0, STEPS),
    Role("distance", 0.02, 0.7, 1e-6, 10.0, STEPS),
    Role("gap", 0.1, 0.3, 1e-5, 2.0, "slow reversals with strokes greater than the gap"),
    *(Role(name, 0.5, 0.2, 0.01, 0.98, "presliding loops of several strokes up to the breakaway distance,")
      for name in ("share", "fraction")),
    Role("stiffness", 20.0, 0.5, 1e-3, 1e7, LOOPS),
    Role("bristle damping", 0.03, 1.0, 1e-4, 1e3,
         "fast changes while presliding: small oscillations below breakaway, of an angular frequency near the ratio of "
         "bristle stiffness to bristle damping,"),
    Role("viscous damping", 0.1, 0.5, 1e-3, 1e2,
         "steady sliding at several speeds well above the Stribeck velocity"),
    Role("smoothing velocity", 0.02, 0.5, 1e-6, 2.0, "slow reversals, sampled many times within the width,"),
    Role("Stribeck velocity", 0.1, 0.7, 1e-5, 20.0, SWEEP),
    Role("fading velocity", 0.1, 0.7, 1e-5, 20.0, "fast changes of the speed while sliding, at several speeds"),
    Role("decay rate", 10.0, 0.7, 0.05, 1e5, SWEEP),
    Role("attraction rate", 20.0, 0.7, 1e-2, 1e5, "fast changes of the speed while sliding"),
    Role("level", 1.0, 0.1, 1e-4, 20.0, "steady sliding at high speed"),
)}
# fmt: on
UNKNOWN = Role("unknown", 1.0, 0.3, 0.0, math.inf, "a motion that excites its effect")


def role(law: Any, name: str) -> Role:
    """The role of a parameter of a law or of its class; unknown for what is no parameter of it (an offset)."""
    roles = (info.role for info in parameter_table(law) if info.name == name)
    return EXPECTED.get(next(roles, ""), UNKNOWN)


def with_role(law: Any, *roles: str) -> tuple[str, ...]:
    """Names of the parameters of a law, or of its class, that have one of these roles, in their order."""
    return tuple(info.name for info in parameter_table(law) if info.role in roles)


def unit_of(info: ParameterInfo, known_load: bool) -> str:
    """SI unit of a parameter, "" if it declares none; a coefficient is a force in N where the load is not known."""
    return "" if info.dimension is None else info.dimension.unit(known_load)


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
        changes |= {"step": COARSE_STEP, "jumps": kinds[name].name == "gap"} if coarse else {}
        coordinates.append(dataclasses.replace(coordinate, **changes))
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
    # a searched exponent starts off whole numbers, which would choose the formula of a product of powers
    whole = {k: 0.97 * v for k, v in values.items() if k in template.shape_parameters and v == int(v)}
    try:
        template = with_values(template, {**held, **values, **whole})
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
    for name, (low, high) in bounds.items():
        if not low < high:
            raise ArgumentError("bounds", f"{name} should have its lower bound first, got {low!r} and {high!r}")
    if free is None:
        values = {name: getattr(template, name) for name in names}
        shapes = [name for name in template.shape_parameters if values[name] == int(values[name])]
        floats = [name for name in names if isinstance(values[name], float) and role(template, name).fitted]
        free_names = [name for name in floats if name not in fixed and name not in shapes]
    else:
        free_names = [name for name in names if name in set(free)]
        if both := [name for name in free_names if name in fixed]:
            raise ArgumentError("free", f"{both[0]} is also in fixed; name it in one of them")
    if not free_names:
        raise ArgumentError("free", f"no parameter of {template.name} is free; there are {', '.join(names)}")
    return free_names


def _limits(cls: Any, name: str) -> tuple[float, float, bool]:
    """Limits that the law's own checks set: (low, high, whether low itself is allowed)."""
    low, high, inclusive = -math.inf, math.inf, True
    for constraint in cls.__pydantic_fields__[name].metadata:
        for field in ("gt", "ge", "lt", "le"):
            if (limit := getattr(constraint, field, None)) is not None and field in ("lt", "le"):
                high = float(limit)
            elif limit is not None:
                low, inclusive = float(limit), field == "ge"
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
