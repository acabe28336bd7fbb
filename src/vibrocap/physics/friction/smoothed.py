"""Any set-valued law with its jump at rest smoothed: for comparison with the contact that sticks."""

import functools
from typing import ClassVar, Literal

from vibrocap.physics.elementary import atan, tanh
from vibrocap.physics.friction.law import Law, Positive, parameter
from vibrocap.physics.parameters import inner_part, wrapped_class

HALF_TURN = 3.141592653589793


@functools.cache
def smoothed(law: type[Law]) -> type[Law]:
    """The class of a set-valued law smoothed at rest: its fields, and the width and shape of the smoothing.

    The jump of the friction force becomes a steep rise, so that the contact cannot stick but creeps:

        R = S(|v|/epsilon) R_law(v),    S(x) = tanh(x)  or  (2/pi) arctan(x)

    with the law's own steady curve, viscous part included. As epsilon goes to zero it becomes the law; its slope at
    rest, N eta_s/epsilon over the mass (2/pi times that for arctan), is the rate that makes the equations stiff.
    Raises ValueError for a law that is not set-valued.
    """
    if law.kind != "set-valued":
        raise ValueError(f"only a set-valued law can be smoothed, got the {law.name} law, which is {law.kind}")

    class Smoothed(law):
        smoothing_velocity: Positive = parameter(
            1e-3, "epsilon", "speed over which friction changes its sign", "smoothing velocity"
        )
        shape: Literal["tanh", "arctan"] = parameter("tanh", "S", "function that takes the place of sgn")

        kind: ClassVar = "kinked"  # |v| in the steady curve
        special_cases: ClassVar = {}
        source: ClassVar[str] = f"{law.source}; andersson2007; leine1998"
        creeps: ClassVar[bool] = True

        def _smoothed_sign(self, speed):
            """S, the share of the friction force that is left at a speed."""
            if self.shape == "tanh":
                return tanh(speed / self.smoothing_velocity)
            return (2.0 / HALF_TURN) * atan(speed / self.smoothing_velocity)

        def steady_force(self, speed, load, *side):
            return self._smoothed_sign(speed) * inner_part(law, self).steady_force(speed, load, *side)

        def force(self, velocity, internal, side, load):
            force, _ = inner_part(law, self).force(velocity, internal, side, load)
            return self._smoothed_sign(side * velocity) * force, ()

        def losses(self, velocity, internal, side, load):
            """All that the contact takes is lost by sliding."""
            return Law.losses(self, velocity, internal, side, load)

        def holding_limit(self, load):
            """None: the contact does not stick."""
            return Law.holding_limit(self, load)

        def holding_centre(self, load):
            return 0.0

    return wrapped_class(smoothed, Smoothed, law)
