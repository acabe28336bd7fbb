"""Lyapunov exponents against closed forms and multipliers, the 0-1 test, and the class that they give a motion."""

import functools
import math

import numpy as np
import pytest

import vibrocap as vc
from systems import capsule
from vibrocap.orbits.attractors import classification, lyapunov
from vibrocap.orbits.attractors.classification import classify
from vibrocap.orbits.attractors.lyapunov import LyapunovExponents, ZeroOneTest, lyapunov_exponent, zero_one_test
from vibrocap.orbits.maps import stroboscopic_map
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap

START = {"angle": math.pi / 3}
FRICTIONLESS = vc.Exponential(coulomb_coefficient=0.0, static_coefficient=0.0)
# A capsule whose motion is chaotic: the soft spring lets the pendulum buckle to either side.
CHAOTIC = vc.System(vc.PendulumCapsule(stiffness=0.6, damping=0.3), vc.Exponential(), vc.Harmonic(amplitude=1.2))


@pytest.mark.plain
def test_a_run_that_fails_has_no_certified_exponent(monkeypatch):
    monkeypatch.setattr(lyapunov, "MOST_STEPS", 0)
    exponent = lyapunov_exponent(oscillator(0.1), transient=20, periods=20)
    assert (exponent.finished, exponent.certified, exponent.periods) == (False, False, 0)


def oscillator(damping, stiffness=1.0):
    return vc.System(vc.Oscillator(damping=damping, stiffness=stiffness), FRICTIONLESS, vc.Harmonic(amplitude=0.3))


@pytest.fixture
def plain(monkeypatch):
    monkeypatch.setattr(stroboscopic_map, "StroboscopicMap", functools.partial(StroboscopicMap, plain=True))


def logistic(r, count, start=0.3):
    values = [start]
    for _ in range(count + 500):
        values.append(r * values[-1] * (1.0 - values[-1]))
    return np.array(values[-count:])


# --- the 0-1 test ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("r", [3.97, 4.0])
def test_chaotic_series_gives_one(r):
    assert zero_one_test(logistic(r, 2000)).value > 0.98
    assert zero_one_test(20.0 + logistic(r, 1000)).value > 0.95  # the swinging that a mean makes is taken off


@pytest.mark.parametrize("r", [2.9, 3.2, 3.5, 3.83])  # periods 1, 2, 4 and, in the window, 3
def test_periodic_series_gives_zero(r):
    assert abs(zero_one_test(logistic(r, 2000)).value) < 0.03


def test_quasi_periodic_series_gives_zero_whatever_its_mean():
    golden = 2.0 * math.pi * 0.5 * (math.sqrt(5.0) - 1.0)
    swing = np.cos(golden * np.arange(2000))
    for mean in (0.0, 0.3, 5.0):
        assert abs(zero_one_test(mean + swing).value) < 0.1


def test_displacement_is_the_mean_over_pairs():
    """Against the definition, term by term; sums of 300 numbers of size 10 err by 1e-12 of their squares."""
    phi, c, longest = logistic(3.9, 300), 1.3, 30
    z = np.cumsum(phi * np.exp(1j * c * np.arange(1, 301)))
    expected = [np.mean(np.abs(z[n : n + 270] - z[:270]) ** 2) for n in range(1, longest + 1)]
    assert lyapunov._displacement(phi, c, longest) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(
    ("series", "complaint"),
    [
        (np.zeros(50), "at least 200"),
        (np.zeros((300, 2)), "at least 200"),
        ("chaos", "numbers, one per period"),
        (np.full(300, np.nan), "finite"),
    ],
)
def test_what_is_no_series_is_refused(series, complaint):
    with pytest.raises(ValueError, match=complaint):
        zero_one_test(series)


# --- exponents -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_damped_linear_oscillator(plain):
    """x'' + c x' + k x = drive: the exponents are the roots of s^2 + c s + k, here real; their sum is -c anyway."""
    with np.errstate(all="ignore"):
        exponent = lyapunov_exponent(oscillator(1.25, 0.25), periods=40, transient=0, tolerance=1e-11)
    assert exponent.finished
    assert exponent.spectrum == pytest.approx([-0.25, -1.0], abs=2e-9)
    assert exponent.spectrum[0] == exponent.value


@pytest.mark.slow
def test_exponent_of_an_orbit_is_its_multiplier():
    """A pair of complex ones: within the error, and their sum without any."""
    orbit = vc.orbit(capsule(), initial=START)
    exponent = lyapunov_exponent(capsule(), orbit.state, transient=10)
    expected = math.log(abs(orbit.multipliers[0])) / orbit.period
    assert abs(exponent.value - expected) < exponent.error < 1e-3
    assert exponent.spectrum[:2].sum() == pytest.approx(2.0 * expected, abs=1e-8)
    assert exponent.spectrum[2] == -math.inf  # what sticking forgets


