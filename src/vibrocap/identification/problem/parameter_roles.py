"""Roles of parameters: what one does in a law, hence its dimension, its likely size and what would determine it.

Laws share few parameter names but many roles. A parameter finds its role by its name; one of an unknown role is fitted
from the value that the law starts with.
"""

import dataclasses
import math
import re


@dataclasses.dataclass(frozen=True)
class Role:
    """What a parameter does.

    dimension: exponents of (coefficient, force, length, time), where a coefficient is a force over the normal load:
        the product of the data's scales to these exponents is a natural size of the parameter.
    share: the likely value over that natural size. decades: how many powers of ten a start may be away from it.
    low, high: range that physics leaves, over the natural size (a search beyond them finds nothing that is measurable);
        a parameter that may be zero is searched down to zero, and on a linear scale below `low`.
    experiment: what determines the parameter, in words that follow "... would determine it".
    fitted: whether it is free unless asked for otherwise.
    """

    name: str
    pattern: str
    dimension: tuple[float, float, float, float]
    share: float
    decades: float
    low: float
    high: float
    experiment: str
    fitted: bool = True


INFINITE, NUMBER = math.inf, (0.0, 0.0, 0.0, 0.0)
SWEEP = "a slow sweep of velocity through the range where friction drops"
LOOPS = "presliding loops: reversals with strokes below the breakaway distance, sampled many times within them,"
STEPS = "steps of the sliding velocity, sampled many times over the critical distance and lasting several of it,"
BOTH = "steady sliding in both directions"
CONVENTION = "nothing: it is a convention, choose it"
# fmt: off
ROLES = (  # name, pattern, dimension, share, decades, low, high, experiment
    Role("reference", "reference_(velocity|speed)", (0, 0, 1, -1), 1.0, 0.0, 0.0, INFINITE, CONVENTION, fitted=False),
    Role("convention", "^(forward_ratio|amplitude|dissipative_shape)$", NUMBER, 1.0, 0.0, 0.0, INFINITE,
         CONVENTION, fitted=False),
    Role("cutoff", "cutoff_velocity", (0, 0, 1, -1), 1e-3, 0.5, 1e-9, 1.0, "sliding at very low speeds", fitted=False),
    Role("softening", "elastic_shape", NUMBER, 0.5, 0.2, -0.45, 20.0, LOOPS),
    Role("shape", "exponent|sharpness|shape", NUMBER, 2.0, 0.2, 0.1, 12.0,
         SWEEP + ", and loops through the knee at breakaway,"),
    Role("static level", "static", (1, 0, 0, 0), 1.2, 0.15, 1e-4, 20.0,
         "repeated slow break-aways from rest, or a sweep down to speeds far below the Stribeck velocity,"),
    Role("ratio", "ratio", NUMBER, 1.0, 0.1, 0.02, 50.0, BOTH),
    Role("direct effect", "direct_effect", (1, 0, 0, 0), 0.015, 0.5, 3.5e-3, 1.0, STEPS),
    Role("evolution effect", "evolution_effect", (1, 0, 0, 0), 0.015, 0.5, 1e-6, 1.0, STEPS),
    Role("critical distance", "critical_distance", (0, 0, 1, 0), 0.02, 0.7, 1e-6, 10.0, STEPS),
    Role("gap", "gap|backlash|play", (0, 0, 1, 0), 0.1, 0.3, 1e-5, 2.0,
         "slow reversals with strokes greater than the gap"),
    Role("share", "share", NUMBER, 0.5, 0.2, 0.01, 0.98,
         "presliding loops of several strokes up to the breakaway distance,"),
    Role("stiffness", "stiffness", (0, 1, -1, 0), 20.0, 0.5, 1e-3, 1e7, LOOPS),
    Role("bristle damping", "bristle_damping", (0, 1, -1, 1), 0.03, 1.0, 1e-4, 1e3,
         "fast changes while presliding: small oscillations below breakaway, of an angular frequency near the ratio of "
         "bristle stiffness to bristle damping,"),
    Role("viscous", "viscous|damping", (0, 1, -1, 1), 0.1, 0.5, 1e-3, 1e2,
         "steady sliding at several speeds well above the Stribeck velocity"),
    Role("width", "smoothing", (0, 0, 1, -1), 0.02, 0.5, 1e-6, 2.0,
         "slow reversals, sampled many times within the width,"),
    Role("Stribeck velocity", "velocity|speed", (0, 0, 1, -1), 0.1, 0.7, 1e-5, 20.0, SWEEP),
    Role("decay over speed", "decay_rate", (0, 0, -1, 1), 10.0, 0.7, 0.05, 1e5, SWEEP),
    Role("attraction", "attraction_rate", (1, 0, 0, -1), 20.0, 0.7, 1e-2, 1e5,
         "fast changes of the speed while sliding"),
    Role("level", "coefficient|level", (1, 0, 0, 0), 1.0, 0.1, 1e-4, 20.0, "steady sliding at high speed"),
)
# fmt: on
UNKNOWN = Role("unknown", "", NUMBER, 1.0, 0.3, 0.0, INFINITE, "a motion that excites what it stands for")


def role(name: str) -> Role:
    """The role of a parameter of this name."""
    return next((each for each in ROLES if re.search(each.pattern, name)), UNKNOWN)


def is_gap(name: str) -> bool:
    """Whether a parameter is the width of a gap, in which the force is not smooth: it moves the instants of closing."""
    return role(name).name == "gap"


def unit_of(name: str, known_load: bool) -> str:
    """SI unit of a parameter; a coefficient is a force in N where the normal force is not known."""
    found = role(name)
    if found is UNKNOWN:
        return ""
    coefficient, force, length, time = found.dimension
    powers = {"N": force + (0 if known_load else coefficient), "m": length, "s": time}
    above = [unit + ("" if e == 1 else f"^{e:g}") for unit, e in powers.items() if e > 0]
    below = [unit + ("" if e == -1 else f"^{-e:g}") for unit, e in powers.items() if e < 0]
    return (" ".join(above) or "1") + ("/" + " ".join(below) if below else "")
