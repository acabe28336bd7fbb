"""Branches, basins and bifurcation diagrams as labelled datasets, which say of themselves what they hold."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import Case, case_text
from vibrocap.orbits.attractors.basins import PHASE
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Shown
from vibrocap.quantities.dimensional import computed
from vibrocap.studies.plan.code_version import code_version
from vibrocap.studies.variables import coordinate_attributes, state_attributes

if TYPE_CHECKING:
    import xarray

PHASE_ATTRIBUTES = {"long_name": "phase of the drive at the start, as a share of its period", "symbol": "t_0/T"}
LABELS = {"not_certified": -5, "not_told_apart": -4, "failed": -3, "not_settled": -2}


def basin_dataset(basins: Shown) -> "xarray.Dataset":
    """The arrays of basins over both axes, with the attractors along the dimension "attractor"."""
    import xarray

    paths = [name if name == PHASE else f"initial.{name}" for name in basins.axes]
    length = {"units": basins.unit_of("drift")}
    axes = [{"units": basins.unit_of(name)} for name in ("x", "y")]
    coordinates: dict[str, Any] = {
        path: (path, values, PHASE_ATTRIBUTES if path == PHASE else coordinate_attributes(path) | units)
        for path, values, units in zip(paths, (basins.x, basins.y), axes, strict=True)
    }
    motions = [each.motion for each in basins.attractors]
    of_each = {
        "attractor_kind": ([motion.kind for motion in motions], "class of the attractor"),
        "attractor_drift": ([_number(motion.drift) for motion in motions], "its drift per drive period"),
        **{
            f"attractor_winding_{name}": ([motion.winding[name] for motion in motions], "its turns per drive period")
            for name in basins.system.turns
        },
        "attractor_share": ([each.share for each in basins.attractors], "share of the starts that lead to it"),
        "attractor_twin": (
            [-1 if each.twin is None else each.twin for each in basins.attractors],
            "index of its mirror twin, -1: none seen",
        ),
    }
    data: dict[str, Any] = {
        "direction": (
            paths,
            basins.direction,
            _flags("direction of travel in the end", {**LABELS, "back": -1, "no_travel": 0, "forward": 1}),
        ),
        "label": (paths, basins.label.astype(np.int16), _flags("index of the attractor", LABELS)),
        "drift": (
            paths,
            basins.drift,
            {"long_name": "drift in the end, per drive period"} | length,
        ),
    }
    data |= {
        name: ("attractor", np.array(column, dtype=str if name.endswith("kind") else None), {"long_name": meaning})
        for name, (column, meaning) in of_each.items()
    }
    if basins.si_context() is not None:
        data["attractor_drift"][2].update(length)
    attributes = {"title": "Basins of direction", "settle_periods": basins.settle_periods}
    if PHASE not in basins.axes:
        attributes["phase"] = basins.phase
    return xarray.Dataset(data, coordinates, attributes | _source(basins.system, dict(computed(basins).initial)))


def bifurcation_dataset(diagram: Shown) -> "xarray.Dataset":
    """The arrays of a bifurcation diagram: states [direction, start, parameter, mark], drift and response period."""
    import xarray

    dims = ("direction", "start", diagram.over)
    data: dict[str, Any] = {
        name: ((*dims, "mark"), diagram.states[..., i], state_attributes(name, diagram))
        for i, name in enumerate(diagram.state_names)
    }
    data["drift"] = (dims, diagram.drift, {"long_name": "drift per drive period", "units": diagram.unit_of("drift")})
    data["response_period"] = (
        dims,
        diagram.response_period.astype(np.int16),
        _flags("drive periods after which the motion repeats", {"not_certified": -2, "failed": -1, "not_settled": 0}),
    )
    coordinates: dict[str, Any] = {
        "direction": ("direction", np.array(diagram.directions, dtype=str)),
        diagram.over: (diagram.over, diagram.values, coordinate_attributes(diagram.over, diagram.system)),
    }
    return xarray.Dataset(data, coordinates, {"title": "Bifurcation diagram"} | _source(diagram.system, {}))


def _source(system: System, initial: dict[str, float]) -> dict[str, str]:
    """Where a dataset comes from: the version of the code and the case."""
    return {"source": f"vibrocap {code_version()['version']}", "case": case_text(Case(system, initial))}


def _flags(meaning: str, flags: dict[str, int]) -> dict[str, Any]:
    return {"long_name": meaning, "flag_values": list(flags.values()), "flag_meanings": " ".join(flags)}


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


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
