"""The sprung mass: a capsule driven by a mass that a motor shakes along an inclined track between two stops."""

from typing import ClassVar

from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Stop, coordinate


@parameters
class SprungMass(Machine):
    """Inner mass m on a spring and a damper in a capsule M; the drive pushes them apart along a track in it.

    The track rises forward by the angle beta and ends at soft stops. Units are m, a length l of the user's choice and
    sqrt(l/g), so that the unit of force is m g.
    """

    mass_ratio: Positive = parameter(2.5, "lambda", "capsule mass over inner mass, M/m", "mass")
    stiffness: NonNegative = parameter(2.0, "rho", "spring, k l/(m g)", "stiffness")
    damping: NonNegative = parameter(0.5, "nu", "viscous damper, c sqrt(l/g)/m", "viscous damping")
    gap: NonNegative = parameter(0.6, "delta", "clearance of the mass to either stop", "gap")
    stop_stiffness: NonNegative = parameter(20.0, "kappa", "spring of a stop, k_s l/(m g)", "stiffness")
    track_angle: Number = parameter(0.15, "beta", "rise of the track, forward upwards", "phase")

    name: ClassVar[str] = "sprung-mass"
    source: ClassVar[str] = "vibrocap"
    displacement = coordinate("z", "displacement of the mass along the track", "m")
    position = coordinate("X", "position of the capsule", "m")

    def parts(self, q):
        """Capsule and inner mass on its track, which ends at stops."""
        z, rise = q.displacement, sin(self.track_angle)
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        inner = Mass("inner mass", 1.0, on=capsule, x=z * cos(self.track_angle), z=z * rise)
        joint = Spring(self.stiffness, z, rest=-rise / self.stiffness), Damper(self.damping, z), Drive(z)
        stops = Stop(z, self.gap, self.gap, stiffness=self.stop_stiffness)
        return capsule, inner, joint, stops, Contact(capsule)
