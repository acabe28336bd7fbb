from typing import ClassVar

from vibrocap.physics.friction.law import STRIBECK_EXPONENT, STRIBECK_VELOCITY, Exponent, TwoLevels, stribeck_level
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters


@parameters
class Stribeck(TwoLevels):
    """Stribeck curve: friction drops from static to Coulomb level as a film builds up, then rises with its viscosity.

        R = {N [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)] + delta2 |v|} sgn(v),   |R| <= N eta_s at v = 0
                                                                    Bo and Pavelescu 1982; Armstrong-Helouvry 1991

    alpha = 2 is the Gaussian, alpha = 1 the exponential law with a = 1/v_s. It is a function of velocity alone: no lag,
    no presliding.
    """

    stribeck_velocity: Positive = STRIBECK_VELOCITY
    stribeck_exponent: Exponent = STRIBECK_EXPONENT
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")

    name: ClassVar[str] = "stribeck"
    shape_parameters: ClassVar = ("stribeck_exponent",)
    source: ClassVar[str] = "bo1982; armstrong1991"

    def steady_force(self, speed, load):
        return stribeck_level(self, speed, load) + self.viscous_damping * speed
