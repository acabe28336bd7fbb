"""Pictures of searches for designs: a Pareto front, each point a design, and the best value over the evaluations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrocap.design.front import ParetoFront
from vibrocap.design.optimise import Optimum
from vibrocap.design.search.goal import INFEASIBLE
from vibrocap.plotting.look.colours import BLUE, GREY
from vibrocap.plotting.look.labels import bracketed
from vibrocap.plotting.look.style import drawing, legend_below, new_figure

FRONT = {"markersize": 4.0, "linewidth": 0.8, "zorder": 2}  # a staircase: nothing lies between two designs
SAME = 1e-3  # relative: a design of the front as it was before its motion was closed to rounding
MOST_OTHERS = 20_000  # designs that are drawn behind a front


def front_figure(found: ParetoFront) -> Figure:
    """The front, and behind it all designs that were evaluated and allowed."""
    with new_figure((6.2, 4.2)) as fig:
        fig.legend(handles=_draw(fig.subplots(), found), loc="outside lower center", ncols=2)
    return fig


def draw_front(found: ParetoFront, *, ax: Axes | None = None) -> Axes:
    """The panel of `front_figure`."""
    with drawing(ax) as ax:
        legend_below(ax, _draw(ax, found), ncols=2)
    return ax


def _draw(ax: Axes, found: ParetoFront) -> list[Line2D]:
    """Draw the front and what is near it; the handles of the legend."""
    others = found.others()[:MOST_OTHERS]
    ax.plot(others[:, 0], others[:, 1], ".", color=GREY, markersize=1.6, rasterized=True, zorder=1)
    ax.plot(found.values[:, 0], found.values[:, 1], ".-", drawstyle="steps-post", color=BLUE, **FRONT)
    if len(found):  # all of the front, and as much beside it
        for low, high, keep in zip(found.values.min(0), found.values.max(0), (ax.set_xlim, ax.set_ylim), strict=True):
            room = 0.6 * (high - low) or 0.1 * abs(high) or 1.0
            keep(low - room, high + room)
    for name, unit, keep in zip(found.measures, found.units, (ax.set_xlabel, ax.set_ylabel), strict=True):
        keep(name.replace("_", " ") + bracketed(unit))
    ax.set_title("Pareto front")
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    seen = others[(others[:, 0] > left) & (others[:, 0] < right) & (others[:, 1] > low) & (others[:, 1] < high)]
    alike = np.all(np.isclose(seen[:, None], found.values[None], rtol=SAME, atol=0.0), axis=2)
    motions = f"{len(found)} stable motion{'s' * (len(found) != 1)}"
    handles = [Line2D([], [], color=BLUE, marker=".", linewidth=0.8, label=f"front ({motions})")]
    if not np.all(np.any(alike, axis=1)):
        handles.append(Line2D([], [], color=GREY, marker=".", linestyle="none", label="other designs"))
    return handles


def search_figure(found: Optimum) -> Figure:
    """The measure of every allowed design in the order of evaluation, and the best so far."""
    cost, sign = found.population.best_cost, 1.0 if found.maximised else -1.0
    merits = np.where(cost < INFEASIBLE, -cost, np.nan) * found.scale
    with new_figure((6.2, 3.2)) as fig:
        ax = fig.subplots()
        ax.plot(np.arange(len(cost)), sign * merits, ".", color=GREY, markersize=1.8, rasterized=True, label="a design")
        best = np.fmax.accumulate(np.where(np.isnan(merits), -np.inf, merits))
        best = np.where(np.isinf(best), np.nan, best)
        ax.plot(np.arange(len(cost)), sign * best, "-", color=BLUE, label="the best so far")
        label = found.measure.replace("_", " ") + bracketed(found.unit or "1")
        ax.set(xlabel="designs evaluated", ylabel=label, title="The search")
        fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return fig
