"""Bristles, which carry the load until they slip: LuGre, and an elasto-plastic law, in which they slip as they load."""

import math
from typing import ClassVar

from vibrocap.physics.elementary import bristle_slip, exp, sin
from vibrocap.physics.friction.law import (
    STRIBECK_EXPONENT,
    STRIBECK_VELOCITY,
    Exponent,
    Law,
    NonNegative,
    Positive,
    Share,
    levels_in_order,
    parameter,
    parameters,
    stribeck_level,
)

CELLS = 4096  # of speed, in which the bound for passivity is made
DAMPED_SPEEDS = 6.0  # damping velocities, beyond which the damping of the bristles is below 1e-15 of that at rest
MARGIN = 1e-6  # of the static level, by which the force passes a border before the piece changes


@parameters
class Bristles(Law):
    """A law of bristles of mean deflection xi, the first internal state: R = delta0 xi + delta1 xi' + delta2 v.

    They store the energy delta0 xi^2/2. Of R v less its rate, sliding takes (delta0 xi + delta1 xi') (v - xi') +
    delta2 v^2 and their deformation delta1 xi'^2. The steady force is the Stribeck level and delta2 v.
    """

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the bristles", "stiffness")
    bristle_damping: NonNegative = parameter(10.0, "delta1", "damping of the bristles", "bristle damping")
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: Positive = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = STRIBECK_VELOCITY
    stribeck_exponent: Exponent = STRIBECK_EXPONENT

    kind: ClassVar = "kinked"
    shape_parameters: ClassVar = ("stribeck_exponent",)

    _levels = levels_in_order

    def _damping(self, velocity):
        return self.bristle_damping

    def _slip_rate(self, velocity, internal, side, load):
        """v - xi': the part of the velocity at which bristles slip."""
        raise NotImplementedError

    def steady_force(self, speed, load):
        return stribeck_level(self, speed, load) + self.viscous_damping * speed

    def force(self, velocity, internal, side, load):
        rate = velocity - self._slip_rate(velocity, internal, side, load)
        elastic = self.bristle_stiffness * internal[0] + self._damping(velocity) * rate
        return elastic + self.viscous_damping * velocity, (rate, *(0.0 for _ in self.switched))

    def internal_scales(self, load):
        """The largest deflection, g(0); 1 of a piece."""
        return (load * self.static_coefficient / self.bristle_stiffness, *(1.0 for _ in self.switched))

    def losses(self, velocity, internal, side, load):
        slip, damping = self._slip_rate(velocity, internal, side, load), self._damping(velocity)
        rate = velocity - slip
        elastic = self.bristle_stiffness * internal[0] + damping * rate
        return elastic * slip + self.viscous_damping * velocity * velocity, damping * rate * rate

    def stored_energy(self, internal):
        return 0.5 * self.bristle_stiffness * internal[0] * internal[0]


@parameters
class LuGre(Bristles):
    """LuGre law (LM): elastic bristles of mean deflection xi carry the load until they slip.

    The force lags the velocity (hysteresis) and yields elastically below breakaway (presliding).

        R   = delta0 xi + delta1 xi' + delta2 v                                            Liu et al. 2019, eq. 6
        xi' = v - |v| xi / g(v)                                                            eq. 7
        g   = (N/delta0) [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)]                     eq. 10

    |xi| <= g(0) = N eta_s/delta0 is invariant. The relaxation rate |v|/g(v) makes the law stiff for a large delta0.
    The law creeps: under an oscillating force below breakaway it drifts (Dupont et al. 2002).

    With a damping velocity v_d the bristles' damping fades as the contact speeds up, which makes the law passive with
    less viscous friction (Olsson 1996; Canudas de Wit et al. 1995):

        delta1(v) = delta1 exp(-(v/v_d)^2)
    """

    damping_velocity: Positive | None = parameter(
        None, "v_d", "speed over which the damping of the bristles fades; none: it stays", "fading velocity"
    )

    name: ClassVar[str] = "lugre"
    internal: ClassVar = ("bristle",)
    source: ClassVar[str] = "canudas1995; olsson1996"
    creeps: ClassVar[bool] = True
    special_cases: ClassVar = {
        "dahl": {"bristle_damping": 0.0, "viscous_damping": 0.0, "static_coefficient": "coulomb_coefficient"}
    }

    def _damping(self, velocity):
        if self.damping_velocity is None:
            return self.bristle_damping
        share = velocity / self.damping_velocity
        return self.bristle_damping * exp(-(share * share))

    def _slip_rate(self, velocity, internal, side, load):
        level = stribeck_level(self, side * velocity, load)
        return bristle_slip(side * velocity, internal[0], self.bristle_stiffness, level)

    @property
    def passive(self) -> bool:
        """delta2 >= delta1(v) (eta_s/l(v) - 1) at all speeds, l(v) the level between eta_s and eta_c.

        With u = xi sgn(v)/g(v), which lies within +-g(0)/g(v), and the stored energy delta0 xi^2/2,

            R v - d(stored)/dt = delta0 |v| g u^2 + v^2 [delta2 - delta1(v) (u - 1)],

        so the condition is sufficient for any load and any delta0. For a constant delta1 it reads
        delta2 >= delta1 (eta_s - eta_c)/eta_c, which is necessary as well (Barahanov and Ortega, IEEE Transactions on
        Automatic Control 45 (2000) 830-832); the paper's values are outside. A damping that fades is bounded within
        each of many cells of speed by its value at one end and eta_s/l(v) - 1 at the other: true only where proven.
        """
        drop = self.static_coefficient - self.coulomb_coefficient
        if self.damping_velocity is None:
            return self.viscous_damping >= self.bristle_damping * drop / self.coulomb_coefficient
        speeds = [DAMPED_SPEEDS * self.damping_velocity * i / CELLS for i in range(CELLS + 1)]
        excess = [self.static_coefficient / stribeck_level(self, speed, 1.0) - 1.0 for speed in speeds[1:]]
        excess.append(drop / self.coulomb_coefficient)
        pairs = zip(speeds, excess, strict=True)
        return all(self._damping(speed) * most <= self.viscous_damping for speed, most in pairs)


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
