from typing import ClassVar

from vibrocap.physics.elementary import exp, log, power
from vibrocap.physics.friction.law import AtLeastOne, Law, Positive, parameter, parameters

ROUNDING = 1e-10  # of 1 - r, within which |1 - r|^(i-1) is rounded off


@parameters
class Dahl(Law):
    """Dahl's law: the force follows the displacement like the stress of a metal follows its strain.

    Near reversal the contact is a spring; it yields gradually towards the Coulomb level, at any speed.

        R  = delta0 xi,   dR/dx = delta0 |1 - r|^i sgn(1 - r),   r = R sgn(v)/(N eta_c)    Dahl 1968, 1976
        xi' = v |1 - r|^(i-1) (1 - r);   for i = 1   xi' = v - delta0 |v| xi/(N eta_c)

    The exponent i is 1 or somewhat more for ductile materials (below 1, for brittle ones, the level would be reached at
    a corner, which is not offered). |xi| <= N eta_c/delta0 is invariant.

    Limits: no static level, no Stribeck droop and no lag. The law creeps: loading is softer than unloading, so an
    oscillating force below the level ratchets. |1 - r|^(i-1) is rounded off within 1e-10 of r = 1 where i is not an odd
    whole number.
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the contact at reversal", "stiffness")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient of sliding", "level")
    shape_exponent: AtLeastOne = parameter(1.0, "i", "shape of the approach to Coulomb level", "exponent")

    name: ClassVar[str] = "dahl"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle",)
    shape_parameters: ClassVar = ("shape_exponent",)
    source: ClassVar[str] = "dahl1968; dahl1976"
    creeps: ClassVar[bool] = True

    def steady_force(self, speed, load):
        return load * self.coulomb_coefficient

    def _yielding(self, rest):
        """|rest|^(i-1), for any sign of rest = 1 - r."""
        exponent = self.shape_exponent
        if isinstance(exponent, (int, float)) and exponent == 1.0:
            return 1.0
        if isinstance(exponent, (int, float)) and exponent in (3, 5, 7):
            return power(rest, exponent - 1.0)
        return exp(0.5 * (exponent - 1.0) * log(rest * rest + ROUNDING**2))  # rest may have either sign

    def force(self, velocity, internal, side, load):
        (bristle,) = internal
        force = self.bristle_stiffness * bristle
        rest = 1.0 - side * force / (load * self.coulomb_coefficient)
        return force, (velocity * (rest * self._yielding(rest)),)

    def internal_scales(self, load):
        return (load * self.coulomb_coefficient / self.bristle_stiffness,)

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy, R (v - xi'): all of it is lost by sliding."""
        force, (rate,) = self.force(velocity, internal, side, load)
        return force * (velocity - rate), 0.0

    def stored_energy(self, internal):
        (bristle,) = internal
        return 0.5 * self.bristle_stiffness * bristle * bristle

    @property
    def passive(self) -> bool:
        """Always: R (v - xi') = N eta_c |v| r (1 - |1 - r|^(i-1) (1 - r)), of which both factors have the sign of r."""
        return True
