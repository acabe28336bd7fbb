"""Steady curves, comparisons, matched laws, bootstraps, designs and velocity steps through a spring."""

import math

import numpy as np
import pytest

from vibrocap.identification.experiments.comparison import compare, match
from vibrocap.identification.experiments.experiment_design import (
    Motion,
    candidate_motions,
    experiment_design,
    multisine,
    ramp,
    sinusoid,
    synthetic_record,
)
from vibrocap.identification.experiments.parameter_samples import bootstrap
from vibrocap.identification.fit import fit, steady_fit
from vibrocap.identification.problem.coordinates import Coordinate, Space
from vibrocap.identification.problem.prediction import steady_force
from vibrocap.identification.spring_fit import Step, found_step, measured_stiffness, spring_fit
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential, Stribeck
from vibrocap.physics.friction.rate_and_state import RateAndStateAgeing
from vibrocap.records.record import Record

LAW = LuGre(viscous_damping=0.05, bristle_damping=1.0)
MOTIONS = (
    sinusoid(0.003, 0.5, 2, 150),
    ramp(0.5, 8.0, 150),
    multisine(0.05, [1.0, 2.3], 150),
    sinusoid(0.02, 1.0, 2, 150),
)


@pytest.fixture(scope="module")
def records():
    return [synthetic_record(LAW, motion, noise=0.02, seed=i) for i, motion in enumerate(MOTIONS)]


@pytest.fixture(scope="module")
def found(records):
    return fit(records, LAW, starts=1, start="relaxed", intervals="covariance")


def test_coordinates_lead_to_the_same_parameters_whichever_leads():
    space = Space(
        (
            Coordinate("coulomb_coefficient", "log", 1e-3, 1e3),
            Coordinate("viscous_damping", "foot", 0.0, 10.0, scale=1e-3),
            Coordinate("static_coefficient", "above", 0.0, math.inf, partner="coulomb_coefficient"),
        )
    )
    values = {"coulomb_coefficient": 0.2, "viscous_damping": 0.002, "static_coefficient": 0.5}
    for each in (space, space.with_leader("static_coefficient")):
        u = each.of(values)
        back = dict(zip(each.names, each.values(u), strict=True))
        assert all(math.isclose(back[name], value, abs_tol=1e-12) for name, value in values.items())
        step = 1e-6
        numeric = np.array([(each.values(u + step * e) - each.values(u - step * e)) / (2 * step) for e in np.eye(3)]).T
        assert np.allclose(each.slopes(u), numeric, rtol=1e-6, atol=1e-9)
    lead = space.with_leader("static_coefficient")
    moved = dict(zip(lead.names, lead.values(lead.of(values) + np.array([0.3, 0.0, 0.0])), strict=True))
    assert math.isclose(moved["static_coefficient"], 0.5 * math.exp(0.3))


@pytest.mark.parametrize("law", [Exponential(), Stribeck(viscous_damping=0.1), LAW])
def test_the_steady_force_of_arrays_is_that_of_numbers(law):
    velocity = np.array([-2.0, -0.1, 0.0, 0.003, 0.7])
    expected = [math.copysign(1, v) * law.steady_force(abs(v), 2.0) if v else 0.0 for v in velocity.tolist()]
    assert np.allclose(steady_force(law, velocity, 2.0), expected, rtol=1e-14)


def test_a_steady_fit_finds_the_curve_and_holds_what_it_does_not_show():
    velocity = np.concatenate([np.geomspace(1e-3, 1, 150), -np.geomspace(1e-3, 1, 150)])
    force = steady_force(LAW, velocity) * (1 + 0.02 * np.random.default_rng(3).standard_normal(300))
    one = steady_fit(Record("curve", np.arange(300.0), force, velocity=velocity), LuGre, starts=2)
    assert one.free == ("viscous_damping", "coulomb_coefficient", "static_coefficient", "stribeck_velocity")
    for name in one.free:
        assert getattr(LAW, name) in one[name], name
    with pytest.raises(ValueError, match="bristle_stiffness does not change the steady curve"):
        steady_fit(Record("curve", np.arange(300.0), force, velocity=velocity), LuGre, free=["bristle_stiffness"])


