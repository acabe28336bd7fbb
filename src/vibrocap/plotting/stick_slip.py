"""Pictures of stick-slip records: force with its phases and levels, periods, and the diagram of regimes."""

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from vibrocap.records.regimes import INERTIAL, SLOW, STEADY, STICK_SLIP
from vibrocap.records.stick_slip import RegimeDiagram, StickSlip

DETAIL_PERIODS = 5  # in the detail beside the whole record
MOST_BINS = 40
PRINTED = 1.7  # inches: the height of a panel in a column
CROWD = 80  # slips; more have smaller marks
MOST_POINTS = 4000  # of a line: longer records are drawn by the extremes of as many stretches
MARKS = {STICK_SLIP: ("o", BLUE), INERTIAL: ("^", VERMILION), STEADY: ("s", GREEN), SLOW: ("D", ORANGE)}


def stick_slip_figure(analysis: StickSlip) -> Figure:
    """The whole record above; below a detail with its phases and levels, the slider's velocity there, the periods."""
    moves, periods = analysis.velocity is not None, np.diff([slip.start for slip in analysis.main_slips])
    counted = len(periods) > 1
    heights = [1.6, 1.0 + moves, 1.4][: 2 + counted]
    narrow_height = PRINTED * sum(heights)
    with plots.new_figure(
        (page().width_or(10.0), narrow_height if page().narrow else page().width_or(10.0) * 0.74)
    ) as fig:
        if page().narrow or not counted:
            top, left, *others = fig.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
        else:
            top, bottom = fig.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.35))[:, 0]
            left, *others = bottom.subfigures(1, 2, squeeze=False, width_ratios=(1.65, 1.0))[0]
        _whole(top.subplots(), analysis)
        window = _detail_window(analysis)
        if not moves:
            _detail(left.subplots(), analysis, window)
        else:
            axes = left.subplots(2, 1, sharex=True, height_ratios=(1.5, 1.0))
            _detail(axes[0], analysis, window)
            _velocity(axes[1], analysis, window)
            axes[0].set_xlabel("")
            left.align_ylabels()
        for part in others:
            _periods(part.subplots(), analysis, periods)
        plots.heading(fig, f"{analysis.name}: {analysis.regime.name}")
        reason = analysis.regime.reason
        plots.footnote(fig, textwrap.fill(f"{reason[:1].upper()}{reason[1:]}.", 150))
    return fig


def regime_figure(diagram: RegimeDiagram) -> Figure:
    """Records as marks over stiffness and pulling speed; form and colour are the regime, the number P/T0."""
    with plots.new_figure((page().width_or(6.4), min(page().width_or(6.4), 6.4) * 0.72 + 0.4 * page().narrow)) as fig:
        ax = fig.subplots()
        ax.set(xscale="log", yscale="log", xlabel="stiffness k [N/m]", ylabel="pulling speed V [m/s]")
        for regime, (mark, colour) in MARKS.items():
            at = np.array([kind == regime for kind in diagram.regimes])
            if at.any():
                ax.plot(
                    diagram.stiffness[at], diagram.pulling_speed[at], mark, color=colour, markersize=9,
                    markeredgecolor="white", markeredgewidth=0.6, linestyle="none", label=f"{regime} ({at.sum()})",
                )  # fmt: skip
        for k, v, ratio in zip(diagram.stiffness, diagram.pulling_speed, diagram.period_ratio, strict=True):
            if np.isfinite(ratio):
                ax.annotate(
                    f"{ratio:.3g}", (k, v), (7, 0), textcoords="offset points", va="center", fontsize=plots.letters(8)
                )
        ax.margins(0.22)
        if np.isfinite(diagram.border):
            (low, high), heights = ax.get_xlim(), ax.get_ylim()
            k = np.geomspace(low, high, 50)
            ax.plot(
                k, diagram.border / np.sqrt(k), color=BLACK, linewidth=0.9, linestyle=(0, (5, 3)),
                label="a Coulomb block sticks half of the time",
            )  # fmt: skip
            ax.set(xlim=(low, high), ylim=heights)
        for name in "xy":
            plots.logarithmic(ax, name)
        fig.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
        plots.footnote(fig, r"Beside each mark: period over $2\pi\sqrt{m/k}$, where the mass is known.")
    return fig


def _whole(ax: Axes, analysis: StickSlip) -> None:
    x, y = plots.decimated(analysis.time, analysis.force, MOST_POINTS)
    ax.plot(x, y, color="#5A5A5A", linewidth=0.5)
    minor = tuple(slip for slip in analysis.slips if slip.minor)
    size = 0.8 if len(analysis.slips) <= CROWD else 0.4
    for slips, face, name in ((analysis.main_slips, VERMILION, "slip"), (minor, "white", "minor slip")):
        if slips:
            where = [slip.start for slip in slips]
            ax.plot(
                where, [slip.start_force for slip in slips], "v", color=VERMILION, markerfacecolor=face,
                markersize=5 * size, markeredgewidth=size, label=f"{name} ({len(slips)})",
            )  # fmt: skip
    _levels(ax, analysis)
    window = _detail_window(analysis)
    if window[1] - window[0] < 0.99 * (analysis.time[-1] - analysis.time[0]):
        ax.axvspan(*window, color=BLUE, alpha=0.10, linewidth=0, label="detail below")
    ax.set(xlabel="time [s]", ylabel=_force_label(analysis), title="The record")
    handles = ax.get_legend_handles_labels()[0]
    if handles and page().width is None:
        plots.legend(ax, loc="center left", bbox_to_anchor=(1.005, 0.5))
    elif handles:
        plots.legend_below(ax, handles, ncols=2 if page().narrow else 3)


