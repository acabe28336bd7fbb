"""Pictures of branches: where steady motions travel, how fast, and which of them are stable."""

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrocap.arguments import check_one_of
from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram
from vibrocap.orbits.walk.kinds import CORNERS, SpecialKind
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.physics.dimensions.conversion import Quantity, quantity_in_si
from vibrocap.physics.dimensions.conversion import quantity as quantity_of
from vibrocap.physics.dimensions.units import suffix
from vibrocap.physics.names import split_path
from vibrocap.physics.parameters import parameter_table
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import bracketed, law_words, parts_in_si, parts_title, scale, symbol_text, with_unit
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

QUANTITIES = {
    "mean_velocity": "mean velocity of the steady motion",
    "drift": "drift over one response",
    "period": "period of the steady motion",
}
UNITS = {"mean_velocity": "velocity", "drift": "position", "period": "time"}  # what has the same unit
LINE = 0.16  # inches: the height of a line of parameters above a picture
UNSTABLE = (0, (3.0, 2.2))
LINES: dict[str, dict[str, Any]] = {"stable": {"linewidth": 1.8}, "unstable": {"linewidth": 1.0, "linestyle": UNSTABLE}}
# (marker, size, filled) of each kind: told apart without colour; a fold is drawn around what may be near it
MARKS: dict[SpecialKind, tuple[str, float, bool]] = {
    SpecialKind.PITCHFORK: ("D", 5.5, True),
    SpecialKind.FOLD: ("o", 10.0, False),
    SpecialKind.FLIP: ("s", 5.0, True),
    SpecialKind.NEIMARK_SACKER: ("o", 5.5, True),
    SpecialKind.BRANCH_POINT: ("P", 6.0, True),
    SpecialKind.HOPF: ("h", 7.0, True),
    SpecialKind.MODE_CHANGE: ("|", 7.0, False),
    SpecialKind.GRAZING: ("v", 6.0, True),
    SpecialKind.CHATTER: ("^", 6.0, True),
    SpecialKind.JUMP: ("X", 6.0, True),
    SpecialKind.UNLOCATED: ("x", 6.0, False),
}
WORDS = {SpecialKind.PITCHFORK: "pitchfork: symmetry breaks", SpecialKind.MODE_CHANGE: "change of the mode sequence"}
# An open pitchfork: symmetry breaks where the multipliers jump.
LOSS: dict[str, Any] = {"marker": "D", "markersize": 6.0, "markerfacecolor": "white", "color": BLACK}
LOSS |= {"linestyle": "none", "zorder": 5}
LOSS_WORDS = "symmetry breaks at a change of mode sequence"
# Two halves of one disc: full where both sweeps agree.
HALF: dict[str, Any] = {"marker": "o", "markersize": 4.0, "markerfacecolor": VERMILION, "markerfacecoloralt": "none"}
HALF |= {"markeredgecolor": VERMILION, "markeredgewidth": 0.6}
SWEPT: dict[str, dict[str, Any]] = {"up": HALF | {"fillstyle": "right"}, "down": HALF | {"fillstyle": "left"}}
# Where stable motions end within the range: an arrow to what follows them, a cross where nothing closes.
LEADS, ENDS = "end of stable motions, and their successor", "stable motions end: nothing closes beyond"
LONGER = {2: GREEN, 4: PURPLE, 8: ORANGE}


