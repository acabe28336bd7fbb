"""Pictures of what smoothing a contact costs: error and steps against the width."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes

from vibrocap.laboratory.regularisation import Regularisation, WidthNeeded
from vibrocap.plotting.style import BLACK, BLUE, GREEN, STYLE, VERMILION, figure, legend, save

COLOURS = {"tanh": VERMILION, "arctan": BLUE}
FORMULAS = {"tanh": r"$\tanh(v/\epsilon)$", "arctan": r"$(2/\pi)\,\arctan(v/\epsilon)$"}
WIDTH = r"width of the smoothing $\epsilon$"


def plot_regularisation(reports: Regularisation | Sequence[Regularisation], path: str | Path) -> Path:
    """Error of the measure and steps of the integrator against the width, for one system and one or two shapes."""
    given = [reports] if isinstance(reports, Regularisation) else list(reports)
    if not given:
        raise ValueError("reports should hold at least one regularisation, got none")
    fig, axes = figure(1, 2, size=(9.2, 3.6))
    with matplotlib.rc_context(STYLE):
        draw_errors(axes[0, 0], given)
        draw_steps(axes[0, 1], given)
        for ax in axes[0]:
            legend(ax)
    return save(fig, path)


def draw_errors(ax: Axes, reports: Sequence[Regularisation], needed: Sequence[WidthNeeded] = ()) -> None:
    """Relative error against width; errors within the noise of integration are left out.

    needed: widths for wanted errors, drawn as dotted guides
    """
    for report in reports:
        known = np.abs(report.errors) > report.noise
        share = np.abs(report.relative_errors)
        colour = COLOURS[report.shape]
        ax.loglog(report.widths[known], share[known], color=colour, linewidth=1.4)
        for sign, face, words in ((-1.0, colour, "too small"), (1.0, "white", "too large")):
            chosen = known & (np.sign(report.errors) == sign)
            if chosen.any():
                ax.loglog(
                    report.widths[chosen], share[chosen], "o", color=colour, markersize=4, markerfacecolor=face,
                    label=f"{FORMULAS[report.shape]}: {words}",
                )  # fmt: skip
    for found in needed:
        if found.width is not None:
            share = found.error / abs(found.regularisation.exact.value)
            guide = {"color": "#808080", "linewidth": 0.8, "linestyle": ":", "zorder": 1}
            ax.plot([found.width, found.width], [ax.get_ylim()[0], share], **guide)
            ax.plot([ax.get_xlim()[0], found.width], [share, share], **guide)
    name = reports[0].measure.replace("_", " ")
    ax.set(title=f"Error of the {name}", xlabel=WIDTH, ylabel="error over the exact value")


def draw_steps(ax: Axes, reports: Sequence[Regularisation]) -> None:
    """Steps of the integrator against width, and of the run with the contact solved exactly."""
    for report in reports:
        label = f"{FORMULAS[report.shape]}, this package"
        ax.loglog(report.widths, report.steps, "o-", color=COLOURS[report.shape], markersize=4, label=label)
    exact = reports[0].exact.steps
    ax.axhline(exact, color=GREEN, linewidth=2.0, label="exact contact, this package", zorder=1)
    ax.annotate(
        f"{exact:,}", (reports[0].widths.max(), exact), (0, -4), textcoords="offset points", ha="right", va="top",
        color=BLACK, fontsize=8,
    )  # fmt: skip
    ax.set(title="Steps for the whole run", xlabel=WIDTH, ylabel="steps")
