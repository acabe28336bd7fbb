"""The last steps of a figure: fitted to the width of a page, then written to a file.

What would run into its neighbour on a page is broken, thinned out or moved apart.
"""

import contextlib
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from vibrocap.files import replacing
from vibrocap.plotting.look.labels import filled, letters_seen
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import PAGE_STYLE, STYLE, own_lines, settings_of, style

GAP = 3.0  # points between what stands side by side
LEAST_TICKS = 2
LEAST_HEIGHT = 0.75  # of the height for a screen: labels and legends do not shrink as panels do
ROUNDS = 6  # at most: each changes the room that the next finds


def save(fig: Figure, path: str | Path, settings: dict[Any, Any] = STYLE) -> Path:
    """Write a figure to a file (.png, .svg or .pdf), whole or not at all; the same figure gives the same bytes.

    It is fitted to the page for which is drawn, see `plotting.page`.
    """
    path, fig = Path(path), finished(fig)
    dates = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with replacing(path) as temporary, matplotlib.rc_context(settings_of(settings)):
        fig.savefig(temporary, metadata=dates.get(path.suffix.lower()))
    return path


def finished(fig: Figure) -> Figure:
    """The figure in the user's own lines, fitted to the width that is asked for, else to its own."""
    own_lines(fig)
    width = page().width
    with style():
        if width is None:  # a screen, for which it was made: what is left to fit is little
            with _as_printed(fig):
                _fit(fig)
            return fig
        if fig.get_figwidth() != width:
            shrunk = max(width / fig.get_figwidth(), LEAST_HEIGHT)
            fig.set_size_inches(width, fig.get_figheight() * min(shrunk, 1.0))
        return fitted(fig)


def fitted(fig: Figure) -> Figure:
    """The figure, with texts broken to the room that there is, fewer ticks, and legends in fewer columns.

    It is laid out until nothing changes any more.
    """
    before, last = 0.0, None
    with _as_printed(fig):
        for _ in range(ROUNDS):
            _fit(fig)
            height = sum(text.get_window_extent().height for text in _heads(fig)) / fig.dpi
            fig.set_figheight(fig.get_figheight() + height - before)  # the panels keep their height
            looks = _looks(fig)
            if looks == last:
                break
            before, last = height, looks
    return fig


@contextlib.contextmanager
def _as_printed(fig: Figure) -> Iterator[None]:
    """The figure as fine as it is printed: letters of a screen are wider or narrower."""
    shown = fig.dpi
    fig.set_dpi(PAGE_STYLE["savefig.dpi"])
    yield
    fig.set_dpi(shown)


def _fit(fig: Figure) -> None:
    """Lay a figure out, and break and thin out what has too little room there."""
    fig.draw_without_rendering()
    for text in _heads(fig):
        _break(text, fig.bbox.width * 0.97)
    for legend in fig.findobj(Legend):
        _narrow(legend, fig)
    for ax in fig.findobj(Axes):
        _fit_axes(ax)


def _looks(fig: Figure) -> list[Any]:
    """What changes from one layout to the next: texts, places of panels and titles, and columns of legends."""
    axes, legends = fig.findobj(Axes), fig.findobj(Legend)
    texts = [text.get_text() for text in fig.findobj(Text)]
    places = [np.round([*ax.get_position().bounds, ax.titleOffsetTrans.get_matrix()[1, 2]], 2).tolist() for ax in axes]  # type: ignore[attr-defined]
    return [texts, places, [legend._ncols for legend in legends]]  # type: ignore[attr-defined]


def _heads(fig: Figure) -> list[Text]:
    """Title and small print of a figure."""
    return [text for text in (fig._suptitle, fig._supxlabel) if text is not None and text.get_text()]  # type: ignore[attr-defined]


def _fit_axes(ax: Axes) -> None:
    """Labels no longer than the axes, ticks apart, and a legend in the line of the title only where both have room."""
    box = ax.get_window_extent()
    _break(ax.xaxis.label, box.width)
    _break(ax.yaxis.label, box.height, upright=True)
    for axis in (ax.xaxis, ax.yaxis):
        _thin_out(axis)
    title = ax._left_title if ax._left_title.get_text() else ax.title  # type: ignore[attr-defined]
    if not title.get_text():
        return
    _break(title, box.width)
    legend = ax.get_legend()
    points = 72.0 / ax.get_figure(root=True).dpi  # type: ignore[union-attr]
    if legend is not None and legend.get_window_extent().y0 >= box.y1 - GAP / points:
        there = legend.get_window_extent()
        room = box.width - 4 * GAP / points  # the next layout may leave less
        if title.get_window_extent().width + there.width > room:
            ax.set_title(title.get_text(), pad=there.height * points + 2 * GAP)


def _break(text: Text, room: float, upright: bool = False) -> None:
    """Break a text that is longer than its room in pixels, into lines that are about as long as each other."""
    if not text.get_text():
        return
    box = text.get_window_extent()
    length = box.height if upright else box.width
    words = text.get_text()
    if length > room > 0.0:
        longest = max(map(letters_seen, words.splitlines()))
        letters = max(int(longest * room / length), 8)
        if not upright and words.count("\n"):
            text.set_text("\n".join(filled(line, letters, "  ") for line in words.splitlines()))
            return
        words = words.replace("\n", " ")
        while letters > 8 and filled(words, letters - 1).count("\n") == filled(words, letters).count("\n"):
            letters -= 1
        text.set_text(filled(words, letters))


def _narrow(legend: Any, fig: Figure) -> None:
    """Fewer columns, until a legend is no wider than its figure, or its axes."""
    parent = legend.axes if legend.axes is not None else fig
    widest = (parent.get_window_extent() if isinstance(parent, Axes) else fig.bbox).width * 1.02  # in pixels
    while legend._ncols > 1:
        box = legend.get_window_extent()
        if box.x0 >= fig.bbox.x0 and box.x1 <= fig.bbox.x1 and box.width <= widest:
            return
        # Matplotlib sets the number of columns alone, and arranges a legend only when it is made.
        handles, words = legend.legend_handles, [text.get_text() for text in legend.get_texts()]
        legend.set_ncols(legend._ncols - 1)
        legend._init_legend_box(handles, words)
        legend._legend_box.set_offset(legend._findoffset)
        legend.set_title(None)


def _thin_out(axis: Axis) -> None:
    """Fewer ticks, until their numbers do not touch."""
    locator = axis.get_major_locator()
    if axis.get_scale() != "linear" or not isinstance(locator, MaxNLocator):
        return
    count, gap = len(_tick_boxes(axis)), GAP / 2 * axis.get_figure(root=True).dpi / 72.0  # type: ignore[union-attr]
    while count > LEAST_TICKS and any(
        a.padded(gap).overlaps(b.padded(gap)) for a, b in itertools.pairwise(_tick_boxes(axis))
    ):
        count -= 1
        locator.set_params(nbins=max(count - 1, 1))


def _tick_boxes(axis: Axis) -> list:
    """Where the numbers of an axis stand that are shown."""
    shown = [tick.label1 for tick in axis._update_ticks()]  # type: ignore[attr-defined]
    return [label.get_window_extent() for label in shown if label.get_visible() and label.get_text()]
