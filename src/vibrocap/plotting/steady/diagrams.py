"""Pictures of bifurcation diagrams: the states at the section over the parameter, swept up and down."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.plotting.look.colours import BLUE, VERMILION
from vibrocap.plotting.look.labels import quantity_label, scale, with_unit
from vibrocap.plotting.look.style import drawing, legend_below, style
from vibrocap.plotting.steady.branches import diagram_figure, law_title, parameter_label

WIDTH = 6.2  # inches
INKS = {"up": BLUE, "down": VERMILION}
MANY = 2000  # points, of which each is smaller
LOOKS = {"up": {"markersize": 1.0, "markeredgewidth": 0.0}, "down": {"markersize": 2.0, "markerfacecolor": "none"}}


def bifurcation_figure(diagram: BifurcationDiagram, state: str | None = None) -> Figure:
    """A state at the section over the parameter, both ways in which it was swept.

    state: by default that of the machine which varies most there
    """
    fig, axes = diagram_figure([diagram], WIDTH, 4.2)
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
    """Draw a state; the handles of the legend."""
    state = state or _widest(diagram)
    along, up = quantity_in_si(diagram.over, diagram.system).scale, scale(state, diagram.system)
    index = diagram.system.state_names.index(state)
    size = 0.9 if np.count_nonzero(np.isfinite(diagram.states[..., index])) > MANY else 2.5
    for k, direction in enumerate(diagram.directions):
        x = np.broadcast_to(diagram.values[:, None], diagram.states.shape[1:4])
        ax.plot(
            along * x.ravel(), up * diagram.states[k, ..., index].ravel(), rasterized=True, **_look(direction, size)
        )
    ax.set(title=law_title(diagram), xlabel=parameter_label(diagram))  # type: ignore[arg-type]
    ax.set_ylabel(with_unit(f"{quantity_label(state, diagram.system)} at the section", state, diagram.system))
    words = {"up": "parameter going up", "down": "going down"}
    return [Line2D([], [], label=words[direction], **_look(direction, 3.0)) for direction in diagram.directions]


def _look(direction: str, size: float) -> dict[str, Any]:
    """Dots going up, within circles going down: both are seen where they agree."""
    base = {"color": INKS[direction], "marker": "o", "linestyle": "none", "markeredgewidth": 0.5} | LOOKS[direction]
    return base | {"markersize": size * LOOKS[direction]["markersize"]}  # type: ignore[operator]
