"""The mode-coupling block: springs at an angle, and a sliding contact whose load follows the block's second motion."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import (
    Contact,
    Machine,
    NonNegative,
    Number,
    Positive,
    SIScales,
    parameter,
    parameters,
)


@parameters
class ModeCouplingBlock(Machine):
    """Block on a belt, on springs that couple its motion along the belt, x, to that towards it, y.

    The smallest model in which friction makes vibrations though its coefficient is constant (Hoffmann, Fischer,
    Allgaier and Gaul, Mech. Res. Comm. 29, 2002, 197-205): pressed on, the block is pulled along.

        m x'' = drive - k11 x - k12 y - c x' - R,     m y'' = -k12 x - k22 y - c y',     N = N_0 + k3 y

    k22 holds the stiffness k3 of the contact. Sliding steadily in a belt that is faster, R = -mu N, it has the
    stiffness matrix [[k11, k12 - mu k3], [k12, k22]], so that without damping two of its frequencies meet, at
    sqrt((k11 + k22)/(2 m)), and one vibration grows, where

        mu > [(k11 - k22)^2/(4 k12) + k12]/k3

    The run ends where N falls to zero. Any consistent units may be used, SI as well as none.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    sliding_stiffness: Positive = parameter(2.0, "k11", "stiffness along the belt", "stiffness")
    coupling_stiffness: Number = parameter(0.5, "k12", "stiffness that couples both directions", "stiffness")
    normal_stiffness: Positive = parameter(
        1.6, "k22", "stiffness towards the belt, the contact's included", "stiffness"
    )
    contact_stiffness: NonNegative = parameter(1.2, "k3", "stiffness of the contact", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper, in each direction", "viscous damping")
    belt_speed: Number = parameter(1.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(1.0, "N_0", "load on the contact where y = 0", "load")

    name: ClassVar[str] = "mode-coupling-block"
    source: ClassVar[str] = "hoffmann2002"
    states: ClassVar = ("approach", "approach_rate", "position", "sliding_velocity")
    cyclic: ClassVar = None
    place: ClassVar = "position"
    contact_states: ClassVar = ("sliding_velocity",)
    symmetry: ClassVar = (-1, -1, -1, -1)
    channels: ClassVar = ("drive", "damper", "belt")
    si_scales: ClassVar = SIScales
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    @property
    def symmetric(self) -> bool:
        """Only on a belt at rest, and with a load that does not follow the motion."""
        return self.belt_speed == 0.0 and self.contact_stiffness == 0.0

    @property
    def follows_load(self) -> bool:
        """Always."""
        return True

    def scales(self, time=1.0):
        """Amplitude and speed that a force of the size of the load makes, as of an `Oscillator`."""
        stiffness = self.sliding_stiffness + self.mass * (2.0 * math.pi / time) * (2.0 * math.pi / time)
        length, speed = self.normal_load / stiffness, self.normal_load / sqrt(self.mass * stiffness)
        return length, speed, length, speed

    def effort_scale(self):
        """N."""
        return self.normal_load

    def ground_speed(self):
        """v_b."""
        return self.belt_speed

    def contacts(self, t, y, drive):
        """v = x' - v_b, R that keeps v' = 0, and N = N_0 + k3 y, whatever the friction."""
        load = self.normal_load + self.contact_stiffness * y[0]
        return (Contact(y[3], self.outer_force(t, y, drive), reaction=(1.0, load, 0.0)),)

    def outer_force(self, t, y, drive):
        """drive - k11 x - k12 y - c x', with x' = v + v_b."""
        springs = self.sliding_stiffness * y[2] + self.coupling_stiffness * y[0]
        return drive - springs - self.damping * (y[3] + self.belt_speed)

    def rates(self, t, y, drive, frictions):
        """y' = (y', y'', x', v')."""
        pull = self.coupling_stiffness * y[2] + self.normal_stiffness * y[0] + self.damping * y[1]
        sliding = (self.outer_force(t, y, drive) - frictions[0]) / self.mass
        return y[1], -pull / self.mass, y[3] + self.belt_speed, sliding

    def energy(self, t, y):
        """H = m (x'^2 + y'^2)/2 + (k11 x^2 + 2 k12 x y + k22 y^2)/2."""
        velocity = y[3] + self.belt_speed
        springs = self.sliding_stiffness * y[2] * y[2] + self.normal_stiffness * y[0] * y[0]
        kinetic = 0.5 * self.mass * (velocity * velocity + y[1] * y[1])
        return kinetic + 0.5 * springs + self.coupling_stiffness * y[2] * y[0]

    def momentum(self, t, y):
        """p = m x'; p' = drive - k11 x - k12 y - c x' - R."""
        return self.mass * (y[3] + self.belt_speed)

    def powers(self, t, y, drive, frictions):
        """Power of the drive, drive x', of both dampers, and of the belt, -R v_b; with -R v they are H'."""
        velocity = y[3] + self.belt_speed
        return (
            drive * velocity,
            -self.damping * (velocity * velocity + y[1] * y[1]),
            -self.belt_speed * frictions[0],
        )
