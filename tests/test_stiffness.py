"""Time scales of laws: closed forms, differences, and what a Runge-Kutta method does at the step that is reported."""

import math

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.laboratory.stiffness import stiffness_report
from vibrocap.physics.catalogue import laws
from vibrocap.physics.friction.wrappers import smoothed


def steady_level(law, speed, load=1.0):
    drop = law.static_coefficient - law.coulomb_coefficient
    return load * (law.coulomb_coefficient + drop * np.exp(-((speed / law.stribeck_velocity) ** law.stribeck_exponent)))


def runge_kutta(rate, state, step, count):
    """States after steps of the classical method."""
    for _ in range(count):
        k1 = rate(state)
        k2 = rate(state + 0.5 * step * k1)
        k3 = rate(state + 0.5 * step * k2)
        k4 = rate(state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return state


@pytest.mark.parametrize(
    ("law", "load"),
    [(vc.LuGre(), 1.0), (vc.LuGre(bristle_stiffness=740.0, viscous_damping=0.3, stribeck_exponent=0.8), 3.5)],
)
def test_lugre_relaxes_over_its_bristles_length(law, load):
    speeds = [1e-4, 0.03, 0.1, 0.7, 5.0]
    report = stiffness_report(law, load, speeds, mass=2.0)
    v = np.array(speeds)
    length = steady_level(law, v, load) / law.bristle_stiffness
    np.testing.assert_allclose(report.internal[:, 0], length, rtol=1e-8)
    np.testing.assert_allclose(report.eigenvalues[:, 0], -v / length, rtol=1e-12)
    np.testing.assert_allclose(report.relaxation_distance, length, rtol=1e-12)
    np.testing.assert_allclose(report.relaxation_time, length / v, rtol=1e-12)
    assert report.contact_stiffness == pytest.approx(law.bristle_stiffness, rel=1e-6)
    damping = law.bristle_damping + law.viscous_damping
    assert report.contact_damping == pytest.approx(damping, rel=1e-6)
    assert report.natural_frequency == pytest.approx(math.sqrt(law.bristle_stiffness / 2.0), rel=1e-6)
    ratio = damping / (2.0 * math.sqrt(2.0 * law.bristle_stiffness))
    assert report.damping_ratio == pytest.approx(ratio, rel=1e-6)


@pytest.mark.parametrize("law", [vc.LuGre(), laws()["stribeck"](), laws()["stribeck"](viscous_damping=0.9)])
def test_growth_is_that_of_the_falling_branch(law):
    speeds = np.geomspace(1e-3, 1.0, 400)
    report = stiffness_report(law, 2.0, speeds, mass=3.0)
    above, below = (np.array([law.steady_force(float(v) * f, 2.0) for v in speeds]) for f in (1.0001, 0.9999))
    slope = (above - below) / (0.0002 * speeds)
    np.testing.assert_allclose(report.steady_slope, slope, rtol=1e-5, atol=1e-6 * np.max(np.abs(slope)))
    least = int(np.argmin(slope))
    assert report.growth_speed == speeds[least]
    assert report.growth_rate == pytest.approx(max(0.0, -slope[least] / 3.0), rel=1e-5)


def test_mass_and_contact_together_are_the_linearised_motion():
    """Of m v' = pull - R(v, z), z' = f(v, z) about steady sliding, by central differences of the law."""
    law, mass, load = vc.LuGre(viscous_damping=0.2), 3.5, 1.4
    report = stiffness_report(law, load, [0.02, 0.3], mass=mass)
    for i, v in enumerate(report.speeds):
        z = float(report.internal[i, 0])

        def rates(y):
            force, (rate,) = law.force(y[0], (y[1],), 1, load)
            return np.array([-force / mass, rate])

        matrix = np.empty((2, 2))
        for j, step in enumerate((1e-6 * v, 1e-6 * z)):
            change = step * np.eye(2)[j]
            matrix[:, j] = (rates(np.array([v, z]) + change) - rates(np.array([v, z]) - change)) / (2.0 * step)
        expected = np.sort_complex(np.linalg.eigvals(matrix).astype(complex))
        np.testing.assert_allclose(np.sort_complex(report.sliding_eigenvalues[i]), expected, rtol=1e-6)
        assert report.fastest_rate[i] == pytest.approx(np.max(np.abs(expected)), rel=1e-6)


def test_explicit_step_is_where_the_runge_kutta_method_turns_unstable():
    law = vc.LuGre()
    report = stiffness_report(law, speeds=[0.4])
    step, steady = float(report.explicit_step[0]), float(report.internal[0, 0])

    def rate(z):
        return law.force(0.4, (z,), 1, 1.0)[1][0]

    start = 1.01 * steady
    assert abs(runge_kutta(rate, start, 0.98 * step, 400) - steady) < 1e-3 * abs(start - steady)
    assert abs(runge_kutta(rate, start, 1.02 * step, 400) - steady) > 1e3 * abs(start - steady)


def test_laws_relax_as_their_equations_say():
    dahl = stiffness_report(laws()["dahl"](), speeds=[0.2, 3.0])
    np.testing.assert_allclose(dahl.eigenvalues[:, 0], -100.0 * dahl.speeds / 0.15, rtol=1e-6)
    np.testing.assert_allclose(dahl.internal[:, 0], 1.5e-3, rtol=1e-6)
    ageing = laws()["rate-and-state-ageing"]()
    state = stiffness_report(ageing, speeds=[0.01, 0.5])
    np.testing.assert_allclose(state.eigenvalues[:, 0], -state.speeds / ageing.critical_distance, rtol=1e-6)
    slip = laws()["maxwell-slip"]()
    elements = stiffness_report(slip, 2.0, [0.05, 0.4])
    following = 2.0 * slip.attraction_rate / steady_level(slip, elements.speeds, 2.0)
    assert elements.eigenvalues.shape == (2, 4)  # the pieces, which are whole numbers, have no rates
    np.testing.assert_allclose(elements.eigenvalues, np.repeat(-following[:, None], 4, axis=1), rtol=1e-8)
    assert elements.contact_stiffness == pytest.approx(40.0 + 30.0 + 20.0 + 10.0)


def test_set_valued_laws_bring_no_time():
    report = stiffness_report(vc.Exponential(), mass=3.5)
    assert report.eigenvalues.shape == (25, 0)
    np.testing.assert_allclose(report.speeds[[0, -1]], [1e-4, 1.0])  # its own speed is 1/a
    assert np.all(report.relaxation_rate == 0.0)
    assert np.all(np.isinf(report.relaxation_time))
    assert report.contact_stiffness == report.contact_damping == 0.0
    assert math.isnan(report.damping_ratio)
    assert "No internal states" in report.text
    assert "a mode of its own" in report.method


def test_smoothed_sign_is_stiff_at_rest():
    """Slope N eta_s/width at rest: with a mass its inverse is the time to resolve."""
    law = smoothed(vc.Exponential)(smoothing_velocity=1e-4)
    report = stiffness_report(law, 2.0, mass=3.5, duration=6.28)
    assert report.contact_damping == pytest.approx(2.0 * 0.45 / 1e-4, rel=1e-6)
    assert f"{2.785 * 3.5 * 1e-4 / 0.9:.3g} near rest" in report.method
    assert "L-stable" in report.method
    assert "give a mass" in stiffness_report(law).method
    wide = smoothed(vc.Exponential)(smoothing_velocity=0.1)
    assert "an explicit method serves" in stiffness_report(wide, 2.0, mass=3.5, duration=6.28).method


def test_method_depends_on_what_a_motion_lasts():
    """LuGre at speed 1: 0.0015/1 to relax over, so 1500 explicit steps within a period of 2 pi, 150 within a tenth."""
    short, long = (stiffness_report(vc.LuGre(), speeds=[1.0], duration=d).method for d in (0.628, 6.28))
    assert "an explicit method serves" in short
    assert "use an L-stable method" in long
    assert f"{6.28 / 0.0015 / 2.785:.3g} within 6.28" in long
    assert "much longer than 1000 of them" in stiffness_report(vc.LuGre()).method


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"load": -1.0}, "load should be a positive number, got -1.0"),
        ({"mass": 0.0}, "mass should be a positive number, got 0.0"),
        ({"duration": math.inf}, "duration should be a positive number, got inf"),
        ({"speeds": [0.1, 0.0]}, "speeds should be a list of positive numbers"),
        ({"speeds": []}, "speeds should be a list of positive numbers"),
    ],
)
def test_wrong_arguments_are_named(arguments, words):
    with pytest.raises(ValueError, match=words):
        stiffness_report(vc.LuGre(), **arguments)
