from typing import ClassVar

from vibrocap.physics.machines.machine import NonNegative, Positive, parameter, parameters
from vibrocap.physics.machines.stops import BACK_GAP, BackGap, StopDamping, StopStiffness, behind, elastic_stop
from vibrocap.physics.machines.two_mass_capsule import Actuation, TwoMassCapsule, actuation_parameter


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
