"""Results as labelled arrays (xarray) and as tables (pandas), from which the analysis of others continues."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import require
from vibrocap.identification.result.fit_result import Fit
from vibrocap.io.motion_file import case_of, columns, motion_dataset
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.attractors.basins import Basins
from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.equilibria.equilibrium_branch import EquilibriumBranch
from vibrocap.quantities.declared import Shown
from vibrocap.quantities.dimensional import computed

if TYPE_CHECKING:
    import pandas
    import xarray

PARAMETER = ("value", "low", "high", "standard_error", "unit", "verdict", "meaning")


def to_xarray(result: Shown) -> "xarray.Dataset":
    """A result as a dataset of labelled arrays.

    A motion along "time", its uniform grid, and "event", with its case and, if it has been asked for before, its
    certificate among the attributes; a branch along "point" and "special"; basins and bifurcation
    diagrams by their axes; an orbit as the motion over its period.

    Raises TypeError for anything else, and ModuleNotFoundError, which says how to install it, without xarray.
    """
    require("to_xarray", "xarray")
    from vibrocap.studies.orbit_datasets import basin_dataset, bifurcation_dataset, branch_dataset

    if isinstance(result, (Trajectory, Orbit)):
        return _motion_dataset(result if isinstance(result, Trajectory) else result.motion())
    ways = {Branch: branch_dataset, Basins: basin_dataset, BifurcationDiagram: bifurcation_dataset}
    for kind, way in ways.items():
        if isinstance(result, kind):
            return way(result)
    raise TypeError(f"result should be a motion, an orbit, a branch, basins or a diagram, got {_kind(result)}")


def to_pandas(result: Shown) -> "pandas.DataFrame":
    """A result as a table: a motion with a row for each time of its grid, a branch with a row for each point.

    Of a fit the parameters, of a diagram of branches its special points, of events, phases, equilibria, the designs of
    a front and samples a row for each; of a branch of equilibria a row for each point.

    Raises TypeError for anything else, and ModuleNotFoundError, which says how to install it, without pandas.
    """
    require("to_pandas", "pandas")
    import pandas

    if isinstance(result, (Trajectory, Orbit)):
        table = columns(result if isinstance(result, Trajectory) else result.motion())
        return pandas.DataFrame(table).set_index("time")
    if isinstance(result, Branch):
        return _branch_table(result)
    if isinstance(result, Fit):
        rows = {p.name: {name: _plain(getattr(p, name)) for name in PARAMETER} for p in result.parameters}
        return pandas.DataFrame.from_dict(rows, orient="index", columns=list(PARAMETER)).rename_axis("parameter")
    if isinstance(result, EquilibriumBranch):
        table = {result.over: result.parameter, "stable": result.stable, "unstable": result.unstable}
        states = dict(zip(result.system.state_names, result.states.T, strict=True))
        return pandas.DataFrame(table | {"largest_real_part": np.real(result.eigenvalues)[:, 0]} | states).rename_axis(
            "point"
        )
    if callable(table := getattr(result, "table", None)):
        return pandas.DataFrame(table())
    raise TypeError(
        f"result should be a motion, an orbit, a branch or another result with a table, got {_kind(result)}"
    )


def _motion_dataset(motion: Trajectory) -> "xarray.Dataset":
    from vibrocap.quantities.json_text import json_text

    certificate = vars(computed(motion)).get("certificate")  # what was not asked for costs a run
    text = None if certificate is None else json_text(certificate)
    return motion_dataset(motion, case_of(motion), text)


def _branch_table(branch: Branch) -> "pandas.DataFrame":
    import pandas

    states = dict(zip(branch.system.state_names, branch.states.T, strict=True))
    largest = np.max(np.abs(branch.multipliers), axis=1, initial=0.0)
    names = ("period", "drift", "mean_velocity", "stable", "mode_sequence", "arclength")
    found = {branch.over: branch.parameter, **{name: getattr(branch, name) for name in names}}
    return pandas.DataFrame(found | {"largest_multiplier": largest} | states).rename_axis("point")


def _plain(value: Any) -> Any:
    return str(value) if isinstance(value, str) else value


def _kind(result: Any) -> str:
    return f"a {type(result).__name__}"
