"""The speed over which the friction of a law changes."""

import numpy as np

from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table

SPEEDS = np.geomspace(1e-12, 1e6, 721)  # over which a drop of the steady force is looked for, in any units
NO_DROP = 1e-3  # share of the steady force that counts as none


def speed_scale(law: Law, load: float = 1.0) -> float:
    """The first velocity among the parameters of a law, or where half of its Stribeck drop is done; else 1."""
    for info in parameter_table(law):
        value = getattr(law, info.name)
        named = "velocity" in info.name or "speed" in info.name or info.name == "width"
        if isinstance(value, float) and value > 0.0 and (named or info.name == "decay_rate"):
            return value if named else 1.0 / value
    steady = np.array([float(law.steady_force(float(v), load)) for v in SPEEDS])
    drop = steady[0] - steady
    if not np.max(drop) > NO_DROP * abs(steady[0]):
        return 1.0
    return float(SPEEDS[np.argmax(drop >= 0.5 * np.max(drop))])
