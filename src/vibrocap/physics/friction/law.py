"""The contract of a friction law: a record of parameters with the scalar functions below.

`side` is the direction of sliding, +1 or -1, constant over a smooth piece of the motion; with it |v| is
`side * velocity` and sgn(v) is `side`, so that every expression is smooth and has a Taylor series. The integrator
changes the side."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from vibrocap.physics.elementary import stribeck_curve
from vibrocap.physics.parameters import NonNegative, Number, Part, Positive, parameter, parameters  # noqa: F401 for parts

LARGEST_EXPONENT = 1e6  # beyond, a power is a step for all that doubles can tell
AtLeastOne = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1, le=LARGEST_EXPONENT)]
Exponent = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST_EXPONENT)]
Share = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)]

STRIBECK_VELOCITY = parameter(
    0.1, "v_s", "speed over which friction drops from static to Coulomb level", "Stribeck velocity"
)
STRIBECK_EXPONENT = parameter(2.0, "alpha", "shape of the drop (2: Gaussian)", "exponent")


class Law(Part):
    """What every friction law offers.

    kind: "set-valued": at rest any force up to `holding_limit` (the contact sticks);
          "kinked": a force for every velocity, with a kink in it or in its rates at v = 0 (most dynamic laws);
          "smooth": neither.
    internal: names of the internal states, whose rates `force` returns.
    switched: those of the internal states that are whole numbers: they say which piece of the law holds, have the rate
        0.0 and change at reversals and where a guard of `switches` falls to zero. A run starts with all of them at 0.
    internal_symmetry: sign of each internal state when the motion is mirrored; -1 for all unless given.
    shape_parameters: parameters that choose the formula when they are whole numbers (an exponent, for instance).
    state_units: SI units of internal states that no other law has, "N" for instance.
    creeps: whether it drifts under an oscillating force below breakaway.
    special_cases: simpler laws that this one is for some values: by the simpler law's name the values of own parameters
        that it has not, a number or the name of another own parameter whose value it takes. Parameters of the same name
        are the same. A fit starts from the best of each, too.
    """

    name: ClassVar[str]
    kind: ClassVar[Literal["set-valued", "kinked", "smooth"]]
    internal: ClassVar[tuple[str, ...]] = ()
    switched: ClassVar[tuple[str, ...]] = ()
    internal_symmetry: ClassVar[tuple[int, ...] | None] = None
    shape_parameters: ClassVar[tuple[str, ...]] = ()
    state_units: ClassVar[Mapping[str, str]] = {}
    creeps: ClassVar[bool] = False
    special_cases: ClassVar[Mapping[str, Mapping[str, float | str]]] = {}

    def force(self, velocity, internal, side, load):
        """Friction force R and the rates of the internal states, (R, (z', ...)), while sliding to `side`.

        velocity: sliding velocity [1]   internal: as `internal` names them [1]   side: +1 or -1   load: N [1]
        """
        raise NotImplementedError

    def steady_force(self, speed, load):
        """Friction force at a constant speed > 0 (forward, where the directions differ)."""
        raise NotImplementedError

    def holding_limit(self, load):
        """Largest force that the contact can hold at rest (set-valued laws); not less than that at vanishing speed."""
        raise NotImplementedError

    def holding_centre(self, load):
        """Middle of the forces that the contact can hold at rest, which lie within `holding_limit` of it."""
        return 0.0

    def switches(self, velocity, internal, side, load) -> tuple:
        """Guards of the pieces of a kinked law, each positive while its piece lasts.

        Where one falls to zero the internal states become those of `after_switch`. A guard should be clearly positive
        after its own switch (let the new piece last a little beyond the border), or the law would chatter.
        """
        return ()

    def after_switch(self, which, velocity, internal, side, load) -> tuple:
        """The internal states after guard number `which` of `switches` has fallen to zero."""
        raise NotImplementedError

    def after_reversal(self, internal, side, load) -> tuple:
        """The internal states of a kinked law after the contact has turned to `side`."""
        return internal

    def internal_scales(self, load) -> tuple:
        """Natural size of each internal state, over which its error is measured."""
        return ()

    def losses(self, velocity, internal, side, load):
        """Power lost by sliding and by deforming the contact: (contact sliding, bristle loss)."""
        force, _ = self.force(velocity, internal, side, load)
        return force * velocity, 0.0

    def stored_energy(self, internal):
        """Energy stored in the contact."""
        return 0.0

    @property
    def symmetric(self) -> bool:
        """Whether friction is the same in both directions, with these parameters."""
        return True

    @property
    def passive(self) -> bool:
        """Whether the law takes energy in every motion, for certain, with these parameters."""
        raise NotImplementedError


class Curve(Law):
    """A set-valued law without memory: a curve `steady_force` over the speed while sliding, up to N eta_s at rest."""

    kind: ClassVar = "set-valued"

    def force(self, velocity, internal, side, load):
        return side * self.steady_force(side * velocity, load), ()

    def holding_limit(self, load):
        """Largest force at rest, N eta_s."""
        return load * self.static_coefficient  # type: ignore[attr-defined]

    @property
    def passive(self) -> bool:
        """Always: R v >= 0."""
        return True


@model_validator(mode="after")
def levels_in_order(law):
    """Refuse a static coefficient below the Coulomb coefficient; laws with both levels name this validator."""
    if law.static_coefficient < law.coulomb_coefficient:
        raise ValueError(
            f"static_coefficient should be at least coulomb_coefficient ({law.coulomb_coefficient}), "
            f"got {law.static_coefficient}"
        )
    return law


@parameters
class TwoLevels(Curve):
    """A curve from the static level at rest to the Coulomb level at high speed."""

    coulomb_coefficient: NonNegative = parameter(0.15, "eta_c", "friction coefficient at high speed", "level")
    static_coefficient: NonNegative = parameter(0.45, "eta_s", "friction coefficient at rest", "static level")

    _levels = levels_in_order


def stribeck_level(law, speed, load):
    """N [eta_c + (eta_s - eta_c) exp(-|v/v_s|^alpha)], of a law that has these four parameters."""
    levels = law.coulomb_coefficient, law.static_coefficient
    return load * stribeck_curve(speed, *levels, law.stribeck_velocity, law.stribeck_exponent)
