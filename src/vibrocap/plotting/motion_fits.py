"""Picture of a fitted motion: what was measured, what the case predicts with its band, and the errors."""

from matplotlib.figure import Figure

from vibrocap.design.calibration.motion_fit import MotionFit
from vibrocap.plotting.look.colours import BLUE, GREY, VERMILION
from vibrocap.plotting.look.labels import percent
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import blank_figure, footnote, heading, legend_above, style

ROW = 2.6  # inches: a record with its errors
MOST_RECORDS = 6  # of one sheet
MOST_POINTS = 6000  # of a line


def motion_fit_figure(fit: MotionFit) -> Figure:
    """A row for each record: measured and predicted over time with the 95 % band, and below them the errors."""
    names = sorted(fit.measured, key=lambda name: name not in fit.held_out)[:MOST_RECORDS]
    fig = blank_figure((page().width_or(9.0), ROW * len(names) + 0.6))
    unit = "" if fit.unit == "1" else f" ({fit.unit})"
    seconds = "" if fit.unit == "1" else " (s)"
    with style():
        axes = fig.subplots(2 * len(names), 1, squeeze=False, height_ratios=[2.0, 1.0] * len(names))[:, 0]
        for k, name in enumerate(names):
            above, below = axes[2 * k : 2 * k + 2]
            below.sharex(above)
            kept = slice(None, None, -(-len(fit.time[name]) // MOST_POINTS))
            time, measured, predicted, band = (
                part[name][kept] for part in (fit.time, fit.measured, fit.predicted, fit.band)
            )
            held = name in fit.held_out
            colour = VERMILION if held else BLUE
            above.plot(time, measured, color=GREY, linewidth=1.6, label="measured")
            above.plot(time, predicted, color=colour, linewidth=1.0, label="predicted (held out)" if held else "fitted")
            above.fill_between(time, predicted - band, predicted + band, color=colour, alpha=0.2, linewidth=0)
            above.set_ylabel(f"{fit.predict.replace('_', ' ')}{unit}")
            left = fit.not_trusted.get(name) or f"error {percent(fit.relative[name])} of the motion"
            above.set_title(f"{name}: {left}", loc="left")
            above.tick_params(labelbottom=False)
            legend_above(above)
            below.fill_between(time, -band, band, color=colour, alpha=0.2, linewidth=0)
            below.plot(time, predicted - measured, color=colour, linewidth=0.8)
            below.set_ylabel(f"error{unit}")
        axes[-1].set_xlabel(f"time{seconds}")
        fig.align_ylabels()
        heading(fig, f"{fit.predict.replace('_', ' ')} under the measured force")
        footnote(fig, ", ".join(f"{parameter.path} {parameter.value:.4g}" for parameter in fit.parameters))
    return fig
