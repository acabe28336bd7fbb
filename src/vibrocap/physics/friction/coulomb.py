from typing import ClassVar

from vibrocap.physics.friction.law import NonNegative, TwoLevels, parameter, parameters


@parameters
class Coulomb(TwoLevels):
    """Coulomb friction: a kinetic level that does not depend on speed, and a static level that may be higher.

    At rest friction balances the applied force, up to the static level; at the start of sliding it drops to the kinetic
    one, so that the contact leaves rest with an acceleration.

        R = N eta_c sgn(v),   |R| <= N eta_s at v = 0                                      Coulomb 1785

    Limits: no Stribeck droop, no memory and no presliding. The drop at once is the limit of a droop over a speed that
    goes to zero.
    """

    coulomb_coefficient: NonNegative = parameter(0.15, "eta_c", "friction coefficient of sliding", "level")

    name: ClassVar[str] = "coulomb"
    source: ClassVar[str] = "coulomb1785"

    def steady_force(self, speed, load):
        return load * self.coulomb_coefficient