# --- classes ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_classes_of_motions():
    period_one = classify(capsule(), START)
    assert (period_one.kind, period_one.response_period, period_one.symmetric) == ("period-1", 1, False)
    still = classify(capsule(**{"machine.stiffness": 4.0, "machine.damping": 1.2}), START)
    assert (still.kind, still.symmetric, still.drift) == ("period-1", True, 0.0)
    eight = classify(capsule(vc.LuGre(bristle_damping=1.0)), START)
    assert eight.kind == "period-8"  # modulo X, where the paper's figures show LM with its larger delta1
    assert eight.drift == pytest.approx(0.1922473710, abs=1e-9)
    chaotic = classify(CHAOTIC, START)
    assert (chaotic.kind, chaotic.symmetric, chaotic.response_period) == ("chaotic", True, None)
    assert chaotic.lyapunov.value > 0.05
    assert abs(chaotic.drift) < 4.0 * chaotic.drift_error


@pytest.mark.slow
def test_two_frequencies_without_a_common_period_are_quasi_periodic():
    """An undamped oscillator at sqrt(2) under a drive at 1: nothing grows, nothing decays."""
    kind = classify(oscillator(0.0, 2.0), {"position": 1.0}, settle_periods=100)
    assert kind.kind == "quasi-periodic"
    assert kind.lyapunov is not None
    assert abs(kind.lyapunov.value) < kind.lyapunov.error < 1e-3
    assert kind.lyapunov.spectrum.sum() == pytest.approx(0.0, abs=1e-10)


def decided(value, error, chaos, stays=True):
    growth = LyapunovExponents(value, error, np.array([value]), np.array([error]), 900, True)
    test = ZeroOneTest(chaos, np.array([chaos]), np.array([1.0]), 1000)
    return classification._decided(growth, test, 2.0 * math.pi, stays)[0]


def test_both_numbers_have_to_agree():
    assert decided(0.1, 0.005, 0.99) == "chaotic"
    assert decided(0.1, 0.005, 0.5) == "not settled"
    assert decided(0.1, 0.05, 0.99) == "not settled"
    assert decided(1e-5, 1e-5, 0.01) == "quasi-periodic"
    assert decided(1e-5, 1e-5, 0.01, stays=False) == "not settled"
    assert decided(-0.01, 1e-4, 0.01) == "not settled"
    assert decided(1e-4, 1e-5, 0.1) == "quasi-periodic"  # 6e-4 a period is none, 3e-3 is some
    assert decided(1e-4, 1e-5, 0.5) == decided(5e-4, 1e-5, 0.1) == "not settled"
    assert decided(1e-4, 5e-4, 0.1) == "quasi-periodic"
    assert decided(1e-4, 5e-3, 0.1) == "not settled"  # so large an error tells nothing


def test_multiplier_pair_on_the_circle_is_quasi_periodic():
    def kind(*multipliers):
        orbit = vc.Orbit(
            system=capsule(), state={"angle": 0.1}, period=2.0 * math.pi, response_period=1, drift=0.3,
            multipliers=np.array(multipliers, dtype=complex), residual=1e-15, symmetric=False,
            derivative=np.zeros((4, 4)), status=vc.OrbitStatus.CONVERGED, iterations=1, tolerance=1e-12,
        )  # fmt: skip
        return classification.class_of_orbit(orbit).kind

    pair = np.exp(1j), np.exp(-1j)
    assert kind(*pair, 0.0) == "quasi-periodic"
    assert kind(0.999 * pair[0], 0.999 * pair[1], 0.0) == "period-1"
    assert kind(0.5, 0.0, 0.0) == "period-1"


@pytest.mark.parametrize(
    ("function", "arguments", "complaint"),
    [
        (lyapunov_exponent, {"initial": {"angel": 1.0}}, "did you mean 'angle'"),
        (lyapunov_exponent, {"periods": 5}, "periods should be a whole number from 20"),
        (lyapunov_exponent, {"transient": -1}, "transient should be"),
        (lyapunov_exponent, {"tolerance": 1.0}, "tolerance should be"),
        (classify, {"settle_periods": 1.5}, "settle_periods should be a whole number from 10"),
        (classify, {"periods": 100}, "periods should be a whole number from 200"),
    ],
)
def test_bad_input_is_refused(function, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        function(capsule(vc.Exponential()), **arguments)
