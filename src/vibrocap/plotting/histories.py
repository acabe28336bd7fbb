"""Panels of a motion: quantities over time in drive periods, alone or of all contacts, modes and friction loops.

All are drawn from a `Trace`, a stretch of the motion as points of its pieces.
"""

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.measures.recorded.settling import Settling, settling
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.events import IMPACT
from vibrocap.physics.names import name_and_number, number_in, numbered
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import LABELS, quantity_label, scale, with_unit
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

MOST_POINTS, MOST_PER_PIECE = 200_000, 24


class Trace:
    """A stretch of a motion as points of its pieces, each with both its ends: jumps stand upright, peaks are round.

    time: [points]; a border of two pieces is there twice, as what each of them says
    """

    def __init__(self, motion: Trajectory, start: float, end: float):
        self.motion = motion
        begin, length = motion.piece_start, motion.piece_length
        pieces = np.flatnonzero((begin < end) & (begin + length > start))
        low = np.maximum(begin[pieces], start) - begin[pieces]
        high = np.minimum(begin[pieces] + length[pieces], end) - begin[pieces]
        most = max(2, min(MOST_PER_PIECE, MOST_POINTS // max(len(pieces), 1)))
        share = np.linspace(0.0, 1.0, most)
        self.index = np.repeat(pieces, most)
        self.since = (low[:, None] + (high - low)[:, None] * share).ravel()
        self.time = begin[self.index] + self.since

    def __getitem__(self, name: str) -> np.ndarray:
        """A quantity at these points, in SI where the system knows its scales; an angle that turns without end within
        half a turn of zero, cut where it begins again."""
        motion, values = self.motion, self._plain(name)
        if turn := motion.system.machine.turns.get(name):
            values = (values + turn / 2) % turn - turn / 2
            values[1:][np.abs(np.diff(values)) > turn / 2] = np.nan
        return values * (1.0 if name.startswith("side") else scale(name, motion.system))

    def _plain(self, name: str) -> np.ndarray:
        motion = self.motion
        if name in motion.state_names:
            return motion.piece_states(self.index, self.since)[motion.state_names.index(name)]
        if name in motion.observable_names:
            return motion.piece_observables((name,), self.index, self.since)[0]
        if name not in motion.names:
            raise ArgumentError("name", f"a motion has no {name!r}; {suggestion(name, motion.names)}")
        if name in motion.side_names:
            return motion.side_of(name)[self.index]
        integral = motion.integral_names.index(name)
        return (motion.piece_marks[:, self.index] + motion.piece_integrals(self.index, self.since))[integral]


COLOURS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
MODES = {1: ("forward", BLUE), 0: ("stuck", "#B8B8B8"), -1: ("back", VERMILION)}  # side: what it is called
HEIGHT = 0.7  # of a strip, of the distance to the next

Stretch = tuple[float, float]


def contacts_of(motion: Trajectory) -> range:
    """Numbers of the contacts, from 1."""
    return range(1, 1 + len(motion.system.machine.contact_states))


def contact_labels(motion: Trajectory) -> list[str]:
    """The names of the bodies that rub, their numbers where a name is but a number."""
    names = motion.system.machine.contact_names
    return [name.replace("_", " ") if name.replace(" ", "").isalpha() else f"{i}" for i, name in enumerate(names, 1)]


def clock(motion: Trajectory) -> tuple[float, str]:
    """(what times are divided by, the label of their axis): drive periods, or time where nothing drives in time."""
    if equations(motion.system).timed:
        return motion.period, LABELS["periods"]
    return 1.0 / scale("time", motion.system), with_unit(LABELS["time"], "time", motion.system)


def line_of(number: int, count: int) -> dict[str, Any]:
    """The line of a contact: its colour, of a scale where they are many; widths fall, so that all are seen."""
    share = (number - 1) / max(count - 1, 1)
    colour = COLOURS[number - 1] if count <= len(COLOURS) else matplotlib.colormaps["viridis"](share)
    return {"color": colour, "linewidth": 1.3 if count == 1 else 3.0 - 2.2 * share}


def draw_all(motion: Trajectory, names: list[str], label: str, stretch: Stretch, ax: Axes) -> None:
    """Quantities of one kind over a stretch of time, one line for each contact."""
    trace, (unit, time), count = Trace(motion, *stretch), clock(motion), len(names)
    labels = contact_labels(motion) if count == len(contacts_of(motion)) else map(str, range(1, 1 + count))
    for number, (name, contact) in enumerate(zip(names, labels, strict=True), start=1):
        ax.plot(trace.time / unit, trace[name], label=contact, **line_of(number, count))
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
    ax.set_yticks(list(contacts), contact_labels(motion))
    ax.set(ylabel="contact", xlabel=time)
    ax.grid(visible=False, axis="y")
    handles = [Patch(color=colour, label=word) for side, (word, colour) in MODES.items() if side in used]
    plots.legend_above(ax, handles=handles, columnspacing=None, handlelength=None)


def draw_all_loops(motion: Trajectory, stretch: Stretch, ax: Axes) -> None:
    """Friction over sliding velocity of every contact, over a stretch of time; nothing is drawn across a jump.

    A dot at rest is a contact that sticks with one force.
    """
    trace, count, system = Trace(motion, *stretch), len(contacts_of(motion)), motion.system
    cut = np.flatnonzero(trace.index[1:] != trace.index[:-1]) + 1
    for contact in contacts_of(motion):
        velocity, friction = (trace[numbered(name, contact)] for name in ("contact_velocity", "friction"))
        look, label = line_of(contact, count), contact_labels(motion)[contact - 1]
        x, y = (np.insert(values, cut, np.nan) for values in (velocity, friction))
        ax.plot(x, y, label=label, solid_capstyle="butt", **look)
        held = np.unique(np.round(friction[velocity == 0.0], 12))
        if len(held) == 1:
            ax.plot([0.0], held, ".", color=look["color"], markersize=3.0 + 2.0 * look["linewidth"])
    ax.set_xlabel(with_unit("sliding velocity $v_i$", "contact_velocity", system))
    ax.set_ylabel(with_unit("friction force $R_i$", "friction", system))
    ax.locator_params(axis="x", nbins=7)
    numbers_above(ax)


def numbers_above(ax: Axes) -> None:
    """A legend of numbers in the line of the title."""
    look = {"columnspacing": 0.8, "handlelength": 1.0, "handletextpad": 0.5}
    if len(ax.get_legend_handles_labels()[0]) > 6:
        look |= {"columnspacing": 0.6, "handlelength": 0.5, "fontsize": 7.5}
    plots.legend_above(ax, ncols=10, **look)


DETAIL_PERIODS = 4  # the last periods, which the time histories show in detail
MANY = 40  # turns to and fro, of which a line is drawn thinner
FAR = 3.0  # times the largest command: a limit that is not drawn
AT_REST, NEARLY_AT_REST = 1e-6, 1e-3  # of the range of every state: by how much it still differs from its end
FAINT: dict[str, Any] = {"color": "#BDBDBD", "linewidth": 0.7, "zorder": 1}
LAST: dict[str, Any] = {"color": BLUE, "linewidth": 1.5, "zorder": 3}
GIVEN: dict[str, Any] = {"color": BLACK, "linewidth": 1.5, "linestyle": (0, (5, 2)), "zorder": 2}
TRUE: dict[str, Any] = {"color": BLUE, "linewidth": 0.8, "zorder": 3}
PULLING: dict[str, Any] = {"facecolor": "none", "edgecolor": VERMILION, "hatch": "////", "linewidth": 0.0, "zorder": 2}
STRUCK: dict[str, Any] = {"color": VERMILION, "marker": "^", "markersize": 5, "linestyle": "none", "zorder": 5}
STRUCK |= {"clip_on": False, "label": "impact"}
SETTLED: dict[str, Any] = {"color": GREEN, "linewidth": 1.2, "linestyle": (0, (1, 1)), "zorder": 4}
STOPPED: dict[str, Any] = {"color": VERMILION, "linewidth": 1.2, "linestyle": (0, (2, 1.5)), "zorder": 4}


def shade_stick(axes: Axes, motion: Trajectory, start: float, end: float, scale: float, contact: int) -> bool:
    """Shade the times at which a contact sticks, divided by `scale`; returns whether there are any."""
    if motion.system.laws[contact - 1].kind != "set-valued":
        return False
    shade: dict[str, Any] = plots.STICK_SHADE | {"label": "stuck"}
    for phase in motion.phases_of(contact):
        if phase.side == STUCK and phase.end > start and phase.start < end:
            axes.axvspan(max(phase.start, start) / scale, min(phase.end, end) / scale, **shade)
            shade = plots.STICK_SHADE  # named once
    return "label" not in shade


def hides_lift_off(motion: Trajectory) -> bool:
    """Whether the loads are constant, and a true one negative somewhere: the machine would have lifted off."""
    if motion.system.machine.follows_load or not len(motion.piece_start):
        return False
    trace = Trace(motion, *last_periods(motion, None))
    return any(bool(np.min(trace[name]) < 0.0) for name in loads_of(motion))


def loads_of(motion: Trajectory) -> list[str]:
    """Names of the normal loads that are known, of all contacts."""
    return [name for name in motion.observable_names if number_in(name, "reaction")]


def contact_of(motion: Trajectory, name: str) -> int:
    """The contact that a quantity belongs to; of what belongs to none the first."""
    contacts = motion.system.machine.contact_states
    if name in motion.state_names:
        return 1 + contacts.index(name) if name in contacts else 1
    return min(name_and_number(name)[1], len(contacts))


def mark_stop(ax: Axes, motion: Trajectory, unit: float) -> bool:
    """Mark where a run stopped that did not go to its end, at a time divided by `unit`; whether it did."""
    if not motion.run_status.ok:
        ax.axvline(motion.end / unit, label=motion.run_status.value, **STOPPED)
    return not motion.run_status.ok


def draw_history(
    motion: Trajectory, name: str | None = None, *, periods: float | None = None, ax: Axes | None = None
) -> Axes:
    """A quantity of a motion over time in drive periods; where its contact sticks is shaded.

    name: one of `motion.names`, by default the place of what rubs; periods: so many at the end, by default all
    """
    with plots.drawing(ax) as ax:
        return history(motion, name or place_of(motion), last_periods(motion, periods), ax, shaded=periods is not None)


def last_periods(motion: Trajectory, periods: float | None) -> Stretch:
    """So many periods at the end of a motion, None: all of it."""
    start = motion.start_time if periods is None else max(motion.start_time, motion.end - periods * motion.period)
    return start, motion.end


def shown_in_detail(motion: Trajectory) -> Stretch:
    """What histories show in detail: the last periods, of a longer response all of it; or how a motion came to rest."""
    start, end = last_periods(motion, max(DETAIL_PERIODS, repeats_after(motion)))
    states = np.array([motion[name] for name in motion.state_names])
    ranges = np.maximum(np.ptp(states, axis=1, keepdims=True), np.finfo(float).tiny)
    moved = np.abs(states - states[:, -1:]) / ranges
    if start <= motion.start_time or np.max(moved[:, motion.time >= start]) > AT_REST:
        return start, end
    moving = motion.time[np.any(moved > NEARLY_AT_REST, axis=0)]
    begin = motion.start_time
    return begin, min(end, begin + 1.25 * float(np.max(moving, initial=begin) - begin))


def settlement(motion: Trajectory) -> Settling | None:
    """Whether a motion has settled; None where nothing drives it in time, or the run is too short to tell."""
    verdict = settling(motion) if equations(motion.system).timed else None
    return None if verdict is None or verdict.residual is None else verdict


def repeats_after(motion: Trajectory) -> int:
    """The drive periods after which a motion repeats; 1 where it has not settled."""
    return getattr(settlement(motion), "period", None) or 1


def settled_words(motion: Trajectory) -> str:
    """Whether a motion has settled, as a sentence; empty where that is not known."""
    verdict = settlement(motion)
    if verdict is None or verdict.since is None:
        return "" if verdict is None else "Not settled."
    after = repeats_after(motion)
    return f"Settled from period {verdict.since} on; it repeats every {'period' if after == 1 else f'{after} periods'}."


def history(motion: Trajectory, name: str, stretch: Stretch, ax: Axes, shaded: bool) -> Axes:
    """A quantity over a stretch of a motion; shaded: where its contact sticks."""
    trace, (unit, time) = Trace(motion, *stretch), clock(motion)
    whole = stretch == last_periods(motion, None)
    shaded = shaded and shade_stick(ax, motion, *stretch, unit, contact_of(motion, name))
    ax.plot(trace.time / unit, trace[name], **LAST)
    if name not in ("position", motion.system.machine.place):
        ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
    ax.set(ylabel=label_of(motion, name), xlabel=time)
    stopped = mark_stop(ax, motion, unit)
    if not whole:
        ax.set_xlim(stretch[0] / unit, stretch[1] / unit)
    if shaded or stopped:
        plots.legend_above(ax)
    return ax


def draw_load(motion: Trajectory, *, periods: float | None = None, ax: Axes | None = None) -> Axes:
    """The normal load of a motion over time in drive periods, with the line where the ground would have to pull.

    A constant load is drawn beside the true one (thin), and hatched where that is negative: the machine would have
    lifted off. Of several contacts the true loads are drawn.

    periods: so many at the end, by default all. Raises ArgumentError for a machine that does not know its load.
    """
    if not loads_of(motion):
        raise ArgumentError("what", f"the {motion.system.machine.name} does not define its load")
    with plots.drawing(ax) as ax:
        return load_panel(motion, last_periods(motion, periods), ax)


def load_panel(motion: Trajectory, stretch: Stretch, ax: Axes) -> Axes:
    if len(contacts_of(motion)) > 1:
        draw_all(motion, loads_of(motion), "normal load $N_i$", stretch, ax)
        return ax
    trace, (unit, time), machine = Trace(motion, *stretch), clock(motion), motion.system.machine
    load = trace["reaction"]
    ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=1)
    if machine.follows_load:
        ax.plot(trace.time / unit, load, **LAST)
    else:
        constant = float(motion.system.placed.loads()[0]) * scale("reaction", motion.system)
        ax.plot(trace.time[[0, -1]] / unit, [constant, constant], **GIVEN, label="constant load")
        ax.plot(trace.time / unit, load, **TRUE, label="true load")
        if np.min(load) < 0.0:
            below = np.minimum(load, 0.0)
            ax.fill_between(trace.time / unit, below, 0.0, **PULLING, label="the ground would have to pull")
    mark_stop(ax, motion, unit)
    ax.set(ylabel=label_of(motion, "reaction"), xlabel=time)
    if stretch != last_periods(motion, None):
        ax.set_xlim(stretch[0] / unit, stretch[1] / unit)
    if ax.get_legend_handles_labels()[0]:
        plots.legend_above(ax)
    return ax


def whole_run(ax: Axes, motion: Trajectory, detail: Stretch) -> None:
    """The places of all bodies over the whole run, beside the reference where that is what is controlled.

    Marked are when the motion had settled, and what the other panels show.
    """
    (unit, _), whole, controller = clock(motion), last_periods(motion, None), motion.system.controller
    first, places = place_of(motion), places_of(motion)
    what = "Place" if motion.system.cyclic is None else "Travel"
    if len(places) > 1:
        draw_all(motion, places, "position $x_i$", whole, ax)
    else:
        history(motion, first, whole, ax, shaded=False)
        what += f" of {body_of(motion)}" * (len(contacts_of(motion)) > 1)
    if np.count_nonzero(np.diff(np.sign(np.diff(motion[first])))) > MANY:
        for line in ax.lines:
            line.set_linewidth(0.6 * line.get_linewidth())
    if controller is not None and controller.compared(motion.system.machine) == first:
        trace = Trace(motion, *whole)
        ax.plot(trace.time / unit, trace["reference"], **GIVEN, label="reference")
    if (verdict := settlement(motion)) is not None and verdict.since is not None:
        ax.axvline((motion.start_time + verdict.since * motion.period) / unit, **SETTLED, label="settled")
    if detail != whole:
        ax.axvspan(detail[0] / unit, detail[1] / unit, color=SKY, alpha=0.25, linewidth=0, label="detail")
    ax.set_title(f"{what} over the whole run")
    if ax.get_legend_handles_labels()[0]:
        numbers_above(ax) if len(places) > 1 else plots.legend_above(ax)


def mark_impacts(ax: Axes, motion: Trajectory, stretch: Stretch) -> None:
    """A mark at every impact within a stretch, on the edge of the panel."""
    times = [event.time for event in motion.events if event.kind == IMPACT and stretch[0] <= event.time <= stretch[1]]
    if times:
        ax.plot(np.array(times) / clock(motion)[0], np.zeros(len(times)), transform=ax.get_xaxis_transform(), **STRUCK)
        plots.legend_above(ax)


def error_panel(motion: Trajectory, stretch: Stretch, ax: Axes) -> None:
    """What a controller sees: the error, or the reference of a function of states."""
    system, trace, (unit, time) = motion.system, Trace(motion, *stretch), clock(motion)
    followed = system.controller.compared(system.machine)
    label = f"error $r -$ {quantity_label(followed, system).rsplit(' ', 1)[-1]}" if followed else "reference $r$"
    ax.plot(trace.time / unit, trace["reference"] - (trace[followed] if followed else 0.0), **LAST)
    ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
    ax.set(ylabel=with_unit(label, followed or "reference", system), xlabel=time)
    ax.set_xlim(stretch[0] / unit, stretch[1] / unit)


def command_panel(motion: Trajectory, stretch: Stretch, ax: Axes) -> None:
    """What a controller does: its command, and the limit of it; one that would flatten the command stands in words."""
    history(motion, "drive", stretch, ax, shaded=False)
    if (limit := getattr(motion.system.controller, "limit", None)) is None:
        return
    limit *= scale("drive", motion.system)
    if limit > FAR * np.max(np.abs(Trace(motion, *stretch)["drive"])):
        ax.set_title(f"Actuator, far from its limit {with_unit(f'{limit:.4g}', 'drive', motion.system)}")
        return
    for sign in (1.0, -1.0):
        ax.axhline(sign * limit, **GIVEN, label="limit" if sign > 0 else None)
    plots.legend_above(ax)


def places_of(motion: Trajectory) -> list[str]:
    """The places of all bodies that rub, as far as they are known."""
    others = [numbered("position", contact) for contact in contacts_of(motion)[1:]]
    return [name for name in (place_of(motion), *others) if name in motion.names]


def body_of(motion: Trajectory) -> str:
    """What slides at the first contact."""
    return motion.system.machine.derived.contacts[0].body.name


def place_of(motion: Trajectory) -> str:
    """The place of what rubs: the position, or the state that is it in a machine of one's own."""
    return "position" if "position" in motion.names else motion.system.machine.place or motion.state_names[0]


def label_of(motion: Trajectory, name: str) -> str:
    """The axis label of a quantity, with its unit where that is known."""
    return with_unit(quantity_label(name, motion.system), name, motion.system)
