"""plot(result) and figure(result): one way to a picture of anything, a single panel or the whole sheet."""

import base64
import dataclasses
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.calibration import Calibration
from vibrocap.design.calibration.motion_fit import MotionFit
from vibrocap.design.front import ParetoFront
from vibrocap.identification.experiments.comparison import Comparison, Match
from vibrocap.identification.fit_result import Fit
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
from vibrocap.plotting import laboratory
from vibrocap.plotting.designs import calibration_figure, draw_calibration, draw_front, front_figure, motion_fit_figure
from vibrocap.plotting.fits import comparison_figure, draw_forces, fit_figure, match_figure
from vibrocap.plotting.histories import draw_history, draw_load
from vibrocap.plotting.intervals import draw_intervals
from vibrocap.plotting.look.finishing import finished, fitted, save
from vibrocap.plotting.look.page import on_page
from vibrocap.plotting.look.style import STYLE, style
from vibrocap.plotting.look.style import figure as empty_figure
from vibrocap.plotting.motion import draw_friction_loop, draw_phase_plane, motion_figure
from vibrocap.plotting.steady.basins import basin_figure, draw_basins
from vibrocap.plotting.steady.branches import QUANTITIES, branch_figure, draw_branch, draw_floquet_multipliers
from vibrocap.plotting.steady.diagrams import bifurcation_figure, draw_bifurcation, draw_equilibria, equilibrium_figure
from vibrocap.plotting.stick_slip import regime_figure, stick_slip_figure
from vibrocap.plotting.studies.maps import PRINT, draw_study, study_figure
from vibrocap.plotting.studies.view import study_view
from vibrocap.records.stick_slip import RegimeDiagram, StickSlip

SMALL = (3.6, 1.9)  # inches, in a notebook
SMALL_DPI = 90


def plot(result: Any, what: str | None = None, *, ax: Axes | None = None, **options: Any) -> Axes:
    """Draw one panel of a result and return its axes; `figure` draws the whole sheet.

    result, and what can be drawn of it (the first by default):
        a motion or an orbit: "position", any other name of `motion.names`, "phase plane", "friction loop", "load"
        a dataset of a study: the name of a measure
        a branch or a diagram of branches: "mean_velocity", "drift", "period", "multipliers"
        a branch of equilibria: the name of a state, "eigenvalues"
        a fit: "intervals", or the name of a record; a calibration: the name of a measure, "intervals"
        basins: "direction", "attractor"
        a friction law: "steady", "presliding"
    ax: axes to draw into, by default those of a new figure (`.figure` of what is returned, and a notebook shows it;
        pyplot is not asked)
    options: of the function that draws the panel: `draw_history`, `draw_phase_plane`, `draw_friction_loop`,
        `draw_load`, `draw_study`, `draw_branch`, `draw_floquet_multipliers`, `draw_intervals`, `draw_forces`,
        `draw_basins`, `draw_steady_curve`, `draw_presliding`, `draw_equilibria`, `draw_bifurcation`, `draw_front`,
        `draw_calibration`

    The style of the package holds for this drawing only. Raises TypeError for a result that cannot be drawn.
    """
    drawn, picture = _picture_of(result)
    if picture is None or not (picture.panel or picture.panels):
        raise TypeError(
            "result should be a motion, an orbit, a branch, a fit, basins, a friction law or a dataset of a study, "
            f"got a {type(result).__name__}"
        )
    what = picture.first if what is None else what
    if what is not None and what in picture.panels:
        return picture.panels[what](drawn, ax=ax, **options)
    known = None if picture.names is None else (*picture.names(drawn), *picture.panels)
    if what is not None and known is not None and what not in known:
        near = suggestion(what, known, there_is="should be one of")
        raise ArgumentError("what", f"{what!r} cannot be drawn of it; {near}")
    assert picture.panel is not None
    return picture.panel(drawn, *(() if what is None else (what,)), ax=ax, **options)


def figure(
    result: Any,
    path: str | Path | None = None,
    *,
    width: str | float | None = None,
    header: bool = True,
    **options: Any,
) -> Figure:
    """The whole sheet of a result, all its panels, as the command line draws it.

    result: a motion, an orbit, a branch or several, a branch of equilibria, a fit, a calibration, a comparison, a
        match, basins, a bifurcation diagram, a Pareto front, a friction law, a sheet of its tests, a report on
        smoothing, a stick-slip record, a regime diagram, a dataset of a study
    path: a file to write it to as well (.png, .svg or .pdf)
    width: "column" (3.4 inches), "page" (7 inches) or a number of inches: letters, labels and legends suit that width,
        and the panels of a motion stand one below the other where they have no room side by side; by default what suits
        a screen
    header: whether the parameters stand above the panels, and small print below; False for a figure with a caption
    options: of the figure, such as `multipliers=True` of a branch, `load=2.0` of a law, `measure="drift"` of a study

    Settings of `matplotlib.rcParams` that the user has changed, by hand or by a style sheet, hold over the package's.
    """
    with on_page(width, header):
        return sheet(result, path, **options)


