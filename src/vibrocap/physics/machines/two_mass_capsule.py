from typing import Annotated, ClassVar

from vibrocap.physics.machines.inner_mass import Load, WithInnerMass
from vibrocap.physics.machines.machine import NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, coordinate
from vibrocap.physics.parameters import allowed

ACTUATIONS = '"internal" (the drive acts between the masses) or "external" (on the mass alone)'
Actuation = Annotated[str, allowed(ACTUATIONS, ("internal", "external"))]


@parameters
class TwoMassCapsule(WithInnerMass):
    """Inner mass m on a spring and a damper in a capsule M; both move along one line.

    With z the displacement of the mass in the capsule, and the force F that pulls it back,

        z'' + X'' = drive - F,     lambda X'' = F - drive - R,     F = rho z + nu z'

    A drive between the masses pushes the capsule back, as here. One that pulls the mass from outside, a magnet for
    instance (actuation = "external"), does not: lambda X'' = F - R (Liu et al. 2013).

    Time is in units of 1/omega_0 for a frequency omega_0 of one's choice, mass in m, length in a length l of one's
    choice and force in m l omega_0^2; the load is a force in that unit. Nothing rises or falls: the load is constant.
    Where force is counted in m g, as in SI, normal_load = "weight" is that of capsule and mass, lambda + 1.
    """

    mass_ratio: Positive = parameter(
        2.5, "lambda", "capsule mass over inner mass, M/m", "mass", in_si="mass of the capsule"
    )
    stiffness: NonNegative = parameter(1.0, "rho", "spring, k/(m omega_0^2)", "stiffness", in_si="spring")
    damping: NonNegative = parameter(
        0.1, "nu", "viscous damper, c/(m omega_0)", "viscous damping", in_si="viscous damper"
    )
    normal_load: Load = parameter(
        1.0,
        "N",
        'load on the contact over m l omega_0^2: a number, or "weight" (lambda + 1, in units of m g)',
        "load",
        in_si='load on the contact: a force, or "weight"',
    )
    actuation: Actuation = parameter(
        "internal", "a", 'where the drive acts: "internal", between the masses, or "external", on the mass alone'
    )

    name: ClassVar[str] = "two-mass-capsule"
    source: ClassVar[str] = "chernousko2002; liu2013"
    si_load: ClassVar = '"weight" for that of capsule and inner mass, (M + m) g'
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}
    displacement = coordinate("z", "displacement of the inner mass in the capsule", "m")
    position = coordinate("X", "place of the capsule", "m")

    def parts(self, q):
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        inner = Mass("inner mass", 1.0, on=capsule, x=q.displacement)
        joint = Spring(self.stiffness, q.displacement), Damper(self.damping, q.displacement)
        drive = Drive(inner.along if self.actuation == "external" else q.displacement)
        return [capsule, inner, *joint, drive, Contact(capsule, load=self.normal_load)]
