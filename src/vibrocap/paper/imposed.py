"""Friction under an imposed velocity, as in the schematic of Fig. 3."""

import numpy as np

from vibrocap.friction.lugre import LuGre

SAMPLES = 4000  # steps per cycle of an imposed velocity, far below the relaxation of the bristles
CYCLES = 2  # the last of which is kept
MEAN, AMPLITUDE = 0.1, 0.05  # of the velocity of pure sliding: where steady friction falls most steeply


def imposed_cycle(friction: LuGre, mean: float, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and friction over a cycle of an imposed velocity, X' = mean + amplitude sin(tau), N = 1.

    The bristles follow (7) by the classical Runge-Kutta method; one cycle has passed before.
    """
    step = 2.0 * np.pi / SAMPLES
    side_of = np.sign

    def rate(t: float, bristle: float) -> float:
        v = mean + amplitude * np.sin(t)
        return friction.force(v, (bristle,), side_of(v) or 1.0, 1.0)[1][0]

    bristle, velocities, forces = 0.0, [], []
    for i in range(CYCLES * SAMPLES + 1):
        t = i * step
        if i >= (CYCLES - 1) * SAMPLES:
            v = mean + amplitude * np.sin(t)
            velocities.append(v)
            forces.append(friction.force(v, (bristle,), side_of(v) or 1.0, 1.0)[0])
        k1 = rate(t, bristle)
        k2 = rate(t + step / 2, bristle + step / 2 * k1)
        k3 = rate(t + step / 2, bristle + step / 2 * k2)
        k4 = rate(t + step, bristle + step * k3)
        bristle += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.array(velocities), np.array(forces)


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
