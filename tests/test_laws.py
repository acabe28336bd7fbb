"""Closed forms of each friction law without pieces, driven by SciPy or read off directly: nothing of the engine."""

import math

import numpy as np
import pytest

import vibrocap as vc
from imposed_motion import stroke

EPSILON = float(np.finfo(float).eps)


# --- functions of velocity -------------------------------------------------------------------------------------------


def test_coulomb_has_two_levels_and_a_jump():
    law = vc.Coulomb(coulomb_coefficient=0.2, static_coefficient=0.5)
    forces = [law.force(v, (), side, 1.5)[0] for v, side in ((0.0, 1), (0.3, 1), (-7.0, -1))]
    assert forces == pytest.approx([0.3, 0.3, -0.3], rel=4 * EPSILON)
    assert law.holding_limit(1.5) == 0.75
    with pytest.raises(ValueError, match="static_coefficient: should be at least coulomb_coefficient"):
        vc.Coulomb(coulomb_coefficient=0.5, static_coefficient=0.2)


def test_stribeck_is_the_exponential_law_the_gaussian_and_any_between():
    exponential = vc.Exponential(decay_rate=4.0)
    likewise = vc.Stribeck(stribeck_velocity=0.25, stribeck_exponent=1.0)
    for v in (0.0, 0.03, 0.7):
        assert likewise.steady_force(v, 1.3) == pytest.approx(exponential.steady_force(v, 1.3), rel=4 * EPSILON)
    for exponent in (0.5, 1.6, 2.0, 3.0):
        law = vc.Stribeck(stribeck_exponent=exponent, viscous_damping=0.4)
        v = 0.08
        expected = 1.3 * (0.15 + 0.3 * math.exp(-((v / 0.1) ** exponent))) + 0.4 * v
        assert law.steady_force(v, 1.3) == pytest.approx(expected, rel=1e-12)


def test_hyperbolic_stribeck_is_leines_curve():
    """eta_c = 0: |R| = Fs/(1 + delta |v|), with his delta = 3."""
    law = vc.HyperbolicStribeck(coulomb_coefficient=0.0, static_coefficient=1.0, stribeck_velocity=1 / 3)
    for v in (0.0, 0.2, 5.0):
        assert law.steady_force(v, 1.0) == pytest.approx(1.0 / (1.0 + 3.0 * v), rel=4 * EPSILON)
    assert vc.HyperbolicStribeck(viscous_damping=0.3).steady_force(0.1, 1.0) == pytest.approx(
        0.3 + 0.03, rel=4 * EPSILON
    )


@pytest.mark.parametrize(
    ("kind", "slope", "rest"),
    [
        (vc.SmoothedTanh, 1.0, lambda x: 2 * math.exp(-2 * x)),
        (vc.SmoothedArctan, 2 / math.pi, lambda x: 2 / (math.pi * x)),
    ],
)
def test_smoothed_laws_are_the_stribeck_law_beyond_their_width(kind, slope, rest):
    """Slope N eta_s S'(0) at rest; beyond, with equal levels, 1 - S is lost; v S stands for |v| in the droop."""
    width = 2e-4
    smoothed, exact = kind(smoothing_velocity=width, viscous_damping=0.2), vc.Stribeck()
    at_rest = smoothed.force(1e-9, (), 1, 1.3)[0] / 1e-9
    assert at_rest == pytest.approx(1.3 * 0.45 * slope / width + 0.2, rel=1e-9)
    level, flat = {"coulomb_coefficient": 0.45}, 1.3 * 0.45
    for x in (6.0, 10.0, 300.0):
        v = x * width
        sign = kind(**level, smoothing_velocity=width).steady_force(v, 1.3) / flat
        assert 1.0 - sign == pytest.approx(rest(x), rel=0.01, abs=2 * EPSILON)
        assert smoothed.steady_force(v, 1.3) == pytest.approx(
            sign * exact.steady_force(v * sign, 1.3) + 0.2 * v, rel=1e-12
        )
    assert smoothed.force(0.07, (), 1, 1.0) == smoothed.force(0.07, (), -1, 1.0)


# --- Dahl ------------------------------------------------------------------------------------------------------------


