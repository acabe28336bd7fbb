"""Pictures of motions: time histories, phase planes, the friction loop and the normal load."""

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import STUCK, Trajectory
from vibrocap.physics.names import name_and_number, numbered
from vibrocap.plotting import histories as panel
from vibrocap.plotting.histories import Trace
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import IN_SI, parts_in_si, parts_title, quantity_label, scale, with_unit
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLACK, BLUE, VERMILION

FIRST_PERIODS = 12  # grey in the phase planes
JUMP = 1e-6  # of the range of a velocity: by how much two pieces differ where it jumps
LEAST_WHOLE = 3.0  # on an axis of time, from which its numbers are whole ones
WIDTH = 11.5  # inches of the whole picture
PRINTED = 1.25  # inches: the height of a panel that is fitted to a page
FASTER: dict[str, Any] = {"color": VERMILION, "linewidth": 1.6, "linestyle": "-", "zorder": 3}
SLOWER: dict[str, Any] = {"color": BLUE, "linewidth": 1.6, "linestyle": (0, (4, 1.5)), "zorder": 4}
HELD: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 3.0, "linestyle": "-", "zorder": 2}
# a legend beside a title of some length
CLOSE: dict[str, Any] = {"handlelength": 0.8, "handletextpad": 0.5, "columnspacing": 0.6}
END: dict[str, Any] = {"color": BLACK, "marker": "o", "markersize": 4, "linestyle": "none", "zorder": 5}


def motion_figure(motion: Trajectory) -> Figure:
    """A motion: time histories on the left, phase planes and the friction loop on the right.

    The histories show the last periods in detail; of a motion that comes to rest, how it does. The phase plane of the
    capsule shows its position relative to the mean travel, in which a steady motion closes. Of a load that follows the
    motion, and of a constant one that hides a lift-off, the load is shown as well; of a machine on several contacts
    velocity, friction and mode of every one; of a controlled one the reference, the error and the command. Marked is
    from when on a driven motion has settled.
    """
    system = motion.system
    width, narrow = page().width_or(WIDTH), page().narrow
    title = parts_title(system.parts, width) if system.units is None else parts_in_si(system, width)
    detail, recent = panel.shown_in_detail(motion), _recent(motion)
    histories, planes = _histories(motion), _planes(motion)
    rows, below = 1 + len(histories), 1.2 * len(planes)
    if page().width is None:
        height = 1.3 + 1.6 * rows + 0.17 * (title.count("\n") + 1)
    else:
        height = PRINTED * (rows + below * narrow)
    with plots.new_figure((width, height)) as fig:
        if narrow:
            left, right = fig.subfigures(2, 1, squeeze=False, height_ratios=(rows, below))[:, 0]
        else:
            left, right = fig.subfigures(1, 2, squeeze=False, width_ratios=(1.55, 1.0), wspace=0.02)[0]
        whole, *axes = left.subplots(rows, 1)
        panel.whole_run(whole, motion, detail)
        for ax, (words, draw) in zip(axes, histories, strict=True):
            ax.set_title(words)
            draw(motion, detail, ax)
        _share(axes)
        left.align_ylabels()
        for number, (ax, (words, draw)) in enumerate(zip(right.subplots(len(planes), 1), planes, strict=True)):
            ax.set_title(words)
            draw(motion, recent, ax)
            if 0 < number < len(planes) - 1 and words != "Bodies" and (legend := ax.get_legend()):
                legend.remove()  # as above
        right.align_ylabels()
        plots.setting(fig, title)
        own = plots.ANY_UNITS if type(system.machine).gravity is None else plots.DIMENSIONLESS
        plots.footnote(fig, f"{own if system.units is None else IN_SI} {panel.settled_words(motion)}".strip())
    return fig


def _share(axes: Any) -> None:
    """The axis of time below the last of some histories serves them all, and one legend says what sticks."""
    explained = False
    for ax in axes:
        if ax is not axes[-1]:
            ax.tick_params(labelbottom=False)
            ax.set_xlabel("")
        if np.ptp(ax.get_xlim()) >= LEAST_WHOLE:
            ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        if (legend := ax.get_legend()) and [text.get_text() for text in legend.get_texts()] == ["stuck"]:
            legend.remove() if explained else None
            explained = True


