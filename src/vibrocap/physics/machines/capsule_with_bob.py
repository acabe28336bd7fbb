"""What capsules have in common whose inner mass goes round a pivot: a pendulum, or the eccentric mass of a rotor."""

import math
from typing import Annotated, Any, ClassVar

from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2, Scale, Scales
from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.machines.machine import Machine, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, coordinate
from vibrocap.physics.parameters import MOST, allowed

LOADS = 'a finite number >= 0, "weight" (mass_ratio + 1) or "dynamic" (of the motion)'
Load = Annotated[Any, allowed(LOADS, ("weight", "dynamic"), MOST)]
CAPSULE = parameter(2.5, "lambda", "capsule mass over pendulum mass, M/m", "mass", in_si="mass of the capsule")
SPRING = parameter(2.0, "rho", "torsional spring", "torsional stiffness", over=", k/(m l^2 omega_n^2)")
DAMPER = parameter(1.0, "nu", "viscous damper at the pivot", "torsional damping", over=", c/(m l^2 omega_n)")


def load(default: Any) -> Any:
    """The load of a capsule with a bob, as a parameter of the machine."""
    plain, in_si = 'a number, "weight" (lambda + 1)', 'load on the contact: a force, "weight"'
    words = 'or "dynamic" (the reaction of the ground)'
    return parameter(default, "N", f"load on the contact over m g: {plain} {words}", "load", in_si=f"{in_si} {words}")


@parameters
class PendulumScales(Scales):
    """Scales of a pendulum of mass m and length l under gravity g_0: time in 1/omega_n = sqrt(l/g_0), force in m g_0.

    Liu et al. 2019, before eq. 4.
    """

    pendulum_mass_kg: Scale = parameter(..., "m", "mass of the pendulum", unit="kg")
    pendulum_length_m: Scale = parameter(..., "l", "length of the pendulum", unit="m")
    gravity_m_per_s2: Scale = parameter(STANDARD_GRAVITY_M_PER_S2, "g_0", "gravitational acceleration", unit="m/s^2")

    @property
    def units(self) -> tuple[float, float, float]:
        return self.pendulum_mass_kg, self.pendulum_length_m, math.sqrt(self.pendulum_length_m / self.gravity_m_per_s2)


class CapsuleWithBob(Machine):
    """What swings or turns about a pivot on a capsule: a bob at the distance 1, as in `PendulumCapsule`."""

    mass_ratio: Any
    damping: Any
    normal_load: Any

    angle = coordinate("theta", "angle of the turning body from upright", "rad")
    position = coordinate("X", "place of the capsule", "m")
    bob: ClassVar[str] = "bob"
    effort: ClassVar = "torque"
    si_scales: ClassVar = PendulumScales
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}

    def parts(self, q):
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        bob = Mass(self.bob, 1.0, on=capsule, x=-sin(q.angle), z=cos(q.angle))
        return [capsule, bob, Damper(self.damping, q.angle), Drive(q.angle), Contact(capsule, load=self.normal_load)]
