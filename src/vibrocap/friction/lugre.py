"""The LuGre law (LM): bristles that deflect, so that friction remembers."""

from typing import ClassVar

from vibrocap.friction.law import Law, NonNegative, Positive, exp, levels_in_order, parameter, parameters, power


@parameters
class LuGre(Law):
    """LuGre law (LM): elastic bristles of mean deflection xi carry the load until they slip.

    The force lags the velocity (hysteresis) and yields elastically below breakaway (presliding).

        R   = delta0 xi + delta1 xi' + delta2 v                                            Liu et al. 2019, eq. 6
        xi' = v - |v| xi / g(v)                                                            eq. 7
        g   = (N/delta0) [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)]                     eq. 10

    |xi| <= g(0) = N eta_s/delta0 is invariant. The relaxation rate |v|/g(v) makes the law stiff for a large delta0.
    An exponent that is not a whole number is rounded off within 1e-10 of rest (`vibrocap.elementary.power`).
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the bristles")
    bristle_damping: NonNegative = parameter(10.0, "delta1", "damping of the bristles")
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient at high speed")
    static_coefficient: Positive = parameter(0.45, "eta_s", "friction coefficient at rest")
    stribeck_velocity: Positive = parameter(0.1, "v_s", "speed over which friction drops from static to Coulomb level")
    stribeck_exponent: Positive = parameter(2.0, "alpha", "shape of the drop (2: Gaussian)")

    name: ClassVar[str] = "lugre"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle",)
    shape_parameters: ClassVar = ("stribeck_exponent",)

    _levels = levels_in_order

    def _steady_level(self, speed, load):
        """delta0 g(v) (eq. 10), a force."""
        drop = self.static_coefficient - self.coulomb_coefficient
        shape = exp(-power(speed / self.stribeck_velocity, self.stribeck_exponent))
        return load * (self.coulomb_coefficient + drop * shape)

    def steady_force(self, speed, load):
        """Friction force at a constant speed >= 0 (eq. 11)."""
        return self._steady_level(speed, load) + self.viscous_damping * speed

    def force(self, velocity, internal, side, load):
        """Friction force R and bristle rate (eqs 6, 7) while sliding to `side`.

        velocity: sliding velocity [1]   internal: (xi,) [1]   side: +1 or -1   load: N [1]      Returns (R, (xi',)).
        """
        (bristle,) = internal
        slip = self._slip_rate(velocity, bristle, side, load)
        rate = velocity - slip
        force = self.bristle_stiffness * bristle + self.bristle_damping * rate + self.viscous_damping * velocity
        return force, (rate,)

    def _slip_rate(self, velocity, bristle, side, load):
        """v - xi': the part of the velocity at which bristles slip, |v| xi / g(v)."""
        return self.bristle_stiffness * (side * velocity) * bristle / self._steady_level(side * velocity, load)

    def internal_scales(self, load):
        """g(0), the largest deflection."""
        return (load * self.static_coefficient / self.bristle_stiffness,)

    def visible_speed(self):
        """Where |v/v_s|^alpha = 25; beyond, the terms of a series for its exponential fall below rounding, and fast."""
        return self.stribeck_velocity * power(25.0, 1.0 / self.stribeck_exponent)

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy delta0 xi^2/2, split at the bristles.

        contact sliding: (delta0 xi + delta1 xi') (v - xi') + delta2 v^2      bristle loss: delta1 xi'^2
        """
        (bristle,) = internal
        slip = self._slip_rate(velocity, bristle, side, load)
        rate = velocity - slip
        elastic = self.bristle_stiffness * bristle + self.bristle_damping * rate
        return elastic * slip + self.viscous_damping * velocity * velocity, self.bristle_damping * rate * rate

    def stored_energy(self, internal):
        """Energy of the deflected bristles, delta0 xi^2 / 2."""
        (bristle,) = internal
        return 0.5 * self.bristle_stiffness * bristle * bristle

    @property
    def passive(self) -> bool:
        """delta2 >= delta1 (eta_s - eta_c)/eta_c is sufficient; the paper's values are outside."""
        drop = self.static_coefficient - self.coulomb_coefficient
        return self.viscous_damping >= self.bristle_damping * drop / self.coulomb_coefficient