def branch_figure(
    branches: Branch | BranchDiagram | Sequence[Branch | BranchDiagram],
    quantity: str = "mean_velocity",
    *,
    titles: Sequence[str] = (),
    multipliers: bool = False,
    swept: Sequence[BifurcationDiagram] = (),
    over: str | None = None,
) -> Figure:
    """Mean velocity (drift, period) over a parameter: stable motions solid, unstable dashed, special points marked.

    Of mirror-image solutions, of which a branch holds one, both are drawn. Several diagrams stand side by side, on one
    scale.

    quantity: "mean_velocity", "drift" or "period"; titles: of the panels; by default the friction laws
    multipliers: a second row with the size of the largest Floquet multiplier
    swept: brute force to compare with, one for each panel: settled motions of sweeps up and down
    over: the parameter by another path, such as "drive.frequency_rad_per_s"; by default in SI where the system is
    """
    diagrams = [branches] if isinstance(branches, (Branch, BranchDiagram)) else list(branches)
    _check(diagrams, quantity)
    if swept and [(branch.over, branch.system.law_names) for branch in swept] != [
        (branch.over, branch.system.law_names) for branch in diagrams
    ]:
        raise ValueError("swept should be a diagram for each panel, over its parameter and of its friction law")
    rows, columns = 1 + multipliers, len(diagrams)
    shape: dict[str, Any] = {"sharey": "row", "height_ratios": [3.0, 1.7][:rows]}
    fig, axes = diagram_figure(diagrams, 4.4 * columns + 1.0, 3.4 + 1.9 * multipliers + 0.5, rows, columns, **shape)
    used: set[str] = set()
    with plots.style():
        for column, branch in enumerate(diagrams):
            ax = axes[0, column]
            along = _along(branch, over)
            used |= draw_branches(ax, branch, quantity, along)
            if swept:
                used |= draw_swept(ax, swept[column], quantity, along)
            ax.set_title(titles[column] if titles else law_title(branch), pad=8)
            if multipliers:
                draw_multipliers(axes[1, column], _branches(branch), along)
            axes[-1, column].set(xlabel=parameter_label(branch, over), xlim=_range(branch, along))
        axes[0, 0].set_ylabel(with_unit(QUANTITIES[quantity], UNITS[quantity], diagrams[0].system))
        if multipliers:
            axes[1, 0].set_ylabel("largest\n" + r"multiplier $|\mu|$")
        fig.legend(handles=_handles(diagrams, used), loc="outside lower center", ncols=3 if columns > 1 else 2)
    return fig


def draw_branch(diagram: Branch | BranchDiagram, quantity: str | None = None, *, ax: Axes | None = None) -> Axes:
    """One panel of `branch_figure`: mean velocity, drift or period of steady motions over the parameter.

    quantity: by default the mean velocity, or the period where the machine does not travel
    """
    quantity = quantity or ("mean_velocity" if diagram.system.cyclic is not None else "period")
    _check([diagram], quantity)
    with plots.drawing(ax) as ax:
        used = draw_branches(ax, diagram, quantity, along := _along(diagram))
        ax.set(title=law_title(diagram), xlabel=parameter_label(diagram), xlim=_range(diagram, along))
        ax.set_ylabel(with_unit(quantity.replace("_", " "), UNITS[quantity], diagram.system))
        plots.legend_below(ax, _handles([diagram], used), ncols=2)
    return ax


def draw_floquet_multipliers(diagram: Branch | BranchDiagram, *, ax: Axes | None = None) -> Axes:
    """The size of the largest Floquet multiplier over the parameter: stable below 1."""
    with plots.drawing(ax) as ax:
        draw_multipliers(ax, _branches(diagram), along := _along(diagram))
        ax.set(xlabel=parameter_label(diagram), ylabel=r"largest multiplier $|\mu|$", xlim=_range(diagram, along))
    return ax


def _check(branches: Sequence[Branch | BranchDiagram], quantity: str) -> None:
    if not branches or not any(len(branch) for diagram in branches for branch in _branches(diagram)):
        raise ValueError("found should hold at least one branch that is not empty")
    check_one_of("quantity", quantity, QUANTITIES)
    drifts = [branch.drift for diagram in branches for branch in _branches(diagram)]
    if quantity != "period" and any(np.isnan(drift).any() for drift in drifts):
        raise ValueError("the machine does not travel: its motions have no drift to draw")