def test_a_hidden_static_level_does_not_hold_the_coulomb_level_down():
    """In newtons, far above the law's own values; the curve of Coulomb friction shows nothing of the static level."""
    velocity = np.concatenate([np.linspace(0.01, 1, 60), -np.linspace(0.01, 1, 60)])
    force = 400.0 * np.sign(velocity) + np.random.default_rng(3).standard_normal(120)
    one = steady_fit(Record("curve", np.arange(120.0), force, velocity=velocity), "coulomb", starts=2)
    assert 400.0 in one["coulomb_coefficient"]
    assert one["coulomb_coefficient"].determined
    assert not one["static_coefficient"].determined
    assert one.law.static_coefficient >= one.law.coulomb_coefficient
    lugre = steady_fit(Record("curve", np.arange(120.0), force, velocity=velocity), "lugre", starts=2)
    assert lugre.options["not_shown"] == ["bristle_stiffness", "bristle_damping"]
    assert "does not show bristle_stiffness, bristle_damping" in lugre.summary()


@pytest.mark.slow
def test_laws_are_ranked_by_the_error_where_they_were_not_fitted(records):
    ranking = compare(records, [Exponential, LAW], starts=1, start="relaxed")
    assert [law.law for law in ranking.laws] == ["lugre", "exponential"]
    assert ranking.best.aic == 0 == ranking.best.bic
    assert ranking.laws[1].aic > 100
    assert ranking.best.parameters == 6
    assert ranking.method == "each record in turn"
    assert abs(ranking.best.held_out - 0.02) < 0.003
    assert ranking.summary().splitlines()[1].startswith("lugre")
    with pytest.raises(ValueError, match="'lugre' is given twice"):
        compare(records, [LAW, "lugre"])
    with pytest.raises(ValueError, match="there is none to compare"):
        compare(records, [])


def test_one_record_is_compared_on_its_last_third(records):
    ranking = compare(records[2], [LAW], starts=1, start="relaxed")
    assert ranking.method == "the last third of the record"
    assert ranking.best.held_out < 0.1


def test_a_law_matches_itself_and_leaves_a_difference_to_another():
    same = match(Exponential(decay_rate=4.0), Exponential(), velocity=(1e-3, 1.0))
    assert same.relative_rmse < 1e-6
    assert math.isclose(same.law.decay_rate, 10.0, rel_tol=1e-4)
    other = match(Exponential, LuGre(), velocity=(1e-3, 1.0), starts=2)
    # a planted worse law must differ more than the matched one
    worse = steady_force(Exponential(), other.velocity)
    assert 0.01 < other.relative_rmse < np.sqrt(np.mean((worse - other.target) ** 2) / np.mean(other.target**2))
    assert math.isclose(other.largest, np.abs(other.matched - other.target).max())
    driven = match(LAW, LuGre(), motion=MOTIONS[3], free=["bristle_damping", "viscous_damping"], starts=1)
    assert math.isclose(driven.law.bristle_damping, 10.0, rel_tol=1e-3)
    assert driven.relative_rmse < 1e-4
    with pytest.raises(ValueError, match="either a velocity range or a motion"):
        match(LAW, LuGre())
    for wrong in ((1.0, 0.1), (0.1, math.inf), (0.1, math.nan), 3.0):
        with pytest.raises(ValueError, match="0 < lowest < highest"):
            match(LAW, LuGre(), velocity=wrong)


@pytest.mark.slow
def test_the_bootstrap_scatters_as_the_covariance_says(found):
    drawn = bootstrap(found, replicates=40, over="blocks", seed=1)
    assert drawn.failed == 0
    stated = np.array([found[name].standard_error for name in drawn.names])
    ratio = drawn.values.std(axis=0, ddof=1) / stated
    # 40 draws: a relative error of 0.11; 20 blocks of few samples that matter add as much again
    assert np.all(np.abs(np.log(ratio)) < 0.8), ratio
    assert all(drawn.low[name] < drawn.high[name] for name in drawn.names)
    with pytest.raises(ValueError, match="replicates"):
        bootstrap(found, replicates=2)


