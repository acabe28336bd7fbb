from typing import Annotated, ClassVar

from vibrocap.physics.elementary import atan, cos, sin, sqrt
from vibrocap.physics.machines.capsule_with_bob import CAPSULE, DAMPER, SPRING
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Mass, Spring, coordinate
from vibrocap.physics.parameters import allowed

MOTIONS = '"angle" (the drive is theta) or "displacement" (it is sin(theta))'


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
