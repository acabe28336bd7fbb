"""Closed forms of the friction laws that have pieces, and of the wrappers, driven by SciPy: nothing of the engine."""

import itertools
import math
import random

import numpy as np
import pytest

import vibrocap as vc
from imposed_motion import stroke
from vibrocap.contracts.samples import settled_pieces

SPEED = 0.01


def strokes_between(law, turns, *, speed=SPEED, load=1.0, internal=None, samples=400):
    """Strokes at constant speed from place 0 to each of the places in turn; each begins with a reversal."""
    strokes, place = [], 0.0
    for i, target in enumerate(turns):
        velocity = math.copysign(speed, target - place)
        duration = abs(target - place) / speed
        turned = i > 0
        strokes.append(
            stroke(law, velocity, duration, internal, load=load, turned=turned, samples=samples, tolerance=1e-11)
        )
        internal, place = strokes[-1].end, target
    return strokes


# --- Bouc-Wen --------------------------------------------------------------------------------------------------------


def test_bouc_wen_virgin_curves():
    """z = tanh y for n = 2 and 1 - exp(-y) for n = 1, with A = beta + gamma and y = A x/Y."""
    for exponent, curve in ((2.0, np.tanh), (1.0, lambda y: -np.expm1(-y))):
        law = vc.BoucWen(knee_exponent=exponent, dissipative_shape=0.7, elastic_shape=0.3)
        found = stroke(law, SPEED, 1.0, load=1.4)
        y = found.displacement * 100.0 / (1.4 * 0.15)
        assert np.abs(found.friction - 1.4 * 0.15 * curve(y)).max() <= 1e-8


def test_bouc_wen_unloads_along_its_own_curve():
    """beta = gamma: straight, with the stiffness A delta0, until z = 0; then the virgin curve of the other side."""
    law = vc.BoucWen(bristle_stiffness=80.0, coulomb_coefficient=0.2)
    there, back = strokes_between(law, (0.05, 0.0))
    assert there.friction[-1] == pytest.approx(0.2, rel=1e-9)
    x = -back.displacement
    straight = x <= 0.2 / 80.0
    expected = np.where(straight, 0.2 - 80.0 * x, -0.2 * np.tanh(80.0 * x / 0.2 - 1.0))
    assert np.abs(back.friction - expected).max() <= 1e-7
    assert [which for _, which, *_ in back.switches] == [0]


def test_bouc_wen_level():
    """N eta_c (A/(beta + gamma))^(1/n)."""
    law = vc.BoucWen(amplitude=1.5, dissipative_shape=0.4, elastic_shape=0.2, knee_exponent=3.0)
    found = stroke(law, -SPEED, 5.0, load=0.8)
    assert found.friction[-1] == pytest.approx(-0.8 * 0.15 * 2.5 ** (1 / 3), rel=1e-9)
    with pytest.raises(ValueError, match=r"elastic_shape: should not be -dissipative_shape, got -0\.5"):
        vc.BoucWen(elastic_shape=-0.5)
    with pytest.raises(ValueError, match="knee_exponent"):
        vc.BoucWen(knee_exponent=0.5)


def test_bouc_wen_that_hardens_grows_exponentially():
    """beta + gamma = -s: z = (A/s) (exp(s x/Y) - 1), without a steady force."""
    law = vc.BoucWen(amplitude=1.5, dissipative_shape=0.4, elastic_shape=-0.9, knee_exponent=1.0)
    pulled = stroke(law, SPEED, 0.005)
    expected = 0.15 * 3.0 * np.expm1(0.5 * pulled.displacement / (0.15 / 100.0))
    assert pulled.friction == pytest.approx(expected, rel=1e-9)
    assert law.steady_force(1.0, 1.0) == math.inf


@pytest.mark.parametrize("elastic_shape", [-0.1, 1.5])
def test_bouc_wen_takes_energy_from_any_motion_from_rest(elastic_shape):
    """The work since the start is not negative, even where the split of the losses is (gamma = 1.5 > beta)."""
    law = vc.BoucWen(dissipative_shape=0.2, elastic_shape=elastic_shape)
    assert law.passive
    draw = random.Random(str(elastic_shape))
    for _ in range(3):
        places = list(itertools.accumulate((draw.uniform(-1, 1) for _ in range(8)), initial=0.0))[1:]
        work = 0.0
        for half in strokes_between(law, [2e-3 * place for place in places]):
            course = work + np.concatenate(
                ([0.0], np.cumsum(0.5 * (half.friction[1:] + half.friction[:-1]) * np.diff(half.displacement)))
            )
            assert course.min() >= -1e-9
            work = course[-1]
        assert work > 0.0


