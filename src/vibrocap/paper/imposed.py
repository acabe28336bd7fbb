"""Friction under an imposed velocity, as in the schematic of Fig. 3."""

import numpy as np

from vibrocap.laboratory.driven import driven_force
from vibrocap.physics.friction.lugre import LuGre

SAMPLES = 4000  # per cycle of an imposed velocity, that are returned
# samples for each of these that the law follows, so that the straight lines between them are a sine to 1e-10
FINER = 16
CYCLES = 2  # the last of which is kept
MEAN, AMPLITUDE = 0.1, 0.05  # of the velocity of pure sliding: where steady friction falls most steeply


def imposed_cycle(friction: LuGre, mean: float, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and friction over a cycle of an imposed velocity, X' = mean + amplitude sin(tau), N = 1.

    One cycle has passed before, from bristles at rest.
    """
    time = np.linspace(0.0, 2.0 * np.pi * CYCLES, CYCLES * SAMPLES * FINER + 1)
    velocity = mean + amplitude * np.sin(time)
    forces = driven_force(friction, time, velocity, tolerance=1e-10)
    last = slice(-SAMPLES * FINER - 1, None, FINER)
    return velocity[last], forces.force[last]


def imposed_sliding(damping: float) -> dict[str, np.ndarray]:
    """Friction while accelerating and decelerating at equal speeds, for X' = 0.1 + 0.05 sin(tau): pure sliding."""
    velocity, force = imposed_cycle(LuGre(bristle_damping=damping), MEAN, AMPLITUDE)
    lowest = 3 * SAMPLES // 4
    velocity, force = np.roll(velocity[:-1], -lowest), np.roll(force[:-1], -lowest)
    half = SAMPLES // 2
    speeds = MEAN + AMPLITUDE * np.linspace(-0.95, 0.95, 96)
    return {
        "velocity": speeds,
        "accelerating": np.interp(speeds, velocity[:half], force[:half]),
        "decelerating": np.interp(speeds, velocity[half:][::-1], force[half:][::-1]),
    }
