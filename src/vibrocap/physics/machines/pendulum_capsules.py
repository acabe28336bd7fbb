"""Capsules that a pendulum or a rotor on a pivot moves: one or two of them, driven, stopped, or told their motion."""

import math
from typing import Annotated, Any, ClassVar

from pydantic import model_validator

from vibrocap.physics.dimensions.scales import PendulumScales
from vibrocap.physics.elementary import atan, cos, sin, sqrt
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Stop, coordinate
from vibrocap.physics.parameters import MOST, allowed

LOADS = 'a finite number >= 0, "weight" (mass_ratio + 1) or "dynamic" (of the motion)'
ENDS = "a number from 0 to 1, or be left out where a run is to end at the stop"
MOTIONS = '"angle" (the drive is theta) or "displacement" (it is sin(theta))'
Load = Annotated[Any, allowed(LOADS, ("weight", "dynamic"), MOST)]
EndOrRestitution = Annotated[Any, allowed(ENDS, (None,), 1.0)]
CAPSULE = parameter(2.5, "lambda", "capsule mass over pendulum mass, M/m", "mass", in_si="mass of the capsule")
SPRING = parameter(2.0, "rho", "torsional spring", "torsional stiffness", over=", k/(m l^2 omega_n^2)")
DAMPER = parameter(1.0, "nu", "viscous damper at the pivot", "torsional damping", over=", c/(m l^2 omega_n)")
JOINT = parameter(0.5, "nu", "viscous damper of each joint", "torsional damping")


def load(default: Any) -> Any:
    """The load of a capsule with a bob, as a parameter of the machine."""
    plain, in_si = 'a number, "weight" (lambda + 1)', 'load on the contact: a force, "weight"'
    words = 'or "dynamic" (the reaction of the ground)'
    return parameter(default, "N", f"load on the contact over m g: {plain} {words}", "load", in_si=f"{in_si} {words}")


class CapsuleWithBob(Machine):
    """What swings or turns about a pivot on a capsule: a bob at the distance 1, as in `PendulumCapsule`."""

    mass_ratio: Any
    damping: Any
    normal_load: Any

    angle = coordinate("theta", "angle of the pendulum from upright", "rad")
    position = coordinate("X", "place of the capsule", "m")
    bob: ClassVar[str] = "bob"
    effort: ClassVar = "torque"
    si_scales: ClassVar = PendulumScales
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}

    def parts(self, q):
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        bob = Mass(self.bob, 1.0, on=capsule, x=-sin(q.angle), z=cos(q.angle))
        return [capsule, bob, Damper(self.damping, q.angle), Drive(q.angle), Contact(capsule, load=self.normal_load)]


@parameters
class PendulumCapsule(CapsuleWithBob):
    """Inverted pendulum (mass m, length l) on a capsule (mass M), joined by a torsional spring and a viscous damper.

    The drive torque swings the pendulum, whose reaction pushes the capsule against friction. With
    B = lambda + 1 - cos^2(theta) and P = drive + sin(theta) - rho theta - nu theta' (Liu et al. 2019, eq. 9):

        theta'' = [(lambda+1) P - sin(theta) cos(theta) theta'^2 - R cos(theta)] / B
        X''     = [cos(theta) P - sin(theta) theta'^2 - R] / B

    Time is in units of sqrt(l/g), length in l, mass in m: `PendulumScales`. N = 1, the default without units, is the
    weight of the pendulum, m g; that on the contact is lambda + 1, normal_load = "weight" (erratum 1). In SI there is
    no default. With normal_load = "dynamic" the load follows the bob, N = lambda + 1 + (cos(theta))'', and with eq. 9

        B N = (lambda+1) [B - sin(theta) P] - lambda cos(theta) theta'^2 + sin(theta) cos(theta) R

    Its mean over a period of a motion that repeats is lambda + 1. The capsule lifts off where N falls to zero.
    """

    mass_ratio: Positive = CAPSULE
    stiffness: NonNegative = SPRING
    damping: NonNegative = DAMPER
    normal_load: Load = load(1.0)

    name: ClassVar[str] = "pendulum-capsule"
    source: ClassVar[str] = "liu2019"
    si_load: ClassVar = (
        '"weight" for that of capsule and pendulum, (M + m) g, or "dynamic" (the ground\'s reaction); there is no '
        "default, because the one without units, 1, is the weight of the pendulum alone"
    )

    def parts(self, q):
        return [*super().parts(q), Spring(self.stiffness, q.angle)]


