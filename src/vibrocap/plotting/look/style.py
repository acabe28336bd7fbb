"""The style of all pictures: colours, labels, figures, and files that come out the same every time.

Figures are made as objects, never through pyplot's global state, so that drawing leaves no trace in a session. What
draws into axes that it is given does so within `style()`, which ends with it.
"""

import contextlib
import io
import itertools
import logging
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from vibrocap.plotting.look.page import page

# Okabe and Ito's colours, which colour-blind readers can tell apart, and two more.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
VIOLET, GREY = "#5B3A8C", "#8C8C8C"

# fontTools, which puts letters into PDF files (pdf.fonttype below), complains about the dates of Matplotlib's own fonts
logging.getLogger("fontTools.ttLib.tables._h_e_a_d").setLevel(logging.ERROR)

FEW_DECADES = 1e3  # largest over least value of an axis, up to which ticks are plain numbers

# The paper's arrangement: LuGre red and solid, exponential blue and dashed.
LM_STYLE: dict[str, Any] = {"color": "#C8102E", "linestyle": "-", "linewidth": 1.4}
EM_STYLE: dict[str, Any] = {"color": BLUE, "linestyle": (0, (5, 2)), "linewidth": 1.4}

STICK_SHADE: dict[str, Any] = {"color": "#B8B8B8", "alpha": 0.45, "linewidth": 0, "zorder": 0}
ANY_UNITS = "All quantities in the units of the parameters."
DIMENSIONLESS = r"All quantities dimensionless: lengths in $l$, time in $\sqrt{l/g}$, forces in $m\,g$."

BELOW = 36.0  # points below axes at which a legend begins: room for the numbers and the label of the axis

PREFIXES = ((1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))  # of units

STYLE: dict[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 150,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "mathtext.fontset": "dejavusans",  # the letters of all else
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.xmargin": 0.02,
    "axes.ymargin": 0.06,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "none",
    "legend.fontsize": 8.5,
    "pdf.fonttype": 42,  # letters as outlines of a font that a journal takes and a reader can copy
    "ps.fonttype": 42,
    "svg.hashsalt": "vibrocap",
}
# Over those, where a figure is fitted to a page.
PAGE_STYLE: dict[Any, Any] = {
    "savefig.dpi": 300,
    "font.size": 7.5,
    "axes.titlesize": 8,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
}
HEAD = 6.5  # points: of what stands above and below the panels of such a figure


def style_sheet(path: Path) -> contextlib.AbstractContextManager[None]:
    """A context in which the settings of a style sheet of Matplotlib hold; ValueError for a file that is none."""
    warnings: list[str] = []
    handler, logger = logging.Handler(), logging.getLogger("matplotlib")
    handler.emit = lambda record: warnings.append(" ".join(record.getMessage().split()))
    logger.addHandler(handler)  # Matplotlib warns of lines that are no settings, and goes on
    propagated, logger.propagate = logger.propagate, False
    try:
        settings = matplotlib.rc_params_from_file(path, use_default_template=False)
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise ValueError(f"{str(path)!r} cannot be read: {error}") from None
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagated
    if warnings:
        raise ValueError(f"{str(path)!r} is no style sheet of Matplotlib: {warnings[0]}")
    return matplotlib.rc_context(dict(settings))


def settings_of(package: dict[Any, Any]) -> dict[Any, Any]:
    """Those settings of the package's style which the user has left as Matplotlib sets them."""
    asked, untouched = package | (PAGE_STYLE if page().width is not None else {}), {}
    for name, value in asked.items():  # as Matplotlib has them, or the package within `style`
        ours = [settings[name] for settings in (STYLE, PAGE_STYLE, asked) if name in settings]
        if matplotlib.rcParams[name] in (matplotlib.rcParamsDefault[name], *ours, *([our] for our in ours)):
            untouched[name] = value
    return untouched


@contextlib.contextmanager
def style(settings: Mapping[Any, Any] | None = None) -> Iterator[None]:
    """A context in which Matplotlib draws in the style of this package; it leaves no trace.

    settings: of Matplotlib, such as {"font.size": 12}, over those of the style

    What the user has set in `matplotlib.rcParams`, or by a style sheet, stays as it is.
    """
    with matplotlib.rc_context(settings_of(STYLE) | dict(settings or {})):
        yield


class ShownFigure(Figure):
    """A figure that a notebook shows whether or not it was told of Matplotlib."""

    def _repr_png_(self) -> bytes:
        """The picture, as it is written to a file but for its fineness."""
        buffer = io.BytesIO()
        with style():
            self.savefig(buffer, format="png", dpi=self.dpi)
        return buffer.getvalue()


def figure(
    nrows: int = 1, ncols: int = 1, size: tuple[float, float] = (6.4, 4.0), **options: Any
) -> tuple[ShownFigure, Any]:
    """A figure in the project's style and its axes, an array [nrows, ncols]; `size` in inches.

    Further options go to `Figure.subplots` (sharex, width_ratios, ...).
    """
    with new_figure(size) as fig:
        axes = fig.subplots(nrows, ncols, squeeze=False, **options)
    return fig, axes


def blank_figure(size: tuple[float, float]) -> ShownFigure:
    """A figure in the project's style without axes; `size` in inches."""
    with style():
        fig = ShownFigure(figsize=size, layout="constrained")
        FigureCanvasAgg(fig)
    return fig


@contextlib.contextmanager
def new_figure(size: tuple[float, float]) -> Iterator[ShownFigure]:
    """A figure without axes, and the project's style in which it is filled; `size` in inches."""
    fig = blank_figure(size)
    with style():
        yield fig


