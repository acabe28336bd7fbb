"""The normal load that the pendulum makes: values found by another solver, identities, and where it ends."""

import dataclasses

import numpy as np
import pytest

import vibrocap as vc
from cases import printed_json
from thinned import exhaustive_but, slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import Case, case_from_text, case_text
from vibrocap.cli.main import main
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.api import Budget, EnsembleStart, Form, ensemble_run
from vibrocap.orbits.maps.variations import variational_equations
from vibrocap.studies.plan.planning import planned_study
from vibrocap.studies.plan.variation import varied

pytestmark = pytest.mark.plain

SECOND_HARMONIC = 0.4
START = {"angle": 0.2}
WEIGHT = 3.5  # lambda + 1 in one number: the form of the machine that most tests share
SETTINGS = {
    "periods": 2,
    "tolerance": 1e-7,
    "max_events_per_period": 100,
    "max_steps": 1000,
    "window": 1,
    "settle": 0,
    "extrapolate": True,
}


def capsule(load="dynamic", law=None, amplitude=1.2, **parameters):
    """The capsule of the reference rows: lambda 2.5, rho 2, nu 1, h2 0.4, and the first row's law."""
    law = law or vc.Exponential(coulomb_coefficient=0.05, static_coefficient=0.1, decay_rate=10.0)
    drive = vc.Biharmonic(amplitude=amplitude, frequency=1.0, second_amplitude=SECOND_HARMONIC)
    return vc.System(vc.PendulumCapsule(normal_load=load, **parameters), law, drive)


def test_state_is_that_of_an_independent_solver():
    motion = vc.simulate(capsule(), periods=40, initial=START, tolerance=1e-11)
    known = {"angle": 0.188621822995, "angle_rate": 1.310110531562, "velocity": 0.236601626718}
    assert {name: motion.state[name] for name in known} == pytest.approx(known, abs=1e-11)


def test_light_capsule_lifts_off():
    law = vc.Exponential(coulomb_coefficient=0.15, static_coefficient=0.45)
    system = capsule(law=law, amplitude=1.8, mass_ratio=0.5)
    motion = vc.simulate(system, periods=40, initial=START)
    assert motion.status is vc.Status.LIFT_OFF
    assert motion.events[-1].kind == "lift_off"
    assert motion.events[-1].time == motion.end
    assert 0.0 < motion.end < 2 * motion.period
    load = motion.at(np.linspace(0.0, motion.end, 1001), "reaction")
    assert np.all(load[:-1] > 0.0)
    assert load[-1] == pytest.approx(0.0, abs=1e-8)  # it falls with a slope of order 10; the time is known to 1e-13
    constant = dataclasses.replace(system, machine=dataclasses.replace(system.machine, normal_load=1.5))
    assert vc.simulate(constant, periods=2, initial=START)["reaction"].min() < 0.0


LIGHT = vc.Exponential(coulomb_coefficient=0.15, static_coefficient=0.45)
TOUCHING = 1.20065944821  # amplitude at which the load of `light` touches zero, from halving with a tolerance of 1e-13


def light(amplitude):
    return capsule("dynamic", LIGHT, amplitude, mass_ratio=1.0)


def test_a_load_shortens_the_steps_near_zero_only():
    """Far from it a motion has the steps of one with a constant load; where it touches zero nothing is stepped over."""
    runs = [vc.simulate(capsule(load), periods=10, initial=START, tolerance=1e-8) for load in ("dynamic", WEIGHT)]
    steps = [len(run.piece_start) for run in runs]
    assert steps[0] < 1.1 * steps[1]  # 1.05; 1.51 where the load was held to the tolerance always
    for moved, status in ((-1e-8, vc.Status.FINISHED), (1e-8, vc.Status.LIFT_OFF)):
        assert vc.simulate(light(TOUCHING + moved), periods=3, initial=START, tolerance=1e-8).status is status


@pytest.mark.parametrize(("drive", "status"), [(-0.5, vc.Status.PARADOX), (2.0, vc.Status.PARADOX)])
def test_start_in_the_region_of_the_paradox_is_a_status(drive, status):
    """Sliding forward with 1 < s mu: n > 0 has no way to go on, n < 0 has two."""
    law = vc.Exponential(coulomb_coefficient=0.45, static_coefficient=0.45)
    system = vc.System(vc.PendulumCapsule(mass_ratio=0.02, normal_load="dynamic"), law, vc.Harmonic(amplitude=drive))
    start = {"angle": 0.14, "velocity": 0.5}
    own, slope = system.machine.contacts(0.0, (0.14, 0.0, 0.0, 0.5), drive)[0].reaction
    assert 1.0 - 0.45 * slope < 0.0
    assert (own > 0.0) == (drive < 0.0)
    motion = vc.simulate(system, periods=1, initial=start)
    assert motion.status is status
    assert motion.end == 0.0
    sliding_back = {"periods": 1, "initial": start | {"velocity": -0.5}}  # there friction unloads the contact
    if own < 0.0:
        with pytest.raises(ValueError, match="the normal load is negative at the start"):
            vc.simulate(system, **sliding_back)
    else:
        back = vc.simulate(system, **sliding_back)
        assert back.status is not status or back.end > 0.0


