"""Pictures of searches for designs: the best value over the evaluations."""

import numpy as np
from matplotlib.figure import Figure

from vibrocap.design.optimise import Optimum
from vibrocap.design.search.goal import INFEASIBLE
from vibrocap.plotting.look.colours import BLUE, GREY
from vibrocap.plotting.look.labels import bracketed
from vibrocap.plotting.look.style import figure, style


def search_figure(found: Optimum) -> Figure:
    """The measure of every allowed design in the order of evaluation, and the best so far."""
    fig, axes = figure(1, 1, size=(6.2, 3.2))
    ax, cost = axes[0, 0], found.population.best_cost
    allowed = cost < INFEASIBLE
    merits = np.where(allowed, -cost, np.nan) * found.scale
    sign = 1.0 if found.maximised else -1.0
    with style():
        ax.plot(np.arange(len(cost)), sign * merits, ".", color=GREY, markersize=1.8, rasterized=True, label="a design")
        best = np.fmax.accumulate(np.where(np.isnan(merits), -np.inf, merits))
        best = np.where(np.isinf(best), np.nan, best)
        ax.plot(np.arange(len(cost)), sign * best, "-", color=BLUE, label="the best so far")
        label = found.measure.replace("_", " ") + bracketed(found.unit or "1")
        ax.set(xlabel="designs evaluated", ylabel=label, title="The search")
        fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return fig
