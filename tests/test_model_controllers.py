"""Controllers that know the machine or its friction: computed torque, observer, sliding mode; how loops end.

Closed forms (the crawler of Chernousko 2002, linear errors, times at which a line of errors is reached), the pendulum
crawler, whose torque has an equation of its own, and other solvers on equations written out here.
"""

import math
import re

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.orbits.closing.autonomous_orbit import comes_to_rest
from vibrocap.orbits.closing.periodic_solution import OrbitStatus

LOAD, REACH = 0.15, math.sin(math.pi / 3.0)  # friction over the weight, and how far the bob swings
TRACKED = {2.0: 0.0786504656141, 10.0: 0.1653191219837}  # speed of the crawler by the ratio of its accelerations
GAINS = {"proportional_gain": 3.0, "integral_gain": 4.0, "derivative_gain": 6.0}
START = {"position": -1.0}
LINEAR = np.array([[0.0, 1.0, 0.0], [-3.0, -6.0, 1.0], [-4.0, 0.0, 0.0]])  # x, v and S of the block under GAINS


def crawls(ratio):
    """Pendulum capsule whose bob is told the best stroke of three phases, and that stroke's speed in closed form."""
    best = LOAD * 3.5
    drive = vc.ThreePhase(2.0 * REACH, best, ratio * best, best)
    controller = vc.StrokeComputedTorque(proportional_gain=4.0, derivative_gain=4.0, origin=-REACH)
    system = vc.System(vc.PendulumCapsule(normal_load="weight"), vc.Coulomb(LOAD, LOAD), drive, controller=controller)
    speed = (ratio - 1.0) / (2.0 * ratio) * math.sqrt(2.0 * (1.0 / 3.5) * LOAD * 2.0 * REACH * ratio / (ratio + 1.0))
    return system, speed


# --- computed torque --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [2.0, 10.0])
@pytest.mark.parametrize("angle", [-math.pi / 3.0, -0.9])
def test_tracking_under_feedback_reaches_the_speed_of_the_closed_form(ratio, angle):
    """On the reference from the start on, and beside it; the bob's swing pushes the capsule the other way."""
    system, speed = crawls(ratio)
    motion = vc.simulate(system, periods=14, initial={"angle": angle}, tolerance=1e-12)
    assert speed == pytest.approx(TRACKED[ratio], abs=1e-12)
    assert motion.certificate.ok
    assert -vc.mean_velocity(motion, periods=1).value == pytest.approx(speed, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load", "law"),
    exhaustive_but([2], [(load, law) for load in (2.0, "dynamic") for law in (vc.Coulomb(0.2, 0.3), vc.LuGre())]),
)
def test_errors_die_out_as_the_gains_say_whatever_the_contact_does(load, law):
    drive, controller = vc.Harmonic(0.7, 1.3), vc.AngleComputedTorque(5.0, 1.5)
    system = vc.System(vc.PendulumCapsule(normal_load=load), law, drive, controller=controller)
    motion = vc.simulate(system, periods=2, initial={"angle": 0.1, "angle_rate": -0.4}, tolerance=1e-12)
    assert len({event.kind for event in motion.events}) or load == "dynamic"
    matrix, first = np.array([[0.0, 1.0], [-5.0, -1.5]]), np.array([0.1 - 0.7, -0.4])
    for time in (0.5, 2.0, motion.end):
        error = motion.at([time], "angle")[0] - 0.7 * math.cos(1.3 * time)
        assert error == pytest.approx((scipy.linalg.expm(time * matrix) @ first)[0], abs=1e-10)


