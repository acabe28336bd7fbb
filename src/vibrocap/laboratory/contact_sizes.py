"""The sizes of a contact: the force, the displacement and the speed with which a law has something to show."""

import dataclasses
import math

import numpy as np

from vibrocap.laboratory.driven import driven_force
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


SLOW = 1e-5  # of the speed: a pull that is quasi-static


@dataclasses.dataclass(frozen=True)
class ContactSizes:
    """Natural sizes of a contact, in the units of its law.

    force: the largest force of a slow pull, or of steady sliding up to `speed`: the break-away force
    displacement: twice the way after which a slow pull from rest meets half that force; where it meets it at once, the
        way over which the internal state relaxes; where there is none, the way at `speed` in one unit of time
    speed: over which friction changes: a velocity among the law's parameters, or where half of the Stribeck drop is
        done; 1 for a law that knows no speed
    elastic: whether the contact yields before it slides, so that the displacement is its own
    """

    force: float
    displacement: float
    speed: float
    elastic: bool

    @property
    def stiffness(self) -> float:
        """Force over displacement."""
        return self.force / self.displacement


def contact_sizes(law: Law, load: float = 1.0) -> ContactSizes:
    """Natural sizes of a law, found by pulling it slowly; the canonical tests choose their defaults by them."""
    speed = speed_scale(law, load)
    time = np.concatenate(([0.0], np.geomspace(1e-12, 1e12, 1201)))  # times SLOW speed: any displacement there may be
    pull = np.abs(driven_force(law, time, np.full(len(time), SLOW * speed), load=load).force)
    pull = pull[np.isfinite(pull)]
    force = max(float(pull.max()), *(abs(float(law.steady_force(float(v), load))) for v in SPEEDS[speed >= SPEEDS]))
    if law.kind == "set-valued":
        force = max(force, float(law.holding_limit(load)) + abs(float(law.holding_centre(load))))
    force = force or 1.0
    half = int(np.argmax(pull >= 0.5 * force))
    if law.internal and half > 1:
        return ContactSizes(force, 2.0 * SLOW * speed * float(time[half]), speed, True)
    length = _relaxation_length(law, speed, load)
    return ContactSizes(force, length or speed, speed, False)


def _relaxation_length(law: Law, speed: float, load: float) -> float:
    """Way over which the internal states relax at a constant speed; 0 where there are none."""
    moving = [i for i, name in enumerate(law.internal) if name not in law.switched]
    if not moving:
        return 0.0
    time = np.concatenate(([0.0], np.geomspace(1e-9, 1e9, 200)))
    settled = driven_force(law, time, np.full(len(time), speed), load=load).internal[-1]
    if not np.isfinite(settled).all():
        return 0.0
    before = law.force(speed, tuple(settled), 1, load)[1]
    rates = [0.0]
    for i in moving:
        step = 1e-6 * float(law.internal_scales(load)[i])
        after = law.force(speed, tuple(settled + step * (np.arange(len(settled)) == i)), 1, load)[1]
        rates.append(abs(after[i] - before[i]) / step)
    return speed / max(rates) if math.isfinite(max(rates)) and max(rates) > 0.0 else 0.0
