from typing import ClassVar

from vibrocap.physics.friction.law import NonNegative, Positive, TwoLevels, parameter, parameters


@parameters
class HyperbolicStribeck(TwoLevels):
    """Hyperbolic Stribeck curve: friction falls from static to Coulomb level slowly, as one over the speed.

        R = {N [eta_c + (eta_s - eta_c)/(1 + |v|/v_s)] + delta2 |v|} sgn(v),   |R| <= N eta_s at v = 0
                                                                                           Leine et al. 1998

    With eta_c = 0 it is Fs/(1 + delta |v|), delta = 1/v_s, the curve of Leine's block on a belt. It is a function of
    velocity alone: no lag, no presliding. The level eta_c is approached slowly: half of the drop is left at v_s.
    """

    stribeck_velocity: Positive = parameter(
        0.1, "v_s", "speed at which half of the drop to Coulomb level is done", "Stribeck velocity"
    )
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")

    name: ClassVar[str] = "hyperbolic-stribeck"
    source: ClassVar[str] = "leine1998"

    def steady_force(self, speed, load):
        drop = self.static_coefficient - self.coulomb_coefficient
        level = self.coulomb_coefficient + drop / (1.0 + speed / self.stribeck_velocity)
        return load * level + self.viscous_damping * speed
