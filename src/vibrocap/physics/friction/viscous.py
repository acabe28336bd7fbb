"""Viscous friction beside any law: a part that grows with the speed, and one with its square."""

import functools
from typing import Any, ClassVar

from vibrocap.physics.friction.law import Law, NonNegative, parameter
from vibrocap.physics.parameters import inner_part, wrapped_class


@functools.cache
def viscous(law: type[Law]) -> Any:
    """The class of a law with viscous friction beside it: its fields, and a coefficient for speed and speed squared.

    The film between the bodies, a seal, a fluid that is pushed aside: beside the dry friction of the law,

        R = R_law(v, z) + c_1 v + c_2 |v| v

    (Armstrong-Helouvry, Dupont and Canudas de Wit 1994 for c_1; the square is that of a turbulent flow). It vanishes at
    rest; its loss is one of sliding. It does not depend on the load, but grows with one that follows the motion, as all
    does that a law says there.

    law: a set-valued or kinked law that is not viscous yet
    Returns the class, the same one each time: `viscous(Coulomb)(linear_viscosity=1.0, quadratic_viscosity=0.1)`.
    Raises ValueError for a smooth law, whose |v| would have a kink, and for one with backlash: put the backlash around.
    """
    if viscous in law.wrappers:
        raise ValueError(f"the {law.name} law is viscous already")
    if "engaged" in law.internal:
        raise ValueError(f"put the backlash around, not into it: backlash(viscous(...)), got the {law.name} law")
    if law.kind == "smooth":
        raise ValueError(f"only a set-valued or kinked law can be viscous, got the {law.name} law, which is smooth")

    class Viscous(law):
        linear_viscosity: NonNegative = parameter(
            0.0, "c_1", "friction beside the law, over the speed", "viscous damping"
        )
        quadratic_viscosity: NonNegative = parameter(
            0.0, "c_2", "friction beside the law, over the square of the speed", "quadratic damping"
        )

        special_cases: ClassVar = {law.name: {"linear_viscosity": 0.0, "quadratic_viscosity": 0.0}}
        source: ClassVar[str] = f"{law.source}; armstrong1994"

        def _viscous(self, speed):
            """c_1 + c_2 |v|, over which the velocity is multiplied."""
            return self.linear_viscosity + self.quadratic_viscosity * speed

        def steady_force(self, speed, load, *side):
            return inner_part(law, self).steady_force(speed, load, *side) + self._viscous(speed) * speed

        def force(self, velocity, internal, side, load):
            force, rates = inner_part(law, self).force(velocity, internal, side, load)
            return force + self._viscous(side * velocity) * velocity, rates

        def losses(self, velocity, internal, side, load):
            """Losses of the law; that of the viscous part is one of sliding."""
            sliding, bristles = inner_part(law, self).losses(velocity, internal, side, load)
            return sliding + self._viscous(side * velocity) * velocity * velocity, bristles

    return wrapped_class(viscous, Viscous, law)
