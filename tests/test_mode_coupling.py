"""The mode-coupling block: where its steady sliding loses stability, and that its load is followed."""

import numpy as np
import pytest

import vibrocap as vc

STILL = vc.Harmonic(amplitude=0.0, frequency=1.0)
MACHINE = vc.ModeCouplingBlock()


def critical_coefficient(machine):
    """mu_c = [(k11 - k22)^2/(4 k12) + k12]/k3."""
    k11, k12, k22 = machine.sliding_stiffness, machine.coupling_stiffness, machine.normal_stiffness
    return ((k11 - k22) ** 2 / (4.0 * k12) + k12) / machine.contact_stiffness


def steady_sliding(machine, mu):
    """(x, y) at which the forces of springs and friction are in balance, on a belt that is faster."""
    stiffness = [
        [machine.sliding_stiffness, machine.coupling_stiffness - mu * machine.contact_stiffness],
        [machine.coupling_stiffness, machine.normal_stiffness],
    ]
    x, y = np.linalg.solve(stiffness, [mu * machine.normal_load, 0.0])
    return {"position": x, "approach": y, "sliding_velocity": -machine.belt_speed}


def multipliers(mu, machine=MACHINE, period=1.0):
    """Of steady sliding, over a time that is short against the vibrations."""
    drive = vc.Harmonic(amplitude=0.0, frequency=2.0 * np.pi / period)
    system = vc.System(machine, vc.Coulomb(mu, mu), drive)
    start = steady_sliding(machine, mu)
    orbit = vc.orbit(system, initial=start)
    orbit = orbit.passed or orbit  # what grows leaves it, and settles nowhere
    for name, value in start.items():
        assert orbit.state[name] == pytest.approx(value, abs=1e-12)
    return orbit.multipliers


@pytest.mark.slow
def test_vibrations_grow_beyond_the_critical_coefficient_only():
    expected = critical_coefficient(MACHINE)
    assert np.abs(multipliers(0.999 * expected)) == pytest.approx(1.0, abs=1e-9)
    grown = multipliers(1.01 * expected)
    # omega^2 = mean +- i sqrt(k12 k3 (mu - mu_c)), of a mass of one
    mean, apart = 0.5 * (MACHINE.sliding_stiffness + MACHINE.normal_stiffness), 0.5 * 1.2 * 0.01 * expected
    frequency = np.sqrt(mean - 1j * np.sqrt(apart))
    assert np.max(np.abs(grown)) == pytest.approx(np.exp(-frequency.imag), abs=1e-9)
    assert np.max(np.angle(grown)) == pytest.approx(frequency.real, abs=1e-9)


@pytest.mark.slow
def test_a_growing_vibration_sticks_and_its_balances_close():
    """On a slow belt the vibration is bounded by sticking; on a fast one the block lifts off."""
    machine = vc.ModeCouplingBlock(belt_speed=0.02, damping=0.02)
    mu = 1.1 * critical_coefficient(machine)
    start = steady_sliding(machine, mu) | {"approach_rate": 0.01}
    system = vc.System(machine, vc.Coulomb(mu, mu), STILL)
    motion = vc.simulate(system, periods=60, initial=start)
    assert motion.status is vc.Status.FINISHED
    assert {"stick", "slip_back"} <= set(motion.event_kinds)
    assert motion.certificate.ok
    assert np.min(motion["reaction"]) > 0.0
    assert motion["reaction"] == pytest.approx(1.0 + 1.2 * motion["approach"], abs=1e-12)
    fast = vc.System(vc.ModeCouplingBlock(belt_speed=5.0), vc.Coulomb(mu, mu), STILL)
    ended = vc.simulate(fast, periods=60, initial=start | {"sliding_velocity": -5.0})
    assert ended.status is vc.Status.LIFT_OFF
    assert ended.state["approach"] == pytest.approx(-1.0 / 1.2, abs=1e-9)