@pytest.mark.parametrize(
    ("law", "mass_ratio", "end"),
    slow_but([], exhaustive_but([0], [(vc.LuGre(), 0.05, 4.5105962213216), (vc.LuGre(), 0.08, 4.5595456357635)])),
)
def test_bristles_come_to_the_paradox(law, mass_ratio, end):
    """The divisor 1 - s mu falls to zero like the root of the time left, N grows beyond all bounds: no small steps.

    Ends: DOP853 in the time s with dt = (1 - s mu) ds, in which the divisor passes zero with a slope. The run ends
    within 1e-12 of a period before, and the solver's events are known to about as much.
    """
    machine = vc.PendulumCapsule(mass_ratio=mass_ratio, stiffness=4.0, damping=1.2, normal_load="dynamic")
    system = vc.System(machine, law, vc.Harmonic(amplitude=1.8))
    motion = vc.simulate(system, periods=2, initial={"angle": np.pi / 3, "bristle": 0.0026}, tolerance=1e-12)
    assert motion.status is vc.Status.PARADOX
    assert motion.events[-1].kind == "paradox"
    assert motion.events[-1].time == motion.end == pytest.approx(end, abs=3e-11)
    assert motion.at(motion.end, "reaction")[0] > 1e4
    states = tuple(motion.state[name] for name in system.state_names)
    own, slope = machine.contacts(motion.end, states[:4], system.drive.value(motion.end))[0].reaction
    coefficient, _ = law.force(states[3], states[4:], np.sign(states[3]), 1.0)
    assert own > 0.1
    assert 0.0 < (mass_ratio + np.sin(states[0]) ** 2) * (1.0 - slope * coefficient) < 1e-5
    assert abs(coefficient) > 2.0 * np.sqrt(mass_ratio * (mass_ratio + 1.0))


@pytest.mark.slow
def test_statuses_of_ensembles_are_those_of_single_runs():
    draw = np.random.default_rng(5)
    ratios = np.concatenate((draw.uniform(0.1, 3.0, 12), draw.uniform(0.01, 0.06, 12)))
    over = {"machine.mass_ratio": ratios, "drive.amplitude": draw.uniform(0.2, 2.5, 24)}
    system = capsule(law=vc.Exponential())
    results = vc.ensemble(system, over=over, initial=START, periods=6, window=2, tolerance=1e-9)
    single = []
    for i in range(24):
        one = system.with_parameters({path: float(values[i]) for path, values in over.items()})
        try:
            single.append(vc.simulate(one, periods=6, initial=START, tolerance=1e-9).run_status)
        except ArgumentError:  # of a load that is negative at the start
            single.append(vc.Status.LIFT_OFF)
    assert [list(vc.Status)[code] for code in results["status"]] == single
    assert {vc.Status.FINISHED, vc.Status.LIFT_OFF, vc.Status.PARADOX} == set(single)


def test_a_constant_load_that_hides_a_lift_off_is_said(tmp_path, capsys):
    law = vc.Exponential(coulomb_coefficient=0.15, static_coefficient=0.45)
    light = capsule(1.5, law, amplitude=1.8, mass_ratio=0.5)
    hidden = vc.simulate(light, periods=3, initial=START).certificate
    assert hidden.ok  # the motion is that of its equations
    assert hidden.least_reaction < -2.0
    assert len(hidden.warnings) == 1
    assert 'use normal_load = "dynamic"' in hidden.warnings[0]
    path = str(vc.save_case(light, tmp_path / "light.toml", initial=START, periods=3))
    assert printed_json(capsys, "simulate", path)["certificate"]["warnings"] == list(hidden.warnings)
    assert main(["simulate", path]) == 0
    assert "Warning: the true normal load would be negative" in " ".join("".join(capsys.readouterr()).split())
    for load in (WEIGHT, "dynamic"):
        certificate = vc.simulate(capsule(load), periods=3, initial=START).certificate
        assert certificate.least_reaction > 1.0
        assert not certificate.warnings
    assert vc.simulate(vc.System(vc.Oscillator(), law, vc.Harmonic()), periods=1).certificate.least_reaction is None