@pytest.mark.slow
def test_a_limited_torque_under_bristles_is_what_another_solver_says():
    """u = [B a + sin cos theta'^2 + R cos]/(lambda + 1) - sin + rho theta + nu theta', cut off, on LuGre friction."""
    law, machine, drive = vc.LuGre(), vc.PendulumCapsule(normal_load=2.0), vc.Harmonic(0.7, 1.3)
    controller = vc.AngleComputedTorque(5.0, 1.5, limit=0.8)
    system = vc.System(machine, law, drive, controller=controller)
    motion = vc.simulate(system, periods=2, initial={"angle": 0.1}, tolerance=1e-12)
    ratio = machine.mass_ratio

    def rates(t, y):
        angle, rate, _, velocity, bristle = y
        reference, slope = 0.7 * math.cos(1.3 * t), -0.91 * math.sin(1.3 * t)
        wanted = -1.183 * math.cos(1.3 * t) + 1.5 * (slope - rate) + 5.0 * (reference - angle)
        level = (0.15 + 0.3 * math.exp(-((velocity / 0.1) ** 2))) * 2.0
        drift = velocity - 100.0 * abs(velocity) * bristle / level
        force = 100.0 * bristle + 10.0 * drift
        sine, cosine = math.sin(angle), math.cos(angle)
        inertia = ratio + 1.0 - cosine * cosine
        torque = (inertia * wanted + sine * cosine * rate * rate + force * cosine) / (ratio + 1.0)
        u = max(-0.8, min(0.8, torque - sine + 2.0 * angle + rate))
        torque = u + sine - 2.0 * angle - rate
        capsule = (cosine * torque - sine * rate * rate - force) / inertia
        return [rate, torque + cosine * capsule, velocity, capsule, drift]

    start = [0.1, 0.0, 0.0, 0.0, 0.0]
    exact = scipy.integrate.solve_ivp(rates, (0.0, motion.end), start, "DOP853", rtol=1e-10, atol=1e-12, max_step=0.01)
    states = [motion.state[name] for name in ("angle", "angle_rate", "position", "velocity", "bristle")]
    assert states == pytest.approx(exact.y[:, -1], abs=2e-8)
    assert np.max(np.abs(motion["drive"])) == 0.8
    assert {"command_saturated", "command_unsaturated"} <= {event.kind for event in motion.events}


