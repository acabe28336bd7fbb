"""Anisotropic contact: any law with a level of its own for each direction of sliding."""

import functools
from typing import Any, ClassVar

from vibrocap.physics.friction.law import Law, Positive, parameter
from vibrocap.physics.parameters import inner_part, wrapped_class


@functools.cache
def anisotropic(law: type[Law]) -> Any:
    """The class of a law whose load is scaled by the direction of sliding: its fields and a ratio for each direction.

    Scales, bristles set at an angle, a skate with a stop: one way is smoother than the other. All levels of the law are
    scaled alike, by its load; its stiffness and its viscous part are not:

        R = R_law(v, z; k N),    k = k_fwd where sgn(v) = 1,  k_back where sgn(v) = -1

    A set-valued law holds any force from -k_back N eta_s to k_fwd N eta_s. A dynamic law turns with the internal states
    that it has: R is as continuous at a reversal as before, and the law as passive, for its states may exceed the level
    of one direction only while they act against the motion.

    law: a set-valued or kinked law that is not anisotropic yet
    Returns the class, the same one each time: `anisotropic(LuGre)(forward_ratio=1.0, back_ratio=1.3)`.
    Raises ValueError for a smooth law: it knows no direction, and scaled by one it would not be smooth.
    """
    if anisotropic in law.wrappers:
        raise ValueError(f"the {law.name} law is anisotropic already")
    if law.kind == "smooth":
        reason = f"got the {law.name} law, which is smooth"
        raise ValueError(f"only a set-valued or kinked law can be made anisotropic, {reason}")

    class Anisotropic(law):
        forward_ratio: Positive = parameter(
            1.0, "k_fwd", "load that counts in sliding forward, over the load", "convention"
        )
        back_ratio: Positive = parameter(1.5, "k_back", "load that counts in sliding back, over the load", "back ratio")

        special_cases: ClassVar = {law.name: {"forward_ratio": 1.0, "back_ratio": 1.0}}
        source: ClassVar[str] = f"{law.source}; zimmermann2009"

        def _ratio(self, side):
            """k of a side; their mean at rest (side 0)."""
            middle, half = 0.5 * (self.forward_ratio + self.back_ratio), 0.5 * (self.forward_ratio - self.back_ratio)
            return middle + side * half

        def steady_force(self, speed, load, side=1):
            return inner_part(law, self).steady_force(speed, self._ratio(side) * load)

        def force(self, velocity, internal, side, load):
            return inner_part(law, self).force(velocity, internal, side, self._ratio(side) * load)

        def losses(self, velocity, internal, side, load):
            return inner_part(law, self).losses(velocity, internal, side, self._ratio(side) * load)

        def switches(self, velocity, internal, side, load):
            return inner_part(law, self).switches(velocity, internal, side, self._ratio(side) * load)

        def after_switch(self, which, velocity, internal, side, load):
            return inner_part(law, self).after_switch(which, velocity, internal, side, self._ratio(side) * load)

        def after_reversal(self, internal, side, load):
            return inner_part(law, self).after_reversal(internal, side, self._ratio(side) * load)

        def internal_scales(self, load):
            """Those of the law, with the mean of both loads."""
            return inner_part(law, self).internal_scales(self._ratio(0.0) * load)

        def _held(self, load):
            """Largest forces that the contact can hold, forward and back."""
            inner = inner_part(law, self)
            return inner.holding_limit(self.forward_ratio * load), inner.holding_limit(self.back_ratio * load)

        def holding_limit(self, load):
            forward, back = self._held(load)
            return 0.5 * (forward + back)

        def holding_centre(self, load):
            if law.kind != "set-valued":
                return 0.0
            forward, back = self._held(load)
            return 0.5 * (forward - back)

        @property
        def symmetric(self) -> bool:
            return super().symmetric and self.forward_ratio == self.back_ratio

    return wrapped_class(anisotropic, Anisotropic, law)
