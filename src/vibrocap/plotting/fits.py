"""Pictures of fits: measured and fitted force, loops, residuals; laws compared, and laws matched."""

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.identification.experiments.comparison import Comparison, Match
from vibrocap.identification.fit_result import Fit, MeasuredUnits, RecordResult
from vibrocap.plotting.intervals import forest, forest_height, intervals
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import law_words, percent, whole
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLUE, GREY, VERMILION

MOST_RECORDS, MOST_IN_COLUMN = 6, 3  # of one sheet
HISTORY, LOOPS = 25, 8  # periods of the motion that are shown over time, and as loops
MOST_POINTS = 6000  # of a line
BINS = 60
PRINTED = 1.6  # inches: the height of a row of panels on a page
MEASURED = {"color": GREY, "linewidth": 1.6, "label": "measured"}
FITTED = {"color": BLUE, "linewidth": 1.0, "label": "fitted"}
HELD_OUT = {"color": VERMILION, "linewidth": 1.0, "label": "predicted (held out)"}
TARGET = {"color": GREY, "linewidth": 2.0}
MATCHED = {"color": BLUE, "linewidth": 1.1}
DIFFERENCE = {"color": VERMILION, "linewidth": 1.0}


def fit_figure(fit: Fit) -> Figure:
    """A row for each record, force over time, displacement and velocity; below, the intervals of the parameters."""
    shown = _chosen(fit.records)
    searched = intervals(fit)
    method = fit.options.get("method", "")
    steady = method.startswith("steady")  # samples at rest are left out: no loops
    # the load point's velocity through a spring is made of noise, and its loops tell nothing
    loops = 0 if steady else 1 if method.endswith("spring") else 2
    stacked = page().narrow and loops > 0
    heights = (_row_height(1 + stacked) * len(shown) + 0.25, forest_height(searched))
    with plots.new_figure((page().width_or(11.0), sum(heights) + 0.5)) as fig:
        top, bottom = fig.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        rows = _rows(top, len(shown), loops, stacked)
        for axes, record in zip(rows, shown, strict=True):
            if steady:
                _curve(axes[0], record, fit.units)
            else:
                _history(axes, record, fit.units)
        top.align_ylabels()
        handles = {h.get_label(): h for axes in rows for h in axes[0].get_lines()}
        top.legend(handles=list(handles.values()), loc=_beside_heading(), ncols=3, frameon=False)
        forest(bottom.subplots(), searched)
        held = "" if math.isnan(fit.held_out_relative_rmse) else f", held out {percent(fit.held_out_relative_rmse)}"
        error = f"error {percent(fit.relative_rmse)} of the {fit.units.force_name}'s standard deviation{held}"
        plots.heading(fig, f"{law_words(fit.law_name)}: {error}")
        plots.footnote(fig, _small_print(fit, shown))
    return fig


