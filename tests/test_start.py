"""Motions that begin at another time or phase of the drive, and motions that go on from another one."""

import collections
import pickle

import numpy as np
import pytest

import vibrocap as vc
from thinned import slow_but

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


# --- ends at events ---------------------------------------------------------------------------------------------------

DROP = vc.Coulomb(coulomb_coefficient=0.1, static_coefficient=0.3)
BELT = vc.System(vc.Oscillator(), DROP, vc.Harmonic(amplitude=0.4, frequency=0.3))


def vector(motion):
    return np.array(list(motion.state.values()))


def works(motion):
    """All that is integrated over a motion, and the impulse that stops on the ground have given."""
    return np.append(motion.integrals([motion.end]), np.sum(motion.piece_blows))


def told(*motions):
    """How often each kind of event was told; a law that starts on the border of a branch may tell it again."""
    kinds = (str(kind) for motion in motions for kind in motion.event_kinds)
    return collections.Counter(kind for kind in kinds if not kind.startswith("switch"))


def continued(first, periods):
    """The three ways to continue a motion: it, a copy that was stored, its state and phase."""
    later = vc.Start(time=first.end, phase=first.end_phase)
    for start, initial in ((first, None), (pickle.loads(pickle.dumps(first)), None), (later, first.state)):
        yield vc.simulate(first.system, periods=periods, start=start, initial=initial, tolerance=first.tolerance)


def assert_split_anywhere(system, periods, number=None, tolerance=1e-9):
    """A run that ends at an event and one that continues it are the run in one, and tell each event once."""
    whole = vc.simulate(system, periods=periods, tolerance=tolerance)
    assert whole.status.ok
    name = system.state_names[0]
    beside = {name: whole.initial[name] + tolerance}
    growth = vector(vc.simulate(system, periods=periods, tolerance=tolerance, initial=beside)) - vector(whole)
    near = 30.0 * (tolerance + np.max(np.abs(growth)))
    moments = [event.time for event in whole.events if 0.0 < event.time < whole.end]
    for time in moments[:: max(1, len(moments) // (number or len(moments)))]:
        first = vc.simulate(system, periods=time / whole.period, tolerance=tolerance)
        ends = list(continued(first, periods - time / whole.period))
        for second in ends:
            assert np.max(np.abs(vector(second) - vector(whole))) < near, (system, time)
            np.testing.assert_array_equal(vector(second), vector(ends[0]))
            if not system.machine.imposes_distances:  # bodies that turn together may rest for 1e-11 in between
                assert told(first, second) == told(whole), (system, time)
            assert np.max(np.abs(works(first) + works(second) - works(whole))) < 10.0 * near, (system, time)


@pytest.mark.parametrize(
    "system",
    [
        BELT,
        vc.System(vc.ThreeBlockRow(), vc.anisotropic(vc.Coulomb)(0.1, 0.3, forward_ratio=0.9), vc.Harmonic(0.5, 0.4)),
        vc.System(vc.RigidStopCapsule(restitution=0.5), DROP, vc.Harmonic(amplitude=1.5, frequency=0.9)),
        vc.System(vc.TwoMassCapsule(), DROP, vc.OnOff(1.2, -0.3, 1.0, 0.4)),  # sticks break loose at corners
        vc.System(vc.RotorCapsule(), vc.Coulomb(0.2, 0.3), vc.Harmonic(1.5, 0.8)),
        vc.System(vc.OscillatorWithStops(gap=0.3, back_gap=0.3, restitution=0.0), vc.LuGre(), vc.Square(-1.2, 0.9)),
        vc.System(vc.OscillatorWithStops(gap=0.3, back_gap=0.3, restitution=1.0), vc.LuGre(), vc.Square(-1.2, 0.9)),
    ],
    ids=lambda system: system.machine.name,
)
def test_a_run_that_ends_at_an_event_is_continued_as_if_it_had_not_ended(system):
    assert_split_anywhere(system, 4.9, number=4)


def test_an_event_at_the_last_instant_belongs_to_the_run():
    """The default oscillator comes to rest at 2.84: the run to there has told it, and rests."""
    whole = vc.simulate(BELT, periods=1)
    stick = whole.events[0]
    assert stick.kind == "stick"
    first = vc.simulate(BELT, periods=stick.time / whole.period)
    assert [(event.kind, event.time) for event in first.events] == [("stick", pytest.approx(stick.time, rel=1e-15))]
    assert first.state["sliding_velocity"] == 0.0
    assert first.at(first.end, "side")[0] == 0.0
    assert first.at(first.end, "friction")[0] == pytest.approx(whole.at(stick.time, "friction")[0], rel=1e-9)
    assert [phase.side for phase in first.phases] == [whole.phases[0].side]
    assert first.certificate.ok


@pytest.mark.slow
def test_a_kinked_contact_that_turns_at_the_last_instant_has_turned():
    """Two bodies creep: friction tells from rest what rounding leaves of a velocity; its side does not count."""
    drive = vc.Biharmonic(0.33170867752701, 0.33234405892888214, 0.165854338763505, 0.5)
    law = vc.ElastoPlastic(coulomb_coefficient=0.15, static_coefficient=0.45)
    assert_split_anywhere(vc.System(vc.TwoBodyCrawler(mass_2=1.5), law, drive), 0.8)


@pytest.mark.plain
@pytest.mark.parametrize("law", slow_but([0], [DROP, vc.LuGre()]), ids=lambda law: law.name)
def test_a_velocity_of_rounding_size_is_a_rest_at_the_start(law):
    """Alone, in lanes and moved on from outside: what rounding leaves of 0 does not decide the side."""
    system = vc.System(vc.Oscillator(), law, vc.Harmonic(0.02, 0.3))
    speeds = [0.0, 1.4e-17, -1.4e-17, 5.6e-16, -5.6e-16]
    start = {"position": -0.2}
    runs = [vc.simulate(system, periods=1, initial=start | {"sliding_velocity": speed}) for speed in speeds]
    ends = np.array([vector(run) for run in runs])
    np.testing.assert_array_equal(ends, np.broadcast_to(ends[0], ends.shape))
    assert all(told(run) == told(runs[0]) for run in runs)
    for speed, run in zip(speeds, runs, strict=True):
        stepper = vc.stepper(system, initial=start | {"sliding_velocity": speed})
        assert stepper.sides == (int(run.piece_sides[0, 0]),)
    if law is DROP:
        over = {"initial.sliding_velocity": np.array(speeds)}
        results = vc.ensemble(system, over, measures=["stick_fraction"], initial=start, periods=1)
        np.testing.assert_allclose(results["stick_fraction"], 1.0, rtol=1e-14)
        assert runs[0].state == {"position": -0.2, "sliding_velocity": 0.0}
