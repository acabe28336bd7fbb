"""Pictures of studies that are no maps: lines over one axis, dots for runs that do not lie on a grid."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILION, logarithmic
from vibrocap.plotting.studies.cells import Cell, cell_labels, cells, spread, unsettled, unsettled_label
from vibrocap.plotting.studies.view import Panel, View, value_label

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, SKY, BLACK)
DOT = 2.2
MARKS: dict[Cell, str] = {
    Cell.NO_TRAVEL: "s",
    Cell.INFINITE: "^",
    Cell.NO_VALUE: "|",
    Cell.FAILED: "x",
    Cell.NOT_RUN: "_",
    Cell.NOT_SETTLED: "d",
}
INKS: dict[Cell, str] = dict.fromkeys(MARKS, GREY) | {Cell.FAILED: "#C2187A"}


def draw_lines(ax: Axes, view: View) -> list[Any]:
    """A line for each panel over one axis, with a mark for every run; returns the handles of the legend.

    Filled marks have settled, open ones have not; runs without a value stand as marks of their own at the foot.
    """
    axis = view.axes[0]
    order = np.argsort(view.points[0], kind="stable") if view.points else slice(None)
    heights, ticks = _heights(view)
    handles: list[Any] = []
    for panel, height, colour in zip(view.panels, heights, COLOURS, strict=False):
        x = view.points[0] if view.points else axis.values
        kinds, waiting = cells(view, panel), unsettled(view, panel)
        shown = (kinds == Cell.VALUE) | (kinds == Cell.NO_TRAVEL)
        joined = np.where(shown, height, np.nan)[order]
        style = "none" if view.points or ticks else "-"
        ax.plot(x[order], joined, linestyle=style, color=colour, linewidth=0.9, label=panel.title or "values")
        for where, face, name in ((shown & ~waiting, colour, "settled"), (shown & waiting, "white", "not settled")):
            ax.plot(
                x[where], height[where], "o", color=colour, markersize=DOT, markerfacecolor=face, markeredgewidth=0.6,
                label=f"{panel.title} {name}".strip(),
            )  # fmt: skip
        for cell, mark in MARKS.items():
            if cell is not Cell.NO_TRAVEL and (kinds == cell).any():
                at = x[kinds == cell]
                ax.plot(
                    at, np.full(len(at), 0.03), mark, color=colour, markersize=4, markeredgewidth=0.8,
                    transform=ax.get_xaxis_transform(), clip_on=False, label=cell.name.lower(),
                )  # fmt: skip
        if panel.title:
            handles.append(Line2D([], [], color=colour, linewidth=0.9, marker="o", markersize=DOT, label=panel.title))
    labels = cell_labels(view)
    grey: dict[str, Any] = {"linestyle": "none", "color": "#444444"}
    handles += [Line2D([], [], marker=MARKS[x], label=labels[x], **grey) for x in labels if x is not Cell.NO_TRAVEL]
    if text := unsettled_label(view):
        handles.append(Line2D([], [], marker="o", markersize=3, markerfacecolor="white", label=text, **grey))
    if words := labels.get(Cell.NO_TRAVEL):
        band = ax.axhspan(-view.dead_band, view.dead_band, color=GREY, linewidth=0.8, zorder=0)
        band.set_label(words)
        handles.append(band)
    elif view.kind == "signed":
        ax.axhline(0.0, color=GREY, linewidth=0.6, zorder=0)
    if ticks:
        ax.set_yticks(range(len(ticks)), ticks)
        ax.set_ylim(-0.6, len(ticks) - 0.4)
    else:
        ax.margins(y=0.12)
        if view.kind == "plain" and spread(np.concatenate([panel.values.ravel() for panel in view.panels])):
            logarithmic(ax, "y")
    ax.set(xlabel=axis.label, ylabel=view.label)
    ax.grid(color="#E4E4E4", linewidth=0.5)
    if axis.logarithmic:
        logarithmic(ax, "x")
    elif axis.path in ("case", "run"):  # numbers of runs, between two of which there is none
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    return handles


def _heights(view: View) -> tuple[list[np.ndarray], list[str]]:
    """What stands upright for each panel, and the words of the ticks of a discrete measure."""
    if view.kind != "discrete":
        return [panel.values for panel in view.panels], []
    shown = [panel.values[cells(view, panel) == Cell.VALUE].tolist() for panel in view.panels]
    known = sorted({value for values in shown for value in values}, key=lambda x: (isinstance(x, str) and len(x), x))
    places = {value: float(place) for place, value in enumerate(known)}
    rows = ([places.get(value, np.nan) for value in panel.values.tolist()] for panel in view.panels)
    heights = [np.array(row, dtype=float) for row in rows]
    return heights, [value_label(view.measure, value) for value in known]


def draw_dots(ax: Axes, view: View, panel: Panel, colours: Any, paint: dict[str, Any]) -> None:
    """Runs of a design as dots: values in colours, all else in marks; a ring around what has not settled."""
    assert view.points is not None
    x, y = view.points
    kinds, waiting = cells(view, panel), unsettled(view, panel)
    size = float(np.clip(4000.0 / len(x), 1.0, 16.0))
    for cell, mark in MARKS.items():
        where = kinds == cell
        look: dict[str, Any] = {"marker": mark, "color": INKS[cell], "linewidths": 0.8 if mark in "x|_" else 0.0}
        ax.scatter(x[where], y[where], s=0.6 * size, label=cell.name.lower(), **look)
    shown = kinds == Cell.VALUE
    rim: dict[str, Any] = {"linewidths": 0.2, "edgecolors": "#888888"}
    ax.scatter(x[shown], y[shown], c=np.asarray(colours)[shown], s=size, label="values", **rim, **paint)
    ring = {"facecolors": "none", "edgecolors": BLACK, "linewidths": 0.5}
    ax.scatter(x[waiting], y[waiting], s=3.0 * size, label="not settled", **ring)


def dot_handles(view: View) -> list[Any]:
    """The legend of runs that are drawn as marks."""
    handles = [
        Line2D([], [], linestyle="none", marker=MARKS[cell], markersize=4, color=INKS[cell], label=text)
        for cell, text in cell_labels(view).items()
    ]
    if text := unsettled_label(view):
        look: dict[str, Any] = {"marker": "o", "markersize": 6, "markerfacecolor": "none", "markeredgewidth": 0.5}
        handles.append(Line2D([], [], linestyle="none", color=BLACK, label=text, **look))
    return handles
