"""Capsules with two pendulums: side by side at one pivot, or the second on the bob of the first."""

from typing import ClassVar

from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.machines.capsule_with_bob import PendulumScales
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, coordinate

DAMPER = parameter(0.5, "nu", "viscous damper of each joint", "torsional damping")


@parameters
class PendulumPair(Machine):
    """What both have in common: units of the first pendulum, angles from upright, a load that follows the motion."""

    mass_ratio: Positive = parameter(
        6.0, "lambda", "mass of the capsule", "mass", over=" over that of the first bob, M/m"
    )
    mass_ratio_2: Positive = parameter(
        0.5, "mu", "mass of the second bob", "mass", over=" over that of the first, m_2/m"
    )
    length_2: Positive = parameter(
        0.6, "l_2", "length of the second rod over that of the first", "distance", in_si="second rod"
    )
    effort: ClassVar = "torque"
    source: ClassVar[str] = "vibrocap"
    si_scales: ClassVar = PendulumScales
    si_names: ClassVar = {"mass_ratio": "capsule_mass", "mass_ratio_2": "second_mass"}
    angle = coordinate("theta", "angle of each rod from upright", "rad", count=2)
    position = coordinate("X", "place of the capsule", "m")

    def bodies(self, q, joined: bool) -> list:
        """Capsule, bob and second bob, which hangs on the first one or on the capsule."""
        capsule, (first, second), far = Mass("capsule", self.mass_ratio, x=q.position), q.angle, self.length_2
        bob = Mass("bob", 1.0, on=capsule, x=-sin(first), z=cos(first))
        on = bob if joined else capsule
        return [capsule, bob, Mass("bob 2", self.mass_ratio_2, on=on, x=-far * sin(second), z=far * cos(second))]


@parameters
class TwoPendulumCapsule(PendulumPair):
    """Capsule with two pendulums side by side; the drive turns the second with a share of its torque.

    The masses are m_1 = 1 and m_2 = mu, the lengths l_1 = 1 and l_2; a joint takes -rho_i theta_i - nu theta_i' + a_i
    drive, a_1 = 1 and a_2 = a. Time is in units of sqrt(l/g), length in l, mass in m of the first pendulum.
    """

    stiffness: NonNegative = parameter(2.0, "rho_1", "torsional spring of the first", "torsional stiffness")
    stiffness_2: NonNegative = parameter(1.0, "rho_2", "torsional spring of the second", "torsional stiffness")
    damping: NonNegative = DAMPER
    share: Number = parameter(-0.5, "a", "torque of the drive on the second over that on the first", "share")
    name: ClassVar[str] = "two-pendulum-capsule"

    def parts(self, q):
        bodies, (first, second) = self.bodies(q, joined=False), q.angle
        springs = Spring(self.stiffness, first), Spring(self.stiffness_2, second)
        dampers = [Damper(self.damping, angle) for angle in q.angle]
        return [*bodies, *springs, *dampers, Drive(first), Drive(second, self.share), Contact(bodies[0])]


@parameters
class DoublePendulumCapsule(PendulumPair):
    """Capsule with a double pendulum: the second rod is hinged to the bob of the first, the drive turns the first.

    x_1 = X - sin(theta_1), z_1 = cos(theta_1), x_2 = x_1 - l_2 sin(theta_2) and z_2 = z_1 + l_2 cos(theta_2); the
    joints are stretched by theta_1 and theta_2 - theta_1. Units are those of the first pendulum: sqrt(l/g), l and m.
    """

    stiffness: NonNegative = parameter(6.0, "rho", "torsional spring of each joint", "torsional stiffness")
    damping: NonNegative = DAMPER
    name: ClassVar[str] = "double-pendulum-capsule"

    def parts(self, q):
        bodies, (first, second) = self.bodies(q, joined=True), q.angle
        joints = [(Spring(self.stiffness, s), Damper(self.damping, s)) for s in (first, second - first)]
        return [*bodies, joints, Drive(first), Contact(bodies[0])]
