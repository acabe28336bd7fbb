"""Pictures of studies: maps over two axes, lines over one, dots for runs that do not lie on a grid.

What a run is drawn as never depends on colour alone: failed, unsettled and missing runs are hatched, and the legend
says how many there are. Figures are as wide as a column of print, or a page where there are several panels.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path as Outline

from vibrocap.arguments import ArgumentError, Refusal
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.look.labels import filled
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILION, VIOLET, YELLOW
from vibrocap.plotting.studies import cells as runs
from vibrocap.plotting.studies.cells import dot_handles, draw_dots, draw_lines
from vibrocap.plotting.studies.view import BAND, Panel, View, study_view, travel_of

OTHERS = "#D9D9D9"
# Colours of words and of whole numbers: Okabe and Ito's; their purple stands for failed runs, grey for the others.
DISTINCT = (BLUE, ORANGE, GREEN, SKY, VERMILION, YELLOW, VIOLET)
DIVERGING, SEQUENTIAL = "RdBu_r", "viridis"
# (face, hatch, colour of the hatch) of runs without a value; none of the faces occurs in the scales above
CELL_STYLES: dict[runs.Cell, tuple[str, str, str]] = {
    runs.Cell.NO_TRAVEL: (GREY, "", BLACK),
    runs.Cell.INFINITE: (GREY, "", BLACK),
    runs.Cell.NO_VALUE: ("#FFFFFF", "....", "#777777"),
    runs.Cell.NOT_SETTLED: ("#FFFFFF", "", BLACK),  # hatched with all that did not settle
    runs.Cell.FAILED: ("#E78AC3", "xxxxx", BLACK),
    runs.Cell.NOT_RUN: ("#FFFFFF", "----", "#999999"),
}
UNSETTLED, HIDDEN = "//////", "\\\\\\\\"
HATCH_WIDTH, HALO = 0.45, 1.3  # of lines over colours: black with a white rim shows on any of them
BORDER = 0.7
BORDERS = (BLACK, GREEN, VIOLET, VERMILION)  # of lines where something changes
BORDER_WORDS = {"travel": "travel begins, ends or turns round", "impacts": "grazing of a stop"}
COLUMN, PAGE = 3.54, 7.2  # inches: 90 mm and 183 mm
PRINT: dict[Any, Any] = {
    **plots.STYLE,
    **plots.PAGE_STYLE,
    "axes.grid": False,
    "axes.spines.top": True,
    "axes.spines.right": True,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}
LINE_TITLE, LINE_SMALL = 0.145, 0.115  # inches


def plot_view(view: View, path: str | Path, border: str | Sequence[str] | None = None) -> Path:
    """Draw a view of a study into a file (.png, .svg or .pdf)."""
    return save(study_figure(view, border), path, PRINT)


def study_figure(view: View, border: str | Sequence[str] | None = None) -> Figure:
    """The figure of a view of a study: a map, lines or dots, as its axes are."""
    names = [] if border is None else [border] if isinstance(border, str) else list(border)
    if len(names) > len(BORDERS):
        raise Refusal(f"--border: a map shows {len(BORDERS)} kinds of border at most, got {len(names)}")
    borders = dict(zip(dict.fromkeys(names), BORDERS, strict=False))
    lines = {name: [_border_lines(panel, view, name) for panel in view.panels] for name in borders}
    with plots.style(plots.settings_of(PRINT)):
        if len(view.axes) == 1:
            fig, axes = study_axes(view, 1)
            handles = draw_lines(axes[0], view)
        else:
            fig, axes = study_axes(view, len(view.panels))
            handles = _draw_maps(fig, axes, view)
            for place, (name, ink) in enumerate(borders.items()):  # the first of them above the others
                for ax, segments in zip(axes, lines[name], strict=True):
                    for colour, width in (("white", 2 * BORDER), (ink, BORDER)):
                        options = {"colors": colour, "linewidths": width, "zorder": 3.0 - place / len(BORDERS)}
                        ax.add_collection(LineCollection(list(segments), label="border", **options))
                words = BORDER_WORDS.get(name, f"border of {name.replace('_', ' ')}")
                handles.append(Line2D([], [], color=ink, linewidth=BORDER, label=words))
        add_title_and_legend(fig, view, handles)
    return fig


def draw_study(
    dataset: Any,
    measure: str | None = None,
    *,
    at: Mapping[str, str] | None = None,
    dead_band: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """One panel of a study: a map with its scale of colours, or lines over one axis.

    measure, at, dead_band: as in `study_view`; what would be several maps side by side is refused: fix one with `at`
    """
    view = study_view(dataset, measure, at, dead_band)
    if len(view.axes) > 1 and len(view.panels) > 1:
        titles = ", ".join(panel.title for panel in view.panels)
        raise Refusal(f"at: leaves {len(view.panels)} maps ({titles}), where one pair of axes shows one")
    with plots.drawing(ax, (4.6, 3.8)) as ax:
        assert isinstance(ax.figure, (Figure, SubFigure))
        handles = draw_lines(ax, view) if len(view.axes) == 1 else _draw_maps(ax.figure, [ax], view)
        ax.set_title(view.measure.replace("_", " "))
        if len(view.axes) > 1:
            ax.grid(False)
        if handles:
            plots.legend_below(ax, handles)
    return ax


# --- the frame: title above, legend below -----------------------------------------------------------------------------
def study_axes(view: View, panels: int) -> tuple[Figure, list[Axes]]:
    """An empty figure in the project's style and its axes, in reading order."""
    columns = 1 if panels == 1 or page().narrow else 3 if panels in (3, 5, 6) else 2
    rows = math.ceil(panels / columns)
    width = page().width_or(COLUMN if panels == 1 else PAGE)
    fig = Figure(figsize=(width, rows * 0.8 * min(width / columns, COLUMN)), layout="constrained")
    FigureCanvasAgg(fig)
    axes = fig.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel().tolist()
    for ax in axes[panels:]:
        ax.remove()
    return fig, axes[:panels]