def residual_figure(fit: Fit) -> Figure:
    """A row for each record: error over time, against velocity, and its distribution beside the normal one."""
    shown, stacked = _chosen(fit.records), page().narrow
    with plots.new_figure((page().width_or(11.0), _row_height(1 + stacked) * len(shown) + 0.7)) as fig:
        rows = _rows(fig, len(shown), 2, stacked)
        for (left, middle, right), record in zip(rows, shown, strict=True):
            error = record.predicted - record.measured
            scale, error_label = _labelled(error, "error", fit.units.force)
            error = error / scale
            colour = _style(record)["color"]
            speed_scale, speed_label = _labelled(record.velocity, fit.units.velocity_name, fit.units.velocity)
            at = _even_choice(len(error), MOST_POINTS)
            time, envelope = plots.decimated(record.time, error, MOST_POINTS)
            left.plot(time, envelope, color=colour, linewidth=0.6)
            left.axhline(0.0, color="#444444", linewidth=0.6)
            left.set(xlabel="time [s]", ylabel=error_label, title=_title(record))
            middle.plot(record.velocity[at] / speed_scale, error[at], ".", color=colour, markersize=1.2, alpha=0.5)
            middle.axhline(0.0, color="#444444", linewidth=0.6)
            middle.set(xlabel=speed_label, ylabel=error_label)
            width = float(np.std(error)) or 1.0
            count, edges, _ = right.hist(error, bins=BINS, color=colour, alpha=0.45, linewidth=0, label="errors")
            x = np.linspace(edges[0], edges[-1], 200)
            normal = np.exp(-0.5 * ((x - np.mean(error)) / width) ** 2) / (width * math.sqrt(2 * math.pi))
            right.plot(x, normal * float(np.sum(count)) * (edges[1] - edges[0]), color="#000000", linewidth=0.9)
            right.set(xlabel=error_label, ylabel="samples")
        fig.align_ylabels()
        plots.heading(fig, f"{law_words(fit.law_name)}: fitted less measured {fit.units.force_name}")
        sentences = " ".join(fit.residuals.sentences()) if fit.residuals is not None else ""
        text = f"Lines on the right: normal distribution. {_left_out(fit, shown)} {sentences}".replace("  ", " ")
        plots.footnote(fig, textwrap.fill(text, 190))
    return fig


def _rows(fig: Any, count: int, narrow: int, stacked: bool) -> list[list[Axes]]:
    """The axes of so many records: of each one that is wide, and the narrow ones beside it, or below it.

    stacked: whether they stand below, as in a column
    """
    if stacked:
        grid = fig.add_gridspec(2 * count, narrow)
        places = [[grid[2 * k, :], *(grid[2 * k + 1, i] for i in range(narrow))] for k in range(count)]
    else:
        grid = fig.add_gridspec(count, 1 + narrow, width_ratios=(2,) + (1,) * narrow)
        places = [[grid[k, i] for i in range(1 + narrow)] for k in range(count)]
    return [[fig.add_subplot(cell) for cell in row] for row in places]


def _row_height(rows: int) -> float:
    """The height of the panels of a record that stand in so many rows, in inches."""
    return 2.15 if page().width is None else PRINTED * rows


def _beside_heading() -> Any:
    """Where a legend stands: beside the heading, or below where that takes all the room of a column."""
    return "outside lower left" if page().narrow else "outside upper right"


def comparison_figure(comparison: Comparison) -> Figure:
    """Laws from the best down: the error where they were not fitted, and where they were."""
    laws = [law for law in comparison.laws if law.fit.ok]
    with plots.new_figure((page().width_or(7.0), 1.3 + 0.34 * len(laws))) as fig:
        ax = fig.subplots()
        places = np.arange(len(laws))[::-1]
        held, fitted = (100 * np.array([getattr(x, name) for x in laws]) for name in ("held_out", "relative_rmse"))
        ax.hlines(places, np.fmin(held, fitted), np.fmax(held, fitted), color="#C8C8C8", linewidth=1.5)
        ax.plot(held, places, "D", color=VERMILION, markersize=4, label="held out")
        ax.plot(fitted, places, "o", color=BLUE, markersize=8, markerfacecolor="none", label="fitted to all records")
        ax.set_yticks(places, [f"{law.law} ({law.parameters})" for law in laws])
        ax.set(
            xlabel="error over the standard deviation of the force [%]", xlim=(0.0, 1.05 * np.nanmax((held, fitted)))
        )
        ax.set_ylim(-0.6, len(laws) - 0.4)
        fig.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
        plots.footnote(fig, f"Held out: {comparison.method}. In brackets: number of searched parameters.")
    return fig


