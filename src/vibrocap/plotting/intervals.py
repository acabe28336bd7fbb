"""Intervals of the parameters of a fit or a calibration, about their values."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes

from vibrocap.design.calibration.calibration import Calibration
from vibrocap.identification.fit_result import Fit, number
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import LETTERS_PER_INCH, filled, whole
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import GREEN, VERMILION

NEGLIGIBLE = 1e-4  # of its larger end: a value that is as good as zero has no place on a logarithmic scale
WIDEST = 10.0  # of a parameter's value: what is shown of an interval


class DrawnInterval(NamedTuple):
    """A parameter with the 95 % interval [low, high]: infinite where it is open, NaN where it is not known."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    verdict: Verdict

    @property
    def firm(self) -> bool:
        """Whether the data determine it."""
        return self.verdict == Verdict.DETERMINED

    @property
    def has_size(self) -> bool:
        """Whether it is more than as good as zero, so that its interval can be seen over it."""
        around = [abs(end) for end in (self.low, self.high) if math.isfinite(end)] if self.low <= 0 <= self.high else []
        return abs(self.value) > NEGLIGIBLE * max(around, default=0.0)

    @property
    def ends(self) -> tuple[float, float]:
        """The ends less the value, over its size."""
        low, high = ((end - self.value) / abs(self.value) for end in (self.low, self.high))
        return low, high

    @property
    def words(self) -> str:
        """Value, interval and verdict, in a column with its name, in lines that fit there."""
        text = f"{number(self.value, 4)} {self.unit.removeprefix('1')}".rstrip()
        if not math.isnan(self.low):
            low, high = (number(end, 4) if math.isfinite(end) else "open" for end in (self.low, self.high))
            text += f"  [{low}, {high}]"
        words = text.replace("-", "\N{MINUS SIGN}") + ("" if self.firm else f"  {self.verdict}")
        letters = round(LETTERS_PER_INCH * page().width_or(0.0))
        return filled(f"{self.name}: {words}", letters) if page().narrow else words


def intervals(result: Fit | Calibration) -> list[DrawnInterval]:
    """Those of all parameters that were searched."""
    if isinstance(result, Calibration):
        names = [parameter.path.replace(",", ", ") for parameter in result.parameters]
        units = ["1"] * len(names)  # a path carries its unit
    else:
        names = [parameter.name.replace("_", " ") for parameter in result.parameters]
        units = [parameter.unit for parameter in result.parameters]
    every = [
        DrawnInterval(name, p.value, p.low, p.high, whole(unit), p.verdict)
        for name, unit, p in zip(names, units, result.parameters, strict=True)
    ]
    return [interval for interval in every if interval.verdict != Verdict.HELD]


def draw_intervals(result: Fit | Calibration, *, ax: Axes | None = None) -> Axes:
    """The 95 % interval of each searched parameter, as its distance from the fitted value in percent.

    The scale is linear about zero and logarithmic beyond, so that an interval of a tenth of a percent is seen beside
    one of a hundred percent. Arrows stand where the data leave an end open, or where it lies beyond the scale.
    """
    rows = intervals(result)
    with plots.drawing(ax, (7.5, 1.2 + 0.26 * len(rows))) as ax:
        forest(ax, rows)
    return ax


def forest_height(rows: Sequence[DrawnInterval]) -> float:
    """Inches that `forest` takes; in a column its words stand above the intervals."""
    lines = max((row.words.count("\n") + 1 for row in rows), default=1)
    return 0.9 + len(rows) * (0.22 + 0.12 * lines if page().narrow else 0.24)


def forest(ax: Axes, rows: Sequence[DrawnInterval]) -> None:
    """The interval of each parameter about its value; arrows where the data leave an end open."""
    linear, widest = _scale(rows)
    for place, row in zip(range(len(rows))[::-1], rows, strict=True):
        colour = GREEN if row.firm else VERMILION
        if row.has_size:
            ends = [100.0 * end for end in row.ends]
            low, high = max(ends[0], -widest), min(ends[1], widest)
            ax.plot((low, high), (place, place), color=colour, linewidth=1.4, solid_capstyle="butt")
            for end, shown, open_mark in ((ends[0], low, "<"), (ends[1], high, ">")):
                beyond = end != shown or (open_mark == "<" and row.low == 0.0)
                ax.plot(shown, place, open_mark if beyond else "|", color=colour, markersize=6, clip_on=False)
            face = colour if row.firm else "white"
            ax.plot(0.0, place, "o" if row.firm else "s", color=colour, markersize=4, markerfacecolor=face)
        else:
            ax.text(0.0, place, "as good as zero", ha="center", va="center", fontsize=plots.letters(8), color=colour)
        look: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "fontsize": plots.letters(8), "color": "#222222"}
        x, y, upright = (0.01, place + 0.2, "bottom") if page().narrow else (1.02, place, "center")
        ax.text(x, y, row.words, va=upright, linespacing=1.1, **look)
    ax.axvline(0.0, color="#999999", linewidth=0.7)
    ax.set_xscale("symlog", linthresh=linear, linscale=0.6)
    powers = [linear * 10.0**k for k in range(round(math.log10(widest / linear)) + 1)]
    powers = powers[:: -(-len(powers) // 3)] if page().narrow else powers
    ticks = [-power for power in powers[::-1]] + [0.0] + powers
    ax.set_xticks(ticks, [f"{tick:+g}".replace("-", "\N{MINUS SIGN}") if tick else "0" for tick in ticks])
    ax.minorticks_off()
    ax.set_yticks(range(len(rows))[::-1], [] if page().narrow else [row.name for row in rows])
    if page().narrow:
        ax.grid(visible=False, axis="y")
    ax.set(xlim=(-widest, widest), ylim=(-0.6, len(rows) - 0.4 + 0.3 * page().narrow))
    ax.set_xlabel("95 % interval about the fitted value [%]")
    ax.set_title("Parameters: green and filled where the data determine them")


def _scale(rows: Sequence[DrawnInterval]) -> tuple[float, float]:
    """(end of the linear part, end of the scale) in percent: powers of ten about all closed ends."""
    sizes = [100.0 * abs(end) for row in rows if row.has_size for end in row.ends if 0.0 < abs(end) <= WIDEST]
    low, high = min(sizes, default=1.0), max(sizes, default=1.0)
    linear = 10.0 ** max(math.floor(math.log10(low)), -3)
    return linear, max(10.0 ** math.ceil(math.log10(high)), 10.0 * linear)