def add_title_and_legend(fig: Figure, view: View, handles: list[Any]) -> None:
    """Title above and legend below; the figure grows by them, so that the axes keep their size and nothing is cut."""
    width, height = fig.get_size_inches()
    broad = page().width_or(width)
    title = textwrap.fill(view.title, round(12.5 * broad))
    setting = filled(f"{view.setting}; {view.note}", round(19 * broad))
    first = 0.06 + LINE_TITLE * (title.count("\n") + 1)
    above = first + LINE_SMALL * (setting.count("\n") + 1) + 0.04 if page().header else 0.0
    below = 0.04
    if handles:
        for handle in handles:
            handle.set_label(textwrap.fill(handle.get_label(), round(15 * width), subsequent_indent="  "))
        below = _legend(fig, handles, 4 if broad > COLUMN else 3)
    whole = height + above + below
    fig.set_size_inches(width, whole)
    if page().header:
        fig.text(0.015, 1.0 - 0.06 / whole, title, fontsize=8.5, fontweight="bold", va="top", linespacing=1.15)
        fig.text(0.015, 1.0 - first / whole, setting, fontsize=6.5, color="#555555", va="top", linespacing=1.15)
    fig.set_layout_engine("constrained", rect=(0.0, below / whole, 1.0, height / whole))


def _legend(fig: Figure, handles: list[Any], columns: int) -> float:
    """Put the legend at the foot of a figure, in fewer columns where so many are too wide; its height in inches."""
    room = {"columnspacing": 1.2, "labelspacing": 0.4, "borderaxespad": 0.3, "borderpad": 0.2}
    size = {"handlelength": 2.0, "handleheight": 1.1}
    legend = fig.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 0.0), ncols=columns, **size, **room)
    extent = legend.get_window_extent()
    if columns > 1 and extent.x1 > fig.bbox.x1:
        legend.remove()
        return _legend(fig, handles, columns - 1)
    return extent.height / fig.dpi + 0.08


def _hatched(patch: Any, hatch: str, ink: str, width: float = HATCH_WIDTH) -> Any:
    """A patch with thin hatching."""
    patch.set(hatch=hatch or None, edgecolor=ink, linewidth=0.0)
    patch.set_hatch_linewidth(width)
    return patch


