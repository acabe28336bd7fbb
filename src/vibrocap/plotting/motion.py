"""Pictures of motions: time histories, phase planes, the friction loop and the normal load."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.arguments import ArgumentError
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.events import IMPACT
from vibrocap.physics.names import number_in, numbered
from vibrocap.plotting.contact_panels import contacts_of, draw_all, draw_all_loops, draw_modes
from vibrocap.plotting.look.colours import BLACK, BLUE, SKY, VERMILION
from vibrocap.plotting.look.labels import IN_SI, LABELS, parts_in_si, parts_title, quantity_label, scale, with_unit
from vibrocap.plotting.look.own_lines import in_own_lines
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import (
    ANY_UNITS,
    DIMENSIONLESS,
    STICK_SHADE,
    blank_figure,
    footnote,
    given_axes,
    legend_above,
    setting,
    style,
)
from vibrocap.plotting.look.trace import Trace

DETAIL_PERIODS = 4  # the last periods, which the time histories show in detail
FIRST_PERIODS = 12  # grey in the phase planes
AT_REST, NEARLY_AT_REST = 1e-6, 1e-3  # of the range of every state: by how much it still differs from its end
JUMP = 1e-6  # of the range of a velocity: by how much two pieces differ where it jumps
WIDTH = 11.5  # inches of the whole picture
PRINTED = 1.25  # inches: the height of a panel that is fitted to a page
FAINT: dict[str, Any] = {"color": "#BDBDBD", "linewidth": 0.7, "zorder": 1}
LAST: dict[str, Any] = {"color": BLUE, "linewidth": 1.5, "zorder": 3}
FASTER: dict[str, Any] = {"color": VERMILION, "linewidth": 1.6, "linestyle": "-", "zorder": 3}
SLOWER: dict[str, Any] = {"color": BLUE, "linewidth": 1.6, "linestyle": (0, (4, 1.5)), "zorder": 4}
HELD: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 3.0, "linestyle": "-", "zorder": 2}
GIVEN: dict[str, Any] = {"color": BLACK, "linewidth": 1.5, "linestyle": (0, (5, 2)), "zorder": 2}
TRUE: dict[str, Any] = {"color": BLUE, "linewidth": 0.8, "zorder": 3}
PULLING: dict[str, Any] = {"facecolor": "none", "edgecolor": VERMILION, "hatch": "////", "linewidth": 0.0, "zorder": 2}
STRUCK: dict[str, Any] = {"color": VERMILION, "marker": "^", "markersize": 5, "linestyle": "none", "zorder": 5}
STRUCK |= {"clip_on": False, "label": "impact"}
STOPPED: dict[str, Any] = {"color": VERMILION, "linewidth": 1.2, "linestyle": (0, (2, 1.5)), "zorder": 4}
END: dict[str, Any] = {"color": BLACK, "marker": "o", "markersize": 4, "linestyle": "none", "zorder": 5}


def motion_figure(motion: Trajectory) -> Figure:
    """A motion: time histories on the left, phase planes and the friction loop on the right.

    The histories show the last periods in detail; of a motion that comes to rest, how it does. The phase plane of the
    capsule shows its position relative to the mean travel, in which a steady motion closes. Of a load that follows the
    motion, and of a constant one that hides a lift-off, the load is shown as well; of a machine on several contacts
    velocity, friction and mode of every one; of a controlled one the reference, the error and the command.
    """
    system = motion.system
    width, narrow = page().width_or(WIDTH), page().narrow
    title = parts_title([*system.parts.values()], width) if system.units is None else parts_in_si(system, width)
    loaded, several = system.machine.follows_load or hides_lift_off(motion), len(system.machine.contact_states) > 1
    more = loaded + several + 2 * (system.controller is not None)
    rows, below = 4 + more, 1.2 * (len(_planes(motion)) + 1)
    if page().width is None:
        height = 7.7 + 1.6 * more + 0.17 * (title.count("\n") + 1)
    else:
        height = PRINTED * (rows + below * narrow)
    fig = blank_figure((width, height))
    with style():
        if narrow:
            left, right = fig.subfigures(2, 1, squeeze=False, height_ratios=(rows, below))[:, 0]
        else:
            left, right = fig.subfigures(1, 2, squeeze=False, width_ratios=(1.55, 1.0), wspace=0.02)[0]
        axes, detail = left.subplots(rows, 1), _detail(motion)
        if several:
            _histories_of_all(axes[:5], motion, detail)
        else:
            _time_histories(axes[:4], motion, detail)
        if system.controller is not None:
            _control(axes[4 + several : 6 + several], motion, detail)
        if loaded and several:
            names = [numbered("reaction", each) for each in contacts_of(motion)]
            draw_all(motion, names, "normal load $N_i$", detail, axes[-1])
            axes[-1].set_title("Loads")
        elif loaded:
            _load(motion, detail, axes[-1])
            axes[-1].set_title("Load")
        _share_time(axes[1:])
        left.align_ylabels()
        shown = _planes(motion)
        *planes, loop = right.subplots(len(shown) + 1, 1)
        recent = _last(motion, 1) if detail[1] == motion.end else detail
        for ax, (what, x, y) in zip(planes, shown, strict=True):
            _phase_plane(motion, x, y, recent, ax).set_title(what)
            if ax is not planes[0] and (legend := ax.get_legend()):
                legend.remove()  # as above
        if several:
            draw_all_loops(motion, recent, loop)
        else:
            _friction_loop(motion, 1, recent, loop)
        loop.set_title("Friction")
        right.align_ylabels()
        setting(fig, title)
        own = ANY_UNITS if type(system.machine).gravity is None else DIMENSIONLESS
        footnote(fig, own if system.units is None else IN_SI)
    return fig


def shade_stick(axes: Axes, motion: Trajectory, start: float, end: float, scale: float = 1.0) -> bool:
    """Shade the times at which the contact sticks, divided by `scale`; returns whether there are any."""
    stuck = [phase for phase in motion.phases if phase.side == STUCK and phase.end > start and phase.start < end]
    if motion.system.friction.kind != "set-valued":
        return False
    for number, phase in enumerate(stuck):
        label = "stuck" if number == 0 else None
        axes.axvspan(max(phase.start, start) / scale, min(phase.end, end) / scale, label=label, **STICK_SHADE)
    return bool(stuck)


def hides_lift_off(motion: Trajectory) -> bool:
    """Whether the load is constant, and the true one negative somewhere: the machine would have lifted off."""
    if motion.system.machine.follows_load or "reaction" not in motion.observable_names or not len(motion.piece_start):
        return False
    return bool(np.min(Trace(motion, motion.start_time, motion.end)["reaction"]) < 0.0)


def _mark_stop(ax: Axes, motion: Trajectory, unit: float) -> bool:
    """Mark where a run stopped that did not go to its end, at a time divided by `unit`; whether it did."""
    if not motion.run_status.ok:
        ax.axvline(motion.end / unit, label=motion.run_status.value, **STOPPED)
    return not motion.run_status.ok


# --- single panels ----------------------------------------------------------------------------------------------------
@in_own_lines
def draw_history(
    motion: Trajectory, name: str = "position", *, periods: float | None = None, ax: Axes | None = None
) -> Axes:
    """A quantity of a motion over time in drive periods; where the contact sticks is shaded.

    name: a state, an observable or an integral (`motion.names`); periods: so many at the end, by default all
    Returns the axes: `ax`, or those of a new figure.
    """
    return _history(motion, name, _last(motion, periods), given_axes(ax), shaded=periods is not None)


Stretch = tuple[float, float]


def _last(motion: Trajectory, periods: float | None) -> Stretch:
    """So many periods at the end of a motion, None: all of it."""
    start = motion.start_time if periods is None else max(motion.start_time, motion.end - periods * motion.period)
    return start, motion.end


def _detail(motion: Trajectory) -> Stretch:
    """What histories show in detail: the last periods; of a motion that is at rest in them, how it came to rest."""
    start, end = _last(motion, DETAIL_PERIODS)
    states = np.array([motion[name] for name in motion.state_names])
    ranges = np.maximum(np.ptp(states, axis=1, keepdims=True), np.finfo(float).tiny)
    moved = np.abs(states - states[:, -1:]) / ranges
    if start <= motion.start_time or np.max(moved[:, motion.time >= start]) > AT_REST:
        return start, end
    moving = motion.time[np.any(moved > NEARLY_AT_REST, axis=0)]
    begin = motion.start_time
    return begin, min(end, begin + 1.25 * float(np.max(moving, initial=begin) - begin))


def _history(motion: Trajectory, name: str, stretch: Stretch, ax: Axes, shaded: bool) -> Axes:
    """A quantity over a stretch of a motion; shaded: where the contact sticks."""
    trace, period = Trace(motion, *stretch), motion.period
    with style():
        shaded = shaded and shade_stick(ax, motion, *stretch, period)
        ax.plot(trace.time / period, trace[name], **LAST)
        if name not in ("position", motion.system.machine.place):
            ax.axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
        ax.set(ylabel=_label(motion, name), xlabel=LABELS["periods"])
        stopped = _mark_stop(ax, motion, period)
        if stretch != _last(motion, None):
            ax.set_xlim(stretch[0] / period, stretch[1] / period)
        if shaded or stopped:
            legend_above(ax)
    return ax


@in_own_lines
def draw_load(motion: Trajectory, *, periods: float | None = None, ax: Axes | None = None) -> Axes:
    """The normal load of a motion over time in drive periods, with the line where the ground would have to pull.

    A load that follows the motion is drawn as it is, and where it vanishes the end of the run is marked. A constant
    load is drawn beside the true one (thin), and hatched where that is negative: the machine would have lifted off.

    periods: so many at the end, by default all. Returns the axes: `ax`, or those of a new figure. Raises ArgumentError
    for a machine that does not know its load.
    """
    if "reaction" not in motion.observable_names:
        raise ArgumentError("what", f"the {motion.system.machine.name} does not say how its load follows the motion")
    return _load(motion, _last(motion, periods), given_axes(ax))


def _load(motion: Trajectory, stretch: Stretch, ax: Axes) -> Axes:
    trace, period, machine = Trace(motion, *stretch), motion.period, motion.system.machine
    load = trace["reaction"]
    with style():
        ax.axhline(0.0, color=BLACK, linewidth=0.8, zorder=1)
        if machine.follows_load:
            ax.plot(trace.time / period, load, **LAST)
        else:
            given = float(motion.system.placed.loads()[0]) * scale("reaction", motion.system)
            ax.plot(trace.time[[0, -1]] / period, [given, given], **GIVEN, label="constant load")
            ax.plot(trace.time / period, load, **TRUE, label="true load")
            if np.min(load) < 0.0:
                below = np.minimum(load, 0.0)
                ax.fill_between(trace.time / period, below, 0.0, **PULLING, label="the ground would have to pull")
        _mark_stop(ax, motion, period)
        ax.set(ylabel=_label(motion, "reaction"), xlabel=LABELS["periods"])
        if stretch != _last(motion, None):
            ax.set_xlim(stretch[0] / period, stretch[1] / period)
        if ax.get_legend_handles_labels()[0]:
            legend_above(ax)
    return ax


@in_own_lines
def draw_phase_plane(motion: Trajectory, x: str | None = None, y: str | None = None, *, ax: Axes | None = None) -> Axes:
    """One quantity of a motion over another: the last period over the first ones.

    x, y: by default the first state and its rate, of an imposed motion itself and the force it takes; "position" of
        what travels is drawn less the steady travel, so that a steady motion closes
    Returns the axes: `ax`, or those of a new figure.
    """
    return _phase_plane(motion, x, y, _last(motion, 1), given_axes(ax, (5.0, 3.6)))


def _phase_plane(motion: Trajectory, x: str | None, y: str | None, recent: Stretch, ax: Axes) -> Axes:
    inner, rate = _inner_plane(motion)
    x, y = x or inner, y or rate
    period, begin, (last, end) = motion.period, motion.start_time, recent
    parts = [(Trace(motion, last, end), LAST, "last period" if recent == _last(motion, 1) else "to rest")]
    if last > begin:
        first = Trace(motion, begin, min(last, begin + FIRST_PERIODS * period))
        parts.insert(0, (first, FAINT, "first periods"))
    travels = x == _place(motion) and motion.system.cyclic is not None and end - begin >= period
    size = scale(x, motion.system)
    speed = size * float(np.diff(motion.at([last, end], x))[0]) / period if travels else 0.0
    origin = _relative(parts[-1][0], x, speed).mean() if travels else 0.0
    with style():
        for trace, look, label in parts:
            ax.plot(_relative(trace, x, speed) - origin, trace[y], **look, label=label)
        trace = parts[-1][0]
        ax.plot(_relative(trace, x, speed)[-1:] - origin, trace[y][-1:], **END, label="end")
        steady = r"position less steady travel $X - \langle X' \rangle\,\tau$"
        place = with_unit(steady, x, motion.system) if travels else _label(motion, x)
        ax.set(xlabel=place, ylabel=_label(motion, y))
        ax.locator_params(axis="x", nbins=7)
        legend_above(ax)
    return ax


def _relative(trace: Trace, name: str, speed: float) -> np.ndarray:
    return trace[name] - speed * trace.time


@in_own_lines
def draw_friction_loop(motion: Trajectory, *, contact: int = 1, ax: Axes | None = None) -> Axes:
    """Friction over sliding velocity in the last period: accelerating, decelerating and stuck.

    contact: which, of a machine with several. Returns the axes: `ax`, or those of a new figure. Raises ArgumentError
    for a contact that there is not.
    """
    if contact not in (contacts := contacts_of(motion)):
        raise ArgumentError("contact", f"should be a whole number from 1 to {contacts[-1]}, got {contact!r}")
    return _friction_loop(motion, contact, _last(motion, 1), given_axes(ax, (5.0, 3.6)))


def _friction_loop(motion: Trajectory, contact: int, recent: Stretch, ax: Axes) -> Axes:
    trace = Trace(motion, *recent)
    names = numbered("contact_velocity", contact), numbered("friction", contact)
    velocity, friction = (trace[name] for name in names)
    stuck = np.zeros(len(velocity), bool)
    if motion.system.laws[contact - 1].kind == "set-valued":
        stuck = trace[numbered("side", contact)] == STUCK
    faster = np.append(np.diff(np.abs(velocity)) > 0.0, False)
    ends = np.flatnonzero(np.append(trace.index[1:] != trace.index[:-1], True))
    faster[ends] = faster[np.maximum(ends - 1, 0)]  # the last point of a piece goes on as the piece does
    with style():
        ax.update_datalim([(0.0, 0.0)])  # a constant force is no line without a place
        for chosen, look, label in (
            (stuck, HELD, "stuck"),
            (faster & ~stuck, FASTER, "accelerating"),
            (~faster & ~stuck, SLOWER, "decelerating"),
        ):
            if chosen.any():
                ax.plot(*_runs(velocity, friction, chosen, trace.index), **look, label=label)
        last = ", last period" if recent == _last(motion, 1) else ""
        ax.set(xlabel=_label(motion, names[0]) + last, ylabel=_label(motion, names[1]))
        ax.locator_params(axis="x", nbins=7)
        legend_above(ax)
    return ax


def _runs(x: np.ndarray, y: np.ndarray, chosen: np.ndarray, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The chosen points of a line, cut by NaN where it goes on elsewhere; each run ends on the next point of its piece.

    Where the force jumps from one piece to the next, as a set-valued contact's does, or the velocity in an impact,
    nothing is drawn across.
    """
    joined = np.append(False, chosen[:-1] & (pieces[1:] == pieces[:-1]))
    kept = np.flatnonzero(chosen | joined)
    jumps = (np.abs(np.diff(x)) > JUMP * np.ptp(x)) & (pieces[1:] != pieces[:-1])
    breaks = np.flatnonzero((np.diff(kept) > 1) | ~(chosen[kept[:-1]]) | jumps[kept[:-1]]) + 1
    at = kept.astype(float)
    at = np.insert(at, breaks, np.nan)
    empty = np.isnan(at)
    index = np.where(empty, 0, at).astype(int)
    return np.where(empty, np.nan, x[index]), np.where(empty, np.nan, y[index])


