from typing import ClassVar

from vibrocap.physics.elementary import exp
from vibrocap.physics.friction.law import NonNegative, TwoLevels, parameter, parameters


@parameters
class Exponential(TwoLevels):
    """Exponential law (EM): the friction force drops from static to Coulomb level as the contact speeds up.

    It is a function of velocity alone, so accelerating and decelerating take the same path; at rest it balances
    whatever is applied, up to N eta_s.

        R = N [eta_c + (eta_s - eta_c) exp(-a |v|)] sgn(v),   |R| <= N eta_s at v = 0      Liu et al. 2019, eq. 8

    The paper calls the rate alpha in (8) and a in (9); it counts N a second time in (5) (errata 1 and 2).
    """

    decay_rate: NonNegative = parameter(
        10.0, "a", "rate of the drop from static to Coulomb level over speed", "decay rate"
    )

    name: ClassVar[str] = "exponential"
    source: ClassVar[str] = "tustin1947; armstrong1994"

    def steady_force(self, speed, load):
        drop = self.static_coefficient - self.coulomb_coefficient
        return load * (self.coulomb_coefficient + drop * exp(-self.decay_rate * speed))
