"""Viscous friction beside a law, linear and quadratic, against an independent solver and closed forms."""

import math

import pytest

import vibrocap as vc

pytestmark = pytest.mark.plain

BLOCK = vc.Oscillator(mass=1.0, stiffness=0.0, damping=0.0, normal_load=1.0)
DRIVE = vc.Harmonic(amplitude=25.0, frequency=math.pi / 2)  # from the time 3 on: 25 sin(pi t/2)
DROP = {"coulomb_coefficient": 5.0, "static_coefficient": 15.0, "decay_rate": 2.0}


LAWS = {
    "linear": vc.viscous(vc.Exponential)(**DROP, linear_viscosity=1.0),
    "quadratic": vc.viscous(vc.Exponential)(**DROP, linear_viscosity=1.0, quadratic_viscosity=0.3),
    "curve": vc.Stribeck(5.0, 15.0, stribeck_velocity=0.5, stribeck_exponent=1.0, viscous_damping=1.0),
}


@pytest.mark.parametrize(
    ("name", "place", "velocity"),
    [
        ("linear", 1.76851781138, 6.864840371102),
        ("quadratic", 1.503894225811, 5.400450651404),
        ("curve", 1.76851781138, 6.864840371102),
    ],
)
def test_a_block_under_a_push_is_where_other_solvers_have_it(name, place, velocity):
    """A block of 1 kg under 25 sin(pi t/2) and F(v) = c_1 v + c_2 v^2 + 5 + 10 exp(-2 v), by DOP853 between events.

    v + 5 + 10 exp(-2 v) is a Stribeck curve of exponent 1 with viscous friction, too.
    """
    system = vc.System(BLOCK, LAWS[name], DRIVE)
    motion = vc.simulate(system, periods=1.25, start=3.0, tolerance=1e-12)
    assert motion.end - motion.start_time == 5.0
    assert motion.state["position"] == pytest.approx(place, abs=1e-11)
    assert motion.state["sliding_velocity"] == pytest.approx(velocity, abs=1e-10)
    assert motion.certificate.ok


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_thrown_block_stops_where_the_closed_form_says(side):
    """m v' = -(F + c v^2): it stops after atan(v_0 w)/(c w) with w = sqrt(c/F), m ln(1 + c v_0^2/F)/(2 c) away."""
    level, square, speed = 0.3, 0.8, 1.7
    law = vc.viscous(vc.Coulomb)(level, level, quadratic_viscosity=square)
    system = vc.System(BLOCK, law, vc.Constant())
    motion = vc.simulate(system, periods=6, initial={"sliding_velocity": side * speed}, tolerance=1e-12)
    (event,) = motion.events
    assert event.kind == "stick"
    assert event.time == pytest.approx(
        math.atan(speed * math.sqrt(square / level)) / math.sqrt(square * level), rel=1e-11
    )
    away = math.log1p(square * speed**2 / level) / (2.0 * square)
    assert side * motion.state["position"] == pytest.approx(away, rel=1e-11)
    lost = vc.energy_balance(motion).contact_sliding
    assert lost == pytest.approx(-0.5 * speed**2, rel=1e-11)


def test_what_does_not_fit_is_refused_and_names_and_pickles_lead_back():
    for law, words in (
        (vc.SmoothedTanh, "which is smooth"),
        (vc.viscous(vc.Coulomb), "viscous already"),
        (vc.backlash(vc.LuGre), r"backlash\(viscous\(...\)\)"),
    ):
        with pytest.raises(ValueError, match=words):
            vc.viscous(law)
    law = vc.anisotropic(vc.viscous(vc.Coulomb))(linear_viscosity=0.2, quadratic_viscosity=0.1, back_ratio=1.4)
    assert law.name == "anisotropic-viscous-coulomb"
    assert not law.symmetric
    backward = law.force(-2.0, (), -1, 3.0)[0]
    assert backward == pytest.approx(-(0.15 * 1.4 * 3.0 + 0.4 + 0.4), rel=1e-15)
