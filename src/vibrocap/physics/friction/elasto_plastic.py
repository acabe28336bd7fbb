import math
from typing import ClassVar

from vibrocap.physics.elementary import sin
from vibrocap.physics.friction.law import Bristles, Share, stribeck_level
from vibrocap.physics.parameters import parameter, parameters

MARGIN = 1e-6  # of the static level, by which the force passes a border before the piece changes


@parameters
class ElastoPlastic(Bristles):
    """Elasto-plastic law: below a breakaway deflection the contact is elastic and no displacement is lost.

    LuGre's bristles slip a little under any force, so that an oscillating force below breakaway makes them drift. Here
    they slip in loading only, in part beyond z_ba and wholly from the steady deflection g(v) on: by p, their alpha.

        R   = delta0 xi + delta1 xi' + delta2 v                                            Dupont et al. 2002
        xi' = v [1 - p(xi, v) sgn(v) xi/g(v)]
        g   = (N/delta0) [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)]

        p = 0                                                              where |xi| <= z_ba or xi v < 0
          = {1 + sin[pi (|xi| - (g + z_ba)/2)/(g - z_ba)]}/2               where z_ba < |xi| < g(v)
          = 1                                                              where |xi| >= g(v)

    z_ba is a share of the deflection of the Coulomb level, N eta_c/delta0, so that z_ba < g at every speed. The cases
    are pieces, kept in the switched states `yielding` (|xi| > z_ba in loading) and `flowing` (|xi| > g as well); each
    lasts 1e-6 beyond its border, which changes xi by some 1e-17 of it. |xi| <= g(0) = N eta_s/delta0 is invariant. Like
    LuGre's law it is stiff for a large delta0 |v|.
    """

    elastic_share: Share = parameter(
        0.7, "z_ba", "elastic range, as a share of the deflection of Coulomb level", "fraction"
    )

    name: ClassVar[str] = "elasto-plastic"
    internal: ClassVar = ("bristle", "yielding", "flowing")
    switched: ClassVar = ("yielding", "flowing")
    internal_symmetry: ClassVar = (-1, 1, 1)
    source: ClassVar[str] = "dupont2002"

    def _elastic(self, load):
        """delta0 z_ba, a force."""
        return self.elastic_share * load * self.coulomb_coefficient

    def _slip_rate(self, velocity, internal, side, load):
        """p |v| xi/g(v)."""
        bristle, yielding, flowing = internal
        elastic, level = self._elastic(load), stribeck_level(self, side * velocity, load)
        force = self.bristle_stiffness * bristle
        ramp = 0.5 + 0.5 * sin(math.pi * (side * force - 0.5 * (level + elastic)) / (level - elastic))
        share = yielding * (ramp + flowing * (1.0 - ramp))
        return share * (side * velocity) * force / level

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

    @property
    def passive(self) -> bool:
        """delta2 >= delta1 (eta_s - eta_c)/eta_c, sufficient as for LuGre's law.

        With u = p xi sgn(v)/g(v) in place of LuGre's u, which is no larger and not negative,
        R v - d(stored)/dt = delta0 v xi u + v^2 [delta2 + delta1 (1 - u)].
        """
        drop = self.static_coefficient - self.coulomb_coefficient
        return self.viscous_damping >= self.bristle_damping * drop / self.coulomb_coefficient
