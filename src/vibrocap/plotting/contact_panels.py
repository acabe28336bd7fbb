"""Panels of a motion on several contacts: velocities, friction and modes of every body, side by side in one picture."""

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.names import numbered
from vibrocap.plotting.look.colours import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from vibrocap.plotting.look.labels import LABELS, with_unit
from vibrocap.plotting.look.style import legend_above
from vibrocap.plotting.look.trace import Trace

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
MODES = {1: ("forward", BLUE), 0: ("stuck", "#B8B8B8"), -1: ("back", VERMILION)}  # side: what it is called
HEIGHT = 0.7  # of a strip, of the distance to the next


def contacts_of(motion: Trajectory) -> range:
    """Numbers of the contacts, from 1."""
    return range(1, 1 + len(motion.system.machine.contact_states))


def colour_of(contact: int, count: int) -> Any:
    """Colours that all readers can tell apart, of more contacts than there are such those of a scale."""
    if count <= len(COLOURS):
        return COLOURS[contact - 1]
    return matplotlib.colormaps["viridis"]((contact - 1) / (count - 1))


def draw_all(motion: Trajectory, names: list[str], label: str, stretch: tuple[float, float], ax: Axes) -> None:
    """Quantities of one kind over a stretch of time in drive periods, one line each, named by their numbers."""
    trace, period = Trace(motion, *stretch), motion.period
    for number, name in enumerate(names, start=1):
        ax.plot(trace.time / period, trace[name], color=colour_of(number, len(names)), linewidth=1.3, label=f"{number}")
    ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
    ax.set(xlim=(stretch[0] / period, stretch[1] / period), ylabel=with_unit(label, names[0], motion.system))
    ax.set_xlabel(LABELS["periods"])
    if len(names) > 1:
        numbers_above(ax)


def draw_modes(motion: Trajectory, stretch: tuple[float, float], ax: Axes) -> None:
    """Which way every contact slides, or that it sticks, over a stretch of time in drive periods: a strip for each."""
    period, contacts, used = motion.period, contacts_of(motion), set()
    for contact in contacts:
        if motion.system.contact_kinds[contact - 1] == "smooth":
            continue  # a smooth law, of which nobody notes the side
        for phase in motion.phases_of(contact):
            low, high = max(phase.start, stretch[0]) / period, min(phase.end, stretch[1]) / period
            if high > low:
                place = contact - 0.5 * HEIGHT, HEIGHT
                used.add(phase.side)
                ax.broken_barh([(low, high - low)], place, facecolors=MODES[phase.side][1], linewidth=0)
    ax.set(xlim=(stretch[0] / period, stretch[1] / period), ylim=(contacts[-1] + 0.6, 0.4))
    ax.set(yticks=list(contacts), ylabel="contact", xlabel=LABELS["periods"])
    ax.grid(visible=False, axis="y")
    handles = [Patch(color=colour, label=word) for side, (word, colour) in MODES.items() if side in used]
    legend_above(ax, handles=handles, columnspacing=None, handlelength=None)


def draw_all_loops(motion: Trajectory, stretch: tuple[float, float], ax: Axes) -> None:
    """Friction over sliding velocity of every contact, over a stretch of time; nothing is drawn across a jump."""
    trace = Trace(motion, *stretch)
    contacts = contacts_of(motion)
    cut = np.flatnonzero(trace.index[1:] != trace.index[:-1]) + 1
    for contact in contacts:
        velocity, friction = (trace[numbered(name, contact)] for name in ("contact_velocity", "friction"))
        line = (np.insert(values, cut, np.nan) for values in (velocity, friction))
        ax.plot(*line, color=colour_of(contact, len(contacts)), linewidth=1.4, label=f"{contact}")
    system = motion.system
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
