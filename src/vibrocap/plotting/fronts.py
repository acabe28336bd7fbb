"""Pictures of searches for designs: a Pareto front, each point a design, and the best value over the evaluations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrocap.design.front import ParetoFront
from vibrocap.design.optimise import Optimum
from vibrocap.design.search.problem import INFEASIBLE
from vibrocap.plotting.look.colours import BLUE, GREY
from vibrocap.plotting.look.labels import bracketed
from vibrocap.plotting.look.style import drawing, legend_below, new_figure

FRONT = {"markersize": 4.0, "linewidth": 0.8, "zorder": 2}  # a staircase: nothing lies between two designs
SAME = 1e-3  # relative: a design of the front as it was before its motion was closed to rounding
MOST_OTHERS = 20_000  # designs that are drawn behind a front


def front_figure(front: ParetoFront) -> Figure:
    """The front, and behind it all designs that were evaluated and allowed."""
    with new_figure((6.2, 4.2)) as fig:
        fig.legend(handles=_draw(fig.subplots(), front), loc="outside lower center", ncols=2)
    return fig


def draw_front(front: ParetoFront, *, ax: Axes | None = None) -> Axes:
    """The panel of `front_figure`."""
    with drawing(ax) as ax:
        legend_below(ax, _draw(ax, front), ncols=2)
    return ax


def _draw(ax: Axes, front: ParetoFront) -> list[Line2D]:
    """Draw the front and what is near it; the handles of the legend."""
    others = front.others()[:MOST_OTHERS]
    ax.plot(others[:, 0], others[:, 1], ".", color=GREY, markersize=1.6, rasterized=True, zorder=1)
    ax.plot(front.values[:, 0], front.values[:, 1], ".-", drawstyle="steps-post", color=BLUE, **FRONT)
    if len(front):  # all of the front, and of the other designs as much beside it
        shown = np.concatenate([front.values, others])
        for own, column, keep in zip(front.values.T, shown.T, (ax.set_xlim, ax.set_ylim), strict=True):
            room = 0.6 * np.ptp(own) or 0.1 * abs(own[0]) or 1.0
            near = column[(column >= own.min() - room) & (column <= own.max() + room)]
            margin = 0.05 * np.ptp(near) or room
            keep(near.min() - margin, near.max() + margin)
    for name, unit, keep in zip(front.measures, front.units, (ax.set_xlabel, ax.set_ylabel), strict=True):
        keep(name.replace("_", " ") + bracketed(unit))
    ax.set_title("Pareto front")
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    inside = others[(others[:, 0] > left) & (others[:, 0] < right) & (others[:, 1] > low) & (others[:, 1] < high)]
    alike = np.all(np.isclose(inside[:, None], front.values[None], rtol=SAME, atol=0.0), axis=2)
    motions = f"{len(front)} stable motion{'s' * (len(front) != 1)}"
    handles = [Line2D([], [], color=BLUE, marker=".", linewidth=0.8, label=f"front ({motions})")]
    if not np.all(np.any(alike, axis=1)):
        handles.append(Line2D([], [], color=GREY, marker=".", linestyle="none", label="other designs"))
    return handles


def search_figure(optimum: Optimum) -> Figure:
    """The measure of every allowed design in the order of evaluation, and the best so far."""
    cost, sign = optimum.population.best_cost, 1.0 if optimum.maximised else -1.0
    merits = np.where(cost < INFEASIBLE, -cost, np.nan) * optimum.scale
    with new_figure((6.2, 3.2)) as fig:
        ax = fig.subplots()
        ax.plot(np.arange(len(cost)), sign * merits, ".", color=GREY, markersize=1.8, rasterized=True, label="a design")
        best = np.fmax.accumulate(np.where(np.isnan(merits), -np.inf, merits))
        best = np.where(np.isinf(best), np.nan, best)
        ax.plot(np.arange(len(cost)), sign * best, "-", color=BLUE, label="the best so far")
        label = optimum.measure.replace("_", " ") + bracketed(optimum.unit or "1")
        ax.set(xlabel="designs evaluated", ylabel=label, title="The search")
        fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return fig
