"""Controllers: hunting to published values, limits and windup, another solver, units, and what is refused."""

import dataclasses
import math
import re

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

import vibrocap as vc
from vibrocap.exchange.mjcf import mujoco_model
from vibrocap.motion.recording.equations import equations
from vibrocap.physics.controllers.controller import SATURATED
from vibrocap.physics.part_files import load_parts
from vibrocap.studies.plan import runs
from vibrocap.studies.plan.study import Study

pytestmark = pytest.mark.plain

GAINS = {"proportional_gain": 3.0, "integral_gain": 4.0, "derivative_gain": 6.0}
LOCATED = 2e-12  # of event times and states along a motion at the tolerance 1e-13, with gains of some units
STICKS = vc.Coulomb(1.0, 1.5)
START = {"position": -1.0}


def servo(law=STICKS, drive=None, machine=None, actuator=None, **controller):
    """A block without a spring, e'' = -6 e' - 3 e - 4 int e - friction, as in the issue."""
    block = machine or vc.Oscillator(stiffness=0.0)
    position = vc.PositionPID(**(GAINS | controller))
    return vc.System(block, law, drive or vc.Constant(), actuator=actuator, controller=position)


def events(system, kind, **given):
    motion = vc.simulate(system, initial=START, tolerance=1e-13, **given)
    assert motion.certificate.ok
    return [event for event in motion.events if event.kind == kind]


# --- hunting ----------------------------------------------------------------------------------------------------------


def test_first_stops_of_a_hunting_block_are_those_of_the_literature():
    stops, leaves = events(servo(), "stick", periods=10), events(servo(), "slip_back", periods=10)
    assert [stop.time for stop in stops] == pytest.approx([3.489535263078, 8.319920055770], abs=1e-12)
    assert [stop.state["position"] for stop in stops] == pytest.approx([0.496563422604, -0.229890927444], abs=1e-12)
    assert leaves[0].time == pytest.approx(4.569340265650, abs=1e-12)


@pytest.mark.slow
def test_orbit_finds_the_hunting_cycle_with_both_of_its_sticks():
    orbit = vc.orbit(servo(), initial=START)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.stable
    assert orbit.period == pytest.approx(23.369272293088, abs=1e-11)
    assert abs(orbit.state["position"]) == pytest.approx(0.067240146921, abs=1e-11)
    motion = orbit.motion()
    slips = np.flatnonzero(np.isin(motion.event_kinds, ("slip_forward", "slip_back")))
    times = np.append(motion.event_times, np.inf)
    after = [times[i + 1] - times[i] for i in slips if np.isfinite(times[i + 1])]
    assert after[0] == pytest.approx(2.568438922105, abs=1e-10)


@pytest.mark.parametrize(
    ("anti_windup", "leaves", "stops", "places"),
    [
        (0.0, 0.220088015551, (3.489589955005, 8.303549705376), (0.504927244172, -0.233578463123)),
        (0.5, 0.184612771134, (3.525852634667,), (0.496016686153,)),
    ],
)
def test_a_limited_command_leaves_its_limit_and_stops_at_the_published_instants(anti_windup, leaves, stops, places):
    system = servo(limit=2.2, anti_windup=anti_windup)
    motion = vc.simulate(system, initial=START, periods=10, tolerance=1e-13)
    values = [event for event in motion.events if event.kind == "stick"][: len(stops)]
    (left, *_) = (event.time for event in motion.events if event.kind == "command_unsaturated")
    assert left == pytest.approx(leaves, abs=LOCATED)
    assert [value.time for value in values] == pytest.approx(stops, abs=LOCATED)
    assert [value.state["position"] for value in values] == pytest.approx(places, abs=LOCATED)
    assert np.max(np.abs(motion["drive"])) <= 2.2
    assert np.any(motion[SATURATED] == 1.0)


def test_the_limit_is_held_on_both_sides_of_a_swinging_command():
    system = servo(vc.Coulomb(0.0, 0.0), limit=0.4, derivative_gain=1.0, integral_gain=0.0)
    motion = vc.simulate(system, initial=START, periods=20, tolerance=1e-12)
    assert {*motion[SATURATED]} == {-1.0, 0.0, 1.0}
    assert np.max(np.abs(motion["drive"])) == 0.4
    raw = -3.0 * motion["position"] - motion["sliding_velocity"]
    assert motion["drive"] == pytest.approx(np.clip(raw, -0.4, 0.4), abs=1e-12)


# --- another solver, closed forms -------------------------------------------------------------------------------------