@pytest.mark.slow
def test_a_step_sees_friction_that_rises_only_near_rest():
    """Slopes as differences of rates are so wide in interval arithmetic that a step of 0.7 passed the rise: 1e-6."""
    drive, law = vc.Harmonic(1.8, 1.3), vc.Stribeck()
    system = vc.System(vc.TwoMassCapsule(), law, drive, controller=vc.PositionComputedForce())
    ends = [
        vc.simulate(system, periods=5, initial={"displacement": 1.0}, tolerance=tolerance).state["position"]
        for tolerance in (1e-11, 1e-12)
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


# --- observer of friction ---------------------------------------------------------------------------------------------


def observed(law, share=1.0, **given):
    """A block on a law, under an observer that believes in so much of its friction."""
    beliefs = {"bristle_stiffness": 100.0, "bristle_damping": 5.0, "viscous_damping": 0.4, "stribeck_velocity": 0.05}
    beliefs |= {"coulomb_force": 1.0 * share, "static_force": 1.5 * share, "mass": 1.0}
    controller = vc.FrictionObserver(**{**GAINS, **beliefs, **given})
    return vc.System(vc.Oscillator(stiffness=0.0), law, vc.Harmonic(0.2, 0.8), controller=controller)


BRISTLES = vc.LuGre(100.0, 5.0, 0.4, 1.0, 1.5, 0.05)


@pytest.mark.slow
def test_with_wrong_beliefs_it_is_what_another_solver_says():
    system = observed(BRISTLES, 0.8, observer_gain=0.3, mass=0.7, viscous_damping=0.2)
    motion = vc.simulate(system, periods=1, initial=START, tolerance=1e-12)

    def bristles(velocity, deflection, share):
        level = share * (1.0 + 0.5 * math.exp(-((velocity / 0.05) ** 2)))
        return velocity - 100.0 * abs(velocity) * deflection / level

    def rates(t, y):
        place, velocity, integral, believed, bristle = y
        error, slope = 0.2 * math.cos(0.8 * t) - place, -0.16 * math.sin(0.8 * t) - velocity
        curvature, drift = -0.128 * math.cos(0.8 * t), bristles(velocity, bristle, 1.0)
        guess = bristles(velocity, believed, 0.8) + 0.3 * error
        u = 3.0 * error + 6.0 * slope + integral + 0.7 * curvature + 100.0 * believed + 5.0 * guess + 0.2 * velocity
        force = 100.0 * bristle + 5.0 * drift + 0.4 * velocity
        return [velocity, u - force, 4.0 * error, guess, drift]

    start = [-1.0, 0.0, 0.0, 0.0, 0.0]
    exact = scipy.integrate.solve_ivp(rates, (0.0, motion.end), start, "DOP853", rtol=1e-11, atol=1e-13, max_step=0.005)
    names = ("position", "sliding_velocity", "integral_command", "observed_bristle", "bristle")
    assert [motion.state[name] for name in names] == pytest.approx(exact.y[:, -1], abs=1e-8)


def test_with_right_beliefs_stiff_bristles_are_nothing():
    """Canudas de Wit et al. 1995: a step to the goal 1, where a servo without an observer hunts for ever."""
    bristles = {"bristle_stiffness": 1e5, "bristle_damping": math.sqrt(1e5), "viscous_damping": 0.4}
    law = vc.LuGre(**bristles, coulomb_coefficient=1.0, static_coefficient=1.5, stribeck_velocity=0.001)
    beliefs = bristles | {"coulomb_force": 1.0, "static_force": 1.5, "stribeck_velocity": 0.001}
    observer = vc.FrictionObserver(**GAINS, **beliefs)
    system = vc.System(vc.Oscillator(stiffness=0.0), law, vc.Constant(1.0), controller=observer)
    motion = vc.simulate(system, periods=20, tolerance=1e-11)
    expected = (scipy.linalg.expm(20.0 * LINEAR) @ [-1.0, 0.0, 0.0])[0]
    assert motion.state["position"] - 1.0 == pytest.approx(expected, abs=1e-9)


# --- sliding mode -----------------------------------------------------------------------------------------------------


def switched(size=1.0, rate=1.0, drive=None, law=None, machine=None):
    """A mass in a capsule, without a spring: z'' = u while the capsule does not move."""
    machine = machine or vc.TwoMassCapsule(stiffness=0.0, damping=0.0, normal_load=100.0)
    controller = vc.PositionSlidingMode(rate, size)
    return vc.System(machine, law or vc.Coulomb(0.9, 0.9), drive or vc.Constant(0.0), controller=controller)


@pytest.mark.plain
@pytest.mark.parametrize(("place", "reached"), [(1.0, math.sqrt(3.0) - 1.0), (-1.0, math.sqrt(3.0) - 1.0)])
def test_the_line_is_reached_and_kept(place, reached):
    """s = 1 - t - t^2/2 until sqrt(3) - 1; from there on the error decays as exp(-t), with no event at all."""
    motion = vc.simulate(switched(), periods=8, initial={"displacement": place}, tolerance=1e-13)
    assert [event.kind for event in motion.events] == ["command_unsaturated"]
    assert motion.events[0].time == pytest.approx(reached, abs=1e-12)
    there = place * (1.0 - 0.5 * reached * reached)
    assert motion.state["displacement"] == pytest.approx(there * math.exp(reached - motion.end), abs=1e-12)
    assert motion.state["displacement_rate"] == pytest.approx(-motion.state["displacement"], abs=1e-12)


@pytest.mark.plain
def test_a_line_is_left_at_one_event_where_the_reference_turns_too_sharply():
    """For r'' up to 1.25 of a command of 1, slowly: at the end of the line z'' is that of the line still."""
    system = switched(drive=vc.Harmonic(1.25 / 4.0, 2.0))
    start = {"displacement_rate": -1.25 / 2.0}
    motion = vc.simulate(system, periods=6, initial=start, start=vc.Start(phase=0.25), tolerance=1e-10)
    assert [event.kind for event in motion.events] == ["command_saturated", "command_unsaturated"] * 12
    assert np.min(np.diff([event.time for event in motion.events])) > 0.1


@pytest.mark.plain
def test_a_line_is_left_once_however_loose_the_tolerance():
    """The command reaches its limit to rounding where it leaves; to the tolerance only, the line was met again."""
    pendulum, drive = vc.PendulumCapsule(), vc.Harmonic(0.8, 2.0)
    system = vc.System(pendulum, vc.Exponential(), drive, controller=vc.AngleSlidingMode(1.0, 1.0))
    motions = [vc.simulate(system, periods=2, tolerance=tolerance) for tolerance in (1e-6, 1e-10)]
    commands = [[kind for kind in motion.event_kinds if kind.startswith("command")] for motion in motions]
    assert commands[0] == commands[1]
    assert len(commands[0]) > 6


@pytest.mark.plain
def test_a_line_that_the_command_cannot_keep_is_crossed():
    """From 10 the first passage asks for 3.58 of a command of 1: it turns round there, and again, before it stays."""
    motion = vc.simulate(switched(), periods=20, initial={"displacement": 10.0}, tolerance=1e-13)
    place, velocity, time, push, expected = 10.0, 0.0, 0.0, -1.0, []
    while True:  # parabolas between passages of z + z' = 0
        z, v = np.poly1d([0.5 * push, velocity, place]), np.poly1d([push, velocity])
        step = min(root.real for root in (z + v).roots if root.real > 1e-9)
        place, velocity, time = float(z(step)), float(v(step)), time + step
        expected.append(time)
        if abs(velocity) <= 1.0:
            break
        push = -push
    assert [event.time for event in motion.events if event.kind == "command_unsaturated"] == pytest.approx(
        expected, abs=1e-10
    )
    assert len(expected) == 3
    assert motion.state["displacement"] == pytest.approx(place * math.exp(time - motion.end), abs=1e-10)


@pytest.mark.slow
def test_on_the_line_friction_and_springs_are_nothing():
    """The error decays as exp(-2 t) while the capsule sticks and slips; the command is what that takes, within 4."""
    machine = vc.TwoMassCapsule(normal_load=2.0)
    system = switched(4.0, 2.0, vc.Harmonic(0.6, 1.7), vc.Coulomb(0.5, 0.7), machine)
    start = {"displacement": 0.7, "displacement_rate": -0.2}  # s = -0.2 + 2 (0.7 - 0.6) = 0
    motion = vc.simulate(system, periods=3, initial=start, tolerance=1e-12)
    kinds = {event.kind for event in motion.events}
    assert {"stick", "slip_forward"} <= kinds
    assert "command_saturated" not in kinds
    times = np.linspace(0.0, motion.end, 40)
    error = motion.at(times, "displacement") - 0.6 * np.cos(1.7 * times)
    assert error == pytest.approx(0.1 * np.exp(-2.0 * times), abs=1e-10)
    assert abs(vc.energy_balance(motion).residual) < 1e-10


# --- how loops end ----------------------------------------------------------------------------------------------------


def servo(controller, static=1.5, goal=0.0):
    return vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, static), vc.Constant(goal), controller=controller)