def _time_histories(axes: Any, motion: Trajectory, detail: Stretch) -> None:
    """The position over the whole run, then angle, velocity and friction in detail."""
    _whole_run(axes[0], motion, detail)
    moving = _body_velocity(motion)
    names = (_inner_plane(motion)[0], moving, "friction")
    for ax, name, title in zip(axes[1:], names, (_inner_name(motion), _body_name(motion), "Contact"), strict=True):
        _history(motion, name, detail, ax, shaded=True).set_title(title)
        _mark_impacts(ax, motion, detail) if name == moving else None
        if name != moving and (legend := ax.get_legend()):
            legend.remove()


def _whole_run(ax: Axes, motion: Trajectory, detail: Stretch) -> None:
    """The place over the whole run, beside the reference where it is what is controlled."""
    period, place = motion.period, _place(motion)
    what = ("Place" if motion.system.cyclic is None else "Travel") + " of body 1" * (len(contacts_of(motion)) > 1)
    _history(motion, place, _last(motion, None), ax, shaded=False).set_title(f"{what} over the whole run")
    if motion.system.controller is not None and motion.system.controller.compared(motion.system.machine) == place:
        trace = Trace(motion, *_last(motion, None))
        ax.plot(trace.time / period, trace["reference"], **GIVEN, label="reference")
    if detail != _last(motion, None):
        ax.axvspan(detail[0] / period, detail[1] / period, color=SKY, alpha=0.25, linewidth=0, label="shown below")
    if ax.get_legend_handles_labels()[0]:
        legend_above(ax)