# --- elasto-plastic --------------------------------------------------------------------------------------------------


def drift(law, cycles, low=0.3, high=0.6):
    """Displacement in which a contact ends after its friction force has gone between two shares of eta_c.

    A quasi-static force is imposed: the bristle must carry it, and the contact moves by xi'/(1 - p |xi|/g).
    """
    place, strokes = 0.0, []
    internal, force = (0.0,) * len(law.internal), 0.0
    for i in range(2 * cycles):
        target = 0.15 * (high if i % 2 == 0 else low)
        side = 1 if target > force else -1
        internal = law.after_reversal(internal, side, 1.0) if i else internal
        steps = 40
        for _ in range(steps):
            internal = settled_pieces(law, 1e-9 * side, internal, side, 1.0)
            middle = (0.5 * ((target - force) / steps) + law.bristle_stiffness * internal[0]) / law.bristle_stiffness
            at_middle = (middle, *internal[1:])
            slope = law.force(1e-9 * side, at_middle, side, 1.0)[1][0] / (1e-9 * side)
            place += (target - force) / steps / law.bristle_stiffness / slope
            internal = (internal[0] + (target - force) / steps / law.bristle_stiffness, *internal[1:])
        force = target
        strokes.append(place)
    return strokes


def test_elasto_plastic_contact_does_not_drift_where_lugre_does():
    """Below z_ba it returns to the same place to rounding; LuGre moves on by the same amount in each cycle."""
    share = {"bristle_damping": 0.0, "coulomb_coefficient": 0.15, "static_coefficient": 0.15}
    plastic = drift(vc.ElastoPlastic(**share, elastic_share=0.65), 50)
    assert np.ptp(plastic[1::2]) <= 50 * 1e-18
    lugre = drift(vc.LuGre(**share), 50)
    per_cycle = np.diff(lugre[1::2])
    g = 0.15 / 100.0  # up: dx = dxi/(1 - u), down: dx = dxi/(1 + u), u = xi/g
    expected = g * (math.log((1 - 0.3) / (1 - 0.6)) + math.log((1 + 0.3) / (1 + 0.6)))
    assert per_cycle == pytest.approx(expected, rel=1e-3)
    assert (vc.LuGre.creeps, vc.ElastoPlastic.creeps) == (True, False)


def test_elasto_plastic_range():
    """Elastic, xi = x, up to z_ba; then yielding to the steady deflection g(v), which it never passes."""
    law = vc.ElastoPlastic(bristle_damping=0.0, elastic_share=0.6)
    found = stroke(law, SPEED, 40.0, load=1.2, samples=40_001)
    x, xi = found.displacement, found.internal[:, 0]
    border = 0.6 * 1.2 * 0.15 / 100.0
    elastic = x <= border
    assert elastic.sum() > 100
    assert np.abs(xi[elastic] - x[elastic]).max() <= 1e-14
    assert np.all(np.diff(xi) >= -1e-12)
    g = law.steady_force(SPEED, 1.2) / 100.0
    assert xi.max() <= g * (1 + 1e-9)
    assert xi[-1] == pytest.approx(g, rel=1e-9)
    (time, which, *_), *others = found.switches
    assert (which, others) == (0, [])
    assert time == pytest.approx(border / SPEED, rel=1e-5)
    beyond = np.searchsorted(x, 1.5 * border)
    share = 0.5 + 0.5 * math.sin(math.pi * (xi[beyond] - 0.5 * (g + border)) / (g - border))
    slope = (xi[beyond + 1] - xi[beyond - 1]) / (x[beyond + 1] - x[beyond - 1])
    assert slope == pytest.approx(1.0 - share * xi[beyond] / g, rel=1e-4)


def test_a_branch_changes_once_at_an_instant():
    """Implicit steps know a guard less well between their ends: what only the dense output saw is no event. Before, 14
    of 312 changes were undone at once."""
    system = vc.System(vc.Oscillator(), vc.ElastoPlastic(), vc.Harmonic(1.8, 1.0))
    motion = vc.simulate(system, periods=20, tolerance=1e-5)
    times = np.array([event.time for event in motion.events])
    assert motion.certificate.implicit_steps > 1000
    assert np.min(np.diff(times)) > 1e-6


