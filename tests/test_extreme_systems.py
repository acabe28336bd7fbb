"""Hundreds of random systems far outside the paper's parameters: the certificate must hold for every one.

Sharp contacts (friction that changes within 1e-4 of rest), stiff bristles (1e2 to 1e6), light and heavy capsules, loose
and tight tolerances. Each found a fault once: a step that did not foresee the friction it met, an implicit step that
ended beside its event, a reversal invented by a truncated series.
"""

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but

pytestmark = pytest.mark.slow


def assert_certified(motion, tolerance):
    """Bounds of the issue: residuals within 100 tolerances (and the rounding of some hundred steps)."""
    certificate = motion.certificate
    assert motion.status.ok, motion.status.text
    assert certificate.sign_kept
    assert certificate.event_velocity <= 1e-14 * max(1.0, float(np.abs(motion["velocity"]).max()))
    assert certificate.energy_residual <= 100 * tolerance + 1e-12
    assert certificate.momentum_residual <= 100 * tolerance + 1e-12
    if certificate.stick_force_ratio is not None:
        assert certificate.stick_force_ratio <= 1.0 + tolerance


@pytest.mark.parametrize("seed", exhaustive_but(range(0, 300, 60), range(300)))
def test_sharp_exponential_contacts(seed):
    draw = np.random.default_rng([2, seed])
    machine = vc.PendulumCapsule(
        mass_ratio=10 ** draw.uniform(-1.5, 1),
        normal_load=10 ** draw.uniform(-1, 1),
        stiffness=draw.uniform(0, 5),
        damping=draw.uniform(0, 2),
    )
    drive = vc.Biharmonic(
        amplitude=draw.uniform(0.5, 4), second_amplitude=draw.uniform(0, 1), frequency=10 ** draw.uniform(-0.5, 0.7)
    )
    tolerance = 10 ** draw.uniform(-11, -3)
    system = vc.System(machine, vc.Exponential(decay_rate=10 ** draw.uniform(0, 4)), drive)
    motion = vc.simulate(system, periods=3, initial={"angle": draw.uniform(-1, 1)}, tolerance=tolerance)
    assert_certified(motion, tolerance)


@pytest.mark.parametrize("seed", exhaustive_but(range(0, 20, 5), range(80)))  # every exponent among those kept
def test_stiff_bristles(seed):
    exponent = (1.0, 1.5, 2.0, 4.0)[seed % 4]
    draw = np.random.default_rng([1, seed])
    stiffness = 10 ** draw.uniform(2, 6)
    law = vc.LuGre(
        bristle_stiffness=stiffness,
        bristle_damping=10 ** draw.uniform(-1, 0.5) * np.sqrt(stiffness),
        stribeck_velocity=10 ** draw.uniform(-3, -1),
        stribeck_exponent=exponent,
        viscous_damping=float(draw.choice([0.0, 0.4])),
    )
    tolerance = 10 ** draw.uniform(-9, -3)
    system = vc.System(
        vc.PendulumCapsule(mass_ratio=10 ** draw.uniform(-1, 1)), law, vc.Harmonic(amplitude=draw.uniform(0.5, 2.5))
    )
    motion = vc.simulate(system, periods=2, initial={"angle": draw.uniform(-1, 1)}, tolerance=tolerance)
    assert_certified(motion, tolerance)
