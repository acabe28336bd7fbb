"""LuGre's canonical tests with its authors' own parameters (docs/model.md), and closed forms of the law."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibrocap as vc
from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.loops import creep, frictional_lag, presliding_loop
from vibrocap.laboratory.pulled_block import break_away, stick_slip_test

# Canudas de Wit et al. 1995, table I, in SI: sigma0 [N/m], sigma1, sigma2 [N s/m], Fc, Fs [N], v_s [m/s]; 1 kg
OWN = vc.LuGre(1e5, math.sqrt(1e5), 0.4, 1.0, 1.5, 1e-3)
LEVEL = vc.LuGre(100.0, 0.0, 0.0, 0.3, 0.3)  # a constant g, without damping
G = 0.3 / 100.0


def own_rates(y, drive):
    """(v', z') of a mass of 1 kg on OWN, typed again."""
    v, z = y
    g = (1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2))) / 1e5
    slip = abs(v) * z / g
    return drive - (1e5 * z + math.sqrt(1e5) * (v - slip) + 0.4 * v), v - slip


# --- break-away ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pulls():
    return break_away(OWN, [1.0, 10.0])


@pytest.mark.plain
def test_break_away_by_another_integrator(pulls):
    def rates(t, y):
        return own_rates(y, 10.0 * t)

    solution = solve_ivp(rates, (0.0, 0.14), (0.0, 0.0), "Radau", rtol=1e-10, atol=1e-14, dense_output=True)
    t = np.linspace(0.12, 0.14, 20_001)
    v, z = solution.sol(t)
    friction = 10.0 * t - np.array([own_rates(y, 10.0 * s)[0] for s, y in zip(t, zip(v, z, strict=True), strict=True)])
    assert pulls.force[1] == pytest.approx(friction.max(), rel=1e-8)
    assert pulls.applied[1] == pytest.approx(10.0 * t[friction.argmax()], rel=2e-5)  # of the grid, at a flat maximum
    assert pulls.velocity[1] == pytest.approx(v[friction.argmax()], rel=1e-3)


@pytest.mark.plain
def test_break_away_falls_with_the_rate(pulls):
    assert np.all(np.diff(pulls.force) < 0.0)
    assert pulls.force[0] == pytest.approx(1.5, rel=0.05)
    assert np.all(pulls.applied > pulls.force)


# --- presliding ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reach", [0.3, 1.0, 4.0])
def test_presliding_loop_at_constant_g(reach):
    """|xi|max = g tanh(A/g), loop area 4 Fc [A - g tanh(A/g)]."""
    cycles = math.ceil(30.0 / (4.0 * reach)) + 1  # the first loading is forgotten as exp(-4 A/g) per cycle
    loop = presliding_loop(LEVEL, reach * G, cycles=cycles)
    assert loop.deflection == pytest.approx(G * math.tanh(reach), rel=1e-9)
    assert loop.peak_force == pytest.approx(0.3 * math.tanh(reach), rel=1e-9)
    assert loop.area == pytest.approx(4.0 * 0.3 * (reach * G - G * math.tanh(reach)), rel=1e-9)
    assert loop.closure <= 1e-9
    displacement = loop.displacement[loop.velocity >= 0.0][:500]  # the first loading, but for its end
    assert loop.force[:500] == pytest.approx(0.3 * (1.0 - np.exp(-displacement / G)), abs=1e-9)


def test_presliding_of_the_authors():
    """Slow enough that g stays Fs/sigma0: the same closed forms to 1e-6, and a contact that knows its own sizes."""
    g = 1.5e-5
    loop = presliding_loop(OWN, 2.0 * g, cycles=8, speed=1e-11)
    assert loop.deflection == pytest.approx(g * math.tanh(2.0), rel=1e-6)
    assert loop.area == pytest.approx(4.0 * 1.5 * (2.0 * g - g * math.tanh(2.0)), rel=1e-6)
    sizes = contact_sizes(OWN)
    assert sizes.force == pytest.approx(1.5, rel=1e-6)
    assert sizes.displacement == pytest.approx(2.0 * g * math.log(2.0), rel=0.05)  # of a grid of 1201 times
    assert (sizes.speed, sizes.elastic) == (1e-3, True)


def test_lugre_creeps_as_its_closed_form_says():
    """g ln[(1 - a^2)/(1 - b^2)] per cycle, but for what the damper and the inertia of the block take of the force."""
    found = creep(LEVEL, bias=0.15, amplitude=0.06, cycles=60)
    expected = G * math.log((1.0 - 0.3**2) / (1.0 - 0.7**2))
    assert found.creeps
    assert found.drift_per_cycle == pytest.approx(expected, rel=1e-3)
    assert found.drift == pytest.approx(30 * expected, rel=1e-3)
    twice = creep(LEVEL, bias=0.3, amplitude=0.12, cycles=60, load=2.0)  # the load once
    assert twice.drift_per_cycle == pytest.approx(2.0 * found.drift_per_cycle, rel=1e-4)


def test_no_creep_about_zero():
    found = creep(LEVEL, bias=0.0, amplitude=0.2, cycles=60)
    assert not found.creeps


# --- frictional lag --------------------------------------------------------------------------------------------------


def test_frictional_lag_of_the_authors():
    """The loop widens with the frequency, about the steady curve, friction larger while accelerating."""
    lag = frictional_lag(OWN)
    assert np.all(np.diff(lag.width) > 0.0)
    assert lag.width[0] > 0.0
    assert np.all(lag.area > 0.0)
    slow = frictional_lag(OWN, frequencies=[1e-4, 2e-4])
    steady = np.array([OWN.steady_force(float(v), 1.0) for v in slow.velocity])
    assert slow.force[0] == pytest.approx(steady, abs=1e-5)
    assert slow.width[1] == pytest.approx(2.0 * slow.width[0], rel=1e-3)  # of first order in the frequency


def test_frictional_lag_by_another_integrator():
    omega, mean, amplitude = 25.0, 1.3e-3, 1.2e-3
    lag = frictional_lag(OWN, mean, amplitude, [omega])

    def rate(t, z):
        v = mean - amplitude * math.cos(omega * t)
        return [own_rates((v, z[0]), 0.0)[1]]

    period = 2.0 * math.pi / omega
    t = np.linspace(0.0, period, len(lag.velocity))
    run = solve_ivp(rate, (0.0, 3.0 * period), [0.0], "Radau", rtol=1e-10, atol=1e-15, t_eval=2.0 * period + t)
    v = mean - amplitude * np.cos(omega * t)
    friction = [-own_rates((a, b), 0.0)[0] for a, b in zip(v, run.y[0], strict=True)]
    assert lag.force[0] == pytest.approx(np.array(friction), abs=1e-5)  # velocity linear between 2048 samples
    half = len(v) // 2
    assert lag.width[0] == pytest.approx(np.max(np.array(friction[: half + 1]) - friction[: half - 1 : -1]), abs=2e-5)


def test_the_papers_damping_turns_the_loop_round():
    """Erratum 7: at delta1 = 10 friction while accelerating is less; at delta1 = 1 it is more."""
    assert np.all(frictional_lag(vc.LuGre()).width < 0.0)
    assert np.all(frictional_lag(vc.LuGre(bristle_damping=1.0)).width > 0.0)


# --- stick-slip ------------------------------------------------------------------------------------------------------


def test_stick_slip_of_the_authors():
    """k = 2 N/m, 0.1 m/s; the period is that of Radau, and of ours at 1e-11."""
    found = stick_slip_test(OWN, stiffness=2.0, speed=0.1)
    assert found.sticks
    assert found.settled
    assert found.period == pytest.approx(6.36271982, abs=1e-7)
    assert 1.0 < found.kinetic_force < found.static_force < 1.5
    assert found.stick_time + found.slip_time == pytest.approx(found.period, rel=1e-12)


def test_a_fast_pull_slides_steadily():
    found = stick_slip_test(OWN, stiffness=2.0, speed=1.0)
    assert found.regime == "steady"
    assert found.stick_time == 0.0
