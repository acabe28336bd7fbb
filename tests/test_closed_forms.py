"""Motions of the pendulum capsule with a closed form (docs/model.md); others stand beside their machines."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import vibrocap as vc

TOLERANCE = 1e-11


@pytest.mark.parametrize(
    ("law", "stiffness", "frequency"),
    [(vc.Exponential(), 2.0, 1.3), (vc.Exponential(), 4.0, 0.6), (vc.Exponential(0.0, 0.0, 0.0), 2.0, 0.6)],
    ids=["stuck", "stuck, below its own frequency", "heavy"],
)
def test_small_vibration(law, stiffness, frequency):
    """|theta| = h/sqrt((rho-1-omega^2)^2 + nu^2 omega^2), with its phase, for theta = Re A e^(i omega t).

    A stuck capsule has any mass; one without friction must be heavy. Relative error: theta^2 from sin and 1/lambda.
    """
    amplitude, damping = 1e-4, 1.0
    machine = vc.PendulumCapsule(
        mass_ratio=2.5 if law.static_coefficient else 1e9, stiffness=stiffness, damping=damping
    )
    system = vc.System(machine, law, vc.Harmonic(amplitude=amplitude, frequency=frequency))
    motion = vc.simulate(system, periods=20, tolerance=1e-13)
    t = motion.period * (19.0 + np.arange(64) / 64.0)
    value = 2.0 * np.mean(motion.at(t, "angle") * np.exp(-1j * frequency * t))
    response = amplitude / complex(stiffness - 1.0 - frequency**2, damping * frequency)
    assert abs(value - response) <= 1e-7 * abs(response)
    closed = amplitude / math.sqrt((stiffness - 1 - frequency**2) ** 2 + (damping * frequency) ** 2)
    assert abs(value) == pytest.approx(closed, rel=1e-7)


@pytest.mark.parametrize("stiffness", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("side", [1, -1])
def test_buckled_pendulum(stiffness, side):
    """For rho < 1 the upright pendulum is no equilibrium that lasts; it comes to rest at sin(theta) = rho theta."""
    system = vc.System(
        vc.PendulumCapsule(stiffness=stiffness, damping=1.0), vc.Exponential(), vc.Harmonic(amplitude=0.0)
    )
    motion = vc.simulate(system, periods=60, initial={"angle": 0.01 * side}, tolerance=TOLERANCE)
    buckled = brentq(lambda theta: math.sin(theta) - stiffness * theta, 0.1, math.pi, xtol=1e-15)
    assert motion.state["angle"] == pytest.approx(side * buckled, abs=100 * TOLERANCE)
    assert abs(motion.state["angle_rate"]) <= 100 * TOLERANCE
    assert motion.phases[-1].side == 0


def test_without_load_momentum_is_kept():
    """N = 0: (lambda+1) X - sin(theta) is linear in time, with the initial momentum as its slope."""
    machine = vc.PendulumCapsule(mass_ratio=1.3, stiffness=2.0, damping=0.8, normal_load=0.0)
    drive = vc.Biharmonic(amplitude=1.8, frequency=0.9, second_amplitude=0.5, second_phase=0.4)
    system = vc.System(machine, vc.Exponential(), drive)
    start = {"angle": 0.7, "angle_rate": -0.3, "position": 0.2, "velocity": 0.15}
    motion = vc.simulate(system, periods=10, initial=start, tolerance=TOLERANCE)
    slope = 2.3 * 0.15 + math.cos(0.7) * 0.3
    linear = 2.3 * 0.2 - math.sin(0.7) + slope * motion.time
    assert 2.3 * motion["position"] - np.sin(motion["angle"]) == pytest.approx(linear, abs=1e3 * TOLERANCE)
    assert all(phase.side != 0 for phase in motion.phases)
