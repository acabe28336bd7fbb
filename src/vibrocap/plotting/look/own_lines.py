"""Lines in the user's own widths and colours, where the settings of Matplotlib are not its usual ones.

The package draws in colours of its own, which stand for something (what is fitted, what is predicted), and in widths of
its own. Where the user has set `lines.linewidth` or `lines.markersize`, all are that much wider; where the user has set
`axes.prop_cycle`, its colours stand in place of the package's, the first for the first. Areas keep their colours.
"""

import contextlib
import itertools
import weakref
from collections.abc import Iterable, Iterator
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D

from vibrocap.plotting.look.colours import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, VIOLET, YELLOW
from vibrocap.plotting.look.style import given_axes, style

CYCLE = (BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, VIOLET, YELLOW)
COLOURED = ("color", "markerfacecolor", "markeredgecolor")
_DONE: weakref.WeakSet[Line2D] = weakref.WeakSet()


@contextlib.contextmanager
def drawing(ax: Axes | None, size: tuple[float, float] = (6.4, 4.0)) -> Iterator[Axes]:
    """The axes to draw into in the project's style, `ax` or those of a new figure of that size in inches.

    New lines in them get the user's widths and colours; others in `ax` stay as they are.
    """
    _DONE.update([] if ax is None else _lines(ax))
    ax = given_axes(ax, size)
    with style():
        yield ax
    own_lines(ax)


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