def _mark_impacts(ax: Axes, motion: Trajectory, stretch: Stretch) -> None:
    """A mark at every impact within a stretch, on the edge of the panel."""
    times = [event.time for event in motion.events if event.kind == IMPACT and stretch[0] <= event.time <= stretch[1]]
    if times:
        ax.plot(np.array(times) / motion.period, np.zeros(len(times)), transform=ax.get_xaxis_transform(), **STRUCK)
        legend_above(ax)


def _control(axes: Any, motion: Trajectory, stretch: Stretch) -> None:
    """What a controller sees and does: the error, or the reference of a function of states, and the command."""
    controller, system = motion.system.controller, motion.system
    followed, trace, period = controller.compared(system.machine), Trace(motion, *stretch), motion.period
    error = trace["reference"] - (trace[followed] if followed else 0.0)
    with style():
        axes[0].plot(trace.time / period, error, **LAST)
        axes[0].axhline(0.0, color="#808080", linewidth=0.6, zorder=1)
        label = "error $r - y$" if followed else "reference $r$"
        axes[0].set(title="Controller", ylabel=with_unit(label, followed or "reference", system))
        axes[0].set_xlim(stretch[0] / period, stretch[1] / period)
        _history(motion, "drive", stretch, axes[1], shaded=False).set_title("Actuator")
        axes[1].set_xlim(stretch[0] / period, stretch[1] / period)
        if (limit := getattr(controller, "limit", None)) is not None:
            for sign in (1.0, -1.0):
                axes[1].axhline(sign * limit * scale("drive", system), **GIVEN, label="limit" if sign > 0 else None)
            legend_above(axes[1])


