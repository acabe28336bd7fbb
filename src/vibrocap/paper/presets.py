"""Parameter sets, named after the figures of the paper that use them.

The paper prints lambda, rho and nu for Figs 5-8, but neither h nor omega; for Figs 9-11 it prints all of them. Here
Figs 5-8 use h = 1.8 and omega = 1 as well: the values printed for the later figures, which also reproduce the motion
that section 3.1 describes.
"""

import math

from vibrocap.arguments import check_one_of
from vibrocap.physics.drives.harmonics import Harmonic
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.pendulum_capsules import PendulumCapsule
from vibrocap.physics.system import System

LAWS: dict[str, type[Law]] = {"lugre": LuGre, "exponential": Exponential}
SHORT = {"lugre": "LM", "exponential": "EM"}

START_ANGLE = math.pi / 3  # section 3, y1(0)
START_BRISTLE = 0.0026  # section 3, y5(0)
AMPLITUDE, FREQUENCY = 1.8, 1.0  # captions of Figs 9-11
MASS_RATIOS = (0.01, 8.1)  # section 3.2, the range of Fig. 9
DISPLACEMENT_MASS_RATIOS = (0.8, 2.0, 4.0)  # caption of Fig. 11


def law(name: str, **changes: float) -> Law:
    """A friction law with the paper's values (section 3), but for the changes named.

    name: "lugre" (LM) or "exponential" (EM). Raises ValueError for any other.
    """
    check_one_of("law", name, LAWS)
    return LAWS[name](**changes)


def figures_5_to_8(friction: str = "lugre", **friction_changes: float) -> System:
    """The system of Figs 5-8: lambda 2.5, rho 2, nu 1 (printed); h 1.8, omega 1 (not printed, taken from Figs 9-11)."""
    machine = PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0)
    return System(machine, law(friction, **friction_changes), Harmonic(AMPLITUDE, FREQUENCY))


def figures_9_to_11(friction: str = "lugre", mass_ratio: float = 2.5, stiffness: float = 4.0) -> System:
    """The system of Figs 9-11: h 1.8, omega 1, rho 4, nu 1.2 (all printed), at one mass ratio of the range.

    stiffness: another rho, only to show what the printed value does not do.
    """
    machine = PendulumCapsule(mass_ratio=mass_ratio, stiffness=stiffness, damping=1.2)
    return System(machine, law(friction), Harmonic(AMPLITUDE, FREQUENCY))


def with_load(system: System, load: float | str) -> System:
    """The same capsule under another normal load: a number, "weight" (lambda + 1) or "dynamic".

    The paper's is 1, the weight of the pendulum alone.
    """
    return system.with_parameters({"machine.normal_load": load})


def start(system: System, mirrored: bool = False) -> dict[str, float]:
    """The paper's start: angle pi/3, bristle 0.0026 where the law has one, all else zero; or its mirror image."""
    sign = -1.0 if mirrored else 1.0
    initial = {"angle": sign * START_ANGLE}
    if "bristle" in system.state_names:
        initial["bristle"] = sign * START_BRISTLE
    return initial
