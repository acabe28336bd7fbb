"""Pictures of matched laws: both forces, and below them the difference that remains."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibrocap.identification.experiments.match import Match
from vibrocap.plotting.style import BLUE, STYLE, VERMILION, blank_figure, footnote, save

TARGET = {"color": "#8C8C8C", "linewidth": 2.0}
MATCHED = {"color": BLUE, "linewidth": 1.1}
DIFFERENCE = {"color": VERMILION, "linewidth": 1.0}


def plot_match(match: Match, path: str | Path) -> Path:
    """Draw a match into a file (.png, .svg or .pdf)."""
    return save(match_figure(match), path)


def match_figure(match: Match) -> Figure:
    """Force over velocity, and over time where a motion was matched; below, matched less target."""
    driven = len(match.time) > 0
    columns = [(match.velocity, "velocity")]
    if driven:
        columns = [(match.time, "time"), *columns]
    fig = blank_figure((9.5 if driven else 6.0, 4.6))
    with matplotlib.rc_context(STYLE):
        axes = fig.subplots(
            2, len(columns), squeeze=False, sharex="col", height_ratios=(2, 1), width_ratios=(2, 1) if driven else None
        )
        for (upper, lower), (x, label) in zip(axes.T, columns, strict=True):
            upper.plot(x, match.target, label=f"{match.to.name}, the target", **TARGET)
            upper.plot(x, match.matched, label=f"{match.law.name}, matched", **MATCHED)
            lower.plot(x, match.matched - match.target, **DIFFERENCE)
            lower.axhline(0.0, color="#444444", linewidth=0.6)
            upper.set_ylabel("force")
            lower.set(xlabel=label, ylabel="matched less target")
            if not driven and np.min(x) > 0 and np.max(x) > 30 * np.min(x):
                lower.set_xscale("log")
        fig.align_ylabels()
        if driven:  # beside the title, for loops leave no room within
            lines = axes[0, 0].get_lines()
            fig.legend(handles=lines, loc="outside upper right", ncols=2, frameon=False, fontsize=8.5)
        else:
            axes[0, 0].legend(frameon=False, fontsize=8.5)
        for ax in axes[1]:
            if ax.get_xscale() == "linear":
                ax.xaxis.set_major_locator(MaxNLocator(6 if ax is axes[1, 0] else 4))
        fig.suptitle(
            f"{match.law.name} for {match.to.name}: {match.relative_rmse:.1%} remain",
            fontsize=10.5, x=0.01, ha="left", weight="bold",
        )  # fmt: skip
        footnote(fig, f"Matched over {match.over}. Percentage: root mean square difference over that of the target.")
    return fig
