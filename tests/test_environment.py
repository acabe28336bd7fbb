"""Slope, drag and a force from outside: closed forms, an independent solver, balances, and what is refused."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

import vibrocap as vc
from cases import printed, printed_json
from law_instances import LAWS
from thinned import slow_but
from vibrocap.contracts.samples import draws, machine_draw, random_internal
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import derivative, evaluate
from vibrocap.physics.catalogue import machines
from vibrocap.physics.flow import CONTACT_CHANNELS
from vibrocap.physics.names import name_and_number, numbered
from vibrocap.physics.parameters import ParameterError

pytestmark = pytest.mark.plain

ROUNDING = 1e-13
G = 9.81
EVERYTHING = {"inclination": -0.11, "linear_drag": 0.15, "quadratic_drag": 0.3, "force": 0.07}


def capsule(load="weight", law=None, amplitude=1.8, mass_ratio=2.5, drive=None, **environment):
    machine = vc.PendulumCapsule(normal_load=load, mass_ratio=mass_ratio)
    law = law or vc.Exponential(coulomb_coefficient=0.1, static_coefficient=0.2)
    given = vc.Environment(**environment) if environment else None
    return vc.System(machine, law, drive or vc.Harmonic(amplitude=amplitude), environment=given)


def block(law, mass=2.0, load=None, **environment):
    """A block that only its weight presses on the ground, and that nothing shakes."""
    load = mass * G * math.cos(environment.get("inclination", 0.0)) if load is None else load
    machine = vc.Oscillator(mass=mass, stiffness=0.0, normal_load=load)
    return vc.System(machine, law, vc.Constant(), environment=vc.Environment(gravity=G, **environment))


# --- a block on a slope -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_block_slides_down_or_stays_as_the_angle_of_friction_says(side):
    kinetic, static, time = 0.2, 0.3, 1.7
    law = vc.Coulomb(kinetic, static)
    for excess in (-1e-9, 1e-9):
        angle = side * (math.atan(static) + excess)
        motion = vc.simulate(block(law, inclination=angle), periods=time, tolerance=1e-12)
        if excess < 0:
            assert motion.state == {"position": 0.0, "sliding_velocity": 0.0}
            assert not len(motion.events)
        else:
            fall = G * (math.sin(abs(angle)) - kinetic * math.cos(angle))
            assert motion.state["sliding_velocity"] == pytest.approx(-side * fall * time, rel=ROUNDING)
            assert motion.state["position"] == pytest.approx(-side * 0.5 * fall * time**2, rel=ROUNDING)


def test_block_thrown_uphill_stops_and_slides_back_down():
    kinetic, angle, speed = 0.2, 0.4, 3.0
    system = block(vc.Coulomb(kinetic, kinetic), inclination=angle)
    motion = vc.simulate(system, periods=2.0, initial={"sliding_velocity": speed}, tolerance=1e-12)
    up, down = (G * (math.sin(angle) + sign * kinetic * math.cos(angle)) for sign in (1.0, -1.0))
    (event,) = motion.events
    assert (event.kind, event.time) == ("reversal", pytest.approx(speed / up, rel=ROUNDING))
    rest = motion.end - speed / up
    height = 0.5 * speed**2 / up
    assert motion.state["position"] == pytest.approx(height - 0.5 * down * rest**2, rel=ROUNDING)
    balance = vc.energy_balance(motion)
    mass = system.machine.mass
    weight = mass * G * math.sin(angle)
    assert balance.gravity == pytest.approx(-weight * motion.state["position"], rel=1e-12)
    friction = kinetic * mass * G * math.cos(angle)
    assert balance.contact_sliding == pytest.approx(-friction * (2 * height - motion.state["position"]), rel=1e-12)
    assert (balance.drag, balance.outer_force, balance.drive) == (0.0, 0.0, 0.0)


# --- drag -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "law", slow_but([0], [vc.Coulomb(0.3, 0.3), vc.SmoothedTanh(0.0, 0.0)]), ids=lambda law: law.name
)
def test_quadratic_drag_turns_round_at_the_reversal(law):
    """m v' = F + R + c v^2 until it stops, then m v' = F - R - c v^2; a law that is smooth there locates it too."""
    mass, pull, drag, speed = 1.3, 0.9, 0.7, 2.0
    friction = 0.3 if law.name == "coulomb" else 0.0
    system = block(law, mass, load=1.0, force=pull, quadratic_drag=drag)
    motion = vc.simulate(system, periods=4.0, initial={"sliding_velocity": -speed}, tolerance=1e-12)
    rate, against = math.sqrt(drag * (pull + friction)) / mass, math.sqrt((pull + friction) / drag)
    turn = math.atan(speed / against) / rate
    assert [event.kind for event in motion.events] == ["reversal"]
    assert motion.events[0].time == pytest.approx(turn, rel=1e-11)
    rate, limit = math.sqrt(drag * (pull - friction)) / mass, math.sqrt((pull - friction) / drag)
    expected = limit * math.tanh(rate * (motion.end - turn))
    assert motion.state["sliding_velocity"] == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    "drag",
    [
        {"linear_drag": 0.4},
        {"quadratic_drag": 0.4},
        {"linear_drag": 0.4, "linear_drag_back": 0.9},
        {"quadratic_drag_back": 0.7},
    ],
)
def test_drag_has_a_closed_form_each_way(drag):
    """m v' = F - R - d(v): forward with the one coefficient, back with the other if there is one, c v or c v^2."""
    mass, pull, friction, time, law = 2.0, 1.1, 0.3, 3.0, vc.Coulomb(0.3, 0.3)
    for side in (1.0, -1.0):
        system = block(law, mass, load=1.0, force=side * pull, **drag)
        speed = side * vc.simulate(system, periods=time, tolerance=1e-12).state["sliding_velocity"]
        ending = "" if side > 0.0 else "_back"
        linear, quadratic = (
            drag.get(f"{name}_drag{ending}", drag.get(f"{name}_drag", 0.0)) for name in ("linear", "quadratic")
        )
        expected = (pull - friction) * time / mass
        if linear:
            expected = (pull - friction) / linear * -math.expm1(-linear * time / mass)
        elif quadratic:
            expected = math.sqrt((pull - friction) / quadratic)
            expected *= math.tanh(math.sqrt(quadratic * (pull - friction)) * time / mass)
        assert speed == pytest.approx(expected, rel=1e-11)


