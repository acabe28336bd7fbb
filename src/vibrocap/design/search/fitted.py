"""What a fit leaves uncertain: the parameters of a friction law jointly, as the data determine them.

Near its minimum a fit knows combinations of parameters, prod p_i^e_i, each with a standard deviation s of its logarithm
(`identifiability`). The combinations are orthogonal in the logarithms, so

    ln p_i = ln p_i0 + sum_k e_ki s_k z_k        with independent normal z_k

is the joint distribution: parameters that the data confuse vary together. It is taken about the values of the case.
"""

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import Complaint, shown
from vibrocap.inputs import read_input
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.physics.system import System

PREFIX = "fit:"  # before the name of a file fit.json
LARGEST = 2**28  # bytes of it
APART = 1e-3  # relative difference from which a value of the case is not that of the fit


@dataclasses.dataclass(frozen=True)
class Combination:
    """A combination of parameters: paths, powers, and the standard deviation of its logarithm."""

    name: str
    paths: tuple[str, ...]
    powers: tuple[float, ...]
    deviation: float


def is_fit(given: Any) -> bool:
    """Whether the joint uncertainty of a fit is given: a `Fit`, or "fit:FILE.json"."""
    return hasattr(given, "identifiability") or (isinstance(given, str) and given.startswith(PREFIX))


def combinations_of_fit(system: System, section: str, given: Any) -> list[Combination] | Complaint:
    """What a fit of the law in a section (friction, friction_2, ...) leaves uncertain, or what is wrong.

    given: a `Fit`, or "fit:FILE.json" as `vibrocap fit --out` writes it
    """
    law = system.parts.get(section)
    if law is None or not section.startswith("friction"):
        sections = ", ".join(each for each in system.parts if each.startswith("friction"))
        return Complaint(section, f"has no fitted law; give the fit for {sections}")
    known = _read(given)
    if isinstance(known, str):
        return Complaint(section, known)
    if known["law"] != law.name:
        return Complaint(section, f"is {law.name!r} in the case, and {known['law']!r} in the fit")
    directions = known["directions"]
    if not directions:
        return Complaint(section, "should be a fit with intervals; this one has determined nothing")
    for name, value, unit in known["parameters"]:
        place = quantity_in_si(f"{section}.{name}", system)
        own = system.parameter(place.path)
        if unit == place.unit and not math.isclose(own, value, rel_tol=APART):
            advice = "put friction.toml of the fit into the case"
            return Complaint(place.path, f"is {own:g} in the case, and {value:g} in the fit; {advice}")
    found = []
    for exponents, deviation in directions:
        moving = {name: e for name, e in exponents.items() if e != 0.0}
        words = " ".join(f"{name}^{e:.2g}" for name, e in moving.items() if abs(e) >= 0.1)
        if deviation is None or not math.isfinite(deviation):
            advice = f"give distributions of {', '.join(moving)} instead"
            return Complaint(section, f"the data of the fit do not determine {words}; {advice}")
        paths = tuple(quantity_in_si(f"{section}.{name}", system).path for name in moving)
        found.append(Combination(f"{section}: {words}", paths, tuple(moving.values()), float(deviation)))
    return found


def _read(given: Any) -> dict[str, Any] | str:
    """Law, parameters as (name, value, unit) and directions as (exponents, deviation) of a fit, or what is wrong."""
    if not isinstance(given, str):
        report = given.identifiability
        return {
            "law": given.law_name,
            "parameters": [(each.name, each.value, each.unit) for each in given.parameters],
            "directions": [] if report is None else [(each.exponents, each.deviation) for each in report.directions],
        }
    path = given.removeprefix(PREFIX)
    try:
        record = json.loads(read_input(path, LARGEST))
        report = record["identifiability"] or {"directions": []}
        return {
            "law": str(record["law"]),
            "parameters": [(each["name"], float(each["value"]), each["unit"]) for each in record["parameters"]],
            "directions": [(_numbers(each["exponents"]), each["deviation"]) for each in report["directions"]],
        }
    except OSError as error:
        return f"{shown(path)} cannot be read ({error.strerror or error})"
    except (ValueError, KeyError, TypeError):
        return f"{shown(path)} is no fit.json as `vibrocap fit --out` writes it"


def _numbers(given: Mapping[str, Any]) -> dict[str, float]:
    return {str(name): float(value) for name, value in given.items()}
