"""Results as labelled arrays (xarray) and as tables (pandas), from which the analysis of others continues."""

from typing import TYPE_CHECKING

from vibrocap.arguments import require
from vibrocap.io.motion_file import case_of, columns, motion_dataset
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.quantities.declared import Shown
from vibrocap.quantities.dimensional import computed
from vibrocap.quantities.json_text import json_text
from vibrocap.results import Result

if TYPE_CHECKING:
    import pandas
    import xarray


def to_xarray(result: Shown) -> "xarray.Dataset":
    """A result as a dataset of labelled arrays.

    A motion along "time", its uniform grid, and "event", with its case and, if already computed, its certificate among
    the attributes; a branch along "point" and "special"; basins and bifurcation
    diagrams by their axes; an orbit as the motion over its period.

    Raises TypeError for anything else, and ModuleNotFoundError, which says how to install it, without xarray.
    """
    require("to_xarray", "xarray")
    from vibrocap.studies.dataset import labelled_arrays, labelled_result

    if isinstance(result, (Trajectory, Orbit)):
        motion = result if isinstance(result, Trajectory) else result.motion()
        certificate = vars(computed(motion)).get("certificate")  # what was not asked for costs a run
        return motion_dataset(motion, case_of(motion), None if certificate is None else json_text(certificate))
    if not isinstance(result, Result) or not labelled_arrays(result)[0]:
        known = "a motion, an orbit, a branch, basins or a diagram"
        raise TypeError(f"result should be {known}, got a {type(result).__name__}")
    return labelled_result(result)


def to_pandas(result: Shown) -> "pandas.DataFrame":
    """A result as a table: a motion with a row for each time of its grid, a branch with a row for each point.

    Of a fit the parameters, of a diagram of branches its special points, of events, phases, equilibria, the designs of
    a front and samples a row for each; of a branch of equilibria a row for each point.

    Raises TypeError for anything else, and ModuleNotFoundError, which says how to install it, without pandas.
    """
    require("to_pandas", "pandas")
    import pandas

    from vibrocap.studies.dataset import labelled_arrays

    if isinstance(result, (Trajectory, Orbit)):
        table = columns(result if isinstance(result, Trajectory) else result.motion())
        return pandas.DataFrame(table).set_index("time")
    data, coordinates = labelled_arrays(result) if isinstance(result, Result) else ({}, {})
    if points := {name: x for name, (dims, x, _) in (coordinates | data).items() if dims == ("point",)}:
        return pandas.DataFrame(points).rename_axis("point")
    if callable(table := getattr(result, "table", None)):
        rows = pandas.DataFrame(table())
        return rows.set_index("name") if isinstance(result, Result) and "name" in rows else rows
    known = "a motion, an orbit, a branch or another result with a table"
    raise TypeError(f"result should be {known}, got a {type(result).__name__}")