def legend(axes: Axes, **options: Any) -> None:
    """A legend in the project's style."""
    with style():
        axes.legend(**{"loc": "best", **options})


def legend_below(axes: Axes, handles: Sequence[Any], **options: Any) -> None:
    """A legend below axes and their label, where it covers nothing."""
    down = ScaledTranslation(0.0, -BELOW / 72.0, axes.get_figure(root=True).dpi_scale_trans)  # type: ignore[union-attr]
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.0, 0.0), "borderaxespad": 0.0}
    legend(axes, handles=handles, **place, **({"bbox_transform": axes.transAxes + down, "fontsize": 7.5} | options))


def legend_above(axes: Axes, **options: Any) -> None:
    """A legend in the line of the title, where it covers no data."""
    look: dict[str, Any] = {"ncols": 3, "columnspacing": 1.0, "handlelength": 1.4, "handletextpad": 0.5}
    look |= {"fontsize": 8 if page().width is None else 6.5, "frameon": False, "borderpad": 0.1, "borderaxespad": 0.3}
    axes.legend(**{"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), **look, **options})


def letters(points: float) -> float:
    """The size of letters that are so large on a screen, in points; on a page at most those of its labels."""
    return points if page().width is None else min(points, PAGE_STYLE["xtick.labelsize"])


def heading(fig: Figure, text: str) -> None:
    """The title of a whole figure."""
    setting(fig, text, 10.5, HEAD + 1.5, weight="bold")


def setting(fig: Figure, text: str, points: float = 9.5, printed: float = HEAD, **look: Any) -> None:
    """The parameters of what a figure shows, above it. points, printed: size of letters on a screen and on a page"""
    if page().header:
        fig.suptitle(text, fontsize=points if page().width is None else printed, x=0.01, ha="left", **look)


def logarithmic(ax: Axes, name: str) -> None:
    """A logarithmic scale of the axis "x" or "y" whose ticks do not run into each other.

    Over a few decades these are 1, 2 and 5 of each, as plain numbers, within one decade round numbers; over more than
    three, powers of ten.
    """
    getattr(ax, f"set_{name}scale")("log")
    low, high = sorted(getattr(ax, f"get_{name}lim")())
    axis = ax.xaxis if name == "x" else ax.yaxis
    if high < FEW_DECADES * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)) if high >= 10.0 * low else MaxNLocator(5))
        axis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def footnote(fig: Figure, text: str = DIMENSIONLESS) -> None:
    """A line of small print below the axes."""
    if page().header:
        fig.supxlabel(text, fontsize=7.5 if page().width is None else HEAD, color="#555555", x=0.01, ha="left")


def decimated(x: np.ndarray, y: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """A line of at most `most` points through the least and the largest y of as many stretches as that takes."""
    block = -(-2 * len(x) // most)
    if block <= 2:
        return x, y
    number = len(x) // block
    parts = y[: number * block].reshape(number, block)
    at = np.sort(np.stack([parts.argmin(axis=1), parts.argmax(axis=1)], axis=1), axis=1)
    index = (at + block * np.arange(number)[:, None]).ravel()
    return x[index], y[index]


def unit_of(values: np.ndarray) -> tuple[float, str]:
    """The unit in which the largest of the values is between 1 and 1000, as a factor and a prefix."""
    largest = float(np.max(np.abs(values)))
    return next((prefix for prefix in PREFIXES if largest >= prefix[0]), PREFIXES[-1])


CYCLE = (BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, VIOLET, YELLOW)
COLOURED = ("color", "markerfacecolor", "markeredgecolor")
_DONE: weakref.WeakSet[Line2D] = weakref.WeakSet()


@contextlib.contextmanager
def drawing(ax: Axes | None, size: tuple[float, float] = (6.4, 4.0)) -> Iterator[Axes]:
    """The axes to draw into in the project's style, `ax` or those of a new figure of that size in inches.

    The axes of a new figure show themselves in a notebook as that figure. New lines in them get the user's widths and
    colours; others in `ax` stay as they are.
    """
    if ax is None:
        fig, panels = figure(size=size)
        axes: Axes = panels[0, 0]
        axes._repr_png_ = fig._repr_png_  # type: ignore[attr-defined]
    else:
        axes = ax
        _DONE.update(_lines(ax))
    with style():
        yield axes
    own_lines(axes)


def own_lines(drawn: Axes | Figure) -> None:
    """Give the lines of axes or of a figure the user's widths and colours, once."""
    ours, usual = matplotlib.rcParams, matplotlib.rcParamsDefault
    wider, larger = (ours[name] / usual[name] for name in ("lines.linewidth", "lines.markersize"))
    cycle = [] if ours["axes.prop_cycle"] == usual["axes.prop_cycle"] else ours["axes.prop_cycle"].by_key()["color"]
    colours = dict(zip(CYCLE, itertools.cycle(cycle), strict=False))
    panels = [drawn] if isinstance(drawn, Axes) else drawn.findobj(Axes)
    legends = drawn.findobj(Legend)
    for line in itertools.chain(*map(_lines, panels), *(legend.get_lines() for legend in legends)):
        if line in _DONE:
            continue
        _DONE.add(line)
        line.set_linewidth(wider * line.get_linewidth())
        line.set_markersize(larger * line.get_markersize())
        for name in COLOURED if colours else ():
            lines = getattr(line, f"get_{name}")()
            own = next((new for old, new in colours.items() if same_color(lines, old)), None)
            if own is not None:
                getattr(line, f"set_{name}")(own)


def _lines(ax: Any) -> Iterable[Line2D]:
    """The lines of axes, without their grid and ticks, and those of their legend."""
    legend = ax.get_legend()
    return [*ax.get_lines(), *([] if legend is None else legend.get_lines())]
