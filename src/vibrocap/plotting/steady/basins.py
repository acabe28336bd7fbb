"""Pictures of basins: which way each start travels in the end, and which attractor it leads to."""

import dataclasses
import types
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibrocap.arguments import ArgumentError, shown
from vibrocap.orbits.attractors.attractors import FAILED, NOT_CERTIFIED, NOT_SETTLED, NOT_TOLD, Attractor
from vibrocap.orbits.attractors.basins import BACK, FORWARD, NO_TRAVEL, PHASE, Basins
from vibrocap.physics.dimensions.conversion import INITIAL, Quantity, quantity, quantity_in_si
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import EQUALS, bracketed, quantity_label, scale, value_text
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILION, VIOLET, YELLOW
from vibrocap.plotting.studies import maps
from vibrocap.plotting.studies.cells import Cell, share
from vibrocap.plotting.studies.view import ViewAxis, axis_label, case_label, case_of
from vibrocap.studies.dataset import PHASE_ATTRIBUTES, labelled_result

TITLES = {"direction": "direction of travel", "attractor": "attractor"}
DIRECTIONS = {FORWARD: "forward", BACK: "back", NO_TRAVEL: "no travel"}
WAYS = {FORWARD: BLUE, BACK: ORANGE, NO_TRAVEL: GREY}
ATTRACTORS = (GREEN, SKY, VERMILION, YELLOW, VIOLET)  # none of the colours of the ways
# Those that have no value of their own: (words, face, hatch, colour of the hatch), as in maps of studies.
UNVALUED_STYLES = {
    NOT_SETTLED: ("not settled", "#FFFFFF", maps.UNSETTLED, BLACK),
    FAILED: ("failed", *maps.CELL_STYLES[Cell.FAILED]),
    NOT_CERTIFIED: ("not certified", *maps.CELL_STYLES[Cell.FAILED]),
    NOT_TOLD: ("settled, not distinguished", *maps.CELL_STYLES[Cell.NO_VALUE]),
}


def basin_figure(basins: Basins, axes: Sequence[str] | None = None) -> Figure:
    """The figure of basins: directions of travel, and beside them the attractors where several travel one way.

    axes: those of the plane by other keys, such as ("angle_deg", "angle_rate"); by default as the plane was asked for,
        in degrees where it was given in degrees
    Starts that failed, did not settle or are not certified are hatched, so that nothing depends on colour alone.
    """
    along = _along(basins, axes)
    basins = _shown(basins, along)
    travels = basins.system.cyclic is not None
    several = travels and len(basins.attractors) > len(np.unique(basins.direction[basins.label >= 0]))
    which = "Direction of travel by initial condition" + (", and to which attractor" if several else "")
    words: Any = types.SimpleNamespace(
        title=which if travels else "Where each start leads",
        setting=_setting(basins),
        note=f"{basins.label.size:,} starts; {'all dimensionless' if basins.system.units is None else 'in SI'}",
    )
    shown = ["direction"] * travels + ["attractor"] * (several or not travels)
    with plots.style(plots.settings_of(maps.PRINT)):
        fig, panels = maps.study_axes(words, len(shown))
        legend: list[Any] = []
        for ax, what in zip(panels, shown, strict=True):
            legend += _draw(ax, basins, along, what, first=ax is panels[0])
            ax.set_title(TITLES[what] if several else "")
        maps.add_title_and_legend(fig, words, legend + _unvalued(basins))
    return fig


def draw_basins(
    basins: Basins, what: str = "direction", *, axes: Sequence[str] | None = None, ax: Axes | None = None
) -> Axes:
    """One panel of `basin_figure`: where each start of the plane leads.

    what: "direction" of travel, or "attractor"; axes: as in `basin_figure`
    """
    if what not in TITLES:
        raise ArgumentError("what", f"should be direction or attractor, got {shown(what)}")
    along = _along(basins, axes)
    basins = _shown(basins, along)
    with plots.drawing(ax, (4.6, 3.8)) as ax:
        plots.legend_below(ax, _draw(ax, basins, along, what, first=True) + _unvalued(basins))
        ax.set_title(TITLES[what])
        ax.grid(False)
    return ax


def _along(basins: Basins, keys: Sequence[str] | None) -> list[Quantity]:
    """The axes as they are drawn; ArgumentError for keys that are not theirs."""
    names = [name if name == PHASE else INITIAL + name for name in basins.axes]
    keys = basins.keys if keys is None else keys
    if not keys:
        return [quantity_in_si(name, basins.system) for name in names]
    asked = [key if key == PHASE else INITIAL + key for key in ((keys,) if isinstance(keys, str) else keys)]
    quantities = [quantity(path, basins.system) for path in asked]
    quantities = [
        quantity if quantity.unit != "1" else quantity_in_si(quantity.plain, basins.system) for quantity in quantities
    ]
    if [quantity.plain for quantity in quantities] != names:
        right = " and ".join(basins.axes)
        raise ArgumentError("axes", f"should be {right}, each with a unit such as angle_deg, got {shown(keys)}")
    return quantities