def test_a_linear_loop_is_the_exponential_of_its_matrix():
    system = servo(vc.Coulomb(0.0, 0.0), drive=vc.Constant(force=0.3))
    motion = vc.simulate(system, periods=7, tolerance=1e-13)
    matrix = np.array([[0.0, 1.0, 0.0], [-3.0, -6.0, 1.0], [-4.0, 0.0, 0.0]])
    rest = np.array([0.3, 0.0, 0.0])
    expected = rest + scipy.linalg.expm(7.0 * matrix) @ -rest
    assert [*motion.state.values()] == pytest.approx(expected, abs=1e-12)
    assert motion["reference"] == pytest.approx(0.3, abs=0.0)


def test_a_velocity_is_reached_and_held_against_friction():
    """At the goal the integral alone carries the friction force."""
    controller = vc.VelocityPI(proportional_gain=2.0, integral_gain=1.0)
    system = vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(0.3, 0.5), vc.Constant(0.7), controller=controller)
    motion = vc.simulate(system, periods=60, tolerance=1e-11)
    assert motion.state["sliding_velocity"] == pytest.approx(0.7, abs=1e-9)
    assert motion.state["integral_command"] == pytest.approx(0.3, abs=1e-9)


def test_the_controller_stands_before_the_actuator():
    system = servo(vc.Coulomb(0.0, 0.0), actuator=vc.Actuator(0.2))
    motion = vc.simulate(system, initial=START, periods=3, tolerance=1e-13)
    matrix = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [-15, -30, -5, 5], [-4, 0, 0, 0]], dtype=float)
    expected = scipy.linalg.expm(3.0 * matrix) @ [-1.0, 0.0, 0.0, 0.0]
    assert [*motion.state.values()] == pytest.approx(expected, abs=1e-11)
    assert motion.state_names == ("position", "sliding_velocity", "actuator_output", "integral_command")
    raw = -3.0 * motion["position"] - 6.0 * motion["sliding_velocity"] + motion["integral_command"]
    assert motion["command"] == pytest.approx(raw, abs=1e-12)


# --- its place in the house -------------------------------------------------------------------------------------------


def test_its_power_is_a_channel_of_its_own():
    motion = vc.simulate(servo(), initial=START, periods=10, tolerance=1e-12)
    balance = vc.energy_balance(motion)
    times, weights = np.polynomial.legendre.leggauss(60)
    times = 1.7 * (times + 1.0)  # to 3.4, before the first stop
    power = 1.7 * weights @ (motion.at(times, "drive") * motion.at(times, "sliding_velocity"))
    assert motion.at([3.4], "controller_work")[0] == pytest.approx(power, abs=1e-11)
    assert balance.drive == 0.0
    assert balance.controller == pytest.approx(-balance.friction, abs=1e-11)
    assert abs(balance.residual) <= 1e-11
    assert "drive" not in motion.system.channels


def test_a_measured_place_is_no_longer_cyclic_and_a_measured_angle_no_longer_turns():
    capsule, law, drive = vc.PendulumCapsule(), vc.Exponential(), vc.Constant()
    held = vc.System(capsule, law, drive, controller=vc.PositionPID())
    free = vc.System(capsule, law, drive, controller=vc.AnglePID())
    assert (held.cyclic, free.cyclic) == (None, "position")
    assert (equations(held).cyclic_state, equations(free).cyclic_state) == (-1, 2)
    with pytest.raises(ValueError, match="does not travel"):
        vc.mean_velocity(vc.simulate(held, periods=2))
    rotor = vc.RotorCapsule()
    turned = vc.System(rotor, law, drive, controller=vc.AnglePID())
    assert rotor.turns
    assert not turned.turns


def test_symmetry_is_that_of_machine_reference_and_command():
    assert servo().mirrored
    assert servo(drive=vc.Harmonic(0.2, 1.0)).mirrored
    assert not servo(drive=vc.Constant(0.2)).mirrored
    assert not servo(machine=vc.Oscillator(stiffness=0.0, belt_speed=0.1)).mirrored


