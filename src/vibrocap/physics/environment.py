"""The environment of a machine: the slope of its line, the drag of its surroundings and a force from outside."""

import dataclasses
import math
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from vibrocap.arguments import ArgumentError
from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.parameters import NonNegative, Number, Part, parameter, parameters


def _checked_inclination(angle: Any) -> Any:
    if isinstance(angle, (int, float)) and not isinstance(angle, bool) and not abs(angle) < 0.5 * math.pi:
        raise ValueError("should be less steep than 90 degrees, between -pi/2 and pi/2 rad")
    return angle


Inclination = Annotated[Number, BeforeValidator(_checked_inclination)]


@dataclasses.dataclass(frozen=True)
class Outside:
    """What an environment does to a machine at one instant.

    pushes: of each contact, the force on its body along the line, besides friction, while it slides and while it rests.
    total: force on the machine. powers: by channel.
    """

    pushes: tuple[tuple[Any, Any], ...]
    total: Any
    powers: tuple


def _towards(forward: Any, back: Any, side: Any) -> Any:
    """The coefficient of a side: that forward, or, where one is given, that back; their mean at rest (side 0)."""
    return forward if back is None else 0.5 * (forward + back) + 0.5 * side * (forward - back)


@parameters
class Environment(Part):
    """A slope, a fluid at rest around the capsule, and a constant force, along the line of sliding.

    On a line inclined by phi, forward uphill where phi is positive, gravity g has the parts g cos(phi) towards the
    ground and g sin(phi) back, which act on every mass (`Machine.tilted`); a load that is the weight shrinks with
    cos(phi). On the body at the contact, moving at V over its surroundings,

        R becomes R - F_e + c_1 V + c_2 |V| V + m g sin(phi)

    wherever a machine takes the friction force R. Fins, scales or a stern give other coefficients where V < 0:
    `linear_drag_back`, `quadratic_drag_back`. Drag has a kink at rest, which is followed by the side to which the
    contact slides; so the quadratic one, and one that depends on the direction, need ground that does not move.

    Of several contacts every body that slides feels the same law of drag at its own velocity, as chains of equal bodies
    in a resisting medium do (Zimmermann, Zeidis and Behn, Mechanics of Terrestrial Locomotion, 2009). The force F_e
    acts on the first body, the rearmost one of a crawler.
    """

    inclination: Inclination = parameter(0.0, "phi", "inclination of the line, uphill forward", "phase")
    linear_drag: NonNegative = parameter(
        0.0, "c_1", "drag on each body that slides, over its velocity", "viscous damping"
    )
    quadratic_drag: NonNegative = parameter(0.0, "c_2", "drag over the square of the velocity", "quadratic damping")
    linear_drag_back: NonNegative | None = parameter(
        None, "c_1b", "linear drag in moving back; left out, as forward", "viscous damping"
    )
    quadratic_drag_back: NonNegative | None = parameter(
        None, "c_2b", "quadratic drag in moving back; left out, as forward", "quadratic damping"
    )
    force: Number = parameter(
        0.0, "F_e", "constant force on the body at the (first) contact, positive forward", unit="N"
    )
    gravity: NonNegative | None = parameter(
        None, "g", "gravitational acceleration; left out, it is the unit of acceleration of the machine", unit="m/s^2"
    )

    name: ClassVar[str] = "environment"

    @property
    def symmetric(self) -> bool:
        """Whether forward and back are alike: on level ground, without a force, with the same drag both ways."""
        alike = self.linear_drag_back in (None, self.linear_drag)
        alike = alike and self.quadratic_drag_back in (None, self.quadratic_drag)
        return alike and self.inclination == 0.0 and self.force == 0.0

    def check(self, machine: Machine) -> None:
        """ArgumentError for an environment that a machine cannot have."""
        for name in () if machine.over_ground else ("linear_drag", "quadratic_drag", "force"):
            if value := getattr(self, name):
                what = f"should be 0 with the {machine.name}, whose contacts are not all with the ground, got {value:g}"
                raise ArgumentError(f"environment.{name}", what)
        if self.inclination != 0.0 and not self.has_weight(machine):
            raise ArgumentError(
                "environment.gravity",
                f"is missing: the units of the {machine.name} do not define gravity on its slope",
            )
        for name, wanted in (
            ("quadratic_drag", "0"),
            ("quadratic_drag_back", "0 or left out"),
            ("linear_drag_back", "left out"),
        ):
            value = getattr(self, name)
            kinked = value is not None if name == "linear_drag_back" else value
            if kinked and machine.ground_speed() != 0.0:
                raise ArgumentError(
                    f"environment.{name}",
                    f"should be {wanted} over ground that moves: its kink is not at the rest of the contact, "
                    f"got {value}",
                )

    def has_weight(self, machine: Machine) -> bool:
        """Whether it is known how gravity pulls at a machine."""
        return self.gravity is not None or machine.gravity is not None

    def channels(self, machine: Machine) -> tuple[str, ...]:
        """Names of the energy channels, in the order of `Outside.powers`."""
        return ("drag", "outer_force", *(("gravity",) if self.has_weight(machine) else ()))

    def placed(self, machine: Machine) -> Machine:
        if not self.has_weight(machine):
            return machine
        strength = machine.gravity[0] if self.gravity is None else self.gravity
        return machine.tilted(strength * cos(self.inclination), strength * sin(self.inclination))

    def push_at_rest(self, machine: Any):
        """Force on the body of the first contact along the line, besides friction, while it rests; weight included."""
        push = self.force - self.linear_drag * machine.ground_speed()
        if not self.has_weight(machine):
            return push
        return push + machine.weight_along()[0]

    def drag(self, velocity, side):
        """Force that holds up a body at this velocity over the ground, sliding to `side`."""
        linear = _towards(self.linear_drag, self.linear_drag_back, side)
        quadratic = _towards(self.quadratic_drag, self.quadratic_drag_back, side)
        return (linear + quadratic * (side * velocity)) * velocity

    def outside(self, machine: Any, t, y, velocities, sides) -> Outside:
        """What it does to a machine that `placed` gave, at these sliding velocities, each contact sliding to its side,
        or at rest (0).
        """
        ground = machine.ground_speed()
        moving = tuple(velocity + ground for velocity in velocities)
        drags = tuple(map(self.drag, moving, sides))
        lost = sum(-drag * velocity for drag, velocity in zip(drags, moving, strict=True))
        powers: tuple = (lost, self.force * moving[0])
        if self.has_weight(machine):
            powers = (*powers, -machine.gravity[1] * machine.line_momentum(t, y))
        at_rest = self.linear_drag * ground
        forces = (self.force, *(0.0 for _ in moving[1:]))
        pushes = tuple((force - drag, force - at_rest) for force, drag in zip(forces, drags, strict=True))
        return Outside(pushes, sum(push for push, _ in pushes), powers)