# --- what holds for every machine and law -----------------------------------------------------------------------------


def surrounded(machine, law):
    """A system with all of an environment that the machine knows."""
    table = dict(EVERYTHING)
    if machine.ground_speed() != 0.0:
        table["quadratic_drag"] = 0.0
    if not machine.over_ground:
        table |= dict.fromkeys(("linear_drag", "quadratic_drag", "force"), 0.0)
    gravity = 1.3 if machine.gravity is None else None
    environment = vc.Environment(**table, gravity=gravity)
    return vc.System(machine, law, vc.Biharmonic(second_amplitude=0.3), environment=environment)


MACHINES = [make() for make in machines().values() if not make.imposes_motion]
MACHINES += [vc.PendulumCapsule(normal_load=load) for load in ("weight", "dynamic")]
SYSTEMS = [surrounded(machine, law) for machine, law in zip(MACHINES, itertools.cycle(LAWS[::8]), strict=False)]
HELD = [surrounded(machine, vc.Exponential()) for machine in MACHINES]


def name_of(system):
    return f"{system.machine.name} {getattr(system.machine, 'normal_load', '')} {system.friction.name}"


def sample(system, draw):
    """(time, state, side) of a contact that slides."""
    t, y, _, _ = machine_draw(system.placed, draw)
    velocities = [contact.velocity for contact in system.placed.contacts(t, y, 0.0)]
    sides = [1 if velocity > 0 else -1 for velocity in velocities]
    each = zip(system.laws, velocities, sides, strict=True)
    first, *further = [random_internal(law, velocity, side, 1.0, draw) for law, velocity, side in each]
    return t, (*y, *(value for internal in further for value in internal), *first), sides[0]