@pytest.mark.parametrize("velocity", [0.0, 0.3])
def test_a_load_that_is_negative_at_the_start_is_refused(velocity):
    """Upright and as fast as that, the bob pulls with rate^2 where the weight is 3.5."""
    start = {"angle_rate": 2.0, "velocity": velocity}
    with pytest.raises(ValueError, match=r"initial: the normal load is negative at the start, -0\.5: .*angle_rate 2"):
        vc.simulate(capsule(), initial=start)
    assert vc.simulate(capsule(WEIGHT), initial=start, periods=0.01).status.ok
    assert vc.simulate(capsule(), initial=start | {"angle_rate": 1.8}, periods=0.01).status.ok


# Amplitudes at which the true load, lambda + 1 - (sin(theta) theta'' + cos(theta) theta'^2), just touches zero, once in
# three periods; and how much higher it is at the starts of steps, between which the dip lies.
@pytest.mark.parametrize(
    ("law", "amplitude", "hidden"),
    exhaustive_but([0], [(vc.Exponential(), 2.033690010115348, 0.05), (vc.LuGre(), 2.038711113022009, 0.02)]),
)
@pytest.mark.slow
def test_runs_that_would_lift_off_are_told_from_those_that_touch_zero(law, amplitude, hidden):
    system = vc.System(vc.PendulumCapsule(normal_load=3.5), law, vc.Harmonic(amplitude=amplitude))
    options = {"periods": 3, "window": 3, "initial": START, "measures": ["hidden_lift_off"]}
    motion = vc.simulate(system, periods=3, initial=START, tolerance=1e-6)
    starts = motion.piece_observables(("reaction",), np.arange(len(motion.piece_start)), 0.0 * motion.piece_start)
    assert starts.min() > hidden
    assert motion.certificate.least_reaction == pytest.approx(0.0, abs=1e-6)
    for tolerance, off in ((1e-4, 1e-3), (1e-6, 1e-5), (1e-8, 1e-7)):  # the load falls by 3 per amplitude
        over = {"drive.amplitude": amplitude + off * np.array([-1.0, 1.0])}
        assert vc.ensemble(system, over, tolerance=tolerance, **options)["hidden_lift_off"].tolist() == [0.0, 1.0]
    for off, lifts in ((-1e-5, 0.0), (1e-5, 1.0)):
        near = system.with_parameters({"drive.amplitude": amplitude + off})
        one = vc.simulate(near, periods=3, initial=START, tolerance=1e-6)
        assert vc.measured(one, "hidden_lift_off", window=3)["hidden_lift_off"] == lifts
        assert bool(one.certificate.warnings) == bool(lifts)
    states = np.array([[START.get(name, 0.0) for name in system.state_names]])
    budget, parameters = Budget(3, 1e-6, 100, 10_000), np.array([parameter_values(near)])
    assert ensemble_run(
        EnsembleStart(equations(near), parameters, states), budget, Form(lanes=1, plain=True)
    ).lifted == [1.0]


def test_every_study_of_a_constant_load_watches_the_true_one():
    """But not where the least value is measured, or where the load is the true one."""
    settings = {"cases": None, "design": None, "initial": None, "settings": SETTINGS}
    for load, measures, watch in (
        ("weight", ("drift",), ("hidden_lift_off",)),
        ("weight", ("least_reaction",), ()),
        ("dynamic", ("drift",), ()),
    ):
        plan = planned_study(capsule(load), {"machine.mass_ratio": [0.2, 2.5]}, measures=measures, **settings)
        assert plan.measures == (*measures, *watch)


@pytest.mark.slow
def test_a_tangent_takes_the_steps_of_its_motion():
    """That of the position is no tangent that anything depends on, and asked for steps of 1e-7 of a period.

    The derivatives of a load that is a quotient are quotients by the same divisor, and were looked at as if they could
    hide in a step: of a light capsule with bristles, whose load ends, 2 10^6 steps were taken in ten minutes.
    """
    system = vc.System(vc.PendulumCapsule(mass_ratio=0.2, normal_load="dynamic"), vc.LuGre(), vc.Harmonic())
    recorded, row = equations(system), np.array(parameter_values(system))[None]
    start, budget = np.zeros((1, 10)), Budget(1, 1e-6, 1000, 500)
    start[0, [0, 1, 7]] = -1.0, -1.0, 1.0
    alone = ensemble_run(EnsembleStart(recorded, row, start[:, :5]), budget, Form(order=6))
    along = ensemble_run(EnsembleStart(variational_equations(recorded), row, start), budget, Form(order=6))
    assert along.status == alone.status
    assert along.head("taylor_steps") == alone.head("taylor_steps")