def fixed_parameters(diagrams: Sequence[Any], width: float) -> str:
    """The parameters of the systems of branches, each part once, without the one that varies, for a head so wide."""
    width = width if page().width is None else 1.15 * page().width_or(width)  # in smaller letters
    if diagrams[0].system.units is not None:
        return "\n".join(dict.fromkeys(parts_in_si(branch.system, width * 1.1, branch.over) for branch in diagrams))
    parts: Any = diagrams[0].system.parts
    if len(diagrams) > 1:
        several = [
            part for row in zip(*(branch.system.parts.values() for branch in diagrams), strict=False) for part in row
        ]
        parts = [part for i, part in enumerate(several) if part not in several[:i]]
    return parts_title(parts, width * 1.1, without=split_path(diagrams[0].over)[1])


def diagram_figure(
    diagrams: Sequence[Any], width: float, height: float, rows: int = 1, columns: int = 1, **shape: Any
) -> Any:
    """A figure over a parameter of systems with their other parameters in small print above it, and its axes."""
    text = fixed_parameters(diagrams, width)
    fig, axes = plots.figure(rows, columns, (width, height + LINE * (text.count("\n") + 1)), sharex="col", **shape)
    with plots.style():
        plots.setting(fig, text, 8, color="#555555")
    return fig, axes


def law_title(diagram: Branch | BranchDiagram) -> str:
    """The friction law, as a title."""
    return f"{law_words(diagram.system.law_names)} law"


def _along(branch: Any, over: str | None = None) -> Quantity:
    return quantity_in_si(branch.over, branch.system) if over is None else quantity_of(over, branch.system)


def _range(diagram: Branch | BranchDiagram, along: Quantity) -> tuple[float, float]:
    low, high = diagram.between
    return low * along.scale, high * along.scale


def parameter_label(diagram: Branch | BranchDiagram, over: str | None = None) -> str:
    """Name and symbol of the parameter, in SI its unit, for an axis."""
    part, name = split_path(diagram.over)
    along = _along(diagram, over)
    if along.unit != "1":
        stem = split_path(along.path)[1].removesuffix(suffix(along.unit))
        return f"{part} {stem.replace('_', ' ')}{bracketed(along.unit)}"
    record = diagram.system.parts[part]
    symbol = next(info.symbol for info in parameter_table(record) if info.name == name)
    return f"{part} {name.replace('_', ' ')} {symbol_text(symbol)}"


def draw_branches(ax: Axes, diagram: Branch | BranchDiagram, quantity: str, along: Quantity) -> set[str]:
    """Draw branches with their mirror images and special points, and where stable motions end within the range.

    Returns which marks and styles the legend must explain.
    """
    used: set[str] = set()
    marks: list[tuple[SpecialPoint, float, float, str]] = []
    if quantity != "period":
        ax.axhline(0.0, color="#9A9A9A", linewidth=0.6, zorder=1)
    for branch in filter(len, _branches(diagram)):
        colour, across, up = branch_colour(branch), along.scale, scale(UNITS[quantity], branch.system)
        for sign in _signs(branch, quantity):
            for x, y, stable in stretches(branch, quantity):
                word = "stable" if stable else "unstable"
                style = LINES[word] | {"color": colour, "zorder": 3 if stable else 2, "solid_capstyle": "butt"}
                ax.plot(across * x, sign * up * y, **style)
                used.add(word)
            for special in branch.special_points:
                value = sign * up * value_at(branch, special, quantity)
                marks.append((special, across * special.parameter, value, colour))
        used.add(colour)
    for special, x, y, colour in marks:
        lost = special.kind in CORNERS and special.passed is not None
        ax.plot(x, y, **(LOSS if lost else _mark(special.kind, colour)))
        used.add(LOSS_WORDS if lost else special.kind.value)
    for branch in _branches(diagram) if quantity != "period" else ():
        _label_travel(ax, branch, along.scale)
    return used | (_draw_transitions(ax, diagram, quantity, along) if isinstance(diagram, BranchDiagram) else set())