def draw_phase_plane(motion: Trajectory, x: str | None = None, y: str | None = None, *, ax: Axes | None = None) -> Axes:
    """One quantity of a motion over another: the last response over the first periods.

    x, y: by default the first state and its rate, of an imposed motion itself and the force it takes; "position" of
        what travels is drawn less the steady travel, so that a steady motion closes
    """
    inner, rate = _inner_plane(motion) or (panel.place_of(motion), _velocities(motion)[0])
    with plots.drawing(ax, (5.0, 3.6)) as ax:
        return _phase_plane(x or inner, y or rate, motion, _recent(motion), ax)


def _recent(motion: Trajectory) -> panel.Stretch:
    """What planes and loops show: the last response; the detail of what comes to rest, or is not driven in time."""
    detail = panel.shown_in_detail(motion)
    if detail[1] < motion.end or not equations(motion.system).timed:
        return detail
    return panel.last_periods(motion, panel.repeats_after(motion))


def _words(motion: Trajectory, recent: panel.Stretch) -> str:
    after = panel.repeats_after(motion)
    if recent == panel.last_periods(motion, after) and equations(motion.system).timed:
        return "last period" if after == 1 else f"last {after} periods"
    return "detail"


def _phase_plane(x: str, y: str, motion: Trajectory, recent: panel.Stretch, ax: Axes) -> Axes:
    period, begin, (last, end) = motion.period, motion.start_time, recent
    parts = [(Trace(motion, last, end), panel.LAST, _words(motion, recent))]
    if last > begin:
        first = Trace(motion, begin, min(last, begin + FIRST_PERIODS * period))
        parts.insert(0, (first, panel.FAINT, "first periods" if parts[0][2] != "detail" else "before"))
    shift, place = _relative(motion, x, recent)
    for trace, look, label in parts:
        ax.plot(trace[x] - shift(trace), trace[y], **look, label=label)
    trace = parts[-1][0]
    ax.plot((trace[x] - shift(trace))[-1:], trace[y][-1:], **END, label="end")
    ax.set(xlabel=place, ylabel=panel.label_of(motion, y))
    ax.locator_params(axis="x", nbins=7)
    plots.legend_above(ax)
    return ax


def _planes_of_all(motion: Trajectory, recent: panel.Stretch, ax: Axes) -> None:
    trace, places = Trace(motion, *recent), panel.places_of(motion)
    for number, (x, y) in enumerate(zip(places, _velocities(motion), strict=True), start=1):
        shift, label = _relative(motion, x, recent)
        ax.plot(trace[x] - shift(trace), trace[y], label=f"{number}", **panel.line_of(number, len(places)))
        ax.set_xlabel(re.sub(r"_\{?\d\}?", "_i", label))
    ax.set_ylabel(with_unit("velocity $v_i$", _velocities(motion)[0], motion.system))
    ax.locator_params(axis="x", nbins=7)
    panel.numbers_above(ax)


def _relative(motion: Trajectory, name: str, recent: panel.Stretch) -> tuple[Callable[[Trace], Any], str]:
    """(what a quantity is drawn less of, at the times of a trace, and its label): of what travels the steady travel."""
    system, (start, end) = motion.system, recent
    start = min(start, end - motion.period)
    if name not in panel.places_of(motion) or system.cyclic is None or start < motion.start_time:
        return lambda trace: 0.0, panel.label_of(motion, name)
    speed = float(np.diff(motion.at([start, end], name))[0]) * scale(name, system) / (end - start)
    shown = Trace(motion, *recent)
    origin = float(np.mean(shown[name] - speed * shown.time))
    *_, words, symbol = quantity_label(name, system).split(" ")
    time = r"\tau" if system.units is None else "t"
    steady = rf"{words} less steady travel {symbol[:-1]} - \langle {symbol[1:-1]}' \rangle\,{time}$"
    return lambda trace: speed * trace.time + origin, with_unit(steady, name, system)


