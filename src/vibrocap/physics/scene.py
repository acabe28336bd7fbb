"""The scene of a machine: what is drawn of it at a state, as plain data, by whoever draws (a page, a film).

A machine gives shapes whose coordinates are numbers, or expressions of its state where it is recorded. Lengths are
those of the equations; x is along the line of sliding, y upwards from the ground.
"""

import dataclasses
from typing import Any, Literal

from vibrocap.physics.elementary import cos, sin

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


def capsule_with_mass(x: Any, mass: Any) -> tuple[Shape, ...]:
    """A capsule at x with a mass in it, displacements as they are, from the middle."""
    return (
        Shape("box", "capsule", ((x, 0.4),), (1.8, 0.8)),
        Shape("contact", "contact", ((x, 0.0),), (1.7, 0.0)),
        Shape("disc", "inner mass", ((mass, 0.4),), (0.3, 0.3)),
    )


def capsule_with_pendulum(
    x: Any, angle: Any, rod: str = "pendulum", bob: str = "bob", pivot: str = "pivot"
) -> tuple[Shape, ...]:
    """A capsule at x, its pivot on top, and the bob at (x - sin(angle), cos(angle)) from there, by these names."""
    centre, end = (x, 0.5), (x - sin(angle), 0.5 + cos(angle))
    return (
        Shape("box", "capsule", ((x, 0.25),), (1.3, 0.5)),
        Shape("contact", "contact", ((x, 0.0),), (1.2, 0.0)),
        Shape("rod", rod, (centre, end)),
        Shape("disc", bob, (end,), (0.3, 0.3)),
        Shape("hinge", pivot, (centre,)),
    )