def _shown(basins: Basins, along: list[Quantity]) -> Basins:
    """The basins with axes as they are drawn, and drifts in SI, where the system knows its scales."""
    x, y = (values * axis.scale for axis, values in zip(along, (basins.x, basins.y), strict=True))
    return dataclasses.replace(basins, x=x, y=y, drift=basins.drift * scale("position", basins.system))


def _unvalued(basins: Basins) -> list[Any]:
    handles = []
    for code, (text, face, hatch, ink) in UNVALUED_STYLES.items():
        if count := int(np.sum(basins.label == code)):
            patch = Patch(facecolor=face, label=f"{text}: {share(count, basins.label.size)}")
            handles.append(maps._hatched(patch, hatch, ink))
    return handles


def _draw(ax: Axes, basins: Basins, along: list[Quantity], what: str, first: bool) -> list[Patch]:
    """Cells in the colours of their codes, hatched where they have no value; the legend of those that have one.

    first: the leftmost panel, whose upright axis is labelled
    """
    x, y = (ViewAxis(name, values, name).edges for name, values in zip(basins.axes, (basins.x, basins.y), strict=True))
    named, others = basins.attractors[: len(ATTRACTORS)], basins.attractors[len(ATTRACTORS) :]
    if what == "direction":
        codes, colours = basins.direction, WAYS
        legend = {code: _direction_label(basins, code) for code in WAYS if np.any(codes == code)}
    else:
        codes, colours = (
            basins.label,
            dict.fromkeys(range(len(basins.attractors)), maps.OTHERS) | dict(enumerate(ATTRACTORS)),
        )
        legend = {k: _attractor(attractor, basins) for k, attractor in enumerate(named)}
        count = sum(attractor.starts for attractor in others)
        legend |= {len(named): f"{len(others)} others: {share(count, basins.label.size)}"} if others else {}
    faces = colours | {code: face for code, (_, face, _, _) in UNVALUED_STYLES.items()}
    there = [code for code in faces if np.any(codes == code)]
    number = np.zeros(codes.shape)
    for k, code in enumerate(there):
        number[codes == code] = k
    paint: dict[str, Any] = {"cmap": ListedColormap([faces[code] for code in there]), "vmin": -0.5}
    ax.pcolormesh(x, y, number.T, vmax=len(there) - 0.5, rasterized=True, label="values", **paint)
    for code, (_, _, hatch, ink) in UNVALUED_STYLES.items():
        maps._hatch(ax, x, y, basins.label == code, hatch, "white", maps.HALO)
        maps._hatch(ax, x, y, basins.label == code, hatch, ink)
    labels = [
        axis_label(PHASE, PHASE_ATTRIBUTES)
        if name == PHASE
        else f"initial {quantity_label(name, basins.system)}{bracketed(axis.unit)}"
        for name, axis in zip(basins.axes, along, strict=True)
    ]
    ax.set(xlim=x[[0, -1]], ylim=y[[0, -1]], xlabel=labels[0], ylabel=labels[1] if first else "")
    return [Patch(facecolor=faces[code], label=text) for code, text in legend.items()]


def _setting(basins: Basins) -> str:
    """The case in brief, and where the starts are."""
    dataset = labelled_result(basins)
    words = case_label(dataset, case_of(dataset), {})
    if PHASE not in basins.axes and basins.phase:
        words += f", t₀/T{EQUALS}{value_text(basins.phase)}"
    return words


def _direction_label(basins: Basins, code: int) -> str:
    """A direction with its share of all starts, and with the drift where all that travel so drift alike."""
    where = basins.direction == code
    words = f"{DIRECTIONS[code]}: {share(int(np.sum(where)), where.size)}"
    drifts = basins.drift[where]
    if code != NO_TRAVEL and len(drifts) and np.ptp(drifts) <= 1e-9:
        words += _drift(drifts[0], basins)
    return words


def _attractor(attractor: Attractor, basins: Basins) -> str:
    motion = attractor.motion
    drift = "" if motion.drift is None else _drift(motion.drift * scale("position", basins.system), basins)
    return f"{motion.kind}{drift}: {share(attractor.starts, max(round(attractor.starts / attractor.share), 1))}"


def _drift(drift: float, basins: Basins) -> str:
    unit = "" if basins.system.units is None else " m"
    return f", ΔX{EQUALS}{drift:+.4g}{unit}".replace("-", "\N{MINUS SIGN}")
