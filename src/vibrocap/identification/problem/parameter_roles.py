"""What a fit expects of a parameter by its role: its likely size, its range and what would determine it.

A parameter declares its role with its value (`vibrocap.physics.parameters`). One without a role, or with one that no
fit knows, is fitted from the value that the law starts with.
"""

import dataclasses
import math
from typing import Any

from vibrocap.physics.parameters import NUMBER, ROLES, Dimension, ParameterInfo, parameter_table


@dataclasses.dataclass(frozen=True)
class Role:
    """What a parameter does.

    share: the likely value over the natural size, the product of the data's scales that has the role's dimension.
    decades: how many powers of ten a start may be away from it.
    low, high: range that physics leaves, over the natural size (a search beyond them finds nothing that is measurable);
        a parameter that may be zero is searched down to zero, and on a linear scale below `low`.
    experiment: what determines the parameter, in words that follow "... would determine it".
    fitted: whether it is free unless asked for otherwise.
    """

    name: str
    share: float
    decades: float
    low: float
    high: float
    experiment: str
    fitted: bool = True

    @property
    def dimension(self) -> Dimension:
        """The dimension of the role."""
        return ROLES.get(self.name, NUMBER)


SWEEP = "a slow sweep of velocity through the range where friction drops"
LOOPS = "presliding loops: reversals with strokes below the breakaway distance, sampled many times within them,"
STEPS = "steps of the sliding velocity, sampled many times over the critical distance and lasting several of it,"
BOTH = "steady sliding in both directions"
CONVENTION = "nothing: it is a convention, choose it"
# fmt: off
EXPECTED = {role.name: role for role in (  # name, share, decades, low, high, experiment
    Role("reference velocity", 1.0, 0.0, 0.0, math.inf, CONVENTION, fitted=False),
    Role("convention", 1.0, 0.0, 0.0, math.inf, CONVENTION, fitted=False),
    Role("cutoff velocity", 1e-3, 0.5, 1e-9, 1.0, "sliding at very low speeds", fitted=False),
    Role("softening", 0.5, 0.2, -0.45, 20.0, LOOPS),
    Role("exponent", 2.0, 0.2, 0.1, 12.0, SWEEP + ", and loops through the knee at breakaway,"),
    Role("static level", 1.2, 0.15, 1e-4, 20.0,
         "repeated slow break-aways from rest, or a sweep down to speeds far below the Stribeck velocity,"),
    Role("back ratio", 1.0, 0.1, 0.02, 50.0, BOTH),
    Role("direct effect", 0.015, 0.5, 3.5e-3, 1.0, STEPS),
    Role("evolution effect", 0.015, 0.5, 1e-6, 1.0, STEPS),
    Role("distance", 0.02, 0.7, 1e-6, 10.0, STEPS),
    Role("gap", 0.1, 0.3, 1e-5, 2.0, "slow reversals with strokes greater than the gap"),
    *(Role(name, 0.5, 0.2, 0.01, 0.98, "presliding loops of several strokes up to the breakaway distance,")
      for name in ("share", "fraction")),
    Role("stiffness", 20.0, 0.5, 1e-3, 1e7, LOOPS),
    Role("bristle damping", 0.03, 1.0, 1e-4, 1e3,
         "fast changes while presliding: small oscillations below breakaway, of an angular frequency near the ratio of "
         "bristle stiffness to bristle damping,"),
    Role("viscous damping", 0.1, 0.5, 1e-3, 1e2,
         "steady sliding at several speeds well above the Stribeck velocity"),
    Role("smoothing velocity", 0.02, 0.5, 1e-6, 2.0, "slow reversals, sampled many times within the width,"),
    Role("Stribeck velocity", 0.1, 0.7, 1e-5, 20.0, SWEEP),
    Role("fading velocity", 0.1, 0.7, 1e-5, 20.0, "fast changes of the speed while sliding, at several speeds"),
    Role("decay rate", 10.0, 0.7, 0.05, 1e5, SWEEP),
    Role("attraction rate", 20.0, 0.7, 1e-2, 1e5, "fast changes of the speed while sliding"),
    Role("level", 1.0, 0.1, 1e-4, 20.0, "steady sliding at high speed"),
)}
# fmt: on
UNKNOWN = Role("unknown", 1.0, 0.3, 0.0, math.inf, "a motion that excites its effect")


def role(law: Any, name: str) -> Role:
    """The role of a parameter of a law or of its class; unknown for what is no parameter of it (an offset)."""
    roles = (info.role for info in parameter_table(law) if info.name == name)
    return EXPECTED.get(next(roles, ""), UNKNOWN)


def with_role(law: Any, *roles: str) -> tuple[str, ...]:
    """Names of the parameters of a law, or of its class, that have one of these roles, in their order."""
    return tuple(info.name for info in parameter_table(law) if info.role in roles)


def unit_of(info: ParameterInfo, known_load: bool) -> str:
    """SI unit of a parameter, "" if it declares none; a coefficient is a force in N where the load is not known."""
    return "" if info.dimension is None else info.dimension.unit(known_load)
