"""The scene of a machine: what is drawn of it at a state, as plain data, by whoever draws (a page, a film).

A machine gives shapes whose coordinates are numbers, or expressions of its state where it is recorded. Lengths are
those of the equations; x is along the line of sliding, y upwards from the ground.
"""

import dataclasses
from typing import Any, Literal

Kind = Literal["box", "disc", "rod", "spring", "hinge", "contact"]


@dataclasses.dataclass(frozen=True)
class Shape:
    """One shape of a scene.

    kind: "box" (a body: centre, width and height), "disc" (a body: centre and diameter), "rod" and "spring" (from one
        point to another), "hinge" (a point), "contact" (the point of a body at which friction acts, and its width)
    name: what it is, in words
    points: (x, y) of each point, one or two
    size: (width, height); zero where it has none
    """

    kind: Kind
    name: str
    points: tuple[tuple[Any, Any], ...]
    size: tuple[float, float] = (0.0, 0.0)


def block(x: Any, name: str = "block") -> tuple[Shape, ...]:
    """A block at x, on the ground: what is drawn of a machine that says nothing of its looks."""
    return Shape("box", name, ((x, 0.25),), (1.0, 0.5)), Shape("contact", "contact", ((x, 0.0),), (0.9, 0.0))
