"""The bodies of a machine: as a mechanism, for programs of rigid bodies, and as a scene, for pages and films.

The mechanism says in other words what the equations of the machine say: its bodies, on what they move and their joints.
The tests compare energy, momentum and power of both, and accelerations with those of MuJoCo. The scene is what is drawn
at a state, as plain data: shapes whose coordinates are numbers, or expressions of the state where it is recorded.
Lengths are those of the equations; x is along the line of sliding, y upwards from the ground.
"""

import dataclasses
from typing import Any, Literal


@dataclasses.dataclass(frozen=True)
class Body:
    """A body and the joint on which it moves.

    name: that of its shape in the scene. mass: of all of it, at one point.
    joint: "slide" (moves along the line) or "hinge" (turns about a hinge on its carrier, a mass at the distance 1 from
        it; the angle from upright, positive backwards)
    place, rate: of the joint, at the state that was asked for; relative to the carrier
    carrier: name of the body on which it moves, which stands before it; "": the ground
    stiffness, damping: of the spring, not stretched at place 0, and of the viscous damper at the joint
    actuation: share of the drive that acts at the joint
    contact: the number of the contact between body and ground, from 0; None: it does not rub
    """

    name: str
    mass: Any
    joint: Literal["slide", "hinge"] = "slide"
    place: Any = 0.0
    rate: Any = 0.0
    carrier: str = ""
    stiffness: Any = 0.0
    damping: Any = 0.0
    actuation: Any = 0.0
    contact: int | None = None


@dataclasses.dataclass(frozen=True)
class Link:
    """A spring, a damper and a share of the drive between two sliding bodies; a positive drive pushes them apart.

    The spring is not stretched where the places of both bodies are equal.
    """

    behind: str
    ahead: str
    stiffness: Any = 0.0
    damping: Any = 0.0
    actuation: Any = 0.0


@dataclasses.dataclass(frozen=True)
class Mechanism:
    """Bodies, carriers before what they carry, and links between them."""

    bodies: tuple[Body, ...]
    links: tuple[Link, ...] = ()


Kind = Literal["box", "disc", "rod", "spring", "hinge", "contact"]


@dataclasses.dataclass(frozen=True)
class Shape:
    """One shape of a scene.

    kind: "box" (a body: centre, width and height), "disc" (a body: centre and diameter), "rod" and "spring" (from one
        point to another), "hinge" (a point), "contact" (the point of a body at which friction acts, and its width)
    name: what it is, in words
    points: (x, y) of each point of the machine, one or two, in the lengths of the equations
    size: (width, height), in units of drawing; zero where it has none
    box: of a disc the box in which it slides, of a spring that at whose wall it begins, of a contact that above it: a
        box is drawn as wide as what slides in it needs
    aside: how far from each point it is drawn, in units of drawing; by default there
    """

    kind: Kind
    name: str
    points: tuple[tuple[Any, Any], ...]
    size: tuple[float, float] = (0.0, 0.0)
    box: str = ""
    aside: tuple[tuple[Any, Any], ...] = ()

    def places(self, length: float = 1.0) -> tuple[tuple[Any, Any], ...]:
        """Where it is drawn, in units of drawing of this length."""
        beside = self.aside or ((0.0, 0.0),) * len(self.points)
        drawn = zip(self.points, beside, strict=True)
        return tuple((x / length + right, z / length + up) for (x, z), (right, up) in drawn)
