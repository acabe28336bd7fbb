from typing import Annotated, ClassVar

from vibrocap.physics.elementary import atan, cos, sin, sqrt
from vibrocap.physics.machines.capsule_with_bob import DAMPER, SPRING
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Mass, Spring, coordinate
from vibrocap.physics.parameters import allowed

MOTIONS = '"angle" (the drive is theta) or "displacement" (it is sin(theta))'
Motion = Annotated[str, allowed(MOTIONS, ("angle", "displacement"))]


@parameters
class PendulumCrawler(Machine):
    """Pendulum capsule whose angle theta(t), or sin(theta), is what the drive says: an ideal tracking of a motion.

    With s = sin(theta), the displacement of the bob along the line, the balance of momentum alone is left:

        X' = p + mu s',     (lambda + 1) p' = -R,     mu = 1/(lambda + 1)

    which is the crawler with mirrored displacement. The torque that the motion takes follows from the other equation
    (Liu et al. 2019, eq. 4), with the spring rho and the damper nu at the pivot:

        T = theta'' - cos(theta) X'' - sin(theta) + rho theta + nu theta'

    It is `actuator_torque`, and T theta' is `actuator_power`. Energy and work of the drive are those of the common
    centre, as for the crawler. Time is in units of sqrt(l/g), length in l, mass in m, as for the pendulum capsule; the
    load is constant.
    """

    mass_ratio: Positive = parameter(
        2.5, "lambda", "capsule mass over pendulum mass, M/m", "mass", in_si="mass of the capsule"
    )
    stiffness: NonNegative = SPRING
    damping: NonNegative = DAMPER
    normal_load: NonNegative = parameter(1.0, "N", "load on the contact over m g", "load", in_si="load on the contact")
    motion: Motion = parameter("angle", "motion", '"angle" (the drive is theta) or "displacement" (it is sin(theta))')

    name: ClassVar[str] = "pendulum-crawler"
    source: ClassVar[str] = "liu2019; chernousko2002"
    effort: ClassVar = "number"
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}

    position = coordinate("X", "place of the capsule", "m", rate="centre_velocity")

    def _angle(self, given):
        """theta, of what the drive says."""
        return given if self.motion == "angle" else atan(given / sqrt(1.0 - given * given))

    def parts(self, q):
        capsule, angle = Mass("capsule", self.mass_ratio, x=q.position), q.imposed(self._angle(q.drive))
        bob = Mass("bob", 1.0, on=capsule, x=-sin(angle), z=cos(angle))
        joint = Spring(self.stiffness, angle), Damper(self.damping, angle)
        return [capsule, bob, *joint, Contact(capsule, load=self.normal_load)]
