"""Plausible systems at random, laws x machines x drives, to be run at random tolerances: a seeded table.

`python tests/plausible_cases.py 440` runs that many and prints what their balances and states are off by, in
tolerances, against runs at a tolerance near rounding.
"""

import random

from pydantic import ValidationError

import vibrocap as vc
from vibrocap.physics.catalogue import law, laws
from vibrocap.physics.parameters import parameter_table

WRAPPED = (
    "anisotropic-stribeck",
    "anisotropic-lugre",
    "backlash-lugre",
    "backlash-bouc-wen",
    "smoothed-exponential",
    "smoothed-stribeck",
    "anisotropic-maxwell-slip",
)
TIGHT = 1e-13
LEAST_GROWTH, SHIFT = 1.0, 1e-9


def plausible_law(draw: random.Random) -> vc.System:
    """A law with every number changed by up to a factor of ten, but for those of which it refuses such values."""
    kind = law(draw.choice((*laws(), *WRAPPED)))
    while True:
        values = {}
        for info in parameter_table(kind):
            value = info.default
            if isinstance(value, float) and info.name in ("coulomb_coefficient", "static_coefficient"):
                values[info.name] = value * draw.uniform(0.5, 1.5)
            elif isinstance(value, float) and "exponent" in info.name:
                values[info.name] = draw.choice((value, 1.0, 2.0, draw.uniform(1.0, 3.0), draw.uniform(3.0, 20.0)))
            elif isinstance(value, float):
                values[info.name] = value * 10.0 ** draw.uniform(-1.0, 1.0) or draw.choice(
                    (0.0, draw.uniform(0.0, 0.3))
                )
        try:
            return kind(**values)
        except ValidationError:
            continue


def plausible_case(seed: int) -> tuple[vc.System, dict[str, float], float, int]:
    """(system, start, tolerance, periods) of a number."""
    draw = random.Random(f"plausible {seed}")
    friction = plausible_law(draw)
    if draw.random() < 0.6:
        machine = vc.Oscillator(
            mass=10.0 ** draw.uniform(-1.0, 1.0),
            stiffness=10.0 ** draw.uniform(-1.0, 1.0),
            damping=draw.choice((0.0, 0.05, 0.3)),
            belt_speed=draw.choice((0.0, 0.01, 0.1, 0.3, -0.2)),
            normal_load=draw.choice((0.5, 1.0, 2.0, 10.0)),
        )
        force = machine.normal_load
        start = {
            "position": draw.uniform(-0.5, 0.5) * force / machine.stiffness,
            "sliding_velocity": draw.choice((0.0, draw.uniform(-0.5, 0.5))),
        }
    else:
        machine = vc.PendulumCapsule(
            mass_ratio=10.0 ** draw.uniform(-0.7, 0.9),
            stiffness=draw.uniform(0.5, 4.0),
            damping=draw.uniform(0.1, 1.5),
            normal_load=draw.choice(("weight", 0.3, 1.0, 3.0)),
        )
        force = 1.0
        start = {"angle": draw.uniform(-1.0, 1.0)}
    amplitude, frequency = force * draw.uniform(0.05, 1.5), 10.0 ** draw.uniform(-0.5, 0.5)
    drive = vc.Harmonic(amplitude=amplitude, frequency=frequency)
    if draw.random() < 0.25:
        drive = vc.Biharmonic(amplitude=amplitude, frequency=frequency)
    return vc.System(machine, friction, drive), start, 10.0 ** draw.uniform(-10.0, -4.0), draw.choice((2, 5, 10))
