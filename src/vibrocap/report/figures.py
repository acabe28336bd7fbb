"""The paper's figures, drawn with LM red and solid, EM blue and dashed, as in the paper; and what came after it."""

import types
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.files import write_table
from vibrocap.motion.status import Status
from vibrocap.paper.figures.figure import Curve, Figure, Mark, Panel
from vibrocap.paper.travel import PERIODS, SteadyPanel, SteadyTravel
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.look.labels import LABELS as QUANTITIES
from vibrocap.plotting.look.style import BLACK, GREEN
from vibrocap.plotting.steady.branches import branch_figure
from vibrocap.plotting.studies.maps import plot_view
from vibrocap.plotting.studies.view import Panel as StudyPanel
from vibrocap.plotting.studies.view import View, ViewAxis

WIDTH, HEIGHT = 4.1, 2.9  # inches per panel, for up to two columns
NARROW = 3.3  # for three
WIDE = 8.2, 1.9  # for one
SHARED = 3  # labels at most in a legend above all panels
CROWDED = 4  # curves, from which on the legend is set small

ENDED: dict[str, Any] = {"linestyle": "none", "marker": "x", "markersize": 4.5, "markeredgewidth": 1.1}
LAWS = {"LM": "LM: LuGre law (bristles).", "EM": "EM: exponential law (sticks)."}
LABELS = {
    "angle": r"angle $\theta$",
    "angle_rate": r"angular velocity $\theta'$",
    "position": "capsule position $X$",
    "velocity": "capsule velocity $X'$",
    "contact_velocity": "sliding velocity $X'$",
    "mass_ratio": r"mass ratio $\lambda$",
    "mean_velocity": "average velocity",
    "excess": r"friction $-$ steady friction",
    "phase": r"time in the period $\tau/T$",
}


_ROLES: dict[str, dict[str, Any]] = {
    "LM": plots.LM_STYLE,
    "EM": plots.EM_STYLE,
    "steady": {"color": BLACK, "linestyle": "-", "linewidth": 1.3},
    "limit": {"color": "#888888", "linestyle": ":", "linewidth": 1.0},
    "sliding": {"color": GREEN, "linestyle": "-", "linewidth": 1.6},
    "twin": {"color": GREEN, "linestyle": (0, (3, 1.5, 1, 1.5)), "linewidth": 1.8},
}


def draw(figure: Figure, path: Path) -> Path:
    """Draw a figure into a file; its suffix chooses the format."""
    rows = -(-len(figure.panels) // figure.columns)
    width, height = {1: WIDE, 3: (NARROW, HEIGHT)}.get(figure.columns, (WIDTH, HEIGHT))
    fig, axes = plots.figure(rows, figure.columns, size=(width * figure.columns, height * rows + 0.4))
    for panel, ax in zip(figure.panels, axes.flat, strict=True):
        _panel(ax, panel)
    _legends(fig, axes, figure)
    roles = {curve.role for panel in figure.panels for curve in panel.curves}
    laws = [words for role, words in LAWS.items() if role in roles]
    plots.footnote(fig, " ".join([*laws, plots.DIMENSIONLESS]))
    return save(fig, path)


def _panel(ax: Any, panel: Panel) -> None:
    labels = QUANTITIES | LABELS
    for curve in panel.curves:
        style = _style(curve)
        ax.plot(curve.x, curve.y, label=curve.label, **style)
        for share in curve.arrows:
            _arrow(ax, curve, share, style["color"])
    ax.set_xlabel(labels[panel.x])
    ax.set_ylabel(labels[panel.y])
    ax.set_title(panel.title, loc="left", fontsize=9.5, fontweight="bold")
    for begin, end in panel.spans:
        ax.axvspan(begin, end, **plots.STICK_SHADE)
    if panel.x_limits:
        ax.set_xlim(panel.x_limits)
    if panel.y_limits:
        ax.set_ylim(panel.y_limits)
    if panel.zero:
        ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=1)
    for i, mark in enumerate(panel.marks):
        _mark(ax, mark, i)
    for i, ending in enumerate(panel.endings):  # runs that did not go to their end, above the foot of the axes
        look = {"color": _ROLES[ending.role]["color"], "transform": ax.get_xaxis_transform(), "label": ending.label}
        ax.plot(ending.x, np.full(len(ending.x), 0.03 + 0.05 * i), clip_on=False, **look, **ENDED)


