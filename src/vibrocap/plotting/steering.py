"""The picture of a schedule that steers: position over time with the target, and what becomes of it in the samples."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.design.steering.steering import Steering
from vibrocap.physics.system import System
from vibrocap.plotting.look.colours import BLUE, GREEN, GREY, SKY, VERMILION
from vibrocap.plotting.look.labels import bracketed, parts_in_si, parts_title
from vibrocap.plotting.look.own_lines import in_own_lines
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import figure, given_axes, legend_above, setting, style
from vibrocap.plotting.look.trace import Trace
from vibrocap.quantities.dimensional import computed

WIDTH = 8.2  # inches
SHOWN = 12  # samples whose motions are drawn, the worst two among them
SHADES = {"travel": SKY, "approach": GREEN}  # of segments that drive


def steering_figure(found: Steering) -> Figure:
    """Position over time with the band of the target and the segments; below it the samples of what is uncertain."""
    found = computed(found)
    uncertain = bool(len(found.positions))
    fig, axes = figure(1 + uncertain, 1, size=(page().width_or(WIDTH), 3.6 + 2.6 * uncertain), sharex=True)
    with style():
        draw_steering(found, ax=axes[0, 0])
        if uncertain:
            axes[0, 0].set_xlabel("")
            _draw_samples(axes[1, 0], found)
        width = page().width_or(WIDTH)
        parts = {**found.system.parts, "drive": found.system.drive.wave}  # type: ignore[attr-defined]
        system = System.of_parts(parts, found.system.units)
        setting(fig, parts_title([*parts.values()], width) if system.units is None else parts_in_si(system, width))
    return fig


@in_own_lines
def draw_steering(found: Steering, *, ax: Axes | None = None) -> Axes:
    """Position over time, with the band of the target and the segments of the schedule.

    Returns the axes: `ax`, or those of a new figure.
    """
    found, ax = computed(found), given_axes(ax)
    motion = found.motion()
    with style():
        _band(ax, found)
        _segments(ax, found)
        trace = Trace(motion, 0.0, motion.end)
        ax.plot(_times(found, trace.time), trace[str(found.system.cyclic)], color=BLUE, linewidth=1.2, zorder=3)
        if found.arrival is not None:
            ax.axvline(_times(found, found.arrival), color=VERMILION, linewidth=0.9, zorder=2, label="arrives")
        _name(ax, found)
        legend_above(ax, ncols=5)
    return ax


def _draw_samples(ax: Axes, found: Steering) -> None:
    """The motions of some samples, the worst two among them, less the target."""
    system = found.system
    errors = np.abs(found.positions - found.target)
    worst = np.argsort(-np.nan_to_num(errors, nan=-1.0))[:2]
    chosen = dict.fromkeys([*map(int, worst), *range(len(errors))])
    size = system.result_units.factor(str(system.cyclic))
    _band(ax, found, size * found.target)
    _segments(ax, found)
    for k in list(chosen)[:SHOWN]:
        motion = found.motion(k)
        trace = Trace(motion, 0.0, motion.end)
        look = {"color": VERMILION, "zorder": 4} if k in worst else {"color": GREY, "zorder": 3}
        ax.plot(_times(found, trace.time), trace[str(system.cyclic)] - size * found.target, linewidth=0.7, **look)
    room = 1.4 * size * max(found.tolerance, float(np.nanmax(errors)))
    ax.set_ylim(-room, room)
    _name(ax, found)
    ax.set_ylabel("less the target" + bracketed(system.result_units.unit(str(system.cyclic))))
    share = f"{100.0 * found.share_within:.4g} % of {len(errors)} samples"
    ax.set_title(f"{min(SHOWN, len(errors))} samples, the worst two red; {share} end in the band")


def _band(ax: Axes, found: Steering, origin: float = 0.0) -> None:
    """The band of the target, less an origin."""
    size = found.system.result_units.factor(str(found.system.cyclic))
    low, high = (size * (found.target + sign * found.tolerance) - origin for sign in (-1.0, 1.0))
    ax.axhspan(low, high, color=GREEN, alpha=0.25, linewidth=0.0, zorder=1, label="target")
    ax.axhline(0.5 * (low + high), color=GREEN, linewidth=0.6, zorder=2)


def _segments(ax: Axes, found: Steering) -> None:
    """Shades of the segments that drive; pauses and the hold stay white."""
    for each in found.segments:
        if each.kind in SHADES:
            start, end = (_times(found, time) for time in (each.start, each.end))
            factor = f"{each.factor:.4g}".replace("-", "\N{MINUS SIGN}")
            label = f"{each.kind}: {factor} for {each.periods:g} period{'' if each.periods == 1 else 's'}"
            ax.axvspan(start, end, color=SHADES[each.kind], alpha=0.18, linewidth=0.0, zorder=0, label=label)


def _times(found: Steering, time):
    """Times as they are drawn: in seconds, or in periods of the drive."""
    units = found.system.units
    return time / found.system.drive.wave.period if units is None else time * found.system.si.factor_of("s")  # type: ignore[attr-defined]


def _name(ax: Axes, found: Steering) -> None:
    """The names of the axes."""
    unit = bracketed(found.system.result_units.unit(str(found.system.cyclic)))
    ax.set(xlabel="drive periods" if found.system.units is None else "time [s]", ylabel="position" + unit)
    ax.set_xlim(0.0, _times(found, found.duration))
