"""The frame of a picture of a study: its size on paper, the words above it and the legend below."""

import math
import textwrap
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vibrocap.plotting.study_view import View
from vibrocap.plotting.style import STYLE

COLUMN, PAGE = 3.54, 7.2  # inches: 90 mm and 183 mm
PRINT: dict[Any, Any] = {
    **STYLE,
    "savefig.dpi": 300,
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "axes.titlesize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "axes.grid": False,
    "axes.spines.top": True,
    "axes.spines.right": True,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}
LINE_TITLE, LINE_SMALL = 0.145, 0.115  # inches


def blank_study_figure(view: View, panels: int) -> tuple[Figure, list[Axes]]:
    """An empty figure in the project's style and its axes, in reading order."""
    columns = 1 if panels == 1 else 3 if panels in (3, 5, 6) else 2
    rows = math.ceil(panels / columns)
    width = COLUMN if panels == 1 else PAGE
    fig = Figure(figsize=(width, rows * 0.8 * width / columns), layout="constrained")
    FigureCanvasAgg(fig)
    axes = fig.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel().tolist()
    for ax in axes[panels:]:
        ax.remove()
    return fig, axes[:panels]


def put_words(fig: Figure, view: View, handles: list[Any]) -> None:
    """Title above and legend below; the figure grows by them, so that the axes keep their size and nothing is cut."""
    width, height = fig.get_size_inches()
    title = textwrap.fill(view.title, round(12.5 * width))
    setting = textwrap.fill(f"{view.setting}; {view.note}", round(20 * width))
    first = 0.06 + LINE_TITLE * (title.count("\n") + 1)
    above = first + LINE_SMALL * (setting.count("\n") + 1) + 0.04
    below = 0.04
    if handles:
        for handle in handles:
            handle.set_label(textwrap.fill(handle.get_label(), round(15 * width), subsequent_indent="  "))
        below = _legend(fig, handles, 4 if width > COLUMN else 3)
    whole = height + above + below
    fig.set_size_inches(width, whole)
    fig.text(0.015, 1.0 - 0.06 / whole, title, fontsize=8.5, fontweight="bold", va="top", linespacing=1.15)
    fig.text(0.015, 1.0 - first / whole, setting, fontsize=6.5, color="#555555", va="top", linespacing=1.15)
    fig.set_layout_engine("constrained", rect=(0.0, below / whole, 1.0, height / whole))


def _legend(fig: Figure, handles: list[Any], columns: int) -> float:
    """Put the legend at the foot of a figure, in fewer columns where so many are too wide; its height in inches."""
    legend = fig.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 0.0),
        ncols=columns,
        handlelength=2.0,
        handleheight=1.1,
        columnspacing=1.2,
        labelspacing=0.4,
        borderaxespad=0.3,
        borderpad=0.2,
    )
    size = legend.get_window_extent()
    if columns > 1 and size.x1 > fig.bbox.x1:
        legend.remove()
        return _legend(fig, handles, columns - 1)
    return size.height / fig.dpi + 0.08
