"""The elasto-plastic law: LuGre's bristles with a range in which they only bend, so that the contact does not creep."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import sin
from vibrocap.physics.friction.law import Exponent, Law, Share, levels_in_order, stribeck_level
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters

MARGIN = 1e-6  # of the static level, by which the force passes a border before the piece changes


@parameters
class ElastoPlastic(Law):
    """Elasto-plastic law: below a breakaway deflection the contact is elastic and no displacement is lost.

    LuGre's bristles slip a little under any force, so that an oscillating force below breakaway makes them drift. Here
    they slip in loading only, in part beyond z_ba and wholly from the steady deflection g(v) on: by p, their alpha.

        R   = delta0 xi + delta1 xi' + delta2 v                                            Dupont et al. 2002
        xi' = v [1 - p(xi, v) sgn(v) xi/g(v)]
        g   = (N/delta0) [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)]

        p = 0                                                              where |xi| <= z_ba or xi v < 0
          = {1 + sin[pi (|xi| - (g + z_ba)/2)/(g - z_ba)]}/2               where z_ba < |xi| < g(v)
          = 1                                                              where |xi| >= g(v)

    z_ba is a share of the deflection of the Coulomb level, N eta_c/delta0, so that z_ba < g at every speed. The three
    cases are pieces, kept in the switched states `yielding` (|xi| > z_ba in loading) and `flowing` (|xi| > g as well).
    p has no kink between them; a piece lasts 1e-6 beyond its border, which changes xi by some 1e-17 of it.

    |xi| <= g(0) = N eta_s/delta0 is invariant. Like LuGre's law it is stiff for a large delta0 |v|.
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the bristles", "stiffness")
    bristle_damping: NonNegative = parameter(10.0, "delta1", "damping of the bristles", "bristle damping")
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: Positive = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = parameter(
        0.1, "v_s", "speed over which friction drops from static to Coulomb level", "Stribeck velocity"
    )
    stribeck_exponent: Exponent = parameter(2.0, "alpha", "shape of the drop (2: Gaussian)", "exponent")
    elastic_share: Share = parameter(
        0.7, "z_ba", "elastic range, as a share of the deflection of Coulomb level", "fraction"
    )

    name: ClassVar[str] = "elasto-plastic"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle", "yielding", "flowing")
    switched: ClassVar = ("yielding", "flowing")
    internal_symmetry: ClassVar = (-1, 1, 1)
    shape_parameters: ClassVar = ("stribeck_exponent",)
    source: ClassVar[str] = "dupont2002"

    _levels = levels_in_order

    def steady_force(self, speed, load):
        return stribeck_level(self, speed, load) + self.viscous_damping * speed

    def _elastic(self, load):
        """delta0 z_ba, a force."""
        return self.elastic_share * load * self.coulomb_coefficient

    def _slip_rate(self, velocity, internal, side, load):
        """v - xi': the part of the velocity at which bristles slip, p |v| xi/g(v)."""
        bristle, yielding, flowing = internal
        elastic, level = self._elastic(load), stribeck_level(self, side * velocity, load)
        force = self.bristle_stiffness * bristle
        ramp = 0.5 + 0.5 * sin(math.pi * (side * force - 0.5 * (level + elastic)) / (level - elastic))
        share = yielding * (ramp + flowing * (1.0 - ramp))
        return share * (side * velocity) * force / level

    def force(self, velocity, internal, side, load):
        rate = velocity - self._slip_rate(velocity, internal, side, load)
        elastic = self.bristle_stiffness * internal[0] + self.bristle_damping * rate
        return elastic + self.viscous_damping * velocity, (rate, 0.0, 0.0)

    def switches(self, velocity, internal, side, load):
        """The deflection in loading passes z_ba; it passes g(v)."""
        bristle, yielding, flowing = internal
        force = side * self.bristle_stiffness * bristle
        elastic, level = self._elastic(load), stribeck_level(self, side * velocity, load)
        unit = 1.0 / (load * self.static_coefficient)
        return (
            MARGIN + (1.0 - 2.0 * yielding) * (elastic - force) * unit,
            MARGIN + (1.0 - 2.0 * flowing) * (level - force) * unit,
        )

    def after_switch(self, which, velocity, internal, side, load):
        """The other value of the piece whose border was passed."""
        bristle, yielding, flowing = internal
        if which == 0:
            return bristle, 1.0 - yielding, flowing
        return bristle, yielding, 1.0 - flowing

    def after_reversal(self, internal, side, load):
        """Unloading: elastic."""
        return internal[0], 0.0, 0.0

    def internal_scales(self, load):
        return load * self.static_coefficient / self.bristle_stiffness, 1.0, 1.0

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy delta0 xi^2/2, split at the bristles as in LuGre's law.

        contact sliding: (delta0 xi + delta1 xi') (v - xi') + delta2 v^2      bristle loss: delta1 xi'^2
        """
        slip = self._slip_rate(velocity, internal, side, load)
        rate = velocity - slip
        elastic = self.bristle_stiffness * internal[0] + self.bristle_damping * rate
        return elastic * slip + self.viscous_damping * velocity * velocity, self.bristle_damping * rate * rate

    def stored_energy(self, internal):
        return 0.5 * self.bristle_stiffness * internal[0] * internal[0]

    @property
    def passive(self) -> bool:
        """delta2 >= delta1 (eta_s - eta_c)/eta_c, sufficient as for LuGre's law.

        With u = p xi sgn(v)/g(v) in place of LuGre's u, which is no larger and not negative,
        R v - d(stored)/dt = delta0 v xi u + v^2 [delta2 + delta1 (1 - u)].
        """
        drop = self.static_coefficient - self.coulomb_coefficient
        return self.viscous_damping >= self.bristle_damping * drop / self.coulomb_coefficient
