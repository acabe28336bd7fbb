"""Panels of a motion on several contacts: velocities, friction and modes of every body, side by side in one picture."""

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.names import numbered
from vibrocap.plotting.look.colours import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from vibrocap.plotting.look.labels import LABELS, scale, with_unit
from vibrocap.plotting.look.style import legend_above
from vibrocap.plotting.look.trace import Trace

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
MODES = {1: ("forward", BLUE), 0: ("stuck", "#B8B8B8"), -1: ("back", VERMILION)}  # side: what it is called
HEIGHT = 0.7  # of a strip, of the distance to the next

Stretch = tuple[float, float]


def contacts_of(motion: Trajectory) -> range:
    """Numbers of the contacts, from 1."""
    return range(1, 1 + len(motion.system.machine.contact_states))


def clock(motion: Trajectory) -> tuple[float, str]:
    """(what times are divided by, the label of their axis): drive periods, or time where nothing drives in time."""
    if equations(motion.system).timed:
        return motion.period, LABELS["periods"]
    return 1.0 / scale("time", motion.system), with_unit(LABELS["time"], "time", motion.system)


def colour_of(contact: int, count: int) -> Any:
    """Colours that all readers can tell apart, of more contacts than there are such those of a scale."""
    if count <= len(COLOURS):
        return COLOURS[contact - 1]
    return matplotlib.colormaps["viridis"]((contact - 1) / (count - 1))


def width_of(number: int, count: int) -> float:
    """Line widths that fall, so that lines which coincide are all seen."""
    return 1.3 if count == 1 else 3.0 - 2.2 * (number - 1) / (count - 1)


def draw_all(motion: Trajectory, names: list[str], label: str, stretch: Stretch, ax: Axes) -> None:
    """Quantities of one kind over a stretch of time, one line each, named by their numbers."""
    trace, (unit, time), count = Trace(motion, *stretch), clock(motion), len(names)
    for number, name in enumerate(names, start=1):
        look = {"color": colour_of(number, count), "linewidth": width_of(number, count)}
        ax.plot(trace.time / unit, trace[name], label=f"{number}", **look)
    ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
    ax.set(xlim=(stretch[0] / unit, stretch[1] / unit), ylabel=with_unit(label, names[0], motion.system), xlabel=time)
    if count > 1:
        numbers_above(ax)


def draw_modes(motion: Trajectory, stretch: Stretch, ax: Axes) -> None:
    """Which way every contact slides, or that it sticks, over a stretch of time: a strip for each."""
    (unit, time), contacts, used = clock(motion), contacts_of(motion), set()
    for contact in contacts:
        if motion.system.contact_kinds[contact - 1] == "smooth":
            continue  # a smooth law, of which nobody notes the side
        for phase in motion.phases_of(contact):
            low, high = max(phase.start, stretch[0]) / unit, min(phase.end, stretch[1]) / unit
            if high > low:
                place = contact - 0.5 * HEIGHT, HEIGHT
                used.add(phase.side)
                ax.broken_barh([(low, high - low)], place, facecolors=MODES[phase.side][1], linewidth=0)
    ax.set(xlim=(stretch[0] / unit, stretch[1] / unit), ylim=(contacts[-1] + 0.6, 0.4))
    ax.set(yticks=list(contacts), ylabel="contact", xlabel=time)
    ax.grid(visible=False, axis="y")
    handles = [Patch(color=colour, label=word) for side, (word, colour) in MODES.items() if side in used]
    legend_above(ax, handles=handles, columnspacing=None, handlelength=None)


def draw_all_loops(motion: Trajectory, stretch: Stretch, ax: Axes) -> None:
    """Friction over sliding velocity of every contact, over a stretch of time; nothing is drawn across a jump.

    A dot at rest is a contact that sticks with one force.
    """
    trace, count, system = Trace(motion, *stretch), len(contacts_of(motion)), motion.system
    cut = np.flatnonzero(trace.index[1:] != trace.index[:-1]) + 1
    for contact in contacts_of(motion):
        velocity, friction = (trace[numbered(name, contact)] for name in ("contact_velocity", "friction"))
        look = {"color": colour_of(contact, count), "linewidth": width_of(contact, count), "solid_capstyle": "butt"}
        ax.plot(*(np.insert(values, cut, np.nan) for values in (velocity, friction)), label=f"{contact}", **look)
        held = np.unique(np.round(friction[velocity == 0.0], 12))
        if len(held) == 1:
            ax.plot([0.0], held, ".", color=look["color"], markersize=3.0 + 2.0 * look["linewidth"])
    ax.set_xlabel(with_unit("sliding velocity $v_i$", "contact_velocity", system))
    ax.set_ylabel(with_unit("friction force $R_i$", "friction", system))
    ax.locator_params(axis="x", nbins=7)
    numbers_above(ax)


def numbers_above(ax: Axes) -> None:
    """A legend of numbers in the line of the title."""
    look = {"columnspacing": 0.8, "handlelength": 1.0, "handletextpad": 0.3}
    if len(ax.get_legend_handles_labels()[0]) > 6:
        look |= {"columnspacing": 0.6, "handlelength": 0.5, "fontsize": 7.5}
    legend_above(ax, ncols=10, **look)
