"""Pictures of designs: a Pareto front, each point a design, the search, and cases fitted to a table or to motions."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.design.calibration.calibration import Calibration
from vibrocap.design.calibration.motion_fit import MotionFit
from vibrocap.design.front import ParetoFront
from vibrocap.design.optimise import Optimum
from vibrocap.design.search.problem import INFEASIBLE, measure_unit
from vibrocap.plotting.intervals import forest, forest_height, intervals
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import bracketed, percent
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLUE, GREY, VERMILION

FRONT = {"markersize": 4.0, "linewidth": 0.8, "zorder": 2}  # a staircase: nothing lies between two designs
SAME = 1e-3  # relative: a design of the front as it was before its motion was closed to rounding
MOST_OTHERS = 20_000  # designs that are drawn behind a front


def front_figure(front: ParetoFront) -> Figure:
    """The front, and behind it all designs that were evaluated and allowed."""
    with plots.new_figure((6.2, 4.2)) as fig:
        fig.legend(handles=_draw(fig.subplots(), front), loc="outside lower center", ncols=2)
    return fig


def draw_front(front: ParetoFront, *, ax: Axes | None = None) -> Axes:
    """The panel of `front_figure`."""
    with plots.drawing(ax) as ax:
        plots.legend_below(ax, _draw(ax, front), ncols=2)
    return ax


def _draw(ax: Axes, front: ParetoFront) -> list[Line2D]:
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
    with plots.new_figure((6.2, 3.2)) as fig:
        ax = fig.subplots()
        ax.plot(np.arange(len(cost)), sign * merits, ".", color=GREY, markersize=1.8, rasterized=True, label="a design")
        best = np.fmax.accumulate(np.where(np.isnan(merits), -np.inf, merits))
        best = np.where(np.isinf(best), np.nan, best)
        ax.plot(np.arange(len(cost)), sign * best, "-", color=BLUE, label="the best so far")
        label = optimum.measure.replace("_", " ") + bracketed(optimum.unit or "1")
        ax.set(xlabel="designs evaluated", ylabel=label, title="The search")
        fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return fig


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
        held, out = "", calibration.held_out_misfit
        if out is not None:
            held = f", of the held-out rows {out:.3g}"
        plots.heading(fig, f"Calibration: misfit {calibration.misfit:.3g}{held}")
        untrusted = [f"Row {', '.join(map(str, rows))}: {why}." for why, rows in calibration.rows_not_trusted.items()]
        known = "" if calibration.measured.with_errors else " (estimated from the misfit)"
        errors = f"Residuals in standard errors{known}; bars and bands: 95 %."
        outlying = [f"Row {row} is an outlier." for row in calibration.rows_outlying]
        plots.footnote(fig, " ".join([errors, *untrusted, *outlying, str(calibration.doubt or "")]))
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


ROW = 2.6  # inches: a record with its errors
MOST_RECORDS = 6  # of one sheet
MOST_POINTS = 6000  # of a line


def motion_fit_figure(fit: MotionFit) -> Figure:
    """A row for each record: measured and predicted over time with the 95 % band, and below them the errors."""
    names = sorted(fit.measured, key=lambda name: name not in fit.held_out)[:MOST_RECORDS]
    unit, seconds = ("", "") if fit.unit == "1" else (f" ({fit.unit})", " (s)")
    with plots.new_figure((page().width_or(9.0), ROW * len(names) + 0.6)) as fig:
        axes = fig.subplots(2 * len(names), 1, squeeze=False, height_ratios=[2.0, 1.0] * len(names))[:, 0]
        for k, name in enumerate(names):
            above, below = axes[2 * k : 2 * k + 2]
            below.sharex(above)
            kept = slice(None, None, -(-len(fit.time[name]) // MOST_POINTS))
            columns = (fit.time, fit.measured, fit.predicted, fit.band)
            time, measured, predicted, band = (column[name][kept] for column in columns)
            colour, label = (VERMILION, "predicted (held out)") if name in fit.held_out else (BLUE, "fitted")
            above.plot(time, measured, color=GREY, linewidth=1.6, label="measured")
            above.plot(time, predicted, color=colour, linewidth=1.0, label=label)
            above.fill_between(time, predicted - band, predicted + band, color=colour, alpha=0.2, linewidth=0)
            above.set_ylabel(f"{fit.predict.replace('_', ' ')}{unit}")
            left = fit.not_trusted.get(name) or f"error {percent(fit.relative[name])} of the motion"
            above.set_title(f"{name}: {left}", loc="left")
            above.tick_params(labelbottom=False)
            plots.legend_above(above)
            below.fill_between(time, -band, band, color=colour, alpha=0.2, linewidth=0)
            below.plot(time, predicted - measured, color=colour, linewidth=0.8)
            below.set_ylabel(f"error{unit}")
        axes[-1].set_xlabel(f"time{seconds}")
        fig.align_ylabels()
        plots.heading(fig, f"{fit.predict.replace('_', ' ')} under the measured force")
        plots.footnote(fig, ", ".join(f"{parameter.path} {parameter.value:.4g}" for parameter in fit.parameters))
    return fig
