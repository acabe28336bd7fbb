"""A Stribeck curve smoothed at rest, by tanh or by the arc tangent: for comparison with the set-valued laws only."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import atan, tanh
from vibrocap.physics.friction.law import (
    STRIBECK_EXPONENT,
    STRIBECK_VELOCITY,
    Exponent,
    Law,
    levels_in_order,
    stribeck_level,
)
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters


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