@pytest.mark.plain
@pytest.mark.parametrize(
    "controller",
    [
        vc.PositionPID(3.0, 4e4),
        vc.PositionPID(3.0, 4.0),
        vc.SampledPositionPID(3.0, 4.0, 300.0, sample_time=0.1),
    ],
)
def test_an_unstable_loop_ends_as_a_runaway(controller):
    """Long before memory or steps are at an end, at 10^6 natural sizes, 1/(4 pi^2) of this block each."""
    motion = vc.simulate(servo(controller), initial=START, periods=100_000)
    assert motion.status is vc.Status.RUNAWAY
    assert motion.events[-1].kind == "runaway"
    assert abs(motion.state["position"]) == pytest.approx(1e6 / (4.0 * math.pi**2), rel=1e-9)


@pytest.mark.plain
def test_a_goal_far_away_is_no_runaway():
    motion = vc.simulate(servo(vc.PositionPID(**GAINS), goal=1e5), periods=30)
    assert motion.status.ok
    assert motion.state["position"] == pytest.approx(1e5, rel=1e-2)


@pytest.mark.slow
def test_a_stroke_beyond_the_pendulum_ends_by_name():
    system = vc.System(
        vc.PendulumCapsule(), vc.Coulomb(0.2, 0.3), vc.Harmonic(1.8), controller=vc.StrokeComputedTorque()
    )
    motion = vc.simulate(system, periods=3)
    assert motion.status is vc.Status.SINGULAR_COMMAND
    assert abs(math.cos(motion.state["angle"])) == pytest.approx(1e-3, abs=1e-9)


