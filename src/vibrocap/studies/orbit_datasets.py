"""Basins and bifurcation diagrams as labelled datasets, which say of themselves what they hold."""

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
