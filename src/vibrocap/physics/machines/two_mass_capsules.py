"""Capsules with an inner mass on a line: on a spring, with soft or rigid stops, or told its motion."""

from typing import Annotated, Any, ClassVar

from vibrocap.arguments import ArgumentError
from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2, InnerMassScales, Scales
from vibrocap.physics.machines.machine import Machine, NonNegative, Positive, parameter, parameters
from vibrocap.physics.machines.stops import BACK_GAP, BackGap, StopDamping, StopStiffness, behind, elastic_stop
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Stop, coordinate
from vibrocap.physics.parameters import MOST, Fraction, allowed

WEIGHT = "weight"
ROUNDING = 1e-9  # of gravity, within which scales count force in the weight of the inner mass
Load = Annotated[Any, allowed('a finite number >= 0 or "weight" (mass_ratio + 1, in units of m g)', (WEIGHT,), MOST)]
ACTUATIONS = '"internal" (the drive acts between the masses) or "external" (on the mass alone)'
Actuation = Annotated[str, allowed(ACTUATIONS, ("internal", "external"))]


def load(unit: str) -> Any:
    """The load of such a machine, as a parameter of it."""
    plain = f'load on the contact{unit}: a number, or "weight" (lambda + 1, in units of m g)'
    return parameter(1.0, "N", plain, "load", in_si='load on the contact: a force, or "weight"')


class WithInnerMass(Machine):
    """A body of mass lambda in which a mass 1 moves to and fro, on one contact under a constant load or its weight."""

    mass_ratio: Any
    normal_load: Any

    si_scales: ClassVar = InnerMassScales

    def check_scales(self, scales: Scales) -> None:
        """The weight is lambda + 1 where force is counted in m g: ArgumentError for it in other units."""
        gravity = getattr(scales, "gravity_m_per_s2", STANDARD_GRAVITY_M_PER_S2)
        counted = scales.length_m / scales.time_s**2
        if self.normal_load == WEIGHT and not abs(counted - gravity) <= ROUNDING * gravity:
            what = "which counts forces in m g; leave out time_unit_s, or give the load in N, normal_load_N"
            raise ArgumentError("machine.normal_load", f'should be "weight" with a unit of time sqrt(l/g), {what}')


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


@parameters
class VibroImpactCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a spring: forward, and back too where `back_gap` is given.

    The stop is a spring without mass at the distance delta, which the mass touches and leaves without a jump, or a
    spring and a damper; the stop behind may have its own (`Stop`). With actuation = "external", rho = 1 and the
    friction level N eta = 1 it is the capsule of Liu, Wiercigroch, Pavlovskaia and Yu (Int. J. Mech. Sci. 66, 2013,
    2-11): time in 1/sqrt(k_1/m_1), length in P_f/k_1, nu = 2 xi, lambda = gamma.
    """

    mass_ratio: Positive = parameter(
        5.0, "gamma", "capsule mass over inner mass, m_2/m_1", "mass", in_si="mass of the capsule"
    )
    stop_stiffness: NonNegative = parameter(
        15.0, "beta", "spring of the stop", "stiffness", over=", k_2/(m_1 omega_0^2)"
    )
    gap: NonNegative = parameter(0.02, "delta", "gap between mass and front stop", "gap")
    back_gap: BackGap = BACK_GAP
    stop_damping: StopDamping = parameter(
        None,
        "nu_s",
        "damper of the stop, c_2/(m_1 omega_0); none where it has none",
        "viscous damping",
        in_si="damper of the stop; none where it has none",
    )
    back_stop_stiffness: StopStiffness = behind("beta_b", "spring", "stiffness")
    back_stop_damping: StopDamping = behind("nu_b", "damper", "viscous damping")
    actuation: Actuation = actuation_parameter("external")

    source: ClassVar[str] = "liu2013"
    name: ClassVar[str] = "vibro-impact-capsule"

    def parts(self, q):
        return [*super().parts(q), elastic_stop(self, q.displacement)]


@parameters
class RigidStopCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a rigid wall: forward, and back too where `back_gap` is given.

    By Newton's law of impact z' := -e z', which takes lambda/(lambda + 1) (1 - e^2) z'^2/2; dry friction is finite and
    has no impulse then. Rebounds of a mass that is pushed against the wall accumulate in a finite time (Zeno). Those
    slower than 1e-7 natural speeds, which would rise by rounding only, are left out: the masses continue together, with
    the momentum that they have, until the wall would have to pull.
    """

    restitution: Fraction = parameter(0.5, "e", "coefficient of restitution of the stops, 0 to 1", "fraction")
    gap: NonNegative = parameter(0.2, "delta", "gap between mass and front stop", "gap")
    back_gap: BackGap = BACK_GAP

    name: ClassVar[str] = "rigid-stop-capsule"
    source: ClassVar[str] = "liu2013; brogliato2016"

    def parts(self, q):
        stop = Stop(q.displacement, self.gap, self.back_gap, restitution=self.restitution)
        return [*super().parts(q), stop]


@parameters
class TwoMassCrawler(WithInnerMass):
    """Body M with an inner mass m whose motion along it the drive imposes; friction alone acts from outside.

    The drive is the displacement z(t) of the inner mass in the body. The state is p, the velocity of the common centre
    of mass, which continues where z' jumps; the body moves with X' = p - mu z', mu = m/(M + m) = 1/(lambda + 1). With
    z' piecewise constant or linear these are the two-phase and three-phase crawlers of Chernousko (2002), whose
    progress is known in closed form. At rest the contact holds R = -z'', in units of m.

    The energy is that of the common centre, (lambda + 1) p^2/2, and the work of the drive is its gain; that of the
    relative motion, (1 - mu) z'^2/2, goes into the inner mass and back in each period. `actuator_power` has both,
    `actuator_force` is the force between the masses; where z' jumps by d it has the impulse (1 - mu) d besides.

    Mass is counted in m, length and time in units of one's choice; the load is a force in those.
    """

    mass_ratio: Positive = parameter(1.0, "lambda", "mass of the body", "mass", over=" over inner mass, M/m")
    normal_load: Load = load("")

    name: ClassVar[str] = "two-mass-crawler"
    source: ClassVar[str] = "chernousko2002"
    effort: ClassVar = "displacement"
    si_names: ClassVar = {"mass_ratio": "body_mass"}
    si_load: ClassVar = '"weight" for that of body and inner mass, (M + m) g'

    position = coordinate("X", "place of the body", "m", rate="centre_velocity")

    def parts(self, q):
        body = Mass("body", self.mass_ratio, x=q.position)
        return [body, Mass("inner mass", 1.0, on=body, x=q.imposed(q.drive)), Contact(body, load=self.normal_load)]
