"""Branches of steady motions as labelled datasets, which say of themselves what they hold."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import Case, case_text
from vibrocap.quantities.declared import Shown
from vibrocap.studies.plan.code_version import code_version
from vibrocap.studies.variables import coordinate_attributes, state_attributes

if TYPE_CHECKING:
    import xarray


POINTS = {"period": "length of one response", "drift": "drift over one response", "mean_velocity": "mean velocity"}


def branch_dataset(branch: Shown) -> "xarray.Dataset":
    """The arrays of a branch along "point", in order of its arclength, and its special points along "special".

    multiplier_real and multiplier_imag: Floquet multipliers along "multiplier", largest first
    """
    import xarray

    names = branch.system.state_names
    data: dict[str, Any] = {
        name: ("point", branch.states[:, i], state_attributes(name, branch)) for i, name in enumerate(names)
    }
    data |= {
        name: ("point", getattr(branch, name), {"long_name": meaning, "units": branch.unit_of(name)})
        for name, meaning in POINTS.items()
    }
    data |= {
        "multiplier_real": (
            ("point", "multiplier"),
            np.real(branch.multipliers),
            _words("Floquet multiplier, real part"),
        ),
        "multiplier_imag": (
            ("point", "multiplier"),
            np.imag(branch.multipliers),
            _words("Floquet multiplier, imaginary"),
        ),
        "stable": ("point", branch.stable, {"long_name": "all multipliers inside the unit circle"}),
        "certified": (
            "point",
            branch.certified,
            {"long_name": "the motion is one of the equations, by its certificate"},
        ),
        "mode_sequence": (
            "point",
            branch.mode_sequence.astype(str),
            {"long_name": "phases: F forward, S stuck, B back"},
        ),
    }
    for i, name in enumerate(branch.system.turns):
        data[f"winding_{name}"] = ("point", branch.winding[:, i], _words(f"whole turns of {name} over one response"))
    special = branch.special_points
    along = {"units": branch.unit_of("parameter")} if branch.si_context() is not None else {}
    for name, values, meaning in (
        ("special_kind", [each.kind.value for each in special], "kind of special point"),
        ("special_parameter", [each.parameter for each in special], f"{branch.over} there"),
        ("special_error", [each.error for each in special], "error of that at most"),
        ("special_arclength", [each.arclength for each in special], "arclength of the branch there"),
        ("special_stability", [each.stability for each in special], "what happens to the stability along the branch"),
    ):
        kind = str if name in ("special_kind", "special_stability") else float
        unit = along if name in ("special_parameter", "special_error") else {}
        data[name] = ("special", np.array(values, dtype=kind), {"long_name": meaning} | unit)
    coordinates: dict[str, Any] = {
        branch.over: ("point", branch.parameter, coordinate_attributes(branch.over, branch.system)),
        "arclength": ("point", branch.arclength, _words("arclength, in natural sizes and shares of the range")),
    }
    attributes = {
        "title": f"Branch of steady motions over {branch.over}",
        "response_period": branch.response_period,
        "symmetric": "not defined" if branch.symmetric is None else str(branch.symmetric),
        "begins": branch.ends[0].value,
        "ends": branch.ends[1].value,
        "source": f"vibrocap {code_version()['version']}",
        "case": case_text(Case(branch.system, {})),
    }
    return xarray.Dataset(data, coordinates, attributes)


def _words(meaning: str) -> dict[str, str]:
    return {"long_name": meaning, "units": "1"}