@pytest.mark.parametrize("system", SYSTEMS, ids=name_of)
def test_energy_and_momentum_balance_with_all_channels(system):
    """They change by what the channels and forces say, at states drawn at random."""
    recording, values = equations(system), parameter_values(system)
    energy, momentum = (recording.observables[name] for name in ("energy", "momentum"))
    count = len(system.machine.contact_states)
    friction, velocity = (
        [recording.observables[numbered(name, i)] for i in range(1, 1 + count)]
        for name in ("friction", "contact_velocity")
    )
    outer = recording.observables["outer_force"] - sum(friction)
    friction = sum(force * speed for force, speed in zip(friction, velocity, strict=True))
    powers = dict(zip(recording.channels, recording.powers, strict=True))
    powers = {name: power for name, power in powers.items() if name_and_number(name)[0] not in CONTACT_CHANNELS}
    assert set(powers) >= {"drag", "outer_force"}

    def along(quantity):
        found = derivative(quantity, -1)
        for i, rate in enumerate(recording.rates):
            found = found + derivative(quantity, i) * rate
        return found

    asked = [*recording.rates, *powers.values(), friction, outer, along(energy), along(momentum)]
    for draw in draws(10):
        t, y, side = sample(system, draw)
        *rates, gained, pushed = (float(each) for each in evaluate(asked, t, y, float(side), values))
        *inflow, taken, force = rates[len(recording.rates) :]
        size = 1.0 + max(map(abs, rates)) ** 2
        assert gained == pytest.approx(sum(inflow) - taken, abs=1e3 * np.finfo(float).eps * size)
        assert pushed == pytest.approx(force, abs=1e3 * np.finfo(float).eps * size)


@pytest.mark.parametrize("load", [1.0, "weight", "dynamic"])
@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
def test_reaction_is_the_weight_towards_the_ground_and_the_lift_of_the_bob(load, law):
    system = capsule(load, law, **EVERYTHING)
    recording, values = equations(system), parameter_values(system)
    for draw in draws(10):
        t, y, side = sample(system, draw)
        rate, reaction = evaluate([recording.rates[1], recording.observables["reaction"]], t, y, float(side), values)
        lift = -math.sin(y[0]) * rate - math.cos(y[0]) * y[1] ** 2
        assert reaction == pytest.approx(3.5 * math.cos(EVERYTHING["inclination"]) + lift, rel=1e-12)


@pytest.mark.parametrize("system", HELD, ids=name_of)
def test_a_contact_at_rest_is_held_exactly(system):
    contact = system.state_names.index(system.machine.contact_states[0])
    for draw in draws(10):
        t, y, _ = sample(system, draw)
        y = (*y[:contact], 0.0, *y[contact + 1 :])
        flow = system.flow(t, y, 0)
        assert system.machine.imposes_motion or flow.rates[contact] == 0.0
        assert flow.contacts[0].friction == flow.contacts[0].held


# --- symmetry, starts -------------------------------------------------------------------------------------------------


def test_a_slope_a_force_or_fins_break_the_half_period_symmetry_and_drag_does_not():
    assert capsule(linear_drag=0.2, quadratic_drag=0.1).mirrored
    assert not capsule(linear_drag=0.2, linear_drag_back=0.8).mirrored
    assert not capsule(quadratic_drag=0.2, quadratic_drag_back=0.0).mirrored
    assert not capsule(inclination=0.01).mirrored
    assert not capsule(force=0.01).mirrored


# --- runs of many, cases, SI ------------------------------------------------------------------------------------------


BENCH = {
    "machine": vc.PendulumCapsule.in_si(
        capsule_mass_kg=0.5,
        pendulum_mass_kg=0.2,
        pendulum_length_m=0.25,
        stiffness_N_m_per_rad=0.98,
        damping_N_m_s_per_rad=0.08,
        normal_load="weight",
    ),
    "friction": vc.Exponential.in_si(decay_rate_s_per_m=6.5),
    "drive": vc.Harmonic.in_si(amplitude_N_m=0.9, frequency_Hz=1.0),
}


def test_environment_in_si_has_the_units_of_its_machine(tmp_path):
    outside = vc.Environment.in_si(
        inclination_deg=9.0, linear_drag_N_s_per_m=0.1, quadratic_drag_kg_per_m=0.2, force_N=-0.3
    )
    system = vc.System(**BENCH, environment=outside)
    mass, length, gravity = 0.2, 0.25, 9.80665
    expected = {
        "inclination": math.radians(9.0),
        "linear_drag": 0.1 / (mass * math.sqrt(gravity / length)),
        "quadratic_drag": 0.2 * length / mass,
        "force": -0.3 / (mass * gravity),
    }
    table = {name: getattr(system.environment, name) for name in expected}
    assert table == pytest.approx(expected, rel=1e-14)
    path = vc.save_case(system, tmp_path / "case.toml", periods=2)
    assert "quadratic_drag_kg_per_m = 0.2\n" in path.read_text()
    assert vc.read_case(path).system == system
    plain = vc.save_case(system, tmp_path / "plain.toml", units="dimensionless")
    assert dataclasses.replace(vc.read_case(plain).system, units=system.units) == system
    moon = vc.System(**BENCH, environment=vc.Environment.in_si(gravity_m_per_s2=1.625))
    assert moon.environment.gravity == pytest.approx(1.625 / gravity, rel=1e-14)


