"""Pictures of motions: time histories, phase planes and the friction loop."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes

from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.parameters import described
from vibrocap.plotting.style import (
    ANY_UNITS,
    BLACK,
    BLUE,
    DIMENSIONLESS,
    LABELS,
    SKY,
    STICK_SHADE,
    STYLE,
    VERMILION,
    blank_figure,
    footnote,
    save,
)  # fmt: skip

DETAIL_PERIODS = 4  # the last periods, which the time histories show in detail
FIRST_PERIODS = 12  # grey in the phase planes
POINTS_PER_PERIOD, MOST_POINTS = 512, 200_000
FAINT: dict[str, Any] = {"color": "#BDBDBD", "linewidth": 0.7, "zorder": 1}
LAST: dict[str, Any] = {"color": BLUE, "linewidth": 1.5, "zorder": 3}
FASTER: dict[str, Any] = {"color": VERMILION, "linewidth": 1.6, "linestyle": "-", "zorder": 3}
SLOWER: dict[str, Any] = {"color": BLUE, "linewidth": 1.6, "linestyle": (0, (4, 1.5)), "zorder": 4}
HELD: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 3.0, "linestyle": "-", "zorder": 2}
END: dict[str, Any] = {"color": BLACK, "marker": "o", "markersize": 4, "linestyle": "none", "zorder": 5}


def plot_motion(motion: Trajectory, path: str | Path) -> Path:
    """Draw a motion: time histories on the left, phase planes and the friction loop on the right.

    The phase plane of the capsule shows its position relative to the mean travel, in which a steady motion closes.
    """
    fig = blank_figure((11.5, 8.2))
    with matplotlib.rc_context(STYLE):
        left, right = fig.subfigures(1, 2, squeeze=False, width_ratios=(1.55, 1.0), wspace=0.02)[0]
        _time_histories(left.subplots(4, 1), motion)
        left.align_ylabels()
        _phase_planes(right.subplots(3, 1), motion)
        right.align_ylabels()
        parts = (motion.system.machine, motion.system.friction, motion.system.drive)
        fig.suptitle("\n".join(map(described, parts)), fontsize=9.5, x=0.01, ha="left")
        footnote(fig, DIMENSIONLESS if motion.system.machine.cyclic else ANY_UNITS)
    return save(fig, path)


def sample_times(motion: Trajectory, start: float, end: float) -> np.ndarray:
    """Times to draw a motion at: evenly spread, with both sides of every event, so that jumps stand upright."""
    count = min(max(64, round(POINTS_PER_PERIOD * (end - start) / motion.period)), MOST_POINTS)
    events = motion.event_times[(motion.event_times > start) & (motion.event_times < end)][:MOST_POINTS]
    before = np.maximum(start, events - 1e-9 * motion.period)
    return np.unique(np.concatenate((np.linspace(start, end, count + 1), events, before)))


def shade_stick(axes: Axes, motion: Trajectory, start: float, end: float, scale: float = 1.0) -> bool:
    """Shade the times at which the contact sticks, divided by `scale`; returns whether there are any."""
    stuck = [phase for phase in motion.phases if phase.side == STUCK and phase.end > start and phase.start < end]
    if motion.system.friction.kind != "set-valued":
        return False
    for number, phase in enumerate(stuck):
        label = "stuck" if number == 0 else None
        axes.axvspan(max(phase.start, start) / scale, min(phase.end, end) / scale, label=label, **STICK_SHADE)
    return bool(stuck)


def _time_histories(axes: Any, motion: Trajectory) -> None:
    """The position over the whole run, then angle, velocity and friction over the last periods."""
    period, end = motion.period, motion.end
    start = max(0.0, end - DETAIL_PERIODS * period)
    whole = sample_times(motion, 0.0, end)
    axes[0].plot(whole / period, motion.at(whole, "position"), **LAST)
    what = "Place" if motion.system.machine.cyclic is None else "Travel"
    axes[0].set(title=f"{what} over the whole run", ylabel=_place_label(motion), xlabel=LABELS["periods"])
    if start > 0.0:
        axes[0].axvspan(start / period, end / period, color=SKY, alpha=0.25, linewidth=0, label="shown below")
        _legend_above(axes[0])
    t = sample_times(motion, start, end)
    moving = motion.system.machine.contact_state
    names = (motion.state_names[0], moving, "friction")
    for ax, name, title in zip(axes[1:], names, (_inner_name(motion), _body_name(motion), "Contact"), strict=True):
        shaded = shade_stick(ax, motion, start, end, period)
        ax.plot(t / period, motion.at(t, name), **LAST)
        ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
        ax.set(title=title, ylabel=_place_label(motion) if name == "position" else _label(name))
        ax.set_xlim(start / period, end / period)
        if name != "friction":
            ax.tick_params(labelbottom=False)
        if shaded and name == moving:
            _legend_above(ax)
    axes[-1].set_xlabel(LABELS["periods"])


def _phase_planes(axes: Any, motion: Trajectory) -> None:
    """theta-theta', X-X' relative to the mean travel, and R against X'; the last period over the first ones."""
    period, end = motion.period, motion.end
    last = max(0.0, end - period)
    t = sample_times(motion, last, end)
    shown = [(t, LAST, "last period")]
    if last > 0.0:
        shown.insert(0, (sample_times(motion, 0.0, min(last, FIRST_PERIODS * period)), FAINT, "first periods"))
    whole = end >= period and motion.system.machine.cyclic is not None
    moving = motion.system.machine.contact_state
    speed = (motion.at(end, "position")[0] - motion.at(last, "position")[0]) / period if whole else 0.0

    def relative(times: np.ndarray) -> np.ndarray:
        return motion.at(times, "position") - speed * times

    origin = relative(t).mean() if whole else 0.0
    inner, rate = motion.state_names[:2]
    for times, style, label in shown:
        axes[0].plot(motion.at(times, inner), motion.at(times, rate), **style, label=label)
        axes[1].plot(relative(times) - origin, motion.at(times, moving), **style)
    axes[0].plot(motion.at(t[-1:], inner), motion.at(t[-1:], rate), **END, label="end")
    axes[1].plot(relative(t[-1:]) - origin, motion.at(t[-1:], moving), **END)
    label = _place_label(motion) if inner == "position" else _label(inner)
    axes[0].set(title=_inner_name(motion), xlabel=label, ylabel=_label(rate))
    _legend_above(axes[0])
    steady = r"position less steady travel $X - \langle X' \rangle\,\tau$"
    axes[1].set(title=_body_name(motion), xlabel=steady if whole else _place_label(motion), ylabel=_label(moving))

    velocity, friction = motion.at(t, "contact_velocity"), motion.at(t, "friction")
    stuck = np.zeros_like(t, bool)
    if motion.system.friction.kind == "set-valued":
        stuck = motion.at(t, "side") == STUCK
    faster = np.append(np.diff(np.abs(velocity)) > 0.0, False)
    for chosen, style, label in (
        (stuck, HELD, "stuck"),
        (faster & ~stuck, FASTER, "accelerating"),
        (~faster & ~stuck, SLOWER, "decelerating"),
    ):
        if chosen.any():  # with the point after each, so that the lines join
            axes[2].plot(velocity, np.where(chosen | np.roll(chosen, 1), friction, np.nan), **style, label=label)
    axes[2].set(title="Friction", xlabel=LABELS["contact_velocity"] + ", last period", ylabel=LABELS["friction"])
    _legend_above(axes[2])
    for ax in axes:
        ax.locator_params(axis="x", nbins=7)


def _body_name(motion: Trajectory) -> str:
    """What slides."""
    return "Block" if motion.system.machine.cyclic is None else "Capsule"


def _place_label(motion: Trajectory) -> str:
    return "position $x$" if motion.system.machine.cyclic is None else LABELS["position"]


def _inner_name(motion: Trajectory) -> str:
    """What moves within the capsule, or the block."""
    if motion.system.machine.cyclic is None:
        return "Block"
    return "Pendulum" if motion.state_names[0] == "angle" else "Inner motion"


def _label(name: str) -> str:
    """The axis label of a state; its name in words where there is none."""
    return LABELS.get(name, name.replace("_", " "))


def _legend_above(axes: Axes) -> None:
    """A legend in the line of the title, where it covers no data."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.99),
        ncols=3,
        borderaxespad=0.0,
        columnspacing=1.0,
        handlelength=1.5,
        fontsize=8,
    )
