"""Cycles by returns to a section: how many make a turn, and what is said where none is found."""

import dataclasses

import numpy as np
import pytest

import vibrocap as vc
from systems import two_blocks
from thinned import exhaustive_but
from vibrocap.arguments import ArgumentError
from vibrocap.orbits.closing.periodic_solution import OrbitStatus
from vibrocap.quantities.dimensional import view

START = {"position": 1.0, "position_2": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(("belt", "period"), exhaustive_but([0], [(0.2, 11.8962162), (0.3, 10.0706235)]))
def test_two_sticks_of_block_1_make_one_turn(belt, period):
    """Periods of an independent event-driven solver."""
    orbit = vc.orbit(two_blocks(belt), initial=START, settle_periods=120)
    assert (orbit.status, orbit.returns) == (OrbitStatus.CONVERGED, 2)
    assert orbit.period == pytest.approx(period, abs=6e-8)
    # a simulation from its state keeps the period
    sticks = vc.Section("stick", 1).times(orbit.motion(15.0 * orbit.period / 10.0))[::2]
    assert np.diff(sticks) == pytest.approx([orbit.period] * (len(sticks) - 1), abs=1e-10)
    assert orbit.stable
    assert len(orbit.multipliers) == 3
    refused = dataclasses.replace(orbit, status=OrbitStatus.NOT_CERTIFIED)
    assert not refused.stable
    assert "not known" in str(refused)
    assert view(refused)["stability"] == "not known"
    assert not len(view(refused)["multipliers"])


@pytest.mark.slow
def test_the_section_does_not_matter():
    """The same cycle from whichever section it passes, its length and multipliers to rounding."""
    known = vc.orbit(two_blocks(0.2), initial=START, settle_periods=120)
    for section in ("stick_2", vc.Section(observable="position_2", value=0.5)):
        orbit = vc.orbit(two_blocks(0.2), initial=START, settle_periods=120, section=section)
        assert orbit.status is OrbitStatus.CONVERGED
        assert orbit.period == pytest.approx(known.period, abs=1e-10)
        assert abs(orbit.multipliers[0]) == pytest.approx(abs(known.multipliers[0]), abs=1e-8)


@pytest.mark.parametrize(
    ("given", "status"),
    [
        ({"returns": 1, "section": "stick"}, OrbitStatus.MORE_RETURNS),
        ({"section": vc.Section(observable="position", value=9.0)}, OrbitStatus.SECTION_NOT_MET),
        ({"initial": {}, "settle_periods": 1, "section": "impact"}, OrbitStatus.SECTION_NOT_MET),
    ],
)
def test_what_does_not_close_says_why_and_shows_no_stability(given, status):
    orbit = vc.orbit(two_blocks(0.2), **{"initial": START, "settle_periods": 120, **given})
    assert orbit.status is status
    assert not orbit.stable
    assert not orbit.unstable
    assert len(orbit.multipliers) == 0
    assert orbit.failed
    assert orbit.heading.startswith("no closed steady motion")


def creeping(law, **machine):
    return vc.System(vc.Oscillator(**machine), law, vc.Constant())


@pytest.mark.slow
def test_a_cycle_in_which_nothing_sticks_or_turns_round():
    """Without a section as with one: the middle of a state is passed by every cycle."""
    system = creeping(vc.RateAndStateAgeing(0.3, 0.03, 0.06, 0.01, 0.1), stiffness=2.0, belt_speed=-0.05)
    start = {"position": -0.2, "sliding_velocity": 0.05, "log_age": 0.5}
    orbit = vc.orbit(system, initial=start, settle_periods=200)
    assert orbit.status is OrbitStatus.CONVERGED
    assert orbit.period == pytest.approx(6.92497438, abs=1e-8)
    assert {event.kind for event in orbit.motion(5.0 * orbit.period).events} <= {"start", "end"}


@pytest.mark.slow
def test_a_cycle_of_laboratory_friction_too_stiff_for_tangents():
    """Friction turns over within 1e-6 m/s in a machine whose natural speed is 1.6 m/s."""
    law = vc.RateAndStateAgeing(0.6, 0.01, 0.015, 1e-5, 1e-6)
    machine = {"mass": 10.0, "stiffness": 4e6, "belt_speed": -1e-6, "normal_load": 1e4}
    system = vc.System(vc.Oscillator(**machine), law, vc.Constant(0.0, duration=50.0))
    start = {"position": -1.5e-3, "sliding_velocity": 1e-6, "log_age": 0.3}
    orbit = vc.orbit(system, initial=start, settle_periods=200)
    assert orbit.status is OrbitStatus.CONVERGED
    assert orbit.period == pytest.approx(356.98407567, abs=1e-6)
    assert orbit.stable


FORCED = vc.System(
    vc.TwoMassCapsule(), vc.Coulomb(0.1, 0.1), vc.Constant(0.0), environment=vc.Environment(force=1.0, linear_drag=0.5)
)


@pytest.mark.parametrize(
    ("system", "start", "status"),
    [
        pytest.param(FORCED, {}, OrbitStatus.SLIDES_STEADILY, marks=pytest.mark.slow),
        (creeping(vc.Coulomb(1.0, 1.0), belt_speed=0.5, damping=0.1), {}, OrbitStatus.SLIDES_STEADILY),
        (creeping(vc.Coulomb(1.0, 1.0)), {"position": 5.0}, OrbitStatus.COMES_TO_REST),
        (creeping(vc.Coulomb(0.1, 0.2), stiffness=0.0, belt_speed=0.3), {}, OrbitStatus.CARRIED),
        pytest.param(
            creeping(vc.SmoothedTanh(0.3, 0.3, 0.01, 1, 0.01), damping=0.3), {"position": 0.5},
            OrbitStatus.COMES_TO_REST, marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_steady_sliding_is_no_rest(system, start, status):
    assert vc.orbit(system, initial=start).status is status


@pytest.mark.parametrize(
    ("section", "complaint"),
    [
        ("stik", "did you mean 'stick'"),
        ("stick_3", "no event is called 'stick_3'"),
        ("position=fast", "section should be NAME=VALUE"),
        ("position=0.4:sideways", "section should be NAME=VALUE"),
        (vc.Section("stick", 3), "section.contact should be 1 to 2"),
        (vc.Section(observable="positon"), "did you mean 'position'"),
        (vc.Section(observable="position", value=np.nan), "section.value should be a finite number"),
        (vc.Section(observable="position", direction=0), "section.direction should be 1"),
        (vc.Section(), "section should be a Section with an event or an observable"),
        (vc.Section("stick", observable="position"), "section should be a Section with an event or an observable"),
    ],
)
def test_a_section_that_cannot_be_is_refused_by_name(section, complaint):
    with pytest.raises(ArgumentError, match=complaint.replace("(", r"\(")):
        vc.orbit(two_blocks(0.2), section=section)


def test_a_driven_system_has_the_sections_of_its_drive():
    with pytest.raises(ArgumentError, match="section should be None"):
        vc.orbit(vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic()), section="stick")