def _history(axes: list[Axes], record: RecordResult, units: MeasuredUnits) -> None:
    """Force over time, and over displacement and velocity in a shorter stretch, whose loops can be told apart."""
    wide, narrow = _stretch(record, HISTORY), _stretch(record, LOOPS)
    _over_time(axes[0], record, units)
    steps = 0.5 * (record.velocity[1:] + record.velocity[:-1]) * np.diff(record.time)
    displacement = np.concatenate(([0.0], np.cumsum(steps)))
    part = displacement[narrow]
    displacement = displacement - 0.5 * (part.max() + part.min())
    columns = (
        (displacement, *_labelled(displacement[narrow], units.displacement_name, units.displacement)),
        (record.velocity, *_labelled(record.velocity[narrow], units.velocity_name, units.velocity)),
    )
    for ax, (x, factor, label) in zip(axes[1:], columns, strict=False):
        _forces(ax, record, x / factor, narrow, units)
        ax.set_xlabel(label)
    axes[1].set_title(_part(record, narrow).removeprefix(", ") if narrow != wide else "")


def _over_time(ax: Axes, record: RecordResult, units: MeasuredUnits) -> None:
    wide = _stretch(record, HISTORY)
    _forces(ax, record, record.time, wide, units)
    ax.set(xlabel="time [s]", title=_title(record) + _part(record, wide))


def _forces(ax: Axes, record: RecordResult, x: np.ndarray, stretch: slice, units: MeasuredUnits) -> None:
    scale, force_label = _labelled(record.measured, units.force_name, units.force)
    at = np.arange(len(record.time))[stretch]
    at = at[_even_choice(len(at), MOST_POINTS)]
    for force, look in ((record.measured, MEASURED), (record.predicted, _style(record))):
        ax.plot(x[at], force[at] / scale, **look)
    ax.set_ylabel(force_label)


def _curve(ax: Axes, record: RecordResult, units: MeasuredUnits) -> None:
    scale, force = _labelled(record.measured, units.force_name, units.force)
    speed_scale, speed = _labelled(record.velocity, units.velocity_name, units.velocity)
    order = np.argsort(record.velocity)
    at = order[_even_choice(len(order), MOST_POINTS)]
    v = record.velocity[at] / speed_scale
    ax.plot(v, record.measured[at] / scale, ".", markersize=2, color=MEASURED["color"], label=MEASURED["label"])
    for side in (v < 0, v > 0):
        ax.plot(v[side], record.predicted[at][side] / scale, **_style(record))
    ax.set(xlabel=speed, ylabel=force, title=_title(record))


