"""Pictures over a parameter: steady sliding with the cycles that surround it, and states at the section, swept."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.equilibria.equilibrium_branch import EquilibriumBranch
from vibrocap.orbits.walk.kinds import SpecialKind
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.plotting.look.labels import quantity_label, scale, with_unit
from vibrocap.plotting.look.style import BLACK, BLUE, VERMILION, drawing, legend_below, style
from vibrocap.plotting.steady.branches import LINES, diagram_figure, law_title, parameter_label

MARKS: dict[SpecialKind, tuple[str, float]] = {
    SpecialKind.HOPF: ("s", 6.0),
    SpecialKind.FOLD: ("o", 7.0),
    SpecialKind.MODE_COUPLING: ("D", 6.0),
    SpecialKind.BRANCH_POINT: ("P", 7.0),
    SpecialKind.UNLOCATED: ("x", 6.0),
}


def equilibrium_figure(branch: EquilibriumBranch, cycles: Sequence[Branch] = (), state: str | None = None) -> Figure:
    """A state of steady sliding over the parameter, with cycles that surround it, above the eigenvalues' real parts.

    cycles: branches of cycles over the same parameter, drawn by the least and the largest value of the state
    state: by default the first that is neither cyclic nor a rate, such as the position of a block on a belt
    """
    fig, axes = diagram_figure([branch], 5.6, 5.4, 2, height_ratios=[3.0, 2.0])
    with style():
        used = _draw_states(axes[0, 0], branch, cycles, state or _first_state(branch))
        _draw_eigenvalues(axes[1, 0], branch)
        axes[0, 0].set_title(f"steady sliding, {branch.system.law_names} law", pad=8)
        axes[1, 0].set_xlabel(parameter_label(branch))  # type: ignore[arg-type]
        fig.legend(handles=_handles(used), loc="outside lower center", ncols=3)
    return fig


def draw_equilibria(branch: EquilibriumBranch, what: str | None = None, *, ax: Axes | None = None) -> Axes:
    """One panel of `equilibrium_figure`: a state over the parameter, or, by "eigenvalues", their real parts."""
    with drawing(ax) as ax:
        used: set[str] = set()
        if what == "eigenvalues":
            _draw_eigenvalues(ax, branch)
        else:
            used = _draw_states(ax, branch, (), what or _first_state(branch))
        ax.set_xlabel(parameter_label(branch))  # type: ignore[arg-type]
        legend_below(ax, _handles(used), ncols=2)
    return ax


def _first_state(branch: EquilibriumBranch) -> str:
    machine = branch.system.machine
    names = [name for name in machine.states if name not in (machine.cyclic, machine.contact_states[0])]
    return names[0] if names else machine.contact_states[0]


def _draw_states(ax: Axes, curve: EquilibriumBranch, cycles: Sequence[Branch], state: str) -> set[str]:
    """Draw a state of a branch and the extremes of cycles; returns what the legend must explain."""
    along, up = quantity_in_si(curve.over, curve.system).scale, scale(state, curve.system)
    index, used = curve.system.state_names.index(state), set()
    x, y = along * curve.parameter, up * curve.states[:, index]
    for first, last, stable in curve.parts:  # neighbours share a point, so that the line has no gap
        word = "stable" if stable else "unstable"
        ax.plot(x[first : last + 2], y[first : last + 2], color=BLACK, **LINES[word])
        used.add(word)
    for branch in cycles:
        extremes = np.array([_extremes(branch, i, state) for i in range(len(branch))])
        for first, last, stable in branch.parts:
            shown = slice(first, last + 1)
            for end in extremes.T:
                look = LINES["stable" if stable else "unstable"]
                ax.plot(along * branch.parameter[shown], up * end[shown], color=BLUE, **look)
        used |= {"cycles"} | {"stable" if stable else "unstable" for *_, stable in branch.parts}
    for special_point in curve.special_points:
        marker, size = MARKS[special_point.kind]
        look: dict[str, Any] = {"linestyle": "none", "zorder": 5, "color": VERMILION, "markeredgecolor": "white"}
        if special_point.kind is SpecialKind.UNLOCATED:
            look["markeredgecolor"] = VERMILION
        look |= {"marker": marker, "markersize": size}
        ax.plot(along * special_point.parameter, up * special_point.state[state], **look)
        used.add(special_point.kind.value)
    ax.set_ylabel(with_unit(quantity_label(state, curve.system), state, curve.system))
    return used


def _extremes(branch: Branch, point: int, state: str) -> tuple[float, float]:
    """Least and largest value of a state along the cycle at a point of a branch."""
    from vibrocap.motion.simulate import simulate

    system = branch.system.with_parameters({branch.over: float(branch.parameter[point])})
    start = dict(zip(system.state_names, branch.states[point].tolist(), strict=True))
    motion = simulate(system, periods=float(branch.period[point]) / system.drive.period, initial=start)
    values = motion.at(np.linspace(0.0, motion.end, 400), state)
    return float(np.min(values)), float(np.max(values))


def _draw_eigenvalues(ax: Axes, branch: EquilibriumBranch) -> None:
    """Draw the real parts of the eigenvalues that decide: those nearest to the axis."""
    along, si = quantity_in_si(branch.over, branch.system).scale, branch.system.units is not None
    rate = branch.system.si.factor_of("rad/s") if si else 1.0
    real = np.real(branch.eigenvalues) * rate
    ax.axhline(0.0, color="#9A9A9A", linewidth=0.8, zorder=1)
    largest = real[:, 0]
    for column in range(real.shape[1])[::-1]:  # the one that decides above the others
        ax.plot(along * branch.parameter, real[:, column], color=BLACK if column == 0 else "#8A8A8A", linewidth=1.2)
    size = 2.5 * float(np.max(np.abs(largest)))
    low = max(float(np.min(real)), -size) if size > 0.0 else float(np.min(real))
    top = max(float(np.max(largest)), 0.0)
    margin = 0.1 * max(top - low, 1e-300)
    ax.set_ylim(low - margin, top + margin)
    ax.set_ylabel("real parts of\neigenvalues" + (" [1/s]" if si else ""))


def _handles(used: set[str]) -> list[Line2D]:
    """The legend: what was drawn and nothing else."""
    handles = [Line2D([], [], color=BLACK, label=f"{word}", **LINES[word]) for word in LINES if word in used]
    if "cycles" in used:
        handles.append(Line2D([], [], color=BLUE, linewidth=1.8, label="cycles, least and largest"))
    for kind, (marker, size) in MARKS.items():
        if kind.value in used:
            look: dict[str, Any] = {"color": VERMILION, "markersize": size, "linestyle": "none"}
            handles.append(Line2D([], [], marker=marker, label=kind.value, **look))
    return handles


MANY = 2000  # points, of which each is smaller
DOT: dict[str, Any] = {"marker": "o", "linestyle": "none"}
# (words, size, look): dots going up, within circles going down: both are seen where they agree
SWEPT: dict[str, tuple[str, float, dict[str, Any]]] = {
    "up": ("parameter going up", 1.0, DOT | {"color": BLUE, "markeredgewidth": 0.0}),
    "down": ("going down", 2.0, DOT | {"color": VERMILION, "markeredgewidth": 0.5, "markerfacecolor": "none"}),
}


def bifurcation_figure(diagram: BifurcationDiagram, state: str | None = None) -> Figure:
    """A state at the section over the parameter, both ways in which it was swept.

    state: by default that of the machine which varies most there
    """
    fig, axes = diagram_figure([diagram], 6.2, 4.2)
    with style():
        fig.legend(handles=_draw(axes[0, 0], diagram, state), loc="outside lower center", ncols=2)
    return fig


def draw_bifurcation(diagram: BifurcationDiagram, state: str | None = None, *, ax: Axes | None = None) -> Axes:
    """The panel of `bifurcation_figure`."""
    with drawing(ax) as ax:
        legend_below(ax, _draw(ax, diagram, state), ncols=2)
    return ax


def _widest(diagram: BifurcationDiagram) -> str:
    """The state of the machine whose values at the section spread most, over natural sizes."""
    system = diagram.system
    names = [name for name in system.machine.states if name != system.cyclic]
    columns = [system.state_names.index(name) for name in names]
    values = diagram.states[..., columns]
    spread = np.nanmax(values, axis=(0, 1, 2, 3)) - np.nanmin(values, axis=(0, 1, 2, 3))
    return names[int(np.argmax(spread / np.array(system.scales(), dtype=float)[columns]))]


def _draw(ax: Axes, diagram: BifurcationDiagram, state: str | None) -> list[Line2D]:
    state = state or _widest(diagram)
    along, up = quantity_in_si(diagram.over, diagram.system).scale, scale(state, diagram.system)
    index = diagram.system.state_names.index(state)
    size = 0.9 if np.count_nonzero(np.isfinite(diagram.states[..., index])) > MANY else 2.5
    x, handles = np.broadcast_to(diagram.values[:, None], diagram.states.shape[1:4]), []
    for k, direction in enumerate(diagram.directions):
        words, larger, look = SWEPT[direction]
        y = diagram.states[k, ..., index]
        ax.plot(along * x.ravel(), up * y.ravel(), rasterized=True, markersize=size * larger, **look)
        handles.append(Line2D([], [], label=words, markersize=3.0 * larger, **look))
    ax.set(title=law_title(diagram), xlabel=parameter_label(diagram))  # type: ignore[arg-type]
    ax.set_ylabel(with_unit(f"{quantity_label(state, diagram.system)} at the section", state, diagram.system))
    return handles
