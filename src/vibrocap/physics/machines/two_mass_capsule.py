from typing import Annotated, Any, ClassVar

from vibrocap.physics.machines.inner_mass import Load, WithInnerMass, load
from vibrocap.physics.machines.machine import NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, coordinate
from vibrocap.physics.parameters import allowed

ACTUATIONS = '"internal" (the drive acts between the masses) or "external" (on the mass alone)'
Actuation = Annotated[str, allowed(ACTUATIONS, ("internal", "external"))]


def actuation_parameter(default: str) -> Any:
    """Where the drive acts, as a parameter."""
    words = 'where the drive acts: "internal", between the masses, or "external", on the mass alone'
    return parameter(default, "a", words)


@parameters
class TwoMassCapsule(WithInnerMass):
    """Inner mass m on a spring and a damper in a capsule M; both move along one line.

    A drive between the masses pushes the capsule back, lambda X'' = rho z + nu z' - drive - R. One that pulls the mass
    from outside, such as a magnet (actuation = "external"), does not (Liu et al. 2013).

    Mass is counted in m, time in 1/omega_0 and length in l for omega_0 and l of one's choice, force and the load in m l
    omega_0^2. The load is constant; where force is counted in m g, as in SI, normal_load = "weight" is lambda + 1.
    """

    mass_ratio: Positive = parameter(
        2.5, "lambda", "capsule mass over inner mass, M/m", "mass", in_si="mass of the capsule"
    )
    stiffness: NonNegative = parameter(1.0, "rho", "spring", "stiffness", over=", k/(m omega_0^2)")
    damping: NonNegative = parameter(0.1, "nu", "viscous damper", "viscous damping", over=", c/(m omega_0)")
    normal_load: Load = load(" over m l omega_0^2")
    actuation: Actuation = actuation_parameter("internal")

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