# --- maps -------------------------------------------------------------------------------------------------------------
def _draw_maps(fig: Figure | SubFigure, axes: list[Axes], view: View) -> list[Any]:
    """The maps of all panels in one scale of colours; returns the handles of the legend."""
    groups = runs.categories(view) if view.kind == "discrete" else None
    paint = _categories_paint(groups) if groups else _scale_paint(view)
    for ax, panel in zip(axes, view.panels, strict=True):
        colours = groups.codes(view, panel) if groups else panel.values
        _draw_map(ax, view, panel, np.ma.masked_where(runs.cells(view, panel) != runs.Cell.VALUE, colours), paint)
        ax.set_title(panel.title)
    for ax in axes:
        place = ax.get_subplotspec()
        if place is None or len(axes) == 1:
            ax.set(xlabel=filled(view.axes[0].label, 44), ylabel=filled(view.axes[1].label, 44))
            continue
        grid = place.get_gridspec()
        below = axes.index(ax) + grid.ncols
        if below >= len(axes):
            ax.set_xlabel(filled(view.axes[0].label, 44 if grid.ncols < 3 else 28))
            ax.tick_params(labelbottom=True)
        if place.is_first_col():
            ax.set_ylabel(filled(view.axes[1].label, 44 if grid.nrows < 2 or grid.ncols < 3 else 28))
    if not groups:
        _colour_bar(fig, axes, view, paint)
    words = groups.words if groups else ()
    handles: list[Any] = [Patch(facecolor=paint["cmap"](i), label=x, edgecolor="none") for i, x in enumerate(words)]
    if view.points is not None:
        return handles + dot_handles(view)
    for cell, text in runs.cell_labels(view).items():
        face, hatch, ink = CELL_STYLES[cell]
        handles.append(_hatched(Patch(facecolor=face, label=text), hatch, ink))
    marks = ((runs.unsettled_label(view), UNSETTLED), (runs.hidden_label(view), HIDDEN))
    return handles + [_hatched(Patch(facecolor="none", label=text), hatch, BLACK) for text, hatch in marks if text]


def _draw_map(ax: Axes, view: View, panel: Panel, colours: Any, paint: dict[str, Any]) -> None:
    """The cells of one panel: values in colours, all else flat, with hatching over it."""
    kinds, waiting = runs.cells(view, panel), runs.unsettled(view, panel)
    if view.points is None:
        x, y = view.axes[0].edges, view.axes[1].edges
        flat = np.ma.masked_where(kinds == runs.Cell.VALUE, kinds)
        faces = ListedColormap([face for face, _, _ in CELL_STYLES.values()])
        numbers = Normalize(min(CELL_STYLES) - 0.5, max(CELL_STYLES) + 0.5)
        ax.pcolormesh(x, y, colours.T, rasterized=True, label="values", **paint)
        ax.pcolormesh(x, y, flat.T, rasterized=True, label="no values", cmap=faces, norm=numbers)
        for cell, (_, hatch, ink) in CELL_STYLES.items():
            _hatch(ax, x, y, kinds == cell, hatch, ink)
        for where, hatch in ((waiting, UNSETTLED), (runs.hidden_lift_off(panel), HIDDEN)):
            _hatch(ax, x, y, where, hatch, "white", HALO)
            _hatch(ax, x, y, where, hatch, BLACK)
        ax.set(xlim=x[[0, -1]], ylim=y[[0, -1]])
    else:
        draw_dots(ax, view, panel, colours, paint)
    for axis, name in zip(view.axes, "xy", strict=True):
        if axis.logarithmic:
            plots.logarithmic(ax, name)


def _hatch(
    ax: Axes, x: np.ndarray, y: np.ndarray, where: np.ndarray, hatch: str, ink: str, width: float = HATCH_WIDTH
) -> None:
    """Hatching over all cells of a kind, as one outline, which a file of vectors can hold."""
    if hatch and where.any():
        patch = PathPatch(_outline(x, y, where), facecolor="none", label=hatch, zorder=2)
        ax.add_patch(_hatched(patch, hatch, ink, width))


