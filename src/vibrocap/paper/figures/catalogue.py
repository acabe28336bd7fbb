"""The figures by key."""

from collections.abc import Callable

from vibrocap.paper.figures.figure import Figure
from vibrocap.paper.figures.friction import figure_3, figure_6, figure_8
from vibrocap.paper.figures.load_motion import figure_load_5, figure_load_6, figure_load_7, figure_load_8
from vibrocap.paper.figures.load_travel import figure_load_9, figure_load_10, figure_load_11
from vibrocap.paper.figures.motion import figure_5, figure_7, figure_9, figure_10, figure_11, figure_symmetry
from vibrocap.paper.runs import Runs

FIGURES: dict[str, Callable[[Runs], Figure]] = {
    "fig03": figure_3,
    "fig05": figure_5,
    "fig06": figure_6,
    "fig07": figure_7,
    "fig08": figure_8,
    "fig09": figure_9,
    "symmetry": figure_symmetry,
    "fig10": figure_10,
    "fig11": figure_11,
    "load05": figure_load_5,
    "load06": figure_load_6,
    "load07": figure_load_7,
    "load08": figure_load_8,
    "load09": figure_load_9,
    "load10": figure_load_10,
    "load11": figure_load_11,
}

KEYS = tuple(key for key in FIGURES if key.startswith("fig"))  # those of the paper
LOADED = tuple(key for key in FIGURES if key.startswith("load"))  # the same under the dynamic load


def chosen_figures(only: str | None = None) -> tuple[str, ...]:
    """Keys of the figures to make: all, or one with what explains it. ValueError for a key that does not exist."""
    if only is None:
        return tuple(FIGURES)
    if only not in KEYS:
        raise ValueError(f"only should be one of {', '.join(KEYS)}, got {only!r}")
    beside = ("symmetry",) if only == "fig09" else ()
    return (only, *beside, *(key for key in LOADED if key[4:] == only[3:]))