def test_in_si_the_reference_of_a_capsule_is_a_length_and_its_limit_a_torque(tmp_path):
    machine = vc.PendulumCapsule.in_si(
        pendulum_mass_kg=0.5,
        capsule_mass_kg=1.0,
        pendulum_length_m=0.2,
        stiffness_N_m_per_rad=1.0,
        damping_N_m_s_per_rad=0.05,
        normal_load="weight",
    )
    drive = vc.Harmonic.in_si(amplitude_m=0.05, frequency_Hz=0.5)
    gains = {"proportional_gain_N": 3.0, "integral_gain_N_per_s": 2.0, "derivative_gain_N_s": 1.0}
    controller = vc.PositionPID.in_si(**gains, anti_windup_per_N=0.7, limit_N_m=0.3)
    system = vc.System(machine, vc.Coulomb(0.1, 0.2), drive, controller=controller)
    assert system.drive.amplitude == pytest.approx(0.25, rel=1e-15)
    assert system.controller.limit == pytest.approx(0.3 / (0.5 * 9.80665 * 0.2), rel=1e-14)
    weight, second = 0.5 * 9.80665, math.sqrt(0.2 / 9.80665)
    own = system.controller
    assert own.proportional_gain == pytest.approx(3.0 / weight, rel=1e-14)
    assert own.integral_gain == pytest.approx(2.0 * second / weight, rel=1e-14)
    assert own.derivative_gain == pytest.approx(1.0 / (second * weight), rel=1e-14)
    assert own.anti_windup == pytest.approx(0.7 * weight, rel=1e-14)
    saved = vc.save_case(system, tmp_path / "capsule.toml")
    assert vc.read_case(saved).system == system
    units = [system.si.unit(name) for name in ("reference", "drive", "integral_command", "controller_work")]
    assert units == ["m", "N m", "N m", "J"]
    varied = system.with_parameters({"drive.amplitude_m": 0.1})
    assert varied.drive.amplitude == pytest.approx(0.5, rel=1e-15)


def test_a_kind_is_cited_checked_and_recorded():
    assert "Advanced PID Control" in str(vc.cite(servo()))
    assert servo().parameter_paths[-6:] == tuple(
        f"controller.{field.name}" for field in dataclasses.fields(vc.PositionPID)
    )
    for part in (
        vc.PositionPID(2.0, 1.0, 0.5, 0.3, 0.8),
        vc.AnglePID(2.0, 1.0, 0.5, 0.3, 0.8),
        vc.VelocityPI(2.0, 1.0, 0.3, 0.8),
    ):
        assert vc.check_part(part, motion=False).ok


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: servo(measured="angle"), "controller.measured: the oscillator has no state 'angle' to be measured"),
        (lambda: servo(measured="sliding_velocity"), "should be a state in m with a position-pid"),
        (
            lambda: vc.System(vc.Oscillator(), STICKS, vc.Constant(), controller=vc.AnglePID()),
            "the oscillator has no state 'angle'",
        ),
        (
            lambda: vc.System(vc.TwoMassCrawler(), STICKS, vc.Harmonic(), controller=vc.PositionPID()),
            "controller should be left out: the drive imposes a motion",
        ),
        (lambda: servo().with_parameters({"controller.gain": 1.0}), "controller.gain: there is no such parameter"),
        (lambda: vc.PositionPID(limit=0.0), "limit: should be greater than 0, got 0.0"),
        (lambda: vc.PositionPID(integral_gain=-1.0), "integral_gain: should be at least 0, got -1.0"),
        (
            lambda: vc.System(vc.Oscillator(), STICKS, vc.Constant()).parameter("controller.limit"),
            "this system has no controller; give it one",
        ),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(make, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        make()


def test_other_programs_that_know_no_controller_refuse_it():
    case = vc.Case(vc.System(vc.TwoMassCapsule(), STICKS, vc.Harmonic(), controller=vc.VelocityPI()), periods=1)
    with pytest.raises(ValueError, match="controller should be left out: a MuJoCo model"):
        mujoco_model(case)


def test_exported_steps_are_those_of_the_motion():
    case = vc.Case(servo(), START, periods=4, tolerance=1e-12)
    stepped = vc.stepper(case)
    for _ in range(8):
        stepped.step(0.5)
    assert [*stepped.states] == pytest.approx([*case.simulate().state.values()], abs=1e-10)


def test_a_controller_of_ones_own_stands_in_cases_and_studies_know_its_code(tmp_path):
    (part,) = load_parts("examples/own_parts/controllers/cubic.py")
    system = vc.System(vc.Oscillator(stiffness=0.0), STICKS, vc.Constant(0.3), controller=part())
    case = vc.read_case(vc.save_case(system, tmp_path / "own.toml", periods=2))
    assert case.system == system
    study = Study(case, runs.Grid((runs.Column("drive.force", (0.1, 0.3)),)), ("stick_fraction",))
    assert study.own_parts == {f"controller.kind = {part.name}": part}


def test_a_reference_without_a_slope_is_refused_where_it_is_asked_for():
    class Unsloped(vc.Harmonic.__mro__[1]):
        name = "unsloped"
        period, odd = 1.0, True

        def value(self, t):
            return 0.0

    with pytest.raises(ValueError, match="does not say its slope, which the position-pid asks for"):
        servo(drive=Unsloped())
    assert servo(drive=Unsloped(), derivative_gain=None).controller.measures(vc.Oscillator()) == ("position",)
