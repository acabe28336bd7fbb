"""Terms: what a force sensor measures beside friction, each a number times a column of the record."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.identification.problem.coordinates import Coordinate
from vibrocap.identification.problem.samples import Samples

FARTHEST = 100.0  # natural sizes, at which a term alone would make a hundred times the friction


@dataclasses.dataclass(frozen=True)
class Term:
    """A force c s(t): the unknown number c in `unit`, of N, m and s, and the column s of a record.

    signed: whether c may be negative; turning: whether the contact has to turn; farthest: bound of |c|, in natural
    sizes. wave: of a ripple, s = wave(2 pi column/length); of_friction: s is that times the friction.
    """

    meaning: str
    unit: str
    column: Callable[[Samples], np.ndarray]
    signed: bool = True
    turning: bool = False
    farthest: float = FARTHEST
    wave: Callable[[np.ndarray], np.ndarray] | None = None
    of_friction: bool = False


TERMS = {
    "offset": Term("constant force of the sensor", "N", lambda x: np.ones(len(x)), farthest=1.0),
    "mass": Term("inertia that the sensor carries", "kg", lambda x: x.acceleration, signed=False),
    "spring": Term("stiffness beside the contact", "N/m", lambda x: x.position),
    "damping": Term("viscous damping beside the contact", "N s/m", lambda x: x.velocity, signed=False),
    "damping_forward": Term("viscous damping of forward motion", "N s/m", lambda x: np.maximum(x.velocity, 0.0)),
    "damping_back": Term("viscous damping of backward motion", "N s/m", lambda x: np.minimum(x.velocity, 0.0)),
    "drag": Term("quadratic drag", "N s^2/m^2", lambda x: x.velocity * np.abs(x.velocity), signed=False),
    "gravity": Term("weight times arm, times sin(angle)", "N", lambda x: np.sin(x.position), turning=True),
    "gravity_cosine": Term("weight times arm, times cos(angle)", "N", lambda x: np.cos(x.position), turning=True),
}
WAVES = {"sine": np.sin, "cosine": np.cos}
RIPPLES = ("ripple", "friction_ripple")
for _wave, _function in WAVES.items():
    _of_position: dict[str, Any] = {"column": lambda x: x.position, "wave": _function}
    TERMS[f"ripple_{_wave}"] = Term(f"{_wave} of a force periodic in position", "N", **_of_position)
    _meaning = f"{_wave} of friction periodic in position, over its mean"
    TERMS[f"friction_ripple_{_wave}"] = Term(_meaning, "1", **_of_position, farthest=1.0, of_friction=True)


def checked_terms(terms: str | Sequence[str], others: Sequence[str], records: Sequence[Samples]) -> list[str]:
    """The names of terms, or ArgumentError for one that is unknown, or none of such a contact; others: more names."""
    names = [terms] if isinstance(terms, str) else list(terms)
    known = [*(name for name, term in TERMS.items() if term.wave is None), *others]
    for name in names:
        if name not in known:
            raise ArgumentError("terms", f"there is no term {name!r}; {suggestion(name, known)}")
        if name in TERMS and TERMS[name].turning and not all(record.rotary for record in records):
            raise ArgumentError("terms", f"{name} is of a contact that turns; of one that slides, gravity is an offset")
    return names


def length_name(name: str) -> str:
    """The wavelength of a ripple, or of one of its waves."""
    return f"{name.removesuffix('_sine').removesuffix('_cosine')}_length"


def ripple_coordinates(
    name: str, length: float, records: Sequence[Samples], level: float
) -> tuple[Coordinate, Coordinate, Coordinate]:
    """Both waves of a ripple and its length, which stays within half a wave along the path of where it begins."""
    path = max(float(np.ptp(record.position)) for record in records)
    low, high = (1.0 / (1.0 / length + side * 0.5 / path) for side in (1, -1))
    sine, cosine = (coordinate_of(f"{name}_{wave}", records, level) for wave in WAVES)
    of: dict[str, Any] = {"start": float(np.log(length)), "spread": 0.0, "nuisance": True}
    return sine, cosine, Coordinate(length_name(name), "log", low, high, **of, meaning="wavelength", unit="m")


def coordinate_of(name: str, records: Sequence[Samples], level: float) -> Coordinate:
    """The coordinate of a term, which starts at zero; level: N of friction."""
    term = TERMS[name]
    largest = 1.0 if term.wave else max(float(np.max(np.abs(term.column(record)))) for record in records)
    scale = 1.0 if term.of_friction else level / max(largest, 1e-300)
    reach = term.farthest * scale
    of: dict[str, Any] = {"scale": 0.1 * scale, "spread": 0.0, "meaning": term.meaning, "unit": term.unit}
    if term.signed:
        return Coordinate(name, "linear", -reach, reach, nuisance=True, **of)
    return Coordinate(name, "foot", 0.0, reach, whose=("law", "search"), nuisance=True, **of)


def forces_of_terms(
    names: Sequence[str], values: Any, record: Samples, late: Callable, friction: np.ndarray
) -> np.ndarray | float:
    """Force [m, n] of the terms among the named parameters [m, p] on a record, beside the friction [m, n].

    late(column): it, a delay before.
    """
    total: np.ndarray | float = 0.0
    for at, name in enumerate(names):
        if name in TERMS:
            term = TERMS[name]
            column = late(term.column(record))
            if term.wave:
                column = term.wave(2.0 * np.pi * column / values[:, [names.index(length_name(name))]])
            if term.of_friction:
                column = column * friction
            total = total + values[:, [at]] * column
    return total