def _mark(kind: SpecialKind, colour: str = BLACK) -> dict[str, Any]:
    """How a special point is drawn, an open one in the colour of its branch."""
    marker, size, filled = MARKS[kind]
    look: dict[str, Any] = {"marker": marker, "markersize": size, "linestyle": "none", "zorder": 5}
    if filled:
        return look | {"color": BLACK, "markeredgecolor": "white"}
    look |= {"color": colour, "markeredgewidth": 1.1}
    return look | ({"markerfacecolor": "white", "zorder": 4} if kind is SpecialKind.FOLD else {})


def _signs(branch: Branch, quantity: str) -> tuple[float, ...]:
    """Of what is drawn of a branch: where motions travel, their mirror images too."""
    return (1.0, -1.0) if branch.symmetric is False and quantity != "period" else (1.0,)


def _draw_transitions(ax: Axes, diagram: BranchDiagram, quantity: str, along: Quantity) -> set[str]:
    """Draw where stable motions of a diagram end within the range, and what follows; returns what to explain."""
    used: set[str] = set()
    for transition in diagram.transitions:
        branch, x = diagram.branches[transition.branch], transition.parameter * along.scale
        up = scale(UNITS[quantity], branch.system)
        start = float(getattr(branch, quantity)[transition.point]) * up
        end = start
        if transition.reached is not None:
            other = diagram.branches[transition.reached]
            away = np.where(other.stable, np.abs(other.parameter - transition.parameter), np.inf)
            end = float(getattr(other, quantity)[int(np.argmin(away))]) * up
        for sign in _signs(branch, quantity):
            if transition.reached is None:
                ax.plot(x, sign * start, marker="x", markersize=7.0, color=VERMILION, linestyle="none", zorder=6)
            else:
                arrow = {"arrowstyle": "->", "color": VERMILION, "linewidth": 1.1, "shrinkA": 3.0, "shrinkB": 1.0}
                ax.annotate("", (x, sign * end), (x, sign * start), arrowprops=arrow, zorder=6)
            used.add(ENDS if transition.reached is None else LEADS)
    return used


def _label_travel(ax: Axes, branch: Branch, across: float) -> None:
    """Write the parameter beside each place where symmetric motions lose their stability or gain it: travel begins or
    ends there."""
    for special in branch.special_points if branch.symmetric else ():
        if special.stability != "kept":
            lost = (special.stability == "lost") == (branch.parameter[-1] > branch.parameter[0])
            look: dict[str, Any] = {"ha": "right" if lost else "left", "va": "top", "fontsize": 8.5, "color": "#333333"}
            place, beside = across * special.parameter, (-4 if lost else 6, -6)
            ax.annotate(f"{place:.4f}", (place, 0.0), xytext=beside, textcoords="offset points", **look)


def draw_swept(ax: Axes, swept: BifurcationDiagram, quantity: str, along: Quantity) -> set[str]:
    """Mark the settled motions of sweeps: half a disc for each way in which the parameter went."""
    for d, direction in enumerate(swept.directions):
        settled = swept.response_period[d] > 0
        systems = (swept.system.with_parameters({swept.over: float(value)}) for value in swept.values)
        periods = np.array([system.drive.period for system in systems])
        shown = swept.drift[d] * (1.0 / periods if quantity == "mean_velocity" else swept.response_period[d])
        x = np.broadcast_to(swept.values, settled.shape) * along.scale
        y = shown * scale(UNITS[quantity], swept.system)
        ax.plot(x[settled], y[settled], **SWEPT[direction], linestyle="none", zorder=3.5)
    return set(swept.directions)


def draw_multipliers(ax: Axes, branches: Iterable[Branch], along: Quantity) -> None:
    """Size of the largest multiplier over the parameter; a branch jumps where its mode sequence changes."""
    ax.axhline(1.0, color="#9A9A9A", linewidth=0.8, zorder=1)
    for branch in filter(len, branches):
        largest = np.max(np.abs(branch.multipliers), axis=1)
        x = branch.parameter * along.scale
        for first, last, stable in branch.parts:
            style: dict[str, Any] = {"linewidth": 1.6} if stable else {"linewidth": 1.0, "linestyle": UNSTABLE}
            shown = slice(first, last + 1)
            ax.plot(x[shown], largest[shown], color=branch_colour(branch), **style)
    ax.set_ylim(bottom=0.0)


