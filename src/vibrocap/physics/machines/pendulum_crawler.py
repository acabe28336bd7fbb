"""The pendulum crawler: a pendulum capsule whose pendulum moves as it is told, whatever torque that takes."""

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from vibrocap.physics.elementary import atan, sqrt
from vibrocap.physics.machines.machine import (
    Imposed,
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
class PendulumCrawler(Imposed):
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

    mass_ratio: Positive = parameter(2.5, "lambda", "capsule mass over pendulum mass, M/m", "mass")
    stiffness: NonNegative = parameter(2.0, "rho", "torsional spring, k/(m l^2 omega_n^2)", "torsional stiffness")
    damping: NonNegative = parameter(1.0, "nu", "viscous damper at the pivot, c/(m l^2 omega_n)", "torsional damping")
    normal_load: NonNegative = parameter(1.0, "N", "load on the contact over m g", "load")
    motion: Motion = parameter("angle", "motion", '"angle" (the drive is theta) or "displacement" (it is sin(theta))')

    name: ClassVar[str] = "pendulum-crawler"
    states: ClassVar = ("position", "centre_velocity")
    cyclic: ClassVar = "position"
    contact_state: ClassVar = "centre_velocity"
    symmetry: ClassVar = (-1, -1)
    channels: ClassVar = ("drive", "damper")
    effort: ClassVar = "number"
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}
    state_units: ClassVar = {"centre_velocity": "m/s"}

    def _displacement(self, t) -> tuple:
        """(s', s'')."""
        if self.motion == "displacement":
            return self.imposed.slope(t), self.imposed.curvature(t)
        angle, rate = self.imposed.value(t), self.imposed.slope(t)
        return cos(angle) * rate, cos(angle) * self.imposed.curvature(t) - sin(angle) * (rate * rate)

    def _angle(self, t) -> tuple:
        """(theta, theta', theta'')."""
        if self.motion == "angle":
            return self.imposed.value(t), self.imposed.slope(t), self.imposed.curvature(t)
        sine = self.imposed.value(t)
        cosine = sqrt(1.0 - sine * sine)
        rate = self.imposed.slope(t) / cosine
        return atan(sine / cosine), rate, (self.imposed.curvature(t) + sine * (rate * rate)) / cosine

    def load(self):
        """N."""
        return self.normal_load

    def contact_velocity(self, t, y):
        """X' = p + mu s'."""
        return y[1] + self._displacement(t)[0] / (self.mass_ratio + 1.0)

    def holding_force(self, t, y, drive):
        """R that keeps X'' = 0: s''."""
        return self._displacement(t)[1]

    def rates(self, t, y, drive, force):
        """y' = (X', p')."""
        return self.contact_velocity(t, y), -force / (self.mass_ratio + 1.0)

    def energy(self, t, y):
        """H = (lambda + 1) p^2/2, of the common centre."""
        return 0.5 * (self.mass_ratio + 1.0) * y[1] * y[1]

    def momentum(self, t, y):
        """(lambda + 1) p; its rate is -R."""
        return (self.mass_ratio + 1.0) * y[1]

    def powers(self, t, y, drive, force):
        """What of the power of the drive moves the common centre, mu s' R; the damper is the drive's affair."""
        return self._displacement(t)[0] * force / (self.mass_ratio + 1.0), 0.0

    def actuator(self, t, y, force):
        """T and its power."""
        angle, rate, acceleration = self._angle(t)
        capsule = (self._displacement(t)[1] - force) / (self.mass_ratio + 1.0)
        torque = acceleration - cos(angle) * capsule - sin(angle) + self.stiffness * angle + self.damping * rate
        return {"actuator_torque": torque, "actuator_power": torque * rate}