def test_elasto_plastic_contact_flows_when_the_level_falls():
    """While it speeds up, g(v) falls below xi: p = 1, as LuGre's law relaxes; unloading after a reversal is elastic."""
    law = vc.ElastoPlastic(bristle_damping=0.0)
    slow = stroke(law, SPEED, 40.0, samples=2)
    faster = stroke(law, lambda t: SPEED + 0.3 * t, 1.0, slow.end)
    assert [which for _, which, *_ in faster.switches][:1] == [1]
    assert faster.internal[-1, 2] == 1.0
    lugre = stroke(vc.LuGre(bristle_damping=0.0), lambda t: SPEED + 0.3 * t, 1.0, slow.end[:1])
    assert np.abs(faster.friction - lugre.friction).max() <= 1e-5
    back = stroke(law, -SPEED, 0.05, faster.end, turned=True)
    assert np.abs(np.diff(back.internal[:, 0]) - np.diff(back.displacement)).max() <= 1e-14


# --- generalised Maxwell-slip ----------------------------------------------------------------------------------------

IWAN = {"coulomb_coefficient": 0.3, "static_coefficient": 0.3}


def virgin_maxwell(law, x, load):
    """Sum of min(k_i x, nu_i s)."""
    level = load * law.coulomb_coefficient
    shares = (law.share_1, law.share_2, law.share_3, 1.0 - law.share_1 - law.share_2 - law.share_3)
    stiffness = (law.stiffness_1, law.stiffness_2, law.stiffness_3, law.stiffness_4)
    return sum(np.minimum(k * x, share * level) for k, share in zip(stiffness, shares, strict=True))


def test_maxwell_slip_virgin_curve_and_masings_rule():
    """Piecewise linear; a branch after a reversal is the virgin curve twice as large."""
    law, load = vc.MaxwellSlip(**IWAN), 1.3
    there, back, again = strokes_between(law, (0.008, -0.008, 0.008), load=load)
    assert np.abs(there.friction - virgin_maxwell(law, there.displacement, load)).max() <= 1e-9
    assert 1 < len(there.switches) < 4  # some elements slip, some do not
    for branch, sign in ((back, -1), (again, 1)):
        start = branch.friction[0]
        expected = start + sign * 2 * virgin_maxwell(law, np.abs(branch.displacement) / 2, load)
        assert np.abs(branch.friction - expected).max() <= 1e-9
    assert again.friction[-1] == pytest.approx(there.friction[-1], abs=1e-10)


def test_maxwell_slip_remembers_where_it_turned():
    """An inner loop closes and is forgotten: the force goes on as if it had not been (nonlocal memory)."""
    law = vc.MaxwellSlip(**IWAN)
    plain = strokes_between(law, (0.01, -0.006))
    visited = strokes_between(law, (0.01, 0.002, 0.006, -0.006))
    assert visited[-1].friction[-1] == pytest.approx(plain[-1].friction[-1], abs=1e-10)
    inner = strokes_between(law, (0.01, 0.002, 0.006, 0.002))
    assert inner[-1].friction[-1] == pytest.approx(inner[1].friction[-1], abs=1e-10)
    assert inner[-1].end[:4] == pytest.approx(inner[1].end[:4], abs=1e-10)


def test_slipping_elements_follow_the_level():
    """After a step of speed every element moves from nu_i s(v1) to nu_i s(v2) like exp(-N C t/s(v2))."""
    law, load = vc.MaxwellSlip(), 1.4
    slow = stroke(law, 0.02, 3.0, load=load, samples=2)
    assert slow.friction[-1] == pytest.approx(law.steady_force(0.02, load), rel=1e-9)
    fast = stroke(law, 0.15, 0.5, slow.end, load=load)
    first, last = law.steady_force(0.02, load), law.steady_force(0.15, load)
    expected = last + (first - last) * np.exp(-load * 5.0 * fast.time / last)
    assert np.abs(fast.friction - expected).max() <= 1e-8
    assert fast.internal[-1, 4:].tolist() == [1.0] * 4
    shares = fast.internal[:, :4] / fast.internal[:, :4].sum(axis=1)[:, None]
    assert np.abs(shares - [0.1, 0.2, 0.3, 0.4]).max() <= 1e-9


def test_maxwell_slip_says_when_it_can_give_energy():
    """With a droop a slowing contact is pulled forward; with equal levels it is not."""
    assert vc.MaxwellSlip(**IWAN).passive
    assert not vc.MaxwellSlip().passive
    slow = stroke(vc.MaxwellSlip(), 0.3, 3.0, samples=2)
    lost, _ = vc.MaxwellSlip().losses(1e-3, slow.end, 1, 1.0)
    assert lost < 0.0
    with pytest.raises(ValueError, match=r"share_1, share_2 and share_3: should add up to less than 1, got 1\.1"):
        vc.MaxwellSlip(share_1=0.6)