@pytest.mark.slow
def test_the_bootstrap_over_records_sees_that_records_differ():
    others = [
        synthetic_record(
            LuGre(viscous_damping=0.05, bristle_damping=1.0, coulomb_coefficient=level), MOTIONS[2], noise=0.02, seed=i
        )
        for i, level in enumerate((0.12, 0.14, 0.16, 0.18))
    ]
    renamed = [each.replaced(name=f"record {i}") for i, each in enumerate(others)]
    one = fit(renamed, LAW, free=["coulomb_coefficient"], starts=1, start="relaxed", intervals="covariance")
    drawn = bootstrap(one, replicates=60)
    assert drawn.over == "records"
    # the mean of four drawn from four levels: their standard deviation over two
    assert math.isclose(drawn.values.std(ddof=1), np.std([0.12, 0.14, 0.16, 0.18]) / 2, rel_tol=0.35)


def test_a_design_names_the_motion_that_determines_what_a_fit_left_open():
    stiff = LuGre(bristle_stiffness=1e4, viscous_damping=0.05)
    time = np.linspace(0.0, 9.0, 450)
    sliding = Motion("one way", time, 0.5 - 0.4 * np.cos(2 * np.pi * 0.25 * time))
    record = synthetic_record(stiff, sliding, noise=0.02).between(1.0, 9.0)
    one = fit(record, stiff, starts=1, intervals="covariance")
    assert "bristle_stiffness" in one.identifiability.undetermined
    small = sinusoid(3e-5, 1.0, 2, 200)
    plan = experiment_design(one, [small], experiments=1)
    assert "bristle_stiffness" in plan.chosen[0].determines
    assert plan.before["bristle_stiffness"] > 0.5 > plan.after["bristle_stiffness"]
    assert plan.sentences[0].startswith(f"{small.name} determines bristle_stiffness")
    both = experiment_design(
        one, [Motion("cruising", time, 0.5 + 0.0 * time), small], experiments=2, parameters=["bristle_stiffness"]
    )
    assert both.rated[0].motion is small


def test_the_information_of_a_motion_is_what_fits_of_it_scatter_by(records):
    noise = 0.02 * float(np.std(synthetic_record(LAW, MOTIONS[0]).force))
    plan = experiment_design(
        LAW, [MOTIONS[0]], noise=noise, criterion="A", experiments=1, parameters=["bristle_stiffness"]
    )
    one = fit(records[0], LAW, free=["bristle_stiffness"], starts=1, start="relaxed", intervals="covariance")
    stated = one["bristle_stiffness"].standard_error / one["bristle_stiffness"].value
    assert math.isclose(plan.after["bristle_stiffness"], stated, rel_tol=0.2)  # noise and correlation are estimated
    with pytest.raises(ValueError, match="noise: is missing"):
        experiment_design(LAW, [MOTIONS[0]])
    with pytest.raises(ValueError, match="criterion"):
        experiment_design(LAW, [MOTIONS[0]], noise=1.0, criterion="E")
    rig = candidate_motions(amplitude=(1e-4, 1e-2), frequency=(0.1, 10.0), speed=0.1)
    assert all(np.abs(each.velocity).max() <= 0.1 * (1 + 1e-9) for each in rig)


BASALT = RateAndStateAgeing(
    reference_coefficient=0.6,
    direct_effect=0.008,
    evolution_effect=0.009,
    critical_distance=8e-6,
    reference_velocity=3e-6,
)


@pytest.fixture(scope="module")
def velocity_step():
    """3 to 10 um/s through a spring of 5000 1/m, by SciPy's Radau on the equations as printed."""
    from scipy.integrate import solve_ivp

    law, stiffness = BASALT, 5000.0
    time = np.concatenate([np.arange(0.0, 20.0, 0.1), np.arange(20.0, 40.0, 0.02)])

    def rates(t, y):
        friction, age = y
        level = law.reference_coefficient + law.evolution_effect * math.log(age * 3e-6 / law.critical_distance)
        speed = 3e-6 * math.exp((friction - level) / law.direct_effect)
        pulled = 3e-6 if t < 21.0 else 10e-6
        return stiffness * (pulled - speed), 1 - speed * age / law.critical_distance

    before = time[time <= 21.0]
    after = time[time > 21.0]
    y = [law.reference_coefficient, law.critical_distance / 3e-6]
    run = solve_ivp(rates, (21.0, 40.0), y, method="Radau", t_eval=after, rtol=1e-9, atol=[1e-12, 1e-9])
    friction = np.concatenate([np.full(len(before), y[0]), run.y[0]])
    displacement = 3e-6 * np.minimum(time, 21.0) + 10e-6 * np.maximum(time - 21.0, 0.0)
    return time, friction, displacement