@pytest.mark.slow
@pytest.mark.parametrize(("mass_ratio", "end"), [(0.03, 0.217156157262), (0.07, 0.210985337175)])
def test_a_light_capsule_with_bristles_comes_to_its_lift_off(mass_ratio, end):
    """At the end by DOP853 at 1e-12 on the equations of docs/model.md, in steps of at most 1e-3.

    It went by steps of 1e-14 as soon as it was fast: a bound of its load passed infinity, whatever the step.
    """
    numbers = {"mass_ratio": mass_ratio, "stiffness": 2.0, "damping": 0.5}
    system = vc.System(
        vc.PendulumCapsule(normal_load="dynamic", **numbers), vc.LuGre(), vc.Harmonic(amplitude=1.8, frequency=1.0)
    )
    start = {"angle": -0.7, "angle_rate": 1.0, "velocity": 2.6}
    run = vc.simulate(system, periods=2, initial=start, tolerance=1e-10, max_steps=1000)
    assert run.status is vc.Status.LIFT_OFF
    assert all(verdict.ok for verdict in run.certificate.verdicts), run.certificate.failures
    assert run.end == pytest.approx(end, abs=1e-8)


# --- in SI ------------------------------------------------------------------------------------------------------------
LUGRE = {"coulomb_coefficient": 0.1, "static_coefficient": 0.2, "stribeck_velocity_m_per_s": 0.05}
OVER_LOAD = {"bristle_stiffness_per_m": 2000.0, "bristle_damping_s_per_m": 8.0, "viscous_damping_s_per_m": 0.4}
AT_A_LOAD = {"bristle_stiffness_N_per_m": 2000.0, "bristle_damping_N_s_per_m": 8.0, "viscous_damping_N_s_per_m": 0.4}


def in_si(load, law):
    bob = {"pendulum_mass_kg": 0.2, "pendulum_length_m": 0.25, "capsule_mass_kg": 0.5}
    joint = {"stiffness_N_m_per_rad": 0.98, "damping_N_m_s_per_rad": 0.08}
    machine = vc.PendulumCapsule.in_si(**bob, **joint, normal_load=load)
    return vc.System(machine, law, vc.Harmonic.in_si(amplitude_N_m=0.9, frequency_Hz=1.1))


@pytest.mark.parametrize(("load", "unit"), [("dynamic", "1"), ("weight", "N")])
def test_states_of_a_law_are_over_a_load_that_follows_the_motion(load, unit):
    """R/N = sum F_i + delta2 v of a Maxwell-slip law, whose F_i are forces at a constant load only."""
    over = {"dynamic": ("per_m", "s_per_m"), "weight": ("N_per_m", "N_s_per_m")}[load]
    elements = {f"stiffness_{i}_{over[0]}": 100.0 * i for i in (1, 2, 3, 4)}
    levels = {"coulomb_coefficient": 0.1, "static_coefficient": 0.2, "stribeck_velocity_m_per_s": 0.05}
    law = vc.MaxwellSlip.in_si(**levels, **elements, attraction_rate_per_s=20.0, **{f"viscous_damping_{over[1]}": 0.4})
    system = in_si(load, law)
    motion = vc.simulate(system, periods=2, initial={"element_force_1": 0.01})
    names = [f"element_force_{i}" for i in (1, 2, 3, 4)]
    per_load = sum(motion[name] for name in names) + 0.4 * motion["velocity"]
    load_on_it = motion["reaction"] if load == "dynamic" else 1.0
    np.testing.assert_allclose(motion["friction"], load_on_it * per_load, atol=1e-12)
    assert motion[names[0]][0] == pytest.approx(0.01)
    assert motion.unit_of(names[0]) == unit
    assert motion.unit_of("element_force_1_rate") == {"1": "1/s", "N": "N/s"}[unit]
    case = Case(system, initial={"element_force_1": 0.01 / system.si.factor("element_force_1")})
    assert case_from_text(case_text(case)) == case


@pytest.mark.parametrize(
    ("load", "keys", "words"),
    [
        (
            "dynamic",
            AT_A_LOAD,
            "friction.viscous_damping_N_s_per_m: is that at a constant load.*viscous_damping_s_per_m",
        ),
        ("weight", OVER_LOAD, "friction.viscous_damping_s_per_m: no such key in SI.*viscous_damping_N_s_per_m"),
    ],
)
def test_units_of_a_law_of_the_other_kind_of_load_are_refused(load, keys, words):
    law = vc.LuGre.in_si(**LUGRE, **keys)
    with pytest.raises(ValueError, match=words):
        in_si(load, law)


def test_a_sweep_over_the_load_asks_for_what_is_then_over_it():
    system = in_si("weight", vc.LuGre.in_si(**LUGRE, **AT_A_LOAD))
    with pytest.raises(ValueError, match="bristle_stiffness_per_m: is missing; it has another unit"):
        vc.sweep(system, over={"machine.normal_load": ["weight", "dynamic"]})
    coulomb = in_si("weight", vc.Coulomb(0.1, 0.2))
    assert varied(coulomb, {"machine.normal_load": "dynamic"}).machine.follows_load