@parameters
class PendulumCapsuleWithStops(PendulumCapsule):
    """Pendulum capsule whose pendulum is stopped at the angles theta_m and -theta_m: the floor, or limits of its drive.

    Without `restitution` a run ends there, with the status "stop reached". With it the pendulum bounces off the
    capsule, theta' := -e theta', without loss of momentum and with no impulse of friction, which is finite under a
    constant load (one that follows the motion is refused). A pendulum that is pushed against its stop rests there after
    its rebounds, see `RigidStopCapsule`.
    """

    limit_angle: Positive = parameter(math.pi / 2, "theta_m", "angle at which the pendulum is stopped", "phase")
    restitution: EndOrRestitution = parameter(
        None, "e", "coefficient of restitution of the stops, 0 to 1; none: a run ends there", "fraction"
    )

    source: ClassVar[str] = "liu2019; brogliato2016"
    name: ClassVar[str] = "pendulum-capsule-with-stops"
    first_case: ClassVar = {"machine.limit_angle": 0.8, "machine.restitution": 0.6}

    @model_validator(mode="after")
    def _constant_load(self):
        if self.restitution is not None and self.follows_load:
            why = 'with normal_load = "dynamic", as a blow would have an impulse of the load'
            raise ValueError(f"restitution should be left out {why}, got {self.restitution}")
        return self

    def parts(self, q):
        gaps = {"gap": self.limit_angle, "back_gap": self.limit_angle}
        return [*super().parts(q), Stop(q.angle, **gaps, restitution=self.restitution)]


@parameters
class RotorCapsule(CapsuleWithBob):
    """Eccentric mass (mass m, eccentricity l) turned by a motor on a capsule (mass M), which its reaction pushes.

    The motor is one of limited power: the faster it turns, the less torque it has left,

        P = T + sin(theta) - nu theta',     nu = T/Omega_0              Kononenko 1969, linear characteristic

    where T is the drive, the torque at standstill, which the voltage of a direct-current motor sets, and Omega_0 the
    speed at which nothing of it is left (damping of the bearings adds to nu). So the speed follows from the motion of
    the capsule; it may be caught at a resonance, or stop where T cannot lift the mass. A constant drive is a motor that
    is switched on. The equations are those of `PendulumCapsule` under this P, with theta from upright; all have the
    period 2 pi in theta, and the number of whole turns in a period of a motion is its winding number.

    Units as of the pendulum capsule. The load is the weight lambda + 1, another constant or "dynamic".
    """

    mass_ratio: Positive = parameter(
        4.0, "lambda", "capsule mass over eccentric mass, M/m", "mass", in_si="mass of the capsule"
    )
    damping: NonNegative = parameter(
        0.75, "nu", "fall of the motor's torque over its speed (stall torque over no-load speed)", "torsional damping"
    )
    normal_load: Load = load("weight")

    name: ClassVar[str] = "rotor-capsule"
    source: ClassVar[str] = "kononenko1969"
    angle = coordinate("theta", "angle of the rotor from upright", "rad", repeats=2.0 * math.pi)
    bob: ClassVar[str] = "eccentric mass"
    si_load: ClassVar = (
        '"weight" for that of capsule and eccentric mass, (M + m) g, or "dynamic" for the reaction of the ground'
    )


@parameters
class PendulumCrawler(Machine):
    """Pendulum capsule whose angle theta(t), or sin(theta), is imposed by the drive: ideal tracking of a motion.

    The balance of momentum alone is left: with sin(theta) it is the two-mass crawler with mirrored displacement. The
    torque T that the motion takes (Liu et al. 2019, eq. 4) is `actuator_torque`, and T theta' is `actuator_power`.
    Energy and work of the drive are those of the common centre, as for the crawler. Units are those of the pendulum
    capsule; the load is constant.
    """

    mass_ratio: Positive = CAPSULE
    stiffness: NonNegative = SPRING
    damping: NonNegative = DAMPER
    normal_load: NonNegative = parameter(1.0, "N", "load on the contact", "load", over=" over m g")
    motion: Annotated[str, allowed(MOTIONS, ("angle", "displacement"))] = parameter("angle", "motion", MOTIONS)

    name: ClassVar[str] = "pendulum-crawler"
    source: ClassVar[str] = "liu2019; chernousko2002"
    effort: ClassVar = "number"
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}

    position = coordinate("X", "place of the capsule", "m", rate="centre_velocity")

    def parts(self, q):
        motion = q.drive
        angle = q.imposed(motion if self.motion == "angle" else atan(motion / sqrt(1.0 - motion * motion)))
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        bob = Mass("bob", 1.0, on=capsule, x=-sin(angle), z=cos(angle))
        joint = Spring(self.stiffness, angle), Damper(self.damping, angle)
        return [capsule, bob, *joint, Contact(capsule, load=self.normal_load)]


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
    damping: NonNegative = JOINT
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
    damping: NonNegative = JOINT
    name: ClassVar[str] = "double-pendulum-capsule"
    first_case: ClassVar = {"friction.coulomb_coefficient": 0.05, "friction.static_coefficient": 0.1}

    def parts(self, q):
        bodies, (first, second) = self.bodies(q, joined=True), q.angle
        joints = [(Spring(self.stiffness, s), Damper(self.damping, s)) for s in (first, second - first)]
        return [*bodies, joints, Drive(first), Contact(bodies[0])]
