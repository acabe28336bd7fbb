"""The oscillator: a block on a spring and a damper, on a belt that may run, moved by the force of the drive."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import (
    Body,
    Contact,
    Machine,
    Mechanism,
    NonNegative,
    Number,
    Positive,
    Shape,
    SIScales,
    parameter,
    parameters,
)


@parameters
class Oscillator(Machine):
    """Block of mass m on a spring k and a damper c, on a belt of the speed v_b, moved by the force of the drive.

    The oldest machine of dry friction (Den Hartog 1931), and with a running belt the standard test of stick-slip. The
    block is at x, its contact slides with v over the belt:

        x' = v + v_b,      m v' = drive - k x - c x' - R

    v is the state, not x', so that it is exactly zero while the contact sticks. A block that is pulled over fixed
    ground through a spring, whose far end moves at the speed V, is the same system seen from that end: v_b = -V, and
    the stretch of the spring is -x (`pulled`). Without a spring it is a mass on the ground.

    No constant of nature and no unit stands in these equations, nor in the friction laws: any consistent units may be
    used, SI as well as none. With a friction law whose coefficients are forces in N, the normal load is 1.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    stiffness: NonNegative = parameter(1.0, "k", "stiffness of the spring", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper beside the spring", "viscous damping")
    belt_speed: Number = parameter(0.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(
        1.0, "N", "load on the contact; 1 where the coefficients of the law are forces", "load"
    )

    name: ClassVar[str] = "oscillator"
    source: ClassVar[str] = "denhartog1931"
    states: ClassVar = ("position", "sliding_velocity")
    cyclic: ClassVar = None
    place: ClassVar = "position"
    contact_states: ClassVar = ("sliding_velocity",)
    symmetry: ClassVar = (-1, -1)
    channels: ClassVar = ("drive", "damper", "belt")
    si_scales: ClassVar = SIScales
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    @classmethod
    def pulled(cls, speed: float, **given: float) -> "Oscillator":
        """The block that is pulled at a speed through its spring over fixed ground; `given`: the other parameters.

        Its spring pulls with -k x, and the block has moved by x + V t.
        """
        return cls(belt_speed=-speed, **given)

    @property
    def symmetric(self) -> bool:
        """Only on a belt at rest."""
        return self.belt_speed == 0.0

    def scales(self, time=1.0) -> tuple:
        """Amplitude and speed that a force of the size of the load makes: N/|k + m omega^2| and omega times as much.

        omega^2 is that of the free vibration, k/m, plus that of the drive, so that no parameter but the mass need be
        there. 1.0 would be no size of a motion in SI.
        """
        inertia = self.mass * (2.0 * math.pi / time) * (2.0 * math.pi / time)
        stiffness = self.stiffness + inertia
        return self.normal_load / stiffness, self.normal_load / sqrt(self.mass * stiffness)

    def effort_scale(self):
        """N."""
        return self.normal_load

    def ground_speed(self):
        """v_b."""
        return self.belt_speed

    def masses(self):
        """m."""
        return {"sliding_velocity": self.mass}

    def outer_force(self, t, y, drive):
        """drive - k x - c x', with x' = v + v_b."""
        return drive - self.stiffness * y[0] - self.damping * (y[1] + self.belt_speed)

    def _held(self, t, y, drive):
        """R that keeps v' = 0: all other forces."""
        return self.outer_force(t, y, drive)

    def contacts(self, t, y, drive):
        """v, and what holds the block."""
        return (Contact(y[1], self._held(t, y, drive)),)

    def rates(self, t, y, drive, frictions) -> tuple:
        """y' = (x', v')."""
        return y[1] + self.belt_speed, (self._held(t, y, drive) - frictions[0]) / self.mass

    def energy(self, t, y):
        """H = m x'^2/2 + k x^2/2."""
        velocity = y[1] + self.belt_speed
        return 0.5 * self.mass * velocity * velocity + 0.5 * self.stiffness * y[0] * y[0]

    def momentum(self, t, y):
        """p = m x'; p' = drive - k x - c x' - R."""
        return self.mass * (y[1] + self.belt_speed)

    def powers(self, t, y, drive, frictions) -> tuple:
        """Power of the drive, drive x', of the damper, -c x'^2, and of the belt, -R v_b; with -R v they are H'."""
        velocity = y[1] + self.belt_speed
        return drive * velocity, -self.damping * velocity * velocity, -self.belt_speed * frictions[0]

    def mechanism(self, t, y) -> Mechanism | None:
        """The block on its spring."""
        joint = {"place": y[0], "rate": y[1] + self.belt_speed, "actuation": 1.0, "contact": 0}
        return Mechanism((Body("block", self.mass, stiffness=self.stiffness, damping=self.damping, **joint),))

    def scene(self, t, y) -> tuple[Shape, ...]:
        """The block at x, on its spring from a wall; the units of x are free, so that the wall stands where it fits."""
        return (
            Shape("spring", "spring", ((-2.5, 0.25), (y[0] - 0.5, 0.25))),
            Shape("box", "block", ((y[0], 0.25),), (1.0, 0.5)),
            Shape("contact", "contact", ((y[0], 0.0),), (0.9, 0.0)),
        )
