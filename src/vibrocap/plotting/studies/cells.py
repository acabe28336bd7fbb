"""Cells: what each run of a picture is drawn as, its value or, where it has none to compare, why.

Pictures of them that are no maps stand here too: lines over one axis, dots for runs that do not lie on a grid.
"""

import dataclasses
import enum
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from vibrocap.measures.standard import LOAD_WATCH
from vibrocap.motion.status import Status
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILION, logarithmic
from vibrocap.plotting.studies.view import NOT_RUN, Panel, View, missing_label, status_label, value_label

FINISHED = list(Status).index(Status.FINISHED)
MOST_CATEGORIES = 7
MOST_TOGETHER = 3  # cells of no travel between travel one way and the other, that are a passage through zero
CROWDED = 0.1  # share of a scale below the median, under which it is logarithmic
MOST_DECADES = 1e3  # largest over least value of a logarithmic scale
# (percentile, how many times farther from the median the largest value is) where a scale ends before the largest
TRIMS = ((99.5, 2.0), (98.0, 5.0), (95.0, 10.0))


class Cell(enum.IntEnum):
    """What is drawn for a run."""

    VALUE = 0
    NO_TRAVEL = 1
    INFINITE = 2
    NO_VALUE = 3
    NOT_SETTLED = 4
    FAILED = 5
    NOT_RUN = 6


def cells(view: View, panel: Panel) -> np.ndarray:
    """A `Cell` for every run of a panel."""
    kinds = np.full(panel.status.shape, int(Cell.VALUE))
    if view.kind != "discrete":
        kinds[np.isinf(panel.values)] = Cell.INFINITE
    if view.kind == "signed":
        still = np.abs(panel.values) <= panel.dead_band
        if view.points is None and still.ndim == 2:
            still &= ~_changes_sign(panel.values, still)
        kinds[still] = Cell.NO_TRAVEL
    if panel.values.dtype.kind == "f":
        kinds[np.isnan(panel.values)] = Cell.NO_VALUE
        nothing = panel.values == 0.0 if view.measure == "response_period" else np.isnan(panel.values)
        kinds[nothing & ~panel.settled] = Cell.NOT_SETTLED
    if view.measure != "status":
        kinds[panel.status != FINISHED] = Cell.FAILED
        kinds[panel.status == NOT_RUN] = Cell.NOT_RUN
    return kinds


def _changes_sign(values: np.ndarray, still: np.ndarray) -> np.ndarray:
    """Cells of a grid with travel one way before them and the other way behind, along an axis, a few together.

    There the measure passes zero, and a value that happens to be nearly zero is a value like its neighbours'. Where
    more cells are still side by side, nothing travels.
    """
    from scipy.ndimage import label

    areas = np.empty(still.shape, dtype=int)
    label(still, output=areas)
    few = (np.bincount(areas.ravel()) <= MOST_TOGETHER)[areas]
    changes = np.zeros(values.shape, dtype=bool)
    signs = np.where(still | ~np.isfinite(values), 0.0, np.sign(values))
    for axis in range(values.ndim):
        along = np.moveaxis(signs, axis, 0)
        np.moveaxis(changes, axis, 0)[1:-1] |= along[:-2] * along[2:] < 0.0
    return changes & few


def unsettled(view: View, panel: Panel) -> np.ndarray:
    """Runs that finished but did not settle, so that another length would give other values; marked by hatching.

    Where the measure itself says so, nothing is marked.
    """
    return ~panel.settled & (panel.status == FINISHED) & (view.measure != "settled")


def cell_labels(view: View) -> dict[Cell, str]:
    """The legend of all cells that are no value and occur: what they are, how many, and of failed runs their status."""
    counts: Counter[int] = Counter()
    statuses: Counter[int] = Counter()
    for panel in view.panels:
        kinds = cells(view, panel)
        counts.update(kinds.ravel().tolist())
        statuses.update(panel.status[kinds == Cell.FAILED].tolist())
    symbol = {"mean_velocity": "|⟨X′⟩|"}.get(view.measure, "|ΔX|")
    words = {
        Cell.NO_TRAVEL: f"no travel, {symbol} ≤ {view.band}",
        Cell.INFINITE: "infinite: no travel" if view.measure == "cost_of_transport" else "infinite",
        Cell.NO_VALUE: missing_label(view.meaning),
        Cell.FAILED: "failed: " + ", ".join(f"{status_label(code)} {n:,}" for code, n in statuses.most_common()),
        Cell.NOT_RUN: "not run yet",
    }
    runs = sum(counts.values())
    return {
        cell: text if cell is Cell.FAILED else f"{text}: {share(counts[cell], runs)}"
        for cell, text in words.items()
        if counts[cell]
    }  # those that did not settle have `unsettled_label`


def unsettled_label(view: View) -> str:
    """The legend of runs that did not settle; empty where there is none."""
    return _counted("not settled", view, [unsettled(view, panel) for panel in view.panels])


def _counted(words: str, view: View, marked: list[np.ndarray]) -> str:
    """How many of all runs are marked; empty where none is."""
    count = sum(int(where.sum()) for where in marked)
    return f"{words}: {share(count, sum(panel.status.size for panel in view.panels))}" if count else ""


def share(count: int, total: int) -> str:
    """So many of all runs."""
    percent = 100 * count / total
    return f"{count:,} ({percent:.0f} %)" if percent >= 1 else f"{count:,} (<1 %)" if count else "0"


