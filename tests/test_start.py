"""Motions that begin at another time or phase of the drive, and motions that go on from another one."""

import numpy as np
import pytest

import vibrocap as vc

MACHINE, DRIVE = vc.PendulumCapsule(), vc.Harmonic()
TOLERANCE = 1e-11
# A difference grows by what the motion makes of it over some periods: of the order of ten here.
CLOSE = 100.0 * TOLERANCE


def system(law=None):
    return vc.System(MACHINE, vc.Exponential() if law is None else law, DRIVE)


def difference(one, other, times):
    return max(float(np.max(np.abs(one.at(times, name) - other.at(times, name)))) for name in one.state_names)


@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
@pytest.mark.parametrize("cut", [2, 1.3])
def test_a_motion_in_two_parts_is_the_motion_in_one(law, cut):
    options = {"initial": {"angle": 1.0}, "tolerance": TOLERANCE}
    whole = vc.simulate(system(law), periods=6, **options)
    first = vc.simulate(system(law), periods=cut, **options)
    second = vc.simulate(system(law), periods=6 - cut, start=first, tolerance=TOLERANCE)
    assert second.time[0] == first.end
    assert second.end == pytest.approx(whole.end, rel=1e-14)
    assert difference(whole, second, np.minimum(second.time, whole.end)) < CLOSE
    assert len(first.events) + len(second.events) == len(whole.events)
    assert second.certificate.ok
    drive = np.array([float(DRIVE.value(t)) for t in second.time])
    np.testing.assert_allclose(second["drive"], drive, atol=1e-13)


def test_forces_on_stiff_pieces_know_the_phase_of_the_drive():
    stiff = vc.LuGre(bristle_stiffness=1e6, bristle_damping=100.0)
    whole = vc.simulate(system(stiff), periods=2, initial={"angle": 1.0}, tolerance=1e-9)
    first = vc.simulate(system(stiff), periods=1.3, initial={"angle": 1.0}, tolerance=1e-9)
    later = vc.Start(time=0.0, phase=0.3)
    second = vc.simulate(system(stiff), periods=0.7, initial=first.state, start=later, tolerance=1e-9)
    implicit = np.flatnonzero(second.piece_implicit)
    assert len(implicit)
    middle = 0.5 * second.piece_length[implicit]
    assert np.max(np.abs(second.piece_correction(implicit, middle))) < 1e-7
    times = second.piece_start[implicit] + middle
    np.testing.assert_allclose(second.at(times, "friction"), whole.at(times + first.end, "friction"), atol=1e-5)
    assert second.certificate.ok


def test_phase_of_the_drive_is_that_of_the_time():
    later = vc.simulate(system(), periods=1.5, initial={"angle": 1.0}, start=0.4)
    np.testing.assert_allclose(later["drive"], DRIVE.amplitude * np.cos(later.time), atol=1e-13)
    assert later.time[0] == 0.4
    apart = vc.simulate(system(), periods=1.5, initial={"angle": 1.0}, start=vc.Start(0.4, phase=0.25))
    np.testing.assert_allclose(apart["drive"], -DRIVE.amplitude * np.sin(apart.time - 0.4), atol=1e-13)
    again = vc.simulate(system(), periods=1.5, initial={"angle": 1.0}, start=vc.Start(0.4, phase=-2.75))
    assert again == apart


def test_phase_goes_on_where_the_frequency_changes():
    first = vc.simulate(system(), periods=1.25, initial={"angle": 1.0})
    faster = vc.System(MACHINE, vc.Exponential(), vc.Harmonic(frequency=2.0))
    second = vc.simulate(faster, periods=1, start=first)
    angle = 2.0 * np.pi * 0.25 + 2.0 * (second.time - first.end)
    np.testing.assert_allclose(second["drive"], DRIVE.amplitude * np.cos(angle), atol=1e-13)


def test_measures_of_a_motion_that_begins_later_are_those_of_the_same_stretch():
    whole = vc.simulate(system(), periods=30, initial={"angle": 1.0}, tolerance=TOLERANCE)
    first = vc.simulate(system(), periods=10.3, initial={"angle": 1.0}, tolerance=TOLERANCE)
    second = vc.simulate(system(), periods=19.7, start=first, tolerance=TOLERANCE)
    assert len(second.sections) == 20
    np.testing.assert_array_equal(second.sections[0], list(first.state.values()))
    np.testing.assert_allclose(second.sections[7], second.states([second.start_time + 7 * second.period])[:, 0])
    window = (second.start_time, second.end)
    assert vc.stick_fraction(second) == pytest.approx(vc.stick_fraction(whole, window), rel=1e-9)
    assert vc.energy_balance(second).residual == pytest.approx(0.0, abs=1e-9)
    assert vc.mean_velocity(second, periods=5).value == pytest.approx(
        vc.mean_velocity(whole, periods=5).value, rel=1e-6
    )
    assert vc.response_class(second).kind == vc.response_class(whole).kind
    loop, known = vc.friction_loop(second), vc.friction_loop(whole)
    assert loop.displacement_area == pytest.approx(known.displacement_area, rel=1e-6)
    with pytest.raises(ValueError, match="motion should begin where the drive begins a period"):
        vc.measured(second, ["mean_velocity"], window=5)
    third = vc.simulate(system(), periods=5, start=vc.simulate(system(), periods=3))
    assert vc.measured(third, ["mean_velocity"], window=5)["mean_velocity"] == pytest.approx(
        vc.mean_velocity(third, periods=5).value
    )


def test_states_can_be_changed_where_a_motion_goes_on():
    first = vc.simulate(system(), periods=2, initial={"angle": 1.0})
    kicked = vc.simulate(system(), periods=1, start=first, initial={"velocity": 0.5})
    assert kicked.initial == {**first.state, "velocity": 0.5}


def test_start_that_makes_no_sense_is_refused_by_name():
    lugre = vc.simulate(system(vc.LuGre()), periods=1)
    for start, words in (
        (lugre, "start should be a motion of the states angle, angle_rate, position, velocity to continue from"),
        ("now", "start should be a motion, a time or a Start, got 'now'"),
        (float("nan"), "start.time should be a finite number, got nan"),
    ):
        with pytest.raises(ValueError, match=words):
            vc.simulate(system(), periods=1, start=start)
    with pytest.raises(ValueError, match=r"start.phase should be a finite number, got 'half'"):
        vc.Start(phase="half")
