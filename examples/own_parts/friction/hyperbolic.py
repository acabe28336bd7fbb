"""The hyperbolic law: static friction with a droop like 1/(1 + |v|/v_s), set-valued at rest."""

from typing import ClassVar

from vibrocap.physics.friction.law import Law, NonNegative, Positive, levels_in_order, parameter, parameters


@parameters
class Hyperbolic(Law):
    """Hyperbolic law: the friction force drops from static to Coulomb level like 1/(1 + |v|/v_s).

    The tail is long: at ten times v_s a tenth of the drop remains, where the exponential law has nothing left.

        R = N [eta_c + (eta_s - eta_c)/(1 + |v|/v_s)] sgn(v),   |R| <= N eta_s at v = 0      after Leine et al. 1998
    """

    coulomb_coefficient: NonNegative = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: NonNegative = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = parameter(0.1, "v_s", "speed at half of the drop", "Stribeck velocity")

    name: ClassVar[str] = "hyperbolic"
    source: ClassVar[str] = "leine1998"
    kind: ClassVar = "set-valued"

    _levels = levels_in_order

    def steady_force(self, speed, load):
        """Friction force at a constant speed >= 0."""
        drop = self.static_coefficient - self.coulomb_coefficient
        return load * (self.coulomb_coefficient + drop / (1.0 + speed / self.stribeck_velocity))

    def force(self, velocity, internal, side, load):
        """Friction force R while sliding to `side`; there are no internal states.

        velocity: sliding velocity [1]   side: +1 or -1   load: normal load N [1]      Returns (R, ()).
        """
        return side * self.steady_force(side * velocity, load), ()

    def holding_limit(self, load):
        """Largest force at rest, N eta_s: the limit of `steady_force` as the speed vanishes."""
        return load * self.static_coefficient

    @property
    def passive(self) -> bool:
        """Always true: R v >= 0."""
        return True