def hidden_lift_off(panel: Panel) -> np.ndarray:
    """Runs that finished although the true load was negative, which a constant load does not notice.

    Marked by hatching. A study without the measure `least_reaction` watches the load by itself.
    """
    hidden = np.zeros(panel.status.shape, bool)
    if "least_reaction" in panel.dataset:
        hidden = panel.other("least_reaction") < 0.0
    elif LOAD_WATCH in panel.dataset:
        hidden = panel.other(LOAD_WATCH) > 0.0
    return hidden & (panel.status == FINISHED)


def hidden_label(view: View) -> str:
    """The legend of runs whose constant load hides a lift-off; empty where there is none."""
    return _counted("the true load would be negative", view, [hidden_lift_off(panel) for panel in view.panels])


@dataclasses.dataclass(frozen=True)
class Categories:
    """The values of a discrete measure that are drawn in colours of their own, and their legend."""

    values: tuple[str | float, ...]
    words: tuple[str, ...]  # one more than values where there are others

    def codes(self, view: View, panel: Panel) -> np.ndarray:
        """The number of each run's category; -1 where the run is drawn as another `Cell`."""
        known = {value: code for code, value in enumerate(self.values)}
        flat = [known.get(value, len(known)) for value in panel.values.ravel().tolist()]
        codes = np.array(flat).reshape(panel.values.shape)
        return np.where(cells(view, panel) == Cell.VALUE, codes, -1)


def categories(view: View, most: int = MOST_CATEGORIES) -> Categories:
    """The most frequent values of a discrete measure; numbers in ascending order, words by frequency."""
    counts: Counter[str | float] = Counter()
    total = 0
    for panel in view.panels:
        shown = cells(view, panel) == Cell.VALUE
        counts.update(panel.values[shown].tolist())
        total += panel.status.size
    frequent = [value for value, _ in sorted(counts.items(), key=lambda item: (-item[1], str(item[0])))][:most]
    if frequent and not isinstance(frequent[0], str):
        frequent.sort(key=float)
    words = [f"{value_label(view.measure, value)}: {share(counts[value], total)}" for value in frequent]
    others = len(counts) - len(frequent)
    if others:
        rest = sum(counts.values()) - sum(counts[value] for value in frequent)
        words.append(f"{others} other{'s' if others > 1 else ''}: {share(rest, total)}")
    return Categories(tuple(frequent), tuple(words))


def limits(view: View) -> tuple[float, float, bool, bool, bool]:
    """(least, largest, values below, values above, logarithmic) of a colour scale.

    For travel symmetric about zero, or from zero on where all of it goes one way. The scale follows the settled runs
    where there are any, less a few percent that lie far out: some runs just short of a border must not take all colours
    from the others.
    """
    values, settled = _shown(view)
    base = values[settled] if settled.any() else values
    if not len(base):
        return (-1.0, 1.0, False, False, False) if view.kind == "signed" else (0.0, 1.0, False, False, False)
    if view.kind == "signed":
        top = _trimmed(np.abs(base))
        low, high = (0.0 if (values >= 0.0).all() else -top), (0.0 if (values <= 0.0).all() else top)
        return low, high, bool((values < -top).any()), bool((values > top).any()), False
    low, high = -_trimmed(-base), _trimmed(base)
    if low == high:
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    logarithmic = bool((values > 0.0).all() and spread(np.clip(base, low, high)))
    if logarithmic:
        high = min(high, MOST_DECADES * low)
    return low, high, bool((values < low).any()), bool((values > high).any()), logarithmic


def spread(values: np.ndarray) -> bool:
    """Whether positive values crowd at the lower end of their range, so that their scale should be logarithmic."""
    values = values[np.isfinite(values)]
    if not len(values) or values.min() <= 0.0:
        return False
    return bool(np.median(values) - values.min() < CROWDED * np.ptp(values))


def _shown(view: View) -> tuple[np.ndarray, np.ndarray]:
    """Values that are drawn in the colours of a scale, and whether each has settled: arrays [runs]."""
    parts: Sequence[np.ndarray] = [cells(view, panel) == Cell.VALUE for panel in view.panels]
    values = [panel.values[shown] for panel, shown in zip(view.panels, parts, strict=True)]
    settled = [panel.settled[shown] for panel, shown in zip(view.panels, parts, strict=True)]
    return np.concatenate(values), np.concatenate(settled)


def beyond_label(view: View) -> str:
    """How many values lie beyond the scale of colours, which its arrows stand for; empty where none does."""
    low, high, below, above, _ = limits(view)
    values, _ = _shown(view)
    sides = ((below, values < low, "below"), (above, values > high, "above"))
    return ", ".join(f"{share(int(out.sum()), len(values))} {side}" for there, out, side in sides if there)


def _trimmed(values: np.ndarray) -> float:
    """The largest value; where it lies far out beyond a percentile of `TRIMS`, the largest of those that do not."""
    middle, largest = np.percentile(values, (50.0, 100.0))
    for percentile, farther in TRIMS:
        far = np.percentile(values, percentile)
        if far > middle and largest - middle > farther * (far - middle):
            return float(np.max(values[values - middle <= farther * (far - middle)]))
    return float(largest)


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
    x = view.points[0] if view.points else axis.values
    for panel, height, colour in zip(view.panels, heights, COLOURS, strict=False):
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
        bands = [panel.dead_band[order] for panel in view.panels]
        look = {"color": GREY, "linewidth": 0.8, "zorder": 0, "label": words}
        handles += [ax.fill_between(x[order], -band, band, **look) for band in bands][:1]
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