def _share_time(axes: Any) -> None:
    """The axis of time below the last of some histories serves them all."""
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")


def _histories_of_all(axes: Any, motion: Trajectory, detail: Stretch) -> None:
    """The position over the whole run, then all gaps, velocities, friction forces and modes in detail."""
    _whole_run(axes[0], motion, detail)
    contacts = contacts_of(motion)
    gaps = [name for name in motion.state_names if number_in(name, "displacement")]
    machine = motion.system.machine
    imposed = machine.imposes_distances  # its velocities are no states, and its gaps are shares of the drive
    bodies = [numbered("contact_velocity", each) for each in contacts] if imposed else machine.contact_states
    places = [name for name in (numbered("position", each) for each in contacts) if name in motion.names]
    second = ["drive"] if imposed else gaps or places or [_place(motion)]
    words = "displacement $z$" if imposed else "gap $z_i$" if gaps else "position $x_i$"
    draw_all(motion, second, words, detail, axes[1])
    draw_all(motion, bodies, "velocity $v_i$", detail, axes[2])
    draw_all(motion, [numbered("friction", each) for each in contacts], "friction force $R_i$", detail, axes[3])
    draw_modes(motion, detail, axes[4])
    titles = "Gaps" if imposed or gaps else "Positions", "Bodies", "Contacts", "Modes"
    for ax, title in zip(axes[1:], titles, strict=True):
        ax.set(title=title)
    _mark_impacts(axes[2], motion, detail)


