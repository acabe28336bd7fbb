"""The mechanism of a machine: its bodies, on what they move and what joins them, for programs of rigid bodies.

It says in other words what the equations of the machine say. `check_part` compares the energy and momentum of both, and
the tests compare the accelerations with those of MuJoCo.
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