def shrinking():
    """Share that is left of a stop at the next one: x''' + 6 x'' + 3 x' + 4 x = 0 from (1, 0, 0) to x' = 0."""
    matrix = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-4.0, -3.0, -6.0]])

    def state(t):
        return scipy.linalg.expm(t * matrix)[:, 0]

    return state(scipy.optimize.brentq(lambda t: state(t)[1], 1.0, 6.0, xtol=1e-15))[0]


def test_without_static_friction_a_servo_comes_to_rest_in_the_limit_and_nothing_calls_it_a_cycle():
    system = servo(vc.PositionPID(**GAINS), static=1.0)
    motion = vc.simulate(system, initial=START, periods=800, tolerance=1e-12)
    stops = np.array([event.state["position"] for event in motion.events if event.kind == "stick"])
    assert stops[1:] / stops[:-1] == pytest.approx([shrinking()] * (len(stops) - 1), rel=1e-9)
    assert shrinking() == pytest.approx(-0.452093368595, abs=1e-11)
    orbit = vc.orbit(system, initial=START)
    assert orbit.status is OrbitStatus.COMES_TO_REST
    assert not orbit.stable
    assert not orbit.unstable
    assert len(orbit.multipliers) == 0
    (rest,) = vc.equilibria(system)
    assert (rest.kind, rest.dimension) == ("rest", 1)
    assert (rest.least["integral_command"], rest.most["integral_command"]) == pytest.approx((-1.0, 1.0), abs=1e-12)


@pytest.mark.parametrize("static", [1.0001, 1.5])
def test_a_contact_that_holds_more_than_it_rubs_is_never_said_to_come_to_rest(static):
    """Its stops shrink at first, too, and end in a cycle however small."""
    motion = vc.simulate(servo(vc.PositionPID(**GAINS), static), initial=START, periods=200)
    assert not comes_to_rest(motion)


# --- their place in the house -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: told(vc.Oscillator(), vc.PositionComputedForce()), "the place of a body that comes to rest"),
        (lambda: told(vc.Oscillator(), vc.PositionSlidingMode()), "the place of a body that comes to rest"),
        (
            lambda: told(vc.TwoMassCapsule(), vc.PositionComputedForce(), actuator=vc.Actuator()),
            "actuator should be left out with a position-computed-force",
        ),
        (
            lambda: told(vc.PendulumCapsuleWithStops(restitution=0.5), vc.AngleComputedTorque()),
            "a stop of the pendulum-capsule-with",
        ),
        (lambda: told(vc.LinkageCrawler(), vc.PositionComputedForce()), "should have a rate that is a state"),
        (lambda: told(vc.PendulumCapsule(), vc.FrictionObserver()), "should be one whose first contact is pushed"),
        (lambda: told(vc.TwoMassCapsule(), vc.FrictionObserver()), "should be one whose first contact is pushed"),
        (
            lambda: vc.FrictionObserver(static_force=0.1),
            "static_force: should be at least coulomb_force, got 0.1",
        ),
        (lambda: told(vc.PendulumCapsule(), vc.AngleComputedTorque(measured="position")), "should be a state in rad"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(make, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        make()


def told(machine, controller, **given):
    return vc.System(machine, vc.Coulomb(0.2, 0.3), vc.Harmonic(), controller=controller, **given)
