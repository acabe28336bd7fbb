"""Curves over the speed, without memory: Coulomb, exponential and Stribeck, and a Stribeck curve smoothed at rest."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import atan, exp, tanh
from vibrocap.physics.friction.law import (
    STRIBECK_EXPONENT,
    STRIBECK_VELOCITY,
    Exponent,
    Law,
    NonNegative,
    Positive,
    TwoLevels,
    levels_in_order,
    parameter,
    parameters,
    stribeck_level,
)


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


@parameters
class SmoothedStribeck(Law):
    """Stribeck curve with a smooth S in place of sgn(v): what is often solved instead of a set-valued law.

    The jump at rest becomes a steep rise over the smoothing velocity epsilon. For comparison only: the contact cannot
    stick, it creeps under any force, and what a motion gets wrong is known only from runs at several widths.

        R = N [eta_c + (eta_s - eta_c) exp(-(v S/v_s)^alpha)] S + delta2 v

    v S stands for |v|, so that the law is smooth at rest. As epsilon goes to zero it becomes the Stribeck law, the
    exponential law (alpha = 1, a = 1/v_s) or Coulomb's (equal levels); its slope at rest makes it stiff.
    """

    coulomb_coefficient: NonNegative = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: NonNegative = parameter(
        0.45, "eta_s", "friction coefficient at rest, were it not smoothed", "static level"
    )
    stribeck_velocity: Positive = STRIBECK_VELOCITY
    stribeck_exponent: Exponent = STRIBECK_EXPONENT
    smoothing_velocity: Positive = parameter(
        1e-3, "epsilon", "speed over which friction changes its sign", "smoothing velocity"
    )
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")

    kind: ClassVar = "smooth"
    shape_parameters: ClassVar = ("stribeck_exponent",)
    creeps: ClassVar[bool] = True

    _levels = levels_in_order

    def _sign(self, velocity):
        raise NotImplementedError

    def steady_force(self, speed, load):
        return self.force(speed, (), 1, load)[0]

    def force(self, velocity, internal, side, load):
        sign = self._sign(velocity)
        return sign * stribeck_level(self, velocity * sign, load) + self.viscous_damping * velocity, ()

    @property
    def passive(self) -> bool:
        """Always: R v >= 0."""
        return True


@parameters
class SmoothedTanh(SmoothedStribeck):
    """Stribeck curve with tanh(v/epsilon) in place of sgn(v) (cf. Andersson et al. 2007), see `SmoothedStribeck`.

        R = N [eta_c + (eta_s - eta_c) exp(-(v S/v_s)^alpha)] S + delta2 v,     S = tanh(v/epsilon)

    v S differs from |v| by less than 0.28 epsilon; the slope at rest is N eta_s/epsilon.
    """

    name: ClassVar[str] = "smoothed-tanh"
    source: ClassVar[str] = "andersson2007"

    def _sign(self, velocity):
        return tanh(velocity / self.smoothing_velocity)


@parameters
class SmoothedArctan(SmoothedStribeck):
    """Stribeck curve with an arc tangent in place of sgn(v) (cf. Leine et al. 1998), see `SmoothedStribeck`.

        R = N [eta_c + (eta_s - eta_c) exp(-(v S/v_s)^alpha)] S + delta2 v,     S = (2/pi) atan(v/epsilon)

    v S differs from |v| by less than (2/pi) epsilon; the slope at rest is (2/pi) N eta_s/epsilon. S comes to its end
    slowly, to 1 - (2/pi) epsilon/|v|: at equal epsilon the error is far greater than with tanh.
    """

    name: ClassVar[str] = "smoothed-arctan"
    source: ClassVar[str] = "leine1998"

    def _sign(self, velocity):
        return (2.0 / math.pi) * atan(velocity / self.smoothing_velocity)
