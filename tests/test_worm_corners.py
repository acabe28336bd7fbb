"""Worms whose distances change at another rate from one instant on: every contact takes its new side at a corner."""

import math

import pytest

import vibrocap as vc

BRISTLES = {"coulomb_coefficient": 0.1, "static_coefficient": 0.2}
TRIANGLE = vc.Triangle(amplitude=0.3, rise=0.6)
EXAMPLE = vc.System(vc.TwoBodyWorm(mass_2=0.5, actuation=-1.0), vc.LuGre(**BRISTLES), TRIANGLE)
START = {"centre_velocity": 0.1}
GROWN = 30.0  # tolerances, over what a small shift of the start grows to


@pytest.mark.slow
def test_a_contact_with_bristles_keeps_its_velocity_at_a_corner():
    """Body 2 turns at the corner, body 1 some 0.08 later: a further contact was stopped there, and all with it.

    Against an independent solver this motion stands in `test_several_contacts.py`.
    """
    motion = vc.simulate(EXAMPLE, initial=START, periods=3, tolerance=1e-10)
    assert motion.state["position"] == pytest.approx(1.7692, abs=5e-5)
    corner = 0.6 * TRIANGLE.period
    turns = [[event.time for event in motion.events if event.kind == kind] for kind in ("reversal", "reversal_2")]
    first, second = (min(t for t in times if t > corner - 1e-9) for times in turns)
    assert (first, second) == pytest.approx((corner + 0.0785, corner), abs=1e-4)
    # a motion that ends at the corner goes on from there
    begun = vc.simulate(EXAMPLE, initial=START, periods=0.6, tolerance=1e-10)
    rest = vc.simulate(EXAMPLE, start=begun, periods=2.4, tolerance=1e-10)
    for name in ("position", "centre_velocity"):
        assert rest.state[name] == pytest.approx(motion.state[name], abs=GROWN * 1e-10 * 2.0 / 1.5)


@pytest.mark.slow  # its kernel
def test_what_a_contact_at_rest_holds_is_asked_once_the_others_have_turned():
    """Body 1 does not move at the corner; with bodies 2 and 3 on their old sides it could not hold what they push.

    Before it, R_2 + R_3 = 0.4 (1.2 - 1), with forces of the bristles alone; after it, at ten times the speed, bristles
    as they were and their damping: 0.08 + 3 d_2 v - 3 d_3 v, which is 0, but 0.08 - d_2 v + d_3 v = 0.107 on their old
    sides. Body 1 holds 0.1.
    """
    period, rise, slow = 2.0 * math.pi, 0.95, 0.05
    settings = {
        "bristle_stiffness": 50.0,
        "coulomb_coefficient": 0.2,
        "static_coefficient": 0.4,
        "stribeck_velocity": 0.3,
    }
    system = vc.System(
        vc.ThreeBodyWorm(actuation=1.0, actuation_2=-2.0, normal_load_3=1.2),
        [
            vc.Coulomb(0.1, 0.1),
            vc.LuGre(bristle_damping=0.1, **settings),
            vc.LuGre(bristle_damping=0.1 + 0.08 / (3.0 * slow * rise / (1.0 - rise)), **settings),
        ],
        vc.Triangle(amplitude=-0.5 * slow * rise * period, rise=rise),
    )
    motion = vc.simulate(system, periods=1.2)
    assert motion.certificate.ok
    assert [(event.kind, event.time) for event in motion.events] == [
        ("reversal_2", pytest.approx(rise * period)),
        ("reversal_3", pytest.approx(rise * period)),
        ("reversal_2", pytest.approx(period)),
        ("reversal_3", pytest.approx(period)),
    ]
    assert motion.state["position"] == 0.0


@pytest.mark.slow  # its kernel
def test_contacts_that_turn_together_are_all_told():
    """While the distance dwells both bodies move alike, and turn at one instant."""
    system = vc.System(
        vc.TwoBodyWorm(mass_2=0.5), vc.LuGre(**BRISTLES), vc.Trapezoid(amplitude=0.3, rise=0.2, hold=0.4, fall=0.2)
    )
    motion = vc.simulate(system, periods=1)
    dwell = [(event.time, event.kind) for event in motion.events if 0.2 < event.time / motion.period % 1.0 < 0.6]
    times = [[time for time, kind in dwell if kind == wanted] for wanted in ("reversal", "reversal_2")]
    assert len(times[0]) > 2
    assert times[0] == pytest.approx(times[1], abs=1e-14)
