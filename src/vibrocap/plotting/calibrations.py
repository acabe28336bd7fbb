"""Picture of a calibration: what was measured and what the case predicts row by row, residuals, intervals."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.calibration import Calibration
from vibrocap.design.search.problem import measure_unit
from vibrocap.plotting.intervals import forest, forest_height, intervals
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.colours import BLUE, GREY, VERMILION
from vibrocap.plotting.look.labels import bracketed
from vibrocap.plotting.look.page import page

MEASURE = 2.9  # inches: a measure with its residuals
HALF = 1.96  # standard errors: half of a 95 % interval


def calibration_figure(calibration: Calibration) -> Figure:
    """Of each measure the rows, measured and predicted, with their residuals below; then the intervals."""
    names, rows = calibration.measured.measures, intervals(calibration)
    heights = (MEASURE * len(names), forest_height(rows))
    with plots.new_figure((page().width_or(9.0), sum(heights) + 0.6)) as fig:
        top, bottom = fig.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        axes = top.subplots(2 * len(names), 1, squeeze=False, sharex=True, height_ratios=[2.0, 1.0] * len(names))[:, 0]
        for name, above, below in zip(names, axes[::2], axes[1::2], strict=True):
            _rows(above, calibration, name)
            plots.legend_above(above)
            _residuals(below, calibration, name)
        axes[-1].set_xlabel("row of the table")
        top.align_ylabels()
        forest(bottom.subplots(), rows)
        held = (
            "" if calibration.held_out_misfit is None else f", of the held-out rows {calibration.held_out_misfit:.3g}"
        )
        plots.heading(fig, f"Calibration: misfit {calibration.misfit:.3g}{held}")
        untrusted = [f"Row {', '.join(map(str, rows))}: {why}." for why, rows in calibration.rows_not_trusted.items()]
        known = "" if calibration.measured.with_errors else " (estimated from the misfit)"
        errors = f"Residuals in standard errors{known}; bars and bands: 95 %."
        plots.footnote(
            fig,
            " ".join(
                [
                    errors,
                    *untrusted,
                    *(f"Row {row} is an outlier." for row in calibration.rows_outlying),
                    str(calibration.doubt or ""),
                ]
            ),
        )
    return fig


def draw_calibration(calibration: Calibration, measure: str | None = None, *, ax: Axes | None = None) -> Axes:
    """A measure row by row, as it was measured and as the case predicts it.

    measure: of the table, by default its first
    """
    names = calibration.measured.measures
    if measure not in (None, *names):
        raise ArgumentError("measure", f"the table has no {measure!r}; {suggestion(measure, names)}")
    with plots.drawing(ax) as ax:
        _rows(ax, calibration, measure or names[0])
        ax.set_xlabel("row of the table")
        plots.legend(ax)
    return ax


def _rows(ax: Axes, calibration: Calibration, name: str) -> None:
    table = calibration.measured
    rows = np.arange(1, table.rows + 1)
    ax.plot(rows, table.targets[name], "o", color=GREY, markerfacecolor="none", markersize=8.0, label="measured")
    half = HALF * _size(calibration) * table.errors[name]
    ax.vlines(rows, table.targets[name] - half, table.targets[name] + half, color=GREY, linewidth=1.2)
    for label, mark, colour, part in _parts(calibration):
        ax.plot(rows[part], calibration.predicted[name][part], mark, color=colour, markersize=3.5, label=label)
    unit, _ = measure_unit(calibration.system, name)
    ax.set(ylabel=name.replace("_", " ") + bracketed(unit), xlim=(0.4, table.rows + 0.6))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))


def _residuals(ax: Axes, calibration: Calibration, name: str) -> None:
    """Measured less predicted, in standard errors, with the band within which 95 % of them should be."""
    rows = np.arange(1, calibration.measured.rows + 1)
    ax.axhspan(-HALF, HALF, color=GREY, alpha=0.2, linewidth=0)
    ax.axhline(0.0, color="#444444", linewidth=0.6)
    for _, mark, colour, part in _parts(calibration):
        left = calibration.residuals[name][part] / _size(calibration)
        ax.vlines(rows[part], 0.0, left, color=colour, linewidth=0.9)
        ax.plot(rows[part], left, mark, color=colour, markersize=3.5)
    ax.set_ylabel("residual")


def _parts(calibration: Calibration) -> list[tuple[Any, ...]]:
    """(label, mark, colour, rows) of what was fitted and of what was held out, where there is such."""
    held = np.isin(np.arange(calibration.measured.rows), calibration.held_out)
    parts = (("fitted", "D", BLUE, ~held), ("predicted (held out)", "s", VERMILION, held))
    return [part for part in parts if part[-1].any()]


def _size(calibration: Calibration) -> float:
    """Size of an error over what the table has: its own where errors were given."""
    return 1.0 if calibration.measured.with_errors else float(np.sqrt(calibration.misfit))