def _outline(x: np.ndarray, y: np.ndarray, where: np.ndarray) -> Outline:
    """Rectangles over cells [x, y], those that touch along x joined."""
    steps = np.diff(np.pad(where.T.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, start = np.nonzero(steps == 1)
    _, stop = np.nonzero(steps == -1)
    left, right, low, high = x[start], x[stop], y[row], y[row + 1]
    corners = np.stack([(left, low), (right, low), (right, high), (left, high), (left, low)])  # [5, 2, rectangles]
    codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    return Outline(corners.transpose(2, 0, 1).reshape(-1, 2), codes * len(row))


def _scale_paint(view: View) -> dict[str, Any]:
    low, high, _, _, logarithmic = runs.limits(view)
    cmap = matplotlib.colormaps[DIVERGING if view.kind == "signed" else SEQUENTIAL]
    if view.kind == "signed" and low * high == 0.0:  # one way only: that half of the colours
        cmap = ListedColormap(cmap(np.linspace(0.5, 1.0, 256) if low == 0.0 else np.linspace(0.0, 0.5, 256)))
    return {"cmap": cmap, "norm": LogNorm(low, high) if logarithmic else Normalize(low, high)}


def _categories_paint(groups: runs.Categories) -> dict[str, Any]:
    """Colours of categories, those beyond the named ones in grey."""
    colours = [*DISTINCT[: len(groups.values)], *([OTHERS] if len(groups.words) > len(groups.values) else [])]
    cmap = ListedColormap(colours or [OTHERS])
    return {"cmap": cmap, "norm": Normalize(-0.5, cmap.N - 0.5)}


def _colour_bar(fig: Figure | SubFigure, axes: list[Axes], view: View, paint: dict[str, Any]) -> None:
    """The scale of colours beside the maps, pointed where values lie beyond it; none where no cell has a value."""
    kinds = {int(kind) for panel in view.panels for kind in np.unique(runs.cells(view, panel))}
    if runs.Cell.VALUE not in kinds:
        still = kinds <= {runs.Cell.NO_TRAVEL, runs.Cell.INFINITE}
        words = f"{view.label}:\nno {'run' if view.points else 'cell'} {'travels' if still else 'has a value'}"
        beside: dict[str, Any] = {
            "rotation": 90,
            "ha": "left",
            "va": "center",
            "fontsize": axes[0].yaxis.label.get_fontsize(),
        }
        axes[-1].text(1.03, 0.5, words, transform=axes[-1].transAxes, **beside)
        return
    _, _, below, above, _ = runs.limits(view)
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    shape = {"extend": extend[below, above], "aspect": 28 if len(axes) == 1 else 22, "pad": 0.02, "fraction": 0.05}
    bar = fig.colorbar(ScalarMappable(paint["norm"], paint["cmap"]), ax=axes, **shape)
    beyond = runs.beyond_label(view)
    bar.set_label(f"{view.label}\n{beyond}" if beyond else view.label)
    bar.outline.set_linewidth(0.5)  # type: ignore[operator]


def _border_lines(panel: Panel, view: View, name: str) -> np.ndarray:
    """Where a discrete variable changes over a panel: segments [edges, 2 ends, 2] in the units of the axes.

    Those that end with the values end with the cells around these.
    """
    from vibrocap.studies.adaptive import border

    if view.points is not None or len(view.axes) < 2:
        raise Refusal("--border: needs a map over two axes")
    dataset = panel.dataset
    if "computed" not in dataset:
        dataset = dataset.assign(computed=dataset["status"] >= 0)
    way = travel_of(dataset, view.measure)
    if name == "travel" and name not in dataset and way:
        sign = np.sign(dataset[way].where(abs(dataset[way]) > dataset[BAND], 0.0))
        dataset = dataset.assign(travel=sign)
    try:
        segments = border(dataset.load(), name).segments
    except ArgumentError as error:
        raise Refusal(error.complaint.about("--border")) from None
    ends = [[(axis.values[end], axis.edges[end]) for end in (0, -1)] for axis in view.axes]
    columns = [
        np.select([column == value for value, _ in pair], [edge for _, edge in pair], column)
        for column, pair in zip(np.moveaxis(segments, -1, 0), ends, strict=True)
    ]
    return np.stack(columns, axis=-1)
