"""plot(result) and figure(result): one way to a picture of anything, a single panel or the whole sheet."""

import base64
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.front import ParetoFront
from vibrocap.identification.experiments.comparison import Comparison
from vibrocap.identification.experiments.match import Match
from vibrocap.identification.result.fit_result import Fit
from vibrocap.laboratory.regularisation import Regularisation
from vibrocap.laboratory.test_sheet import TestSheet
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.attractors.basins import Basins
from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram
from vibrocap.orbits.equilibria.equilibrium_branch import EquilibriumBranch
from vibrocap.physics.friction.law import Law
from vibrocap.plotting.fits import comparison_figure, draw_forces, draw_intervals, fit_figure, match_figure
from vibrocap.plotting.fronts import draw_front, front_figure
from vibrocap.plotting.histories import draw_history, draw_load
from vibrocap.plotting.laboratory import (
    draw_presliding,
    draw_steady_curve,
    law_figure,
    regularisation_figure,
    sheet_figure,
)
from vibrocap.plotting.look.finishing import finished, save
from vibrocap.plotting.look.page import on_page
from vibrocap.plotting.look.style import STYLE
from vibrocap.plotting.look.style import figure as empty_figure
from vibrocap.plotting.motion import draw_friction_loop, draw_phase_plane, motion_figure
from vibrocap.plotting.steady.basins import basin_figure, draw_basins
from vibrocap.plotting.steady.branches import QUANTITIES, branch_figure, draw_branch, draw_floquet_multipliers
from vibrocap.plotting.steady.diagrams import bifurcation_figure, draw_bifurcation
from vibrocap.plotting.steady.equilibria import draw_equilibria, equilibrium_figure
from vibrocap.plotting.stick_slip import regime_figure, stick_slip_figure
from vibrocap.plotting.studies.maps import PRINT, draw_study, study_figure
from vibrocap.plotting.studies.view import study_view
from vibrocap.records.regime_diagram import RegimeDiagram
from vibrocap.records.stick_slip import StickSlip

SMALL = (3.6, 1.9)  # inches, in a notebook
SMALL_DPI = 90


def plot(result: Any, what: str | None = None, *, ax: Axes | None = None, **options: Any) -> Axes:
    """Draw one panel of a result and return its axes; `figure` draws the whole sheet.

    result, and what can be drawn of it (the first by default):
        a motion or an orbit: "position", any other name of `motion.names`, "phase plane", "friction loop", "load"
        a dataset of a study: the name of a measure
        a branch or a diagram of branches: "mean_velocity", "drift", "period", "multipliers"
        a branch of equilibria: the name of a state, "eigenvalues"
        a fit: "intervals", or the name of a record
        basins: "direction", "attractor"
        a friction law: "steady", "presliding"
    ax: axes to draw into, by default those of a new figure (`.figure` of what is returned, and a notebook shows it;
        pyplot is not asked)
    options: of the function that draws the panel: `draw_history`, `draw_phase_plane`, `draw_friction_loop`,
        `draw_load`, `draw_study`, `draw_branch`, `draw_floquet_multipliers`, `draw_intervals`, `draw_forces`,
        `draw_basins`, `draw_steady_curve`, `draw_presliding`, `draw_equilibria`, `draw_bifurcation`, `draw_front`

    The style of the package holds for what is drawn here and nowhere else. Raises TypeError for what cannot be drawn.
    """
    if isinstance(result, Orbit):
        result = result.motion()
    if isinstance(result, Trajectory):
        panels: dict[str, Callable[..., Axes]] = {
            "phase plane": draw_phase_plane,
            "friction loop": draw_friction_loop,
            "load": draw_load,
        }
        if what in panels:
            return panels[what](result, ax=ax, **options)
        return draw_history(result, what or "position", ax=ax, **options)
    if isinstance(result, (Branch, BranchDiagram)):
        if what == "multipliers":
            return draw_floquet_multipliers(result, ax=ax, **options)
        _check(what, (*QUANTITIES, "multipliers"))
        return draw_branch(result, what, ax=ax, **options)
    if isinstance(result, EquilibriumBranch):
        _check(what, (*result.system.state_names, "eigenvalues"))
        return draw_equilibria(result, what, ax=ax, **options)
    if isinstance(result, Fit):
        if what in (None, "intervals"):
            return draw_intervals(result, ax=ax, **options)
        return draw_forces(result, what, ax=ax, **options)
    if isinstance(result, Basins):
        return draw_basins(result, what or "direction", ax=ax, **options)
    if isinstance(result, BifurcationDiagram):
        _check(what, result.system.state_names)
        return draw_bifurcation(result, what, ax=ax, **options)
    if isinstance(result, ParetoFront):
        return draw_front(result, ax=ax, **options)
    if isinstance(result, Law):
        _check(what, ("steady", "presliding"))
        return (draw_presliding if what == "presliding" else draw_steady_curve)(result, ax=ax, **options)
    if _is_dataset(result):
        return draw_study(result, what, ax=ax, **options)
    raise TypeError(
        "result should be a motion, an orbit, a branch, a fit, basins, a friction law or a dataset of a study, "
        f"got a {type(result).__name__}"
    )


