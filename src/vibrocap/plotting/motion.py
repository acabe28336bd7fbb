"""Pictures of motions: time histories, phase planes, the friction loop and the normal load."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.arguments import ArgumentError
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.names import number_in, numbered
from vibrocap.plotting.contact_panels import contacts_of, draw_all, draw_all_loops, draw_modes
from vibrocap.plotting.histories import (
    FAINT,
    LAST,
    Stretch,
    body_of,
    control_panels,
    hides_lift_off,
    history,
    label_of,
    last_periods,
    load_panel,
    mark_impacts,
    place_of,
    shown_in_detail,
    whole_run,
)
from vibrocap.plotting.look.colours import BLACK, BLUE, VERMILION
from vibrocap.plotting.look.labels import IN_SI, parts_in_si, parts_title, quantity_label, scale, with_unit
from vibrocap.plotting.look.own_lines import in_own_lines
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import (
    ANY_UNITS,
    DIMENSIONLESS,
    blank_figure,
    footnote,
    given_axes,
    legend_above,
    setting,
    style,
)
from vibrocap.plotting.look.trace import Trace

FIRST_PERIODS = 12  # grey in the phase planes
JUMP = 1e-6  # of the range of a velocity: by how much two pieces differ where it jumps
WIDTH = 11.5  # inches of the whole picture
PRINTED = 1.25  # inches: the height of a panel that is fitted to a page
FASTER: dict[str, Any] = {"color": VERMILION, "linewidth": 1.6, "linestyle": "-", "zorder": 3}
SLOWER: dict[str, Any] = {"color": BLUE, "linewidth": 1.6, "linestyle": (0, (4, 1.5)), "zorder": 4}
HELD: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 3.0, "linestyle": "-", "zorder": 2}
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
    title = parts_title(system.parts, width) if system.units is None else parts_in_si(system, width)
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
        axes, detail = left.subplots(rows, 1), shown_in_detail(motion)
        if several:
            _histories_of_all(axes[:5], motion, detail)
        else:
            _time_histories(axes[:4], motion, detail)
        if system.controller is not None:
            control_panels(axes[4 + several : 6 + several], motion, detail)
        if loaded:
            load_panel(motion, detail, axes[-1]).set_title("Loads" if several else "Load")
        _share_time(axes[1:])
        left.align_ylabels()
        shown = _planes(motion)
        *planes, loop = right.subplots(len(shown) + 1, 1)
        recent = last_periods(motion, 1) if detail[1] == motion.end else detail
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


# --- single panels ----------------------------------------------------------------------------------------------------


@in_own_lines
def draw_phase_plane(motion: Trajectory, x: str | None = None, y: str | None = None, *, ax: Axes | None = None) -> Axes:
    """One quantity of a motion over another: the last period over the first ones.

    x, y: by default the first state and its rate, of an imposed motion itself and the force it takes; "position" of
        what travels is drawn less the steady travel, so that a steady motion closes
    Returns the axes: `ax`, or those of a new figure.
    """
    return _phase_plane(motion, x, y, last_periods(motion, 1), given_axes(ax, (5.0, 3.6)))


def _phase_plane(motion: Trajectory, x: str | None, y: str | None, recent: Stretch, ax: Axes) -> Axes:
    inner, rate = _inner_plane(motion)
    x, y = x or inner, y or rate
    period, begin, (last, end) = motion.period, motion.start_time, recent
    parts = [(Trace(motion, last, end), LAST, "last period" if recent == last_periods(motion, 1) else "to rest")]
    if last > begin:
        first = Trace(motion, begin, min(last, begin + FIRST_PERIODS * period))
        parts.insert(0, (first, FAINT, "first periods"))
    travels = x == place_of(motion) and motion.system.cyclic is not None and end - begin >= period
    size = scale(x, motion.system)
    speed = size * float(np.diff(motion.at([last, end], x))[0]) / period if travels else 0.0
    origin = _relative(parts[-1][0], x, speed).mean() if travels else 0.0
    with style():
        for trace, look, label in parts:
            ax.plot(_relative(trace, x, speed) - origin, trace[y], **look, label=label)
        trace = parts[-1][0]
        ax.plot(_relative(trace, x, speed)[-1:] - origin, trace[y][-1:], **END, label="end")
        words, symbol = ("position", "$X$") if x == "position" else quantity_label(x, motion.system).rsplit(" ", 1)
        steady = rf"{words} less steady travel {symbol[:-1]} - \langle {symbol[1:-1]}' \rangle\,\tau$"
        place = with_unit(steady, x, motion.system) if travels else label_of(motion, x)
        ax.set(xlabel=place, ylabel=label_of(motion, y))
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
    return _friction_loop(motion, contact, last_periods(motion, 1), given_axes(ax, (5.0, 3.6)))


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
        last = ", last period" if recent == last_periods(motion, 1) else ""
        ax.set(xlabel=label_of(motion, names[0]) + last, ylabel=label_of(motion, names[1]))
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
    whole_run(axes[0], motion, detail)
    moving = _body_velocity(motion)
    names = (_inner_plane(motion)[0], moving, "friction")
    for ax, name, title in zip(
        axes[1:], names, (_inner_name(motion), body_of(motion).capitalize(), "Contact"), strict=True
    ):
        history(motion, name, detail, ax, shaded=True).set_title(title)
        mark_impacts(ax, motion, detail) if name == moving else None
        if name != moving and (legend := ax.get_legend()):
            legend.remove()


def _share_time(axes: Any) -> None:
    """The axis of time below the last of some histories serves them all."""
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")


def _histories_of_all(axes: Any, motion: Trajectory, detail: Stretch) -> None:
    """The position over the whole run, then all gaps, velocities, friction forces and modes in detail."""
    whole_run(axes[0], motion, detail)
    contacts = contacts_of(motion)
    gaps = [name for name in motion.state_names if number_in(name, "displacement")]
    machine = motion.system.machine
    imposed = machine.imposes_distances  # its velocities are no states, and its gaps are shares of the drive
    bodies = [numbered("contact_velocity", each) for each in contacts] if imposed else machine.contact_states
    places = [name for name in (numbered("position", each) for each in contacts) if name in motion.names]
    second = ["drive"] if imposed else gaps or places or [place_of(motion)]
    words = "displacement $z$" if imposed else "gap $z_i$" if gaps else "position $x_i$"
    draw_all(motion, second, words, detail, axes[1])
    draw_all(motion, bodies, "velocity $v_i$", detail, axes[2])
    draw_all(motion, [numbered("friction", each) for each in contacts], "friction force $R_i$", detail, axes[3])
    draw_modes(motion, detail, axes[4])
    titles = "Gaps" if imposed or gaps else "Positions", "Bodies", "Contacts", "Modes"
    for ax, title in zip(axes[1:], titles, strict=True):
        ax.set(title=title)
    mark_impacts(axes[2], motion, detail)


def _planes(motion: Trajectory) -> list[tuple[str, str, str]]:
    """(title, x, y) of the phase planes of a sheet: what moves within, and the body that rubs if it is another."""
    inner, body = _inner_plane(motion), (place_of(motion), _body_velocity(motion))
    title = "Actuator" if motion.system.machine.imposes_motion else _inner_name(motion)
    return [(title, *inner)] + ([(body_of(motion).capitalize(), *body)] if body != inner else [])


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


def _inner_name(motion: Trajectory) -> str:
    """What moves within the capsule, or the block; of a row of bodies, the first gap, or the second of held ones."""
    machine = motion.system.machine
    if _held_row(motion):
        return "Body 2"
    if machine.imposes_motion:
        return "Imposed motion"
    first = motion.state_names[0]
    if len(machine.contact_states) > 1 and first == "displacement":
        return "Gap 1"
    if first == place_of(motion):
        return body_of(motion).capitalize()
    known = {"approach": "Block, across the belt", "angle": "Pendulum", "displacement": "Inner motion"}
    return known.get(first, first.replace("_", " ").capitalize())