# --- anisotropic -----------------------------------------------------------------------------------------------------


def test_anisotropic_levels_and_what_is_held():
    law = vc.anisotropic(vc.Exponential)(forward_ratio=0.8, back_ratio=1.5)
    plain = vc.Exponential()
    assert law.force(0.2, (), 1, 1.1)[0] == pytest.approx(0.8 * plain.steady_force(0.2, 1.1), rel=1e-14)
    assert law.force(-0.2, (), -1, 1.1)[0] == pytest.approx(-1.5 * plain.steady_force(0.2, 1.1), rel=1e-14)
    assert law.holding_centre(1.1) + law.holding_limit(1.1) == pytest.approx(0.8 * 1.1 * 0.45, rel=1e-14)
    assert law.holding_centre(1.1) - law.holding_limit(1.1) == pytest.approx(-1.5 * 1.1 * 0.45, rel=1e-14)
    assert not law.symmetric
    assert vc.anisotropic(vc.Exponential)(forward_ratio=1.2, back_ratio=1.2).symmetric
    assert vc.anisotropic(vc.Exponential) is vc.anisotropic(vc.Exponential)


def test_anisotropic_dynamic_law_settles_to_each_level_and_turns_without_a_jump():
    law = vc.anisotropic(vc.Dahl)(forward_ratio=0.7, back_ratio=1.2)
    there, back = strokes_between(law, (0.1, -0.1), load=1.5)
    assert there.friction[-1] == pytest.approx(0.7 * 1.5 * 0.15, rel=1e-9)
    assert back.friction[0] == there.friction[-1]
    assert back.friction[-1] == pytest.approx(-1.2 * 1.5 * 0.15, rel=1e-9)


# --- backlash --------------------------------------------------------------------------------------------------------


def test_backlash_is_crossed_after_every_reversal():
    """From the end of unloading no force over the width of the gap, then the virgin curve of the law behind."""
    gap, law = 0.02, vc.backlash(vc.Dahl)(gap=0.02)
    there, back = strokes_between(law, (0.1, -0.1), samples=2001)
    x = there.displacement - 0.5 * gap
    assert np.abs(there.friction - np.where(x > 0, 0.15 * -np.expm1(-100.0 * x / 0.15), 0.0)).max() <= 1e-8
    unloading = 0.15 / 100.0 * math.log(2.0)  # R = Fc [2 exp(-delta0 x/Fc) - 1]
    x = -back.displacement
    free = (x > unloading + 1e-9) & (x < unloading + gap)
    assert np.all(back.friction[free] == 0.0)
    assert np.all(back.friction[x < unloading] > 0.0)
    engaged = x > unloading + gap
    rest = x[engaged] - unloading - gap
    assert np.abs(back.friction[engaged] + 0.15 * -np.expm1(-100.0 * rest / 0.15)).max() <= 1e-8
    assert [which for _, which, *_ in back.switches] == [0, 1]
    assert back.end[1:] == (-0.5 * gap, -1.0)


def test_backlash_is_not_crossed_by_a_motion_within_it():
    law = vc.backlash(vc.LuGre)(gap=0.02)
    for half in strokes_between(law, (0.009, -0.009, 0.009)):
        assert not half.friction.any()
        assert half.switches == ()
    assert half.end == (0.0, pytest.approx(0.009), 0.0)


def test_backlash_unloads_deflections_and_keeps_ages():
    lugre = vc.backlash(vc.anisotropic(vc.LuGre))(gap=0.02)
    there, back = strokes_between(lugre, (0.1, 0.05))
    (_, which, before, after), _ = back.switches
    assert which == 0
    assert before[0] > 0.0  # with damped bristles the force is gone before the deflection
    assert after == (0.0, 0.01, 0.0)
    ageing = vc.backlash(vc.RateAndStateAgeing)(gap=0.02)
    there, back = strokes_between(ageing, (0.1, 0.05))
    for _, which, before, after in back.switches:
        assert before[0] == after[0] != 0.0
        assert which in (0, 1)
    assert there.internal[-1, 0] == pytest.approx(math.log(0.1 / SPEED), abs=1e-4)
    free = back.internal[:, 2] == 0.0
    assert np.all(np.diff(back.internal[free, 0]) > 0.0)  # it ages in the gap
