from typing import ClassVar

from vibrocap.physics.elementary import bristle_slip, exp
from vibrocap.physics.friction.law import Bristles, stribeck_level
from vibrocap.physics.parameters import Positive, parameter, parameters

CELLS = 4096  # of speed, in which the bound for passivity is made
DAMPED_SPEEDS = 6.0  # damping velocities, beyond which the damping of the bristles is below 1e-15 of that at rest


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
