"""What a figure is made of, before it is drawn: panels of curves, as they go into its CSV file."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from vibrocap.paper.runs import Runs


@dataclasses.dataclass(frozen=True, eq=False)
class Curve:
    """One line of a panel.

    role: "LM", "EM", or another word that the drawing knows ("steady", "window", "twin", ...)
    weight: 0 to 1, how strongly it is drawn among curves of its role
    arrows: shares of its points (0 to 1) at which an arrow shows the direction
    """

    label: str
    role: str
    x: np.ndarray
    y: np.ndarray
    weight: float = 1.0
    arrows: tuple[float, ...] = ()


@dataclasses.dataclass(frozen=True, eq=False)
class Mark:
    """A point or, with y None, a vertical line that is named in the drawing."""

    label: str
    x: float
    y: float | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class Ending:
    """Runs that did not go to their end, marked at the foot of the axes: where on the x axis, and the time reached."""

    label: str
    role: str
    x: np.ndarray
    time: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes. x and y name their quantities as the code does; limits are of the drawing, not of the data."""

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()
    spans: tuple[tuple[float, float], ...] = ()  # stretches of x in which EM sticks
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float, float] | None = None
    endings: tuple[Ending, ...] = ()
    zero: bool = False  # whether the line y = 0 is shown


@dataclasses.dataclass(frozen=True, eq=False)
class Figure:
    """A figure of the paper, from our own runs."""

    key: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 2
    one_legend: bool = False  # above all panels

    @property
    def rows(self) -> Iterator[tuple[str, str, str, str, float, float]]:
        """The data, one row per point: panel, curve, names of x and y, x, y; of a run that ended the time reached."""
        for panel in self.panels:
            for curve in panel.curves:
                for x, y in zip(curve.x, curve.y, strict=True):
                    yield panel.title, curve.label, panel.x, panel.y, float(x), float(y)
            for ending in panel.endings:
                for x, time in zip(ending.x, ending.time, strict=True):
                    yield panel.title, ending.label, panel.x, "end_time", float(x), float(time)


FIGURES: dict[str, Callable[[Runs], Figure]] = {}  # of the modules that are imported, by key


def figure(key: str, title: str, caption: str, **layout: Any) -> Callable[[Any], Any]:
    """A decorator: the panels that a function makes of the runs are a figure. layout: columns, one_legend"""

    def entered(panels: Callable[[Runs], Sequence[Panel]]) -> Callable[[Runs], Sequence[Panel]]:
        FIGURES[key] = lambda runs: Figure(key, title, caption, tuple(panels(runs)), **layout)
        return panels

    return entered