def draw_friction_loop(motion: Trajectory, *, contact: int = 1, ax: Axes | None = None) -> Axes:
    """Friction over sliding velocity in the last response: accelerating, decelerating and stuck.

    contact: which, of a machine with several. Raises ArgumentError
    for a contact that there is not.
    """
    if contact not in (contacts := panel.contacts_of(motion)):
        raise ArgumentError("contact", f"should be a whole number from 1 to {contacts[-1]}, got {contact!r}")
    with plots.drawing(ax, (5.0, 3.6)) as ax:
        return _friction_loop(motion, _recent(motion), ax, contact)


def _friction_loop(motion: Trajectory, recent: panel.Stretch, ax: Axes, contact: int = 1) -> Axes:
    trace = Trace(motion, *recent)
    names = numbered("contact_velocity", contact), numbered("friction", contact)
    velocity, friction = (trace[name] for name in names)
    stuck = np.zeros(len(velocity), bool)
    if motion.system.laws[contact - 1].kind == "set-valued":
        stuck = trace[numbered("side", contact)] == STUCK
    faster = np.append(np.diff(np.abs(velocity)) > 0.0, False)
    ends = np.flatnonzero(np.append(trace.index[1:] != trace.index[:-1], True))
    faster[ends] = faster[np.maximum(ends - 1, 0)]  # the last point of a piece goes on as the piece does
    ax.update_datalim([(0.0, 0.0)])  # a constant force is no line without a place
    for part, look, label in (
        (stuck, HELD, "stuck"),
        (faster & ~stuck, FASTER, "accelerating"),
        (~faster & ~stuck, SLOWER, "decelerating"),
    ):
        if part.any():
            ax.plot(*_runs(velocity, friction, part, trace.index), **look, label=label)
    if stuck.any() and np.ptp(friction[stuck]) < JUMP * np.ptp(friction):  # one force: no line, but a dot
        ax.plot([0.0], [np.mean(friction[stuck])], "s", color=HELD["color"], markersize=4.0)
    ax.set(xlabel=panel.label_of(motion, names[0]), ylabel=panel.label_of(motion, names[1]))
    ax.set_title(f"Friction, {_words(motion, recent)}")
    ax.locator_params(axis="x", nbins=7)
    plots.legend_above(ax, **({"fontsize": 7.5} if page().width is None else {}), **CLOSE)
    return ax


