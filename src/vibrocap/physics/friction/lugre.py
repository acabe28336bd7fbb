"""The LuGre law (LM): bristles that deflect, so that friction remembers."""

from typing import ClassVar

from vibrocap.physics.elementary import bristle_slip, exp
from vibrocap.physics.friction.law import Exponent, Law, levels_in_order, stribeck_level
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters

CELLS = 4096  # of speed, in which the bound for passivity is made
DAMPED_SPEEDS = 6.0  # damping velocities, beyond which the damping of the bristles is below 1e-15 of that at rest


@parameters
class LuGre(Law):
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

    bristle_stiffness: Positive = parameter(100.0, "delta0", "stiffness of the bristles", "stiffness")
    bristle_damping: NonNegative = parameter(10.0, "delta1", "damping of the bristles", "bristle damping")
    viscous_damping: NonNegative = parameter(0.0, "delta2", "viscous friction coefficient", "viscous damping")
    coulomb_coefficient: Positive = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: Positive = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = parameter(
        0.1, "v_s", "speed over which friction drops from static to Coulomb level", "Stribeck velocity"
    )
    stribeck_exponent: Exponent = parameter(2.0, "alpha", "shape of the drop (2: Gaussian)", "exponent")
    damping_velocity: Positive | None = parameter(
        None, "v_d", "speed over which the damping of the bristles fades; none: it stays", "fading velocity"
    )

    name: ClassVar[str] = "lugre"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("bristle",)
    shape_parameters: ClassVar = ("stribeck_exponent",)
    source: ClassVar[str] = "canudas1995; olsson1996"
    creeps: ClassVar[bool] = True
    special_cases: ClassVar = {
        "dahl": {"bristle_damping": 0.0, "viscous_damping": 0.0, "static_coefficient": "coulomb_coefficient"}
    }

    _levels = levels_in_order

    def _steady_level(self, speed, load):
        """delta0 g(v) (eq. 10), a force."""
        return stribeck_level(self, speed, load)

    def _damping(self, velocity):
        """delta1(v)."""
        if self.damping_velocity is None:
            return self.bristle_damping
        share = velocity / self.damping_velocity
        return self.bristle_damping * exp(-(share * share))

    def steady_force(self, speed, load):
        return self._steady_level(speed, load) + self.viscous_damping * speed

    def force(self, velocity, internal, side, load):
        (bristle,) = internal
        slip = self._slip_rate(velocity, bristle, side, load)
        rate = velocity - slip
        force = self.bristle_stiffness * bristle + self._damping(velocity) * rate + self.viscous_damping * velocity
        return force, (rate,)

    def _slip_rate(self, velocity, bristle, side, load):
        """v - xi': the part of the velocity at which bristles slip, |v| xi / g(v)."""
        level = self._steady_level(side * velocity, load)
        return bristle_slip(side * velocity, bristle, self.bristle_stiffness, level)

    def internal_scales(self, load):
        """g(0), the largest deflection."""
        return (load * self.static_coefficient / self.bristle_stiffness,)

    def losses(self, velocity, internal, side, load):
        """R v less the rate of the stored energy delta0 xi^2/2, split at the bristles.

        contact sliding: (delta0 xi + delta1 xi') (v - xi') + delta2 v^2      bristle loss: delta1 xi'^2

        with delta1(v) for delta1 where it fades.
        """
        (bristle,) = internal
        slip = self._slip_rate(velocity, bristle, side, load)
        rate = velocity - slip
        damping = self._damping(velocity)
        elastic = self.bristle_stiffness * bristle + damping * rate
        return elastic * slip + self.viscous_damping * velocity * velocity, damping * rate * rate

    def stored_energy(self, internal):
        (bristle,) = internal
        return 0.5 * self.bristle_stiffness * bristle * bristle

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