def virgin_dahl(y, exponent):
    """R/(N eta_c) over y = delta0 x/(N eta_c), from dr/dy = (1 - r)^i."""
    if exponent == 1.0:
        return 1.0 - np.exp(-y)
    return 1.0 - (1.0 + (exponent - 1.0) * y) ** (-1.0 / (exponent - 1.0))


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 3.0])
def test_dahls_virgin_curve(exponent):
    law = vc.Dahl(shape_exponent=exponent)
    found = stroke(law, 0.01, 1.0, load=1.4)
    expected = 1.4 * 0.15 * virgin_dahl(100.0 * found.displacement / (1.4 * 0.15), exponent)
    assert np.abs(found.friction - expected).max() <= 1e-8
    with pytest.raises(ValueError, match="shape_exponent"):
        vc.Dahl(shape_exponent=0.5)
    faster = stroke(law, lambda t: 0.02 + 0.01 * math.sin(9 * t), 1.0, load=1.4)  # the path counts, not the speed
    expected = 1.4 * 0.15 * virgin_dahl(100.0 * faster.displacement / (1.4 * 0.15), exponent)
    assert np.abs(faster.friction - expected).max() <= 1e-8


@pytest.mark.parametrize(
    "law", [vc.Dahl(), vc.LuGre(static_coefficient=0.15, bristle_damping=0.0)], ids=lambda law: law.name
)
@pytest.mark.parametrize("amplitude", [5e-4, 3e-3])
def test_loop_of_a_contact_at_constant_level(law, amplitude):
    """|xi|max = g tanh(A/g), area 4 Fc [A - g tanh(A/g)] (docs/model.md): one formula for Dahl and LuGre."""
    g = 0.15 / 100.0
    largest = g * math.tanh(amplitude / g)
    there = stroke(law, 0.01, 200 * amplitude, (-largest,), samples=2001, tolerance=1e-11)
    back = stroke(law, -0.01, 200 * amplitude, there.end, turned=True, samples=2001, tolerance=1e-11)
    assert (there.end[0], back.end[0]) == pytest.approx((largest, -largest), rel=1e-8)
    area = sum(np.trapezoid(half.friction, half.displacement) for half in (there, back))
    assert area == pytest.approx(4 * 0.15 * (amplitude - largest), rel=1e-5)  # of the trapezoidal rule


# --- LuGre with a damping that fades ---------------------------------------------------------------------------------


def test_damping_of_the_bristles_fades():
    """R - delta0 xi - delta2 v = delta1 exp(-(v/v_d)^2) xi'; without a damping velocity delta1 xi'."""
    steady, fading = vc.LuGre(), vc.LuGre(damping_velocity=0.2)
    for v, side in ((0.05, 1), (-0.3, -1)):
        (force, rates), (constant, same) = (law.force(v, (0.001,), side, 1.0) for law in (fading, steady))
        assert rates == same
        assert force - 0.1 == pytest.approx((constant - 0.1) * math.exp(-((v / 0.2) ** 2)), rel=1e-12)
    assert fading.steady_force(0.2, 1.0) == steady.steady_force(0.2, 1.0)


def most_excess(law):
    """sup over speeds of delta1(v) (eta_s/l(v) - 1), by brute force."""
    v = np.linspace(0.0, 1.0, 200_001)
    level = law.coulomb_coefficient + (law.static_coefficient - law.coulomb_coefficient) * np.exp(
        -((v / law.stribeck_velocity) ** law.stribeck_exponent)
    )
    return float(
        (law.bristle_damping * np.exp(-((v / law.damping_velocity) ** 2)) * (law.static_coefficient / level - 1)).max()
    )


@pytest.mark.parametrize("damping_velocity", [0.02, 0.1, 0.5])
def test_bound_of_the_viscous_damping_for_passivity_is_sharp(damping_velocity):
    """The cells of `passive` bound the supremum from above, within one per cent."""
    least = most_excess(vc.LuGre(damping_velocity=damping_velocity))
    assert not vc.LuGre(damping_velocity=damping_velocity, viscous_damping=0.999 * least).passive
    assert vc.LuGre(damping_velocity=damping_velocity, viscous_damping=1.01 * least).passive
    assert least < 10.0 * 0.3 / 0.15  # less than what a constant damping asks for


# --- rate and state --------------------------------------------------------------------------------------------------

