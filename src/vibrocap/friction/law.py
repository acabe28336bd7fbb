"""The contract of a friction law.

A law is one file in this folder: a record of parameters with the scalar functions below. It then appears by itself in
case files, in the command line, in the contract tests and, compiled, in every run.

`side` is the direction of sliding, +1 or -1, constant over a smooth piece of the motion; with it |v| is
`side * velocity` and sgn(v) is `side`, so that every expression is smooth and has a Taylor series. Who changes the
side, and when, is the business of the integrator.
"""

from typing import ClassVar, Literal

from pydantic import model_validator

from vibrocap.elementary import exp, power
from vibrocap.parameters import NonNegative, Number, Positive, parameter, parameters

__all__ = ["Law", "NonNegative", "Number", "Positive", "exp", "levels_in_order", "parameter", "parameters", "power"]


class Law:
    """What every friction law offers.

    kind: "set-valued": at rest any force up to `holding_limit` (the contact sticks);
          "kinked": a force for every velocity, with a kink in it or in its rates at v = 0 (most dynamic laws);
          "smooth": neither.
    internal: names of the internal states, whose rates `force` returns.
    shape_parameters: parameters that choose the formula when they are whole numbers (an exponent, for instance).
    """

    name: ClassVar[str]
    kind: ClassVar[Literal["set-valued", "kinked", "smooth"]]
    internal: ClassVar[tuple[str, ...]] = ()
    shape_parameters: ClassVar[tuple[str, ...]] = ()

    def force(self, velocity, internal, side, load):
        """Friction force R and the rates of the internal states: (R, (z', ...))."""
        raise NotImplementedError

    def steady_force(self, speed, load):
        """Friction force at a constant speed > 0."""
        raise NotImplementedError

    def holding_limit(self, load):
        """Largest force that the contact can hold at rest (set-valued laws); not less than that at vanishing speed."""
        raise NotImplementedError

    def internal_scales(self, load) -> tuple:
        """Natural size of each internal state, over which its error is measured."""
        return ()

    def visible_speed(self):
        """Speed up to which a Taylor series notices that friction changes near rest; 0 where the law does not know.

        From farther out that change is below rounding: the integrator then looks ahead where the contact slows down.
        """
        return 0.0

    def losses(self, velocity, internal, side, load):
        """Power lost by sliding and by deforming the contact: (contact sliding, bristle loss)."""
        force, _ = self.force(velocity, internal, side, load)
        return force * velocity, 0.0

    def stored_energy(self, internal):
        """Energy stored in the contact."""
        return 0.0

    @property
    def passive(self) -> bool:
        """Whether the law takes energy in every motion, for certain, with these parameters."""
        raise NotImplementedError


@model_validator(mode="after")
def levels_in_order(law):
    """Refuse a static coefficient below the Coulomb coefficient; laws with both levels name this validator."""
    if law.static_coefficient < law.coulomb_coefficient:
        raise ValueError(
            f"static_coefficient should be at least coulomb_coefficient ({law.coulomb_coefficient}), "
            f"got {law.static_coefficient}"
        )
    return law