def figure(
    result: Any,
    path: str | Path | None = None,
    *,
    width: str | float | None = None,
    header: bool = True,
    **options: Any,
) -> Figure:
    """The whole sheet of a result, all its panels, as the command line draws it.

    result: a motion, an orbit, a branch or several, a branch of equilibria, a fit, a comparison, a match, basins, a
        bifurcation diagram, a Pareto front, a friction law, a sheet of its tests, a report on
        smoothing, a stick-slip record, a regime diagram, a dataset of a study
    path: a file to write it to as well (.png, .svg or .pdf)
    width: "column" (3.4 inches), "page" (7 inches) or a number of inches: letters, labels and legends suit that width,
        and the panels of a motion stand one below the other where they have no room side by side; by default what suits
        a screen
    header: whether the parameters stand above the panels, and small print below; False for a figure with a caption
    options: of the figure, such as `multipliers=True` of a branch, `load=2.0` of a law, `measure="drift"` of a study

    Settings of `matplotlib.rcParams` that the user has changed, by hand or by a style sheet, hold over the package's.
    """
    if isinstance(result, Orbit):
        result = result.motion()
    with on_page(width, header):
        fig, settings = _sheet(result, options)
        if path is None:
            return finished(fig)
        save(fig, path, settings)
    return fig


def _sheet(result: Any, options: dict[str, Any]) -> tuple[Figure, dict[Any, Any]]:
    """The sheet of a result on the present page, and the style in which it is written."""
    for kind, draw in FIGURES.items():
        if isinstance(result, kind):
            return draw(result, **options), PRINT if kind is Basins else STYLE
    if not _is_dataset(result):
        raise TypeError(f"result should be a result of this package, got a {type(result).__name__}")
    border = options.pop("border", None)
    return study_figure(study_view(result, **options), border), PRINT


FIGURES: dict[type, Callable[..., Figure]] = {
    Trajectory: motion_figure,
    Branch: branch_figure,
    BranchDiagram: branch_figure,
    EquilibriumBranch: equilibrium_figure,
    Fit: fit_figure,
    Comparison: comparison_figure,
    Match: match_figure,
    Basins: basin_figure,
    BifurcationDiagram: bifurcation_figure,
    ParetoFront: front_figure,
    Law: law_figure,
    TestSheet: sheet_figure,
    Regularisation: regularisation_figure,
    StickSlip: stick_slip_figure,
    RegimeDiagram: regime_figure,
}


PLOTTED = (
    Orbit,
    Trajectory,
    Branch,
    BranchDiagram,
    EquilibriumBranch,
    Fit,
    Basins,
    BifurcationDiagram,
    ParetoFront,
    Law,
)


def thumbnail(result: Any) -> str:
    """A small picture of a result for a page, as HTML that holds it; empty where there is nothing to draw."""
    if isinstance(result, Trajectory) and not len(result.piece_start):
        return ""
    if not isinstance(result, PLOTTED) or (isinstance(result, Orbit) and result.failed):
        return ""
    if (isinstance(result, (Branch, ParetoFront)) and not len(result)) or (
        isinstance(result, Fit) and not result.records
    ):
        return ""
    fig, axes = empty_figure(size=SMALL)
    ax = plot(result, result.records[0].name if isinstance(result, Fit) else None, ax=axes[0, 0])
    ax.set_title("")
    if legend := ax.get_legend():
        legend.remove()
    file = io.BytesIO()
    fig.savefig(file, format="png", dpi=SMALL_DPI)
    picture = base64.b64encode(file.getvalue()).decode("ascii")
    return f'<img alt="{type(result).__name__}" src="data:image/png;base64,{picture}">'


def _check(what: str | None, known: tuple[str, ...]) -> None:
    if what is not None and what not in known:
        near = suggestion(what, known, there_is="should be one of")
        raise ArgumentError("what", f"{what!r} cannot be drawn of it; {near}")


def _is_dataset(result: Any) -> bool:
    """Whether a result is a dataset of a study (without importing xarray, which whoever has one has imported)."""
    return hasattr(result, "data_vars") and "status" in result.data_vars