ROCK = {"reference_coefficient": 0.6, "direct_effect": 0.01, "evolution_effect": 0.014}
ROCK |= {"critical_distance": 1e-5, "reference_velocity": 1e-6}
RATE_AND_STATE = [vc.RateAndStateAgeing(**ROCK), vc.RateAndStateSlip(**ROCK, cutoff_velocity=1e-12)]
each_rate_and_state = pytest.mark.parametrize("law", RATE_AND_STATE, ids=lambda law: law.name)


@each_rate_and_state
def test_steady_rate_and_state_is_logarithmic(law):
    for v in (1e-8, 1e-6, 3e-4):
        assert law.steady_force(v, 2.0) == pytest.approx(2.0 * (0.6 + (0.01 - 0.014) * math.log(v / 1e-6)), rel=1e-7)


@each_rate_and_state
def test_a_step_of_speed_is_answered_at_once_and_then_over_the_critical_distance(law):
    """Up: a ln(v2/v1) at once, then the closed form of the state over the displacement, to -b ln(v2/v1) in the end."""
    slow, fast = 1e-6, 1e-5
    settled = stroke(law, slow, 200.0, samples=2).end
    assert settled[0] == pytest.approx(math.log(1e-6 / slow), abs=1e-8)
    found = stroke(law, fast, 10.0, settled, samples=60)
    assert found.friction[0] - law.steady_force(slow, 1.0) == pytest.approx(0.01 * math.log(fast / slow), rel=1e-6)
    x = found.displacement / 1e-5
    if law.name == "rate-and-state-ageing":  # theta' = 1 - v theta/Dc
        theta = 1e-5 / fast + (1e-5 / slow - 1e-5 / fast) * np.exp(-x)
        state = np.log(theta * 1e-6 / 1e-5)
    else:  # phi' = -(v/Dc) [phi + ln(v/v0)]
        state = math.log(1e-6 / fast) * (1.0 - np.exp(-x))
    assert np.abs(found.internal[:, 0] - state).max() <= 1e-7
    assert np.abs(found.friction - (0.6 + 0.01 * math.log(fast / 1e-6) + 0.014 * state)).max() <= 1e-8


def test_ageing_contact_heals_at_rest_and_the_other_does_not():
    """theta = theta0 + t; with the slip law the state stays."""
    ageing, slip = vc.RateAndStateAgeing(), vc.RateAndStateSlip()
    healed = stroke(ageing, 0.0, 30.0, (0.3,), side=1, samples=50)
    theta0 = 0.01 / 0.1 * math.exp(0.3)
    assert np.abs(healed.internal[:, 0] - np.log((theta0 + healed.time) * 0.1 / 0.01)).max() <= 1e-8
    assert slip.force(0.0, (0.3,), 1, 1.0) == (0.0, (0.0,))


@pytest.mark.parametrize(
    "law", [vc.RateAndStateAgeing(), vc.RateAndStateSlip(), *RATE_AND_STATE], ids=lambda law: law.name
)
def test_rate_and_state_is_regular_at_rest(law):
    """R = 0 there, linear within v0 exp[-(mu0 + b phi)/a], and the asinh of what it says beyond."""
    state = 0.4
    strength = (law.reference_coefficient + law.evolution_effect * state) / law.direct_effect
    width = 2 * law.reference_velocity * math.exp(-strength)
    assert law.force(0.0, (state,), 1, 1.7)[0] == 0.0
    for x in (0.3, 1.0, 40.0, 1e5):
        force = law.force(x * width, (state,), 1, 1.7)[0]
        assert force == pytest.approx(1.7 * law.direct_effect * math.asinh(x), rel=1e-13)
    with pytest.raises(ValueError, match=r"direct_effect: should be at least reference_coefficient/300 = 0\.002"):
        type(law)(reference_coefficient=0.6, direct_effect=0.001)


def test_slip_law_is_cut_off_at_rest():
    """The state goes to ln(v0/|v|) above the cut-off velocity and no further than ln(v0/v_c)."""
    law = vc.RateAndStateSlip(cutoff_velocity=1e-3)
    for v, least in ((0.3, 0.3), (1e-3, math.sqrt(2) * 1e-3), (1e-9, 1e-3)):
        target = math.log(0.1 / least)
        rate = law.force(v, (target,), 1, 1.0)[1][0]
        assert abs(rate) <= 1e-4 * v / 0.01
        assert law.force(v, (target - 0.5,), 1, 1.0)[1][0] == pytest.approx(0.5 * v / 0.01, rel=1e-4)