@pytest.mark.slow
def test_a_velocity_step_through_a_spring_gives_back_its_parameters(velocity_step):
    time, friction, displacement = velocity_step
    noise = 0.0004 * np.random.default_rng(4).standard_normal(len(time))
    jump = 2e-6 * (time > 30.0)  # of the sensor
    record = Record("step", time, friction + noise, displacement=displacement + jump, normal_force=1.0)
    one = spring_fit(record, starts=1, intervals="covariance", drift=False)
    for name in ("direct_effect", "evolution_effect", "critical_distance", "reference_coefficient"):
        assert getattr(BASALT, name) in one[name], name
    assert 5000.0 in one["machine_stiffness"]
    assert one["direct_effect"].high / one["direct_effect"].low < 1.3
    assert [step[1] for step in one.options["program"]] == pytest.approx([3e-6, 10e-6], rel=1e-3)
    held = spring_fit(record, starts=1, intervals="covariance", drift=False, machine_stiffness=5000.0)
    assert held.nuisances == ()
    assert held["direct_effect"].standard_error < one["direct_effect"].standard_error


@pytest.mark.slow
def test_the_spring_prediction_is_that_of_an_independent_integrator(velocity_step):
    time, friction, displacement = velocity_step
    exact = Record("step", time, friction, displacement=displacement, normal_force=1.0)
    program = [Step(0.0, 3e-6), Step(21.0, 10e-6)]
    one = spring_fit(exact, starts=1, intervals="covariance", drift=False, program=program)
    # the least change that counts: 1e-4 of ln V per step, times a
    assert np.abs(one.records[0].predicted - friction).max() < 10 * 1e-4 * BASALT.direct_effect
    assert math.isclose(one.law.critical_distance, BASALT.critical_distance, rel_tol=1e-2)


def test_a_step_is_found_beside_jumps_of_the_sensor(velocity_step):
    from vibrocap.identification.problem.samples import samples

    time, friction, displacement = velocity_step
    wobble = 2e-7 * np.random.default_rng(0).standard_normal(len(time))
    jumps = 3e-6 * (time > 8.0) + 2e-6 * (time > 30.0)
    record = Record("step", time, friction, displacement=displacement + jumps + wobble, normal_force=1.0)
    first, second = found_step(samples(record), record.displacement)
    # noise over the change of slope, 0.2 um / 7 um/s, over the root of some 20 samples
    assert abs(second.time - 21.0) < 4 * 0.2 / 7 / math.sqrt(20)
    assert math.isclose(first.speed, 3e-6, rel_tol=0.05)
    assert math.isclose(second.speed, 10e-6, rel_tol=0.02)
    read = measured_stiffness(samples(record), (first, second))
    assert 2000.0 < read < 5000.0  # a lower bound of 5000


def test_bad_programs_get_a_message(velocity_step):
    time, friction, displacement = velocity_step
    record = Record("step", time, friction, displacement=displacement, normal_force=1.0)
    for program, words in (
        ([Step(0.0, 3e-6)], "at least two speeds"),
        ([Step(0.0, 3e-6), Step(20.0, -1e-6)], "every speed should be > 0"),
        ([Step(0.0, 3e-6), Step(50.0, 1e-5)], "end within the record"),
        ([Step(0.0, 3e-6), Step(20.0, 3e-6)], "hardly changes"),
    ):
        with pytest.raises(ValueError, match=words):
            spring_fit(record, program=program)
    with pytest.raises(ValueError, match="rate-and-state"):
        spring_fit(record, "lugre", program=[Step(0.0, 3e-6), Step(21.0, 1e-5)])