def test_case_may_leave_the_environment_out(tmp_path):
    system = capsule()
    assert "environment" not in vc.save_case(system, tmp_path / "plain.toml").read_text()
    assert vc.read_case(tmp_path / "plain.toml").system == system
    changed = vc.read_case(tmp_path / "plain.toml", {"environment.inclination": 0.1}).system
    assert changed == dataclasses.replace(system, environment=vc.Environment(inclination=0.1))
    path = vc.save_case(changed, tmp_path / "slope.toml")
    assert vc.read_case(path).system == changed
    assert changed.with_parameters({"environment.inclination": 0.2}).environment.inclination == 0.2


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"inclination": 0.5 * math.pi}, "inclination: should be less steep than 90 degrees"),
        ({"inclination": -2.0}, "between -pi/2 and pi/2 rad, got -2.0"),
        ({"linear_drag": -0.1}, "linear_drag: should be at least 0, got -0.1"),
        ({"quadratic_drag": -0.1}, "quadratic_drag: should be at least 0, got -0.1"),
        ({"linear_drag_back": -0.1}, "linear_drag_back: should be at least 0, got -0.1"),
        ({"force": math.inf}, "force: should be a finite number"),
        ({"gravity": -1.0}, "gravity: should be at least 0, got -1.0"),
        ({"slope": 0.1}, "slope: there is no such parameter"),
    ],
)
def test_environment_refuses_what_makes_no_sense(given, words):
    with pytest.raises(ParameterError) as caught:
        vc.Environment(**given)
    assert words in str(caught.value)


def test_system_refuses_what_its_machine_cannot_have():
    belt = vc.Oscillator(belt_speed=0.1)
    with pytest.raises(ValueError, match=r"environment\.quadratic_drag should be 0 over ground that moves: its kink"):
        vc.System(belt, vc.Coulomb(), vc.Constant(), environment=vc.Environment(quadratic_drag=0.1))
    for name in ("linear_drag_back", "quadratic_drag_back"):
        with pytest.raises(ValueError, match=rf"environment\.{name} should be .*left out over ground that moves"):
            vc.System(belt, vc.Coulomb(), vc.Constant(), environment=vc.Environment(**{name: 0.1}))
    with pytest.raises(ValueError, match=r"environment\.gravity: is missing: the units of the oscillator"):
        vc.System(belt, vc.Coulomb(), vc.Constant(), environment=vc.Environment(inclination=0.1))
    with pytest.raises(TypeError, match=r"environment should be an environment, got 0\.1"):
        vc.System(belt, vc.Coulomb(), vc.Constant(), environment=0.1)
    with pytest.raises(ValueError, match=r"environment\.inclination: this system has no environment"):
        capsule().with_parameters({"environment.inclination": 0.1})
    with pytest.raises(ValueError, match=r"gravity: is missing.*for run 1"):
        vc.ensemble(
            vc.System(vc.Oscillator(), vc.Coulomb(), vc.Harmonic(), environment=vc.Environment()),
            {"environment.inclination": [0.0, 0.1]},
            measures=("stick_fraction",),
        )


def test_limits_say_what_acts_besides_friction(tmp_path, capsys):
    law = vc.Exponential(coulomb_coefficient=0.1, static_coefficient=0.2)
    gentle = vc.save_case(capsule("weight", law, inclination=0.1, linear_drag=0.2), tmp_path / "gentle.toml")
    record = printed_json(capsys, "friction", gentle)
    weight = 3.5 * math.cos(0.1)
    assert record["load"] == pytest.approx(weight, rel=1e-15)
    assert record["breakaway_force"] == pytest.approx(0.2 * weight, rel=1e-15)
    forward, back = (0.2 * weight + sign * 3.5 * math.sin(0.1) for sign in (1.0, -1.0))
    assert f"breaks away with {forward:.10g} forward and {back:.10g} back" in record["notes"][0]
    assert "without drag" in record["notes"][1]
    steep = vc.save_case(capsule("dynamic", law, inclination=-0.3), tmp_path / "steep.toml")
    text = " ".join(printed(capsys, "friction", steep).split())
    assert "the limits at its mean" in text
    assert "slides forward by itself" in text
    plain = vc.save_case(capsule("weight", law), tmp_path / "plain.toml")
    assert "notes" not in printed_json(capsys, "friction", plain)