def _legends(fig: Any, axes: Any, figure: Figure) -> None:
    """One legend above all panels, if wanted or of a few labels; else one in each panel whose labels are new."""
    handles = {label: h for ax in axes.flat for h, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    if figure.one_legend or len(handles) <= SHARED:
        columns = 2 if len(handles) == 4 else SHARED
        look = {"ncols": columns, "fontsize": 8.5, "frameon": False}
        fig.legend(handles.values(), handles.keys(), loc="outside upper right", **look)
        return
    shown: set[tuple[str, ...]] = set()
    for panel, ax in zip(figure.panels, axes.flat, strict=True):
        labels = tuple(curve.label for curve in panel.curves)
        if labels not in shown:
            plots.legend(ax, **({"fontsize": 6.5, "ncols": 2} if len(labels) > CROWDED else {"fontsize": 8}))
        shown.add(labels)


def _style(curve: Curve) -> dict[str, Any]:
    style = _ROLES[curve.role]
    return style | {"alpha": 0.3 + 0.7 * curve.weight, "linewidth": style["linewidth"] * (0.6 + 0.4 * curve.weight)}


def _arrow(ax: Any, curve: Curve, share: float, color: str) -> None:
    """An arrowhead on a curve, in its direction; nothing where the curve stands still."""
    start = min(int(share * (curve.x.size - 1)), curve.x.size - 2)
    moved = ((values[start:] - values[start]) / np.ptp(values) for values in (curve.x, curve.y))
    ahead = int(np.argmax(np.hypot(*moved) > 0.004))
    if ahead:
        head, tail = ((curve.x[i], curve.y[i]) for i in (start + ahead, start))
        look = {"arrowstyle": "-|>", "color": color, "linewidth": 0.0, "mutation_scale": 11}
        ax.annotate("", xy=head, xytext=tail, arrowprops=look)


def _mark(ax: Any, mark: Mark, place: int) -> None:
    """A named point, or a named vertical line whose names take turns in height."""
    if mark.y is None:
        ax.axvline(mark.x, color="#777777", linewidth=0.8, linestyle=":")
        beside: dict[str, Any] = {"xytext": (2, -9 - 11 * (place % 2)), "textcoords": "offset points", "fontsize": 8}
        ax.annotate(mark.label, (mark.x, 1.0), xycoords=("data", "axes fraction"), color="#444444", **beside)
        return
    ax.plot([mark.x], [mark.y], marker="o", markersize=5, color="#111111", zorder=5)
    if mark.label:
        ax.annotate(mark.label, (mark.x, mark.y), xytext=(7, 4), textcoords="offset points", fontsize=10)


TITLES = {"LM": "LM (LuGre)", "EM": "EM (exponential)"}


def draw_map(travel: SteadyTravel, path: Path) -> Path:
    """The map into a file: mean velocity over mass ratio and spring, a panel for each load."""
    view = View(
        "mean_velocity",
        "of the settled motion",
        "1",
        "signed",
        (
            ViewAxis("machine.mass_ratio", travel.mass_ratio, r"mass ratio $\lambda$"),
            ViewAxis("machine.stiffness", travel.stiffness, r"spring $\rho$"),
        ),
        tuple(_steady_panel(panel) for panel in travel.panels),
        None,
        "h 1.8, omega 1, nu 1.2, the paper's friction and start",
        f"each run until it has settled, at most {PERIODS} periods",
    )
    return plot_view(view, path)


def _steady_panel(panel: SteadyPanel) -> StudyPanel:
    load = "N = 1, as printed" if panel.load == 1.0 else "dynamic load"
    least = types.SimpleNamespace(values=panel.least_load)
    title, band = f"{TITLES[panel.friction]}, {load}", np.full(panel.status.shape, panel.residue)
    numbers = panel.mean_velocity, panel.status, panel.settled, band
    return StudyPanel(title, *numbers, {"least_reaction": least})


def draw_branches(travel: SteadyTravel, path: Path) -> Path:
    """The diagram of branches into a file."""
    return save(branch_figure(travel.branches, "drift"), path)


def write_map(travel: SteadyTravel, path: Path) -> None:
    """The runs of the map: a row for each, full precision."""
    statuses = list(Status)
    head = ("friction", "normal_load", "mass_ratio", "stiffness", "mean_velocity", "least_load", "settled", "status")
    rows = []
    for panel in travel.panels:
        for i, j in np.ndindex(panel.status.shape):
            numbers = travel.mass_ratio[i], travel.stiffness[j], panel.mean_velocity[i, j], panel.least_load[i, j]
            how = bool(panel.settled[i, j]), statuses[int(panel.status[i, j])].value
            rows.append((panel.friction, panel.load, *map(float, numbers), *how))
    write_table(path, head, rows)


def write_branches(travel: SteadyTravel, path: Path) -> None:
    """The points of the branches: a row for each, full precision."""
    rows = (
        (number, float(place), float(drift), bool(stable))
        for number, branch in enumerate(travel.branches.branches)
        for place, drift, stable in zip(branch.parameter, branch.drift, branch.stable, strict=True)
    )
    write_table(path, ("branch", "stiffness", "drift", "stable"), rows)