def _planes(motion: Trajectory) -> list[tuple[str, str, str]]:
    """(title, x, y) of the phase planes of a sheet: what moves within, and the body that rubs if it is another."""
    inner, body = _inner_plane(motion), (_place(motion), _body_velocity(motion))
    title = "Actuator" if motion.system.machine.imposes_motion else _inner_name(motion)
    return [(title, *inner)] + ([(_body_name(motion), *body)] if body != inner else [])


def _place(motion: Trajectory) -> str:
    """The place of what rubs: the position, or the state that is it in a machine of one's own."""
    return "position" if "position" in motion.names else motion.system.machine.place or motion.state_names[0]


def _inner_plane(motion: Trajectory) -> tuple[str, str]:
    """(inner motion, its rate); of an imposed one (the motion, the force or torque that it takes)."""
    if motion.system.machine.imposes_motion:
        taken = [name for name in motion.observable_names if name.startswith("actuator_") and name != "actuator_power"]
        return "drive", (*taken, "contact_velocity")[0]
    inner, rate = motion.state_names[2:4] if _held_row(motion) else motion.state_names[:2]
    return inner, rate


def _held_row(motion: Trajectory) -> bool:
    """Whether it is one of a row of blocks that are held to their places, whose states stand block by block."""
    machine = motion.system.machine
    return len(machine.contact_states) > 1 and machine.cyclic is None


def _body_velocity(motion: Trajectory) -> str:
    """The velocity of the body that rubs; with an imposed motion the state is that of the common centre."""
    machine = motion.system.machine
    return "contact_velocity" if machine.imposes_motion else machine.contact_states[0]


def _body_name(motion: Trajectory) -> str:
    """What slides."""
    if len(motion.system.machine.contact_states) > 1:
        return "Body 1"
    return "Block" if motion.system.cyclic is None else "Capsule"


def _inner_name(motion: Trajectory) -> str:
    """What moves within the capsule, or the block; of a row of bodies, the first gap, or the second of held ones."""
    machine = motion.system.machine
    if _held_row(motion):
        return "Body 2"
    if len(machine.contact_states) > 1:
        return "Gap 1"
    if machine.imposes_motion:
        return "Imposed motion"
    first = motion.state_names[0]
    if first == "position":
        return _body_name(motion)
    known = {"approach": "Block, across the belt", "angle": "Pendulum"}
    return known.get(first, "Inner motion" if machine.cyclic else first.replace("_", " ").capitalize())


def _label(motion: Trajectory, name: str) -> str:
    """The axis label of a quantity, with its unit where that is known."""
    return with_unit(quantity_label(name, motion.system), name, motion.system)
