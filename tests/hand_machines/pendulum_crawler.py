"""The pendulum crawler: a pendulum capsule whose pendulum moves as it is told, whatever torque that takes."""

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from hand_machines.capsule_with_bob import DAMPER, SPRING
from hand_machines.imposed import ImposedDisplacement
from vibrocap.physics.bodies import capsule_with_pendulum
from vibrocap.physics.elementary import atan, sqrt
from vibrocap.physics.machines.machine import (
    NonNegative,
    Positive,
    cos,
    parameter,
    parameters,
    sin,
)

MOTIONS = ("angle", "displacement")


def _checked_motion(given: Any) -> Any:
    if isinstance(given, str) and given in MOTIONS:
        return given
    raise ValueError('should be "angle" (the drive is theta) or "displacement" (it is sin(theta))')


Motion = Annotated[str, BeforeValidator(_checked_motion)]


@parameters
class PendulumCrawler(ImposedDisplacement):
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

    def displacement(self, t) -> tuple:
        """(-s', -s'')."""
        slope, curvature = super().displacement(t)
        if self.motion == "displacement":
            return -slope, -curvature
        angle = self.imposed.value(t)
        return -(cos(angle) * slope), sin(angle) * (slope * slope) - cos(angle) * curvature

    def _angle(self, t) -> tuple:
        """(theta, theta', theta'')."""
        if self.motion == "angle":
            return self.imposed.value(t), self.imposed.slope(t), self.imposed.curvature(t)
        sine = self.imposed.value(t)
        cosine = sqrt(1.0 - sine * sine)
        rate = self.imposed.slope(t) / cosine
        return atan(sine / cosine), rate, (self.imposed.curvature(t) + sine * (rate * rate)) / cosine

    def actuator(self, t, y, frictions):
        """T and its power."""
        angle, rate, acceleration = self._angle(t)
        capsule = (-self.displacement(t)[1] - frictions[0]) / (self.mass_ratio + 1.0)
        torque = acceleration - cos(angle) * capsule - sin(angle) + self.stiffness * angle + self.damping * rate
        return {"actuator_torque": torque, "actuator_power": torque * rate}

    def scene(self, t, y):
        """The capsule and its pendulum, where the drive is known that moves it."""
        return super().scene(t, y) if self.imposed is None else capsule_with_pendulum(y[0], self._angle(t)[0])