def branch_colour(branch: Branch) -> str:
    """Black for symmetric motions and for cycles, blue for those that travel, others for longer responses."""
    if branch.symmetric or branch.response_period == 0:
        return BLACK
    if branch.response_period == 1:
        return BLUE
    return LONGER.get(branch.response_period, SKY if branch.response_period % 2 == 0 else VERMILION)


def value_at(branch: Branch, special: SpecialPoint, quantity: str) -> float:
    """The quantity drawn, at a special point."""
    if quantity == "period":
        return float(np.interp(special.arclength, branch.arclength, branch.period))
    drift = 0.0 if special.drift is None else special.drift
    if quantity == "drift":
        return drift
    system = branch.system.with_parameters({branch.over: special.parameter})
    return drift / (branch.response_period * system.drive.period)


def stretches(branch: Branch, quantity: str) -> list[tuple[np.ndarray, np.ndarray, bool]]:
    """(parameter, quantity, stable) of each stretch of a branch, cut exactly where the stability changes."""
    values = getattr(branch, quantity)
    corners = [(s, p, v, bool(ok), bool(ok)) for s, p, v, ok in zip(
        branch.arclength, branch.parameter, values, branch.stable, strict=True
    )]  # fmt: skip
    for special in branch.special_points:
        before, after = special.unstable_before == 0, special.unstable_after == 0
        value = value_at(branch, special, quantity)
        corners.append((special.arclength, special.parameter, value, before, after))
    corners.sort(key=lambda corner: corner[0])
    lines: list[tuple[list[float], list[float], bool]] = []
    for (_, p, v, _, leaving), (_, q, w, arriving, _) in itertools.pairwise(corners):
        stable = leaving or arriving  # the first and the last point may be a birth, whose multiplier is 1
        if not lines or lines[-1][2] != stable:
            lines.append(([p], [v], stable))
        lines[-1][0].append(q)
        lines[-1][1].append(w)
    return [(np.array(x), np.array(y), stable) for x, y, stable in lines]


def _branches(diagram: Branch | BranchDiagram) -> tuple[Branch, ...]:
    return diagram.branches if isinstance(diagram, BranchDiagram) else (diagram,)


def _handles(branches: Sequence[Branch | BranchDiagram], used: set[str]) -> list[Line2D]:
    """The legend: what was drawn and nothing else."""
    handles, symmetries = [], {branch.symmetric for one in branches for branch in _branches(one)}
    whose = "mirror-image solutions" if False in symmetries else "motions"
    for colour, text in {
        BLACK: "symmetric: no travel" if True in symmetries else "cycles",
        BLUE: f"{whose} that travel",
        GREEN: f"{whose} of 2 drive periods",
        PURPLE: "of 4 drive periods",
        ORANGE: "of 8 drive periods",
        SKY: "of other even numbers of periods",
        VERMILION: "of other odd numbers of periods",
    }.items():
        if colour in used:
            handles.append(Line2D([], [], color=colour, linewidth=1.8, label=text))
    handles += [Line2D([], [], color="#444444", label=word, **LINES[word]) for word in LINES if word in used]
    marks: dict[str, dict[str, Any]] = {
        kind.value: _mark(kind) | {"label": WORDS.get(kind, kind.value)} for kind in MARKS
    }
    marks |= {LOSS_WORDS: LOSS | {"label": LOSS_WORDS}}
    handles += [Line2D([], [], **look) for name, look in marks.items() if name in used]
    for words, marker in ((LEADS, r"$\downarrow$"), (ENDS, "x")):
        look = {"marker": marker, "color": VERMILION, "markersize": 8.0}
        handles += [Line2D([], [], linestyle="none", label=words, **look)] if words in used else []
    for direction, look in SWEPT.items():
        if direction in used:
            handles.append(Line2D([], [], linestyle="none", label=f"brute force, parameter {direction}", **look))
    return handles