def _runs(x: np.ndarray, y: np.ndarray, part: np.ndarray, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The chosen points of a line, cut by NaN where it goes on elsewhere; each run ends on the next point of its piece.

    Where the force jumps from one piece to the next, as a set-valued contact's does, or the velocity in an impact,
    nothing is drawn across.
    """
    joined = np.append(False, part[:-1] & (pieces[1:] == pieces[:-1]))
    kept = np.flatnonzero(part | joined)
    jumps = (np.abs(np.diff(x)) > JUMP * np.ptp(x)) & (pieces[1:] != pieces[:-1])
    breaks = np.flatnonzero((np.diff(kept) > 1) | ~(part[kept[:-1]]) | jumps[kept[:-1]]) + 1
    at = kept.astype(float)
    at = np.insert(at, breaks, np.nan)
    empty = np.isnan(at)
    index = np.where(empty, 0, at).astype(int)
    return np.where(empty, np.nan, x[index]), np.where(empty, np.nan, y[index])


Draw = Callable[[Trajectory, panel.Stretch, Axes], Any]


def _histories(motion: Trajectory) -> list[tuple[str, Draw]]:
    """(title, how it is drawn) of the histories of a sheet below the whole run."""
    machine, several = motion.system.machine, len(panel.contacts_of(motion)) > 1
    inner, moving = _inner(motion), panel.body_of(motion).capitalize()
    panels: list[tuple[str, Draw]] = [(_inner_title(motion), _over_time(inner))]
    if several:
        frictions = [numbered("friction", contact) for contact in panel.contacts_of(motion)]
        panels += [("Bodies", _over_time(_velocities(motion), "velocity $v_i$"))]
        panels += [("Contacts", _over_time(frictions, "friction force $R_i$")), ("Modes", panel.draw_modes)]
    else:
        panels += [(moving, _over_time([_velocities(motion)[0]])), ("Contact", _over_time(["friction"]))]
    if motion.system.controller is not None:
        panels += [("Controller", panel.error_panel), ("Actuator", panel.command_panel)]
    if machine.follows_load or panel.hides_lift_off(motion):
        panels += [("Loads" if several else "Load", panel.load_panel)]
    return panels


def _over_time(names: list[str], label: str = "") -> Draw:
    """Quantities of one kind over time; of one where it sticks is shaded. Impacts are marked below velocities."""

    def draw(motion: Trajectory, detail: panel.Stretch, ax: Axes) -> None:
        several = len(panel.contacts_of(motion)) > 1
        if several or len(names) > 1:
            one = quantity_label(names[0], motion.system)
            words = label or (re.sub(r"(_\{?\d\}?)?('*)\$$", r"_i\2$", one) if len(names) > 1 else one)
            panel.draw_all(motion, names, words, detail, ax)
        else:
            panel.history(motion, names[0], detail, ax, shaded=True)
        if names[0] == _velocities(motion)[0]:
            panel.mark_impacts(ax, motion, detail)

    return draw


def _planes(motion: Trajectory) -> list[tuple[str, Draw]]:
    """(title, how it is drawn) of the phase planes of a sheet and of its friction loop."""
    several, inner = len(panel.contacts_of(motion)) > 1, _inner_plane(motion)
    body = panel.place_of(motion), _velocities(motion)[0]
    number = " 1" * (len(_inner(motion)) > 1)
    title = "Actuator" if motion.system.machine.imposes_motion else f"{_inner_words(motion)}{number}"
    planes: list[tuple[str, Draw]] = [(title, partial(_phase_plane, *inner))] if inner else []
    if len(panel.places_of(motion)) == len(panel.contacts_of(motion)) > 1:
        planes += [("Bodies", _planes_of_all)]
    else:
        planes += [(panel.body_of(motion).capitalize(), partial(_phase_plane, *body))]
    words = f"Friction, {_words(motion, _recent(motion))}"
    return [*planes, (words, panel.draw_all_loops if several else _friction_loop)]


def _inner(motion: Trajectory) -> list[str]:
    """What moves within: what is imposed, or a coordinate and its like; where there is no other, the place."""
    machine, place = motion.system.machine, panel.place_of(motion)
    if machine.imposes_motion:
        return ["drive"]
    first = next(iter(machine.coordinates))
    if len(machine.contact_states) > 1:
        first = next((name for name in machine.coordinates if name != place), place)
    alike = [name for name in machine.coordinates if name_and_number(name)[0] == name_and_number(first)[0]]
    return [first] if first == place and len(machine.contact_states) == 1 else alike


def _inner_title(motion: Trajectory) -> str:
    inner = _inner(motion)
    if inner == ["drive"]:
        return "Imposed motion"
    if inner == [panel.place_of(motion)]:
        return panel.body_of(motion).capitalize()
    return _inner_words(motion) + "s" * (len(inner) > 1)


def _inner_words(motion: Trajectory) -> str:
    return re.sub(r" \$.*", "", quantity_label(_inner(motion)[0], motion.system)).capitalize()


def _inner_plane(motion: Trajectory) -> tuple[str, str] | None:
    """(inner motion, its rate), of an imposed one (the motion, the force or torque that it takes); None where no state
    is its rate, or it is the body itself."""
    if motion.system.machine.imposes_motion:
        taken = [name for name in motion.observable_names if name.startswith("actuator_") and name != "actuator_power"]
        return "drive", (*taken, "contact_velocity")[0]
    first = _inner(motion)[0]
    rate = motion.system.machine.coordinates[first]
    return None if first == panel.place_of(motion) or rate not in motion.names else (first, rate)


def _velocities(motion: Trajectory) -> list[str]:
    """The velocities of the bodies that rub; with an imposed motion the state is that of the common centre."""
    machine = motion.system.machine
    if machine.imposes_motion:
        return [numbered("contact_velocity", contact) for contact in panel.contacts_of(motion)]
    return list(machine.contact_states)