def _detail(ax: Axes, analysis: StickSlip, window: tuple[float, float]) -> None:
    kept = (analysis.time >= window[0]) & (analysis.time <= window[1])
    ax.plot(analysis.time[kept], analysis.force[kept], color="#5A5A5A", linewidth=0.7)
    _shade(ax, analysis, window)
    for phase in analysis.phases:
        if phase.kind == "slip" and phase.start >= window[0] and phase.end <= window[1]:
            ax.plot(
                (phase.start, phase.end), (phase.start_force, phase.end_force), "o", color=VERMILION, markersize=3.5,
                markerfacecolor="white" if phase.minor else VERMILION, markeredgewidth=0.8,
            )  # fmt: skip
    title = "Detail: stick phases shaded, start and end of slips" if analysis.phases else "Detail"
    ax.set(xlabel="time [s]", ylabel=_force_label(analysis), title=title, xlim=window)


def _velocity(ax: Axes, analysis: StickSlip, window: tuple[float, float]) -> None:
    assert analysis.velocity is not None
    kept = (analysis.time >= window[0]) & (analysis.time <= window[1])
    scale, prefix = plots.unit_of(analysis.velocity[kept])
    ax.plot(analysis.time[kept], analysis.velocity[kept] / scale, color=BLUE, linewidth=0.7)
    _shade(ax, analysis, window)
    assert analysis.pulling_speed is not None
    ax.axhline(analysis.pulling_speed / scale, color=BLACK, linewidth=0.8, linestyle=(0, (4, 2)))
    ax.set(xlabel="time [s]", ylabel=f"velocity [{prefix}m/s]", title="Slider (pulling speed dashed)", xlim=window)


def _periods(ax: Axes, analysis: StickSlip, periods: np.ndarray) -> None:
    """How often each period occurs, from zero on, so that their spread is seen beside their size."""
    assert analysis.period is not None
    lines: list[tuple[float | None, str, str, Any]] = [
        (analysis.period.mean, f"mean {analysis.period.mean:.4g} s", BLUE, "-"),
        (analysis.period.median, f"median {analysis.period.median:.4g} s", BLUE, (0, (1, 1.5))),
        (analysis.recurrence.spectral_period, "spectrum {:.4g} s", GREEN, (0, (5, 2))),
        (analysis.recurrence.correlation_period, "correlation {:.4g} s", ORANGE, (0, (3, 1, 1, 1))),
        (analysis.regime.inertial_period, r"$2\pi\sqrt{{m/k}}$ = {:.4g} s", VERMILION, (0, (8, 2))),
    ]
    known = [value for value, *_ in lines if value is not None]
    shown = (0.0, 1.05 * max(*known, float(np.max(periods))))
    ax.hist(periods, bins=MOST_BINS, range=shown, color="#BFD9EA", edgecolor="white", linewidth=0.5)
    for value, text, colour, dashes in lines:
        if value is not None:
            ax.axvline(value, color=colour, linestyle=dashes, linewidth=1.2, label=text.format(value))
    ax.set(xlabel="period [s]", ylabel="number of periods", title="Periods", xlim=shown)
    ax.set_ylim(0.0, ax.get_ylim()[1])
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    plots.legend_below(ax, ax.get_legend_handles_labels()[0], ncols=2)


def _levels(ax: Axes, analysis: StickSlip) -> None:
    lines = (
        (analysis.static_level.mean if analysis.static_level else None, "static level", VERMILION, "-"),
        (analysis.kinetic_level, "kinetic level", BLUE, (0, (5, 2))),
        (analysis.slip_end_level.mean if analysis.slip_end_level else None, "level at slip end", GREEN, (0, (1, 1.5))),
    )
    unit = "" if analysis.force_unit == "1" else " N"
    for value, name, colour, dashes in lines:
        if value is not None:
            ax.axhline(value, color=colour, linestyle=dashes, linewidth=1.1, label=f"{name} {value:.4g}{unit}")


def _shade(ax: Axes, analysis: StickSlip, window: tuple[float, float]) -> None:
    for phase in analysis.phases:
        if phase.kind == "stick" and phase.end > window[0] and phase.start < window[1]:
            ax.axvspan(max(phase.start, window[0]), min(phase.end, window[1]), **plots.STICK_SHADE)


def _detail_window(analysis: StickSlip) -> tuple[float, float]:
    """A stretch of some periods around the middle of the record."""
    begin, end = float(analysis.time[0]), float(analysis.time[-1])
    period = analysis.period.mean if analysis.period else (end - begin) / DETAIL_PERIODS
    middle, half = 0.5 * (begin + end), min(0.5 * DETAIL_PERIODS * period, 0.5 * (end - begin))
    return middle - half, middle + half


def _force_label(analysis: StickSlip) -> str:
    return "force over normal force" if analysis.force_unit == "1" else "force [N]"