def sheet(result: Any, path: str | Path | None = None, **options: Any) -> Figure:
    """As `figure`, for the page that is set."""
    drawn, picture = _picture_of(result)
    if picture is None:
        raise TypeError(f"result should be a result of this package, got a {type(result).__name__}")
    fig = picture.sheet(drawn, **options)
    if path is None:
        return finished(fig)
    save(fig, path, picture.style)
    return fig


@dataclasses.dataclass(frozen=True)
class Picture:
    """How results of a type are drawn.

    sheet: all panels; style: in which a file of it is written
    panel: draws what is named; names: what can be, None for anything; panels: further ones by name; first: that of
        them which is drawn where nothing is named, by default what `panel` draws
    content: what has to be there for a small picture; small: what that shows
    """

    sheet: Callable[..., Figure]
    panel: Callable[..., Axes] | None = None
    names: Callable[[Any], Iterable[str]] | None = None
    panels: Mapping[str, Callable[..., Axes]] = dataclasses.field(default_factory=dict)
    first: str | None = None
    content: Callable[[Any], Sequence[Any]] = lambda result: (result,)
    small: Callable[[Any], str | None] = lambda result: None
    style: dict[Any, Any] = dataclasses.field(default_factory=lambda: STYLE)


def _itself(result: Any) -> Any:
    return result


BRANCHES = branch_figure, draw_branch, lambda branch: QUANTITIES, {"multipliers": draw_floquet_multipliers}
LAW_PANELS = {"steady": laboratory.draw_steady_curve, "presliding": laboratory.draw_presliding}
PICTURES: dict[type, Picture] = {
    Trajectory: Picture(
        motion_figure,
        draw_history,
        panels={"phase plane": draw_phase_plane, "friction loop": draw_friction_loop, "load": draw_load},
        content=lambda motion: motion.piece_start,
    ),
    Branch: Picture(*BRANCHES, content=_itself),
    BranchDiagram: Picture(*BRANCHES),
    EquilibriumBranch: Picture(
        equilibrium_figure, draw_equilibria, lambda branch: (*branch.system.state_names, "eigenvalues")
    ),
    Fit: Picture(
        fit_figure,
        draw_forces,
        panels={"intervals": draw_intervals},
        first="intervals",
        content=lambda fit: fit.records,
        small=lambda fit: fit.records[0].name,
    ),
    MotionFit: Picture(motion_fit_figure),
    Calibration: Picture(
        calibration_figure, draw_calibration, lambda of: of.measured.measures, {"intervals": draw_intervals}
    ),
    Comparison: Picture(comparison_figure),
    Match: Picture(match_figure),
    Basins: Picture(basin_figure, draw_basins, style=PRINT),
    BifurcationDiagram: Picture(bifurcation_figure, draw_bifurcation, lambda diagram: diagram.system.state_names),
    ParetoFront: Picture(front_figure, draw_front, lambda front: (), content=_itself),
    Law: Picture(laboratory.law_figure, None, lambda law: (), LAW_PANELS, first="steady"),
    TestSheet: Picture(laboratory.sheet_figure),
    Regularisation: Picture(laboratory.regularisation_figure),
    StickSlip: Picture(stick_slip_figure),
    RegimeDiagram: Picture(regime_figure),
}
STUDY = Picture(lambda data, border=None, **of: study_figure(study_view(data, **of), border), draw_study, style=PRINT)


def _picture_of(result: Any) -> tuple[Any, Picture | None]:
    """(what is drawn of a result, how); None where it cannot be drawn. An orbit is drawn as its motion."""
    drawn: Any = result.motion() if isinstance(result, Orbit) else result
    known = next((PICTURES[kind] for kind in type(drawn).__mro__ if kind in PICTURES), None)
    # a dataset of a study, without importing xarray, which whoever has one has imported
    is_study = known is None and hasattr(drawn, "data_vars") and "status" in drawn.data_vars
    return drawn, STUDY if is_study else known


def thumbnail(result: Any) -> str:
    """A small picture of a result for a page, as HTML that holds it; empty where there is nothing to draw."""
    if isinstance(result, Orbit) and result.failed:
        return ""
    drawn, picture = _picture_of(result)
    if picture is None or not (picture.panel or picture.panels) or not len(picture.content(drawn)):
        return ""
    fig, axes = empty_figure(size=SMALL)
    ax = plot(drawn, picture.small(drawn), ax=axes[0, 0])
    ax.set_title("", loc="left")
    if legend := ax.get_legend():
        legend.remove()
    file = io.BytesIO()
    with style():
        fitted(fig).savefig(file, format="png", dpi=SMALL_DPI)
    shown = base64.b64encode(file.getvalue()).decode("ascii")
    return f'<img alt="{type(result).__name__}" src="data:image/png;base64,{shown}">'
