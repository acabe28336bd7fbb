"""Two approximations of Leine's friction curve, R = N eta_s/(1 + |v|/v_s): rounded off by an arctangent, and bristles.

The laws of the cases leine-smoothed.toml and leine-bristled.toml: `vibrocap simulate FILE --parts leine_laws.py`.
"""

from typing import ClassVar

from vibrocap.physics.elementary import atan
from vibrocap.physics.friction.law import Law, Positive, parameter, parameters

PI = 3.141592653589793


@parameters
class LeineSmoothed(Law):
    """(2/pi) atan(v/w) in place of the sign.

    R = N eta_s (2/pi) atan(v/w) / (1 + |v|/v_s)
    """

    static_coefficient: Positive = parameter(1.0, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = parameter(1.0 / 3.0, "v_s", "speed at which half of it is left", "Stribeck velocity")
    width: Positive = parameter(1e-3, "w", "speed over which the sign is rounded off", "speed")

    name: ClassVar[str] = "leine-smoothed"
    kind: ClassVar = "kinked"

    def steady_force(self, speed, load):
        level = load * self.static_coefficient / (1 + speed / self.stribeck_velocity)
        return level * (2 / PI) * atan(speed / self.width)

    def force(self, velocity, internal, side, load):
        return side * self.steady_force(side * velocity, load), ()

    @property
    def passive(self) -> bool:
        return True


@parameters
class LeineBristled(Law):
    """LuGre's bristles on the same curve.

    R = sigma_0 z + sigma_1 z',   z' = v - |v| z/g,   g = N eta_s/(1 + |v|/v_s)/sigma_0
    """

    bristle_stiffness: Positive = parameter(100.0, "sigma_0", "stiffness of the bristles", "stiffness")
    bristle_damping: Positive = parameter(20.0, "sigma_1", "damping of the bristles", "viscous damping")
    static_coefficient: Positive = parameter(1.0, "eta_s", "friction coefficient at rest", "static level")
    stribeck_velocity: Positive = parameter(1.0 / 3.0, "v_s", "speed at which half of it is left", "Stribeck velocity")

    name: ClassVar[str] = "leine-bristled"
    kind: ClassVar = "kinked"
    internal: ClassVar[tuple[str, ...]] = ("bristle",)

    def steady_force(self, speed, load):
        return load * self.static_coefficient / (1 + speed / self.stribeck_velocity)

    def force(self, velocity, internal, side, load):
        (deflection,) = internal
        speed = side * velocity
        rate = velocity - speed * deflection * self.bristle_stiffness / self.steady_force(speed, load)
        return self.bristle_stiffness * deflection + self.bristle_damping * rate, (rate,)

    def internal_scales(self, load):
        return (load * self.static_coefficient / self.bristle_stiffness,)

    @property
    def passive(self) -> bool:
        return False