def draw_forces(fit: Fit, record: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Measured and predicted force of a record over time.

    record: the name of one of the fit's, by default the first
    """
    names = [record.name for record in fit.records]
    if not names or record not in (None, *names):
        raise ArgumentError("record", f"the fit has no {record!r}; {suggestion(record, names)}")
    forces = fit.records[0 if record is None else names.index(record)]
    with plots.drawing(ax) as ax:
        (_curve if fit.options.get("method", "").startswith("steady") else _over_time)(ax, forces, fit.units)
        plots.legend(ax, ncols=2)
    return ax


def _chosen(records: tuple[RecordResult, ...]) -> list[RecordResult]:
    """The records of a sheet: where they are too many, the first fitted and the first held-out ones."""
    most = MOST_IN_COLUMN if page().narrow else MOST_RECORDS
    if len(records) <= most:
        return list(records)
    held = [record for record in records if record.held_out][: most // 2]
    return [record for record in records if not record.held_out][: most - len(held)] + held


def _left_out(fit: Fit, shown: list[RecordResult]) -> str:
    missing = len(fit.records) - len(shown)
    return f"{missing} more record{'s' * (missing != 1)} not drawn." if missing else ""


def _small_print(fit: Fit, shown: list[RecordResult]) -> str:
    text = f"Percentages: root mean square error over the standard deviation of the measured {fit.units.force_name}. "
    if not fit.options.get("method", "").startswith("steady"):
        text += f"{fit.units.displacement_name.capitalize()}: about the middle of the range shown. "
    if fit.limits:
        text += "At limits: " + "; ".join(limit.text for limit in fit.limits) + ". "
    return text + _left_out(fit, shown)


def _title(record: RecordResult) -> str:
    return f"{record.name}: {percent(record.relative_rmse)}" + (", held out" if record.held_out else "")


def _style(record: RecordResult) -> dict:
    return HELD_OUT if record.held_out else FITTED


def _stretch(record: RecordResult, most: int) -> slice:
    """Samples of at most so many periods of the motion, around its fastest."""
    time, velocity = record.time, record.velocity
    even = np.linspace(time[0], time[-1], min(len(time), 1 << 16))
    spectrum = np.abs(np.fft.rfft(np.interp(even, time, velocity - velocity.mean())))
    periods = max(int(np.argmax(spectrum)), 1)
    if periods <= most:
        return slice(0, len(time))
    half = 0.5 * most * (time[-1] - time[0]) / periods
    middle = min(max(float(time[int(np.argmax(np.abs(velocity)))]), time[0] + half), time[-1] - half)
    begin, end = (int(place) for place in np.searchsorted(time, (middle - half, middle + half)))
    return slice(begin, max(end, begin + 2))


def _part(record: RecordResult, stretch: slice) -> str:
    """Which part of a record a stretch is, where it is not the whole."""
    if stretch == slice(0, len(record.time)):
        return ""
    return f", {record.time[stretch.start]:.3g} to {record.time[stretch.stop - 1]:.3g} s"


def _labelled(values: np.ndarray, name: str, unit: str) -> tuple[float, str]:
    """The factor of the unit that suits the values, and the label of their axis."""
    factor, prefix = plots.unit_of(values)
    return factor, f"{name} [{prefix}{whole(unit)}]"


def _even_choice(count: int, most: int) -> np.ndarray:
    """Places of at most `most` of `count` samples, evenly chosen."""
    return np.arange(count) if count <= most else np.linspace(0, count - 1, most).astype(int)


def match_figure(match: Match) -> Figure:
    """Force over velocity, and over time where a motion was matched; below, matched less target."""
    driven = len(match.time) > 0
    columns = [(match.velocity, "velocity")]
    if driven:
        columns = [(match.time, "time"), *columns]
    stacked = driven and page().narrow
    with plots.new_figure(
        (page().width_or(9.5 if driven else 6.0), 3.4 * (1 + stacked) if page().width else 4.6)
    ) as fig:
        shape: dict[str, Any] = {"width_ratios": (2, 1)} if driven and not stacked else {}
        parts = fig.subfigures(*((2, 1) if stacked else (1, len(columns))), squeeze=False, **shape).ravel()
        for part, (x, label) in zip(parts, columns, strict=True):
            upper, lower = part.subplots(2, 1, sharex=True, height_ratios=(2, 1))
            upper.plot(x, match.target, label=f"{law_words(match.to.name)}, the target", **TARGET)
            upper.plot(x, match.matched, label=f"{law_words(match.law.name)}, matched", **MATCHED)
            lower.plot(x, match.matched - match.target, **DIFFERENCE)
            lower.axhline(0.0, color="#444444", linewidth=0.6)
            upper.set_ylabel("force")
            lower.set(xlabel=label, ylabel="matched less target")
            if not driven and np.min(x) > 0 and np.max(x) > 30 * np.min(x):
                lower.set_xscale("log")
            else:
                lower.xaxis.set_major_locator(MaxNLocator(6 if part is parts[0] else 4))
            part.align_ylabels()
        if driven:  # above, for loops leave no room within
            lines = parts[0].axes[0].get_lines()
            (parts[-1] if page().narrow else fig).legend(handles=lines, loc=_beside_heading(), ncols=2, frameon=False)
        else:
            plots.legend(parts[0].axes[0])
        names = law_words(match.law.name), law_words(match.to.name, first=False)
        plots.heading(fig, f"{' for '.join(names)}: {percent(match.relative_rmse)} remain")
        plots.footnote(
            fig, f"Matched over {match.over}. Percentage: root mean square difference over that of the target."
        )
    return fig
