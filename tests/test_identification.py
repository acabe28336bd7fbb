"""Fits of friction laws: known parameters come back, what data do not determine is said, bad input gets a message."""

import dataclasses
import json
import math
import re

import numpy as np
import pytest

from bench_case import BENCH
from vibrocap.identification.experiments.experiment_design import (
    Motion,
    joined,
    multisine,
    ramp,
    sinusoid,
    synthetic_record,
)
from vibrocap.identification.fit import fit
from vibrocap.identification.fit_result import case_section
from vibrocap.identification.inference import uncertainty as uncertainty_module
from vibrocap.identification.inference.uncertainty import correlation_time
from vibrocap.identification.search import SearchStatus
from vibrocap.physics.catalogue import law as law_of
from vibrocap.physics.dimensions.units import parameter_keys
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Coulomb, Exponential
from vibrocap.quantities.json_text import plain
from vibrocap.records.record import Record

TRUTH = LuGre(viscous_damping=0.05, bristle_damping=1.0)
QUICK = {"starts": 2, "start": "relaxed"}


def record(law=TRUTH, *, noise=0.02, seed=0, motion=None):
    """Presliding loops, slides and a sweep of speed: every parameter of LuGre's law shows."""
    motion = motion or joined(
        [
            sinusoid(0.001, 0.5, 1, 80),
            sinusoid(0.004, 2.0, 2, 120),
            ramp(0.4, 6.0, 200),
            multisine(0.06, [1.0, 3.1], 200),
        ],
        "all of it",
    )
    return synthetic_record(law, motion, noise=noise, seed=seed)


@pytest.fixture(scope="module")
def found():
    return fit(record(), "lugre", **QUICK)


def test_a_fit_finds_the_parameters_that_made_the_record(found):
    assert found.status == SearchStatus.CONVERGED
    # 2 % noise over the standard deviation is what remains; the deviation of that estimate is 0.02/sqrt(2 n)
    assert abs(found.relative_rmse - 0.02) < 5 * 0.02 / math.sqrt(2 * found.samples)
    for name in found.free:
        assert getattr(TRUTH, name) in found[name], name
        assert found[name].determined, name
        assert found[name].high / found[name].low < 1.5, name


def test_numbers_that_are_rounding_are_printed_as_zero(found):
    tiny = dataclasses.replace(found["viscous_damping"], value=3e-17, low=-2e-18, high=0.1)
    text = dataclasses.replace(found, parameters=(tiny,)).summary()
    assert re.search(r"^viscous_damping +0 +0 to 0.1 ", text, re.MULTILINE)


def test_profile_intervals_are_those_of_the_covariance_where_the_law_is_nearly_linear(found):
    for name in found.free:
        one = found[name]
        # half widths: t s on both; the profile's ends are found to 3 %, curvature adds what is left
        assert math.isclose(one.high - one.low, 2 * 1.97 * one.standard_error, rel_tol=0.15), name


def test_same_input_same_numbers_whatever_the_threads(found):
    again = fit(record(), "lugre", **QUICK, threads=1)
    assert [(p.value, p.low, p.high) for p in again.parameters] == [(p.value, p.low, p.high) for p in found.parameters]


@pytest.mark.slow
def test_a_stiffness_without_presliding_is_not_determined_and_an_experiment_is_named():
    """Seen while sliding is bristle damping over stiffness alone: a stiffness held down would pin the damping."""
    stiff = LuGre(bristle_stiffness=1e4, bristle_damping=10.0, viscous_damping=0.05)
    time = np.linspace(0.0, 9.0, 450)
    sliding = Motion("one way", time, 0.5 - 0.4 * np.cos(2 * np.pi * 0.25 * time))
    one = fit(record(stiff, motion=sliding).between(1.0, 9.0), "lugre", starts=2)
    for name in ("bristle_stiffness", "bristle_damping"):
        assert not one[name].determined, name
        assert getattr(stiff, name) in one[name], name
    stiffness = one["bristle_stiffness"]
    assert not math.isfinite(stiffness.high) or stiffness.high > 10 * stiffness.low
    assert "bristle_stiffness" in one.identifiability.undetermined
    assert any("presliding loops" in sentence for sentence in one.identifiability.sentences)
    # the level of sliding is determined all the same
    assert one["coulomb_coefficient"].determined
    assert TRUTH.coulomb_coefficient in one["coulomb_coefficient"]


@pytest.mark.parametrize("intervals", ["profile", "covariance"])
@pytest.mark.parametrize("free", [None, ["static_coefficient"]])
def test_a_parameter_without_effect_is_not_determined_and_never_nan(intervals, free):
    """Coulomb's static level acts at rest alone; here it is one of two parameters, and the only one."""
    one = fit(record(Coulomb(), motion=ramp(0.4, 6.0, 200)), Coulomb(), free=free, intervals=intervals, starts=2)
    static = one["static_coefficient"]
    assert not static.determined
    assert (static.low, static.high) == (0.0, math.inf)
    assert math.isfinite(static.value)
    assert static.standard_error == math.inf
    assert "static_coefficient is not determined" in " ".join(one.identifiability.sentences)
    assert "nan" not in one.summary().lower()
    json.dumps(plain(one), allow_nan=False)  # raises where there is a NaN
    if free is None:
        assert one["coulomb_coefficient"].high < 1.02 * one["coulomb_coefficient"].low


def test_the_inverse_of_no_information_is_large_and_finite():
    for matrix in (np.zeros((1, 1)), np.zeros((2, 2)), np.diag([1.0, 0.0]), np.diag([1e-300, 4.0])):
        inverse = uncertainty_module.inverse(matrix)
        assert np.isfinite(inverse).all()
        assert np.all(np.diag(inverse)[np.diag(matrix) < 1e-20] > 1e15)
    assert math.isclose(uncertainty_module.inverse(np.diag([4.0, 0.0]))[0, 0], 0.25)


def test_a_redundant_combination_is_named():
    anisotropic = law_of("anisotropic-lugre")(viscous_damping=0.05, bristle_damping=1.0, back_ratio=1.3)
    everything = ("coulomb_coefficient", "static_coefficient", "forward_ratio", "back_ratio")
    one = fit(record(anisotropic), anisotropic, free=everything, starts=1, start="relaxed")
    # levels times ratios are all that the force knows: the scale of one against the other is free
    assert set(one.identifiability.undetermined) == set(everything)
    loose = [direction for direction in one.identifiability.directions if not direction.determined]
    assert len(loose) == 1
    assert all(abs(abs(loose[0].exponents[name]) - 0.5) < 0.02 for name in everything)
    assert any("combination" in sentence for sentence in one.identifiability.sentences)


def test_a_robust_loss_bears_outliers():
    plain = record()
    force = plain.force.copy()
    struck = np.random.default_rng(5).choice(len(force), len(force) // 20, replace=False)
    force[struck] += 1.0
    spoilt = plain.replaced(force=force)
    error = {}
    for loss in ("linear", "soft_l1"):
        one = fit(spoilt, TRUTH, loss=loss, intervals="covariance", starts=1, start="relaxed")
        error[loss] = abs(one["coulomb_coefficient"].value / TRUTH.coulomb_coefficient - 1)
    assert error["soft_l1"] < 0.3 * error["linear"]


def test_the_start_of_the_contact_is_fitted_where_the_record_begins_under_load():
    motion = joined([sinusoid(0.003, 1.0, 1.75, 150), ramp(0.4, 6.0, 200)], "cut")
    whole = record(motion=motion)
    cut = whole.between(0.8, whole.time[-1])  # begins with deflected bristles
    fitted = fit(cut, TRUTH, starts=1, start="fitted", intervals="covariance")
    relaxed = fit(cut, TRUTH, starts=1, start="relaxed", intervals="covariance")
    assert fitted.relative_rmse < 0.025 < relaxed.relative_rmse
    assert abs(fitted["bristle_stiffness"].value / TRUTH.bristle_stiffness - 1) < 0.05


def test_correlated_errors_widen_the_intervals():
    white = np.random.default_rng(1).standard_normal(20_000)
    assert correlation_time(white) < 1.15
    smooth = np.empty_like(white)
    smooth[0] = white[0]
    for i in range(1, len(white)):
        smooth[i] = 0.8 * smooth[i - 1] + white[i]
    assert math.isclose(correlation_time(smooth), 9.0, rel_tol=0.15)  # (1 + 0.8)/(1 - 0.8)
    plain = record(noise=0.0)
    noise = np.convolve(np.random.default_rng(2).standard_normal(len(plain) + 19), np.ones(20) / 20, mode="valid")
    noisy = plain.replaced(force=plain.force + 0.02 * np.std(plain.force) * noise / np.std(noise))
    one = fit(noisy, TRUTH, starts=1, start="relaxed", intervals="covariance")
    assert one.effective_samples < one.samples / 8
    j = one.problem.prediction.space.names.index("coulomb_coefficient")
    assert one.problem.uncertainty.inflation[j] > 5


def test_a_saved_fit_reads_back_and_its_law_runs_in_a_case(found, tmp_path):
    from vibrocap.case.case import case_from_text

    data_path, case_path = found.save(tmp_path / "out")
    data = json.loads(data_path.read_text())
    (stiffness,) = [row["value"] for row in data["parameters"] if row["name"] == "bristle_stiffness"]
    assert stiffness == {"value": found.law.bristle_stiffness, "unit": "N/m"}
    assert data["parameters"][0]["low"]["value"] == found["bristle_stiffness"].low
    assert data["identifiability"]["verdicts"]["bristle_stiffness"] == "determined"
    loaded = BENCH.replace('normal_load = "weight"', "normal_load_N = 1.0")  # its levels are forces
    case = case_from_text(loaded + case_path.read_text())
    law = {key: case.system.parameter(f"friction.{key}") for key in parameter_keys(LuGre, "torque")}
    for key in parameter_keys(LuGre, "force").values():
        value = getattr(found.law, key.name)
        assert law[key.key] == (value and pytest.approx(value, rel=1e-14))
    assert case_section(Exponential()).splitlines()[:2] == ["[friction]", 'law = "exponential"']
    assert plain(found)["samples"] == found.samples


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"law": "lugr"}, "did you mean 'lugre'"),
        ({"free": ["bristle_stifness"]}, "did you mean 'bristle_stiffness'"),
        ({"free": []}, "no parameter of lugre is free"),
        ({"fixed": {"gap": 1.0}}, "lugre has no parameter 'gap'"),
        ({"free": ["bristle_stiffness"], "fixed": {"bristle_stiffness": 1.0}}, "also in fixed"),
        ({"bounds": {"bristle_stiffness": (10.0, 1.0)}}, "lower bound first"),
        ({"law": LuGre(), "bounds": {"bristle_stiffness": (1.0, 10.0)}}, "starts at 100, outside"),
        (
            {"free": ["coulomb_coefficient"]},
            "leaves bristle_stiffness, .* and stribeck_velocity of lugre without a value",
        ),
        ({"loss": "l2"}, "loss should be one of"),
        ({"starts": 0}, "starts should be a whole number"),
        ({"start": "rest"}, "start should be one of"),
        ({"intervals": "bayes"}, "intervals should be one of"),
        ({"weights": "none"}, "weights should be one of"),
        ({"held_out": "other"}, "no record is called 'other'"),
        ({"held_out": "all of it"}, "leaves no record"),
        ({"load": -1.0}, "load should be a normal force > 0"),
        ({"records": []}, "there is none"),
        ({"records": [record(), record()]}, "different names"),
    ],
)
def test_bad_input_gets_a_message(arguments, words):
    settings = {"records": record(), "law": "lugre", **arguments}
    with pytest.raises(ValueError, match=words):
        fit(settings.pop("records"), settings.pop("law"), **settings)


def test_more_parameters_than_samples_are_refused():
    few = record(motion=sinusoid(0.01, 1.0, 1, 8))
    with pytest.raises(ValueError, match="8 samples for 10 free parameters"):
        fit([few], "lugre", terms=("offset", "mass"), start="fitted", free=[*fit_names(), "stribeck_exponent"])


def fit_names():
    return ["bristle_stiffness", "bristle_damping", "viscous_damping", "coulomb_coefficient", "static_coefficient",
            "stribeck_velocity"]  # fmt: skip


def test_where_every_start_fails_the_status_says_so(monkeypatch):
    from vibrocap.identification.problem import prediction

    class Nothing:
        def __init__(self, force):
            self.force = force

    monkeypatch.setattr(
        prediction,
        "driven_forces",
        lambda law, rows, names, time, *_, **__: Nothing(np.full((len(rows), len(time)), np.nan)),
    )
    one = fit(record(), "lugre", **QUICK)
    assert one.status == SearchStatus.FAILED
    assert one.law is None
    assert not one.ok
    assert "no start could be driven" in one.summary()
    with pytest.raises(ValueError, match="has no law to save"):
        one.save("nowhere")


def test_forces_in_newtons_of_an_unknown_load_are_fitted_at_their_own_scale():
    plain = record()
    bare = Record("in kilonewtons", plain.time, plain.force * 2e4, velocity=plain.velocity)
    one = fit(bare, "lugre", intervals="covariance", **QUICK)
    assert math.isclose(one.law.coulomb_coefficient, 2e4 * TRUTH.coulomb_coefficient, rel_tol=0.03)
    assert math.isclose(one.law.bristle_stiffness, 2e4 * TRUTH.bristle_stiffness, rel_tol=0.05)
    assert one["coulomb_coefficient"].unit == "N"


def scatter_over_stated(count=12):
    """Scatter of a level fitted to records with correlated noise, over the standard error that the fits state."""
    plain = record(noise=0.0)
    values, errors = [], []
    for seed in range(count):
        rough = np.random.default_rng(seed).standard_normal(len(plain) + 19)
        noise = np.convolve(rough, np.ones(20) / 20, mode="valid")
        noisy = plain.replaced(force=plain.force + 0.02 * np.std(plain.force) * noise / np.std(noise))
        one = fit(noisy, TRUTH, starts=1, start="relaxed", intervals="covariance")
        values.append(one["coulomb_coefficient"].value)
        errors.append(one["coulomb_coefficient"].standard_error)
    return np.std(values, ddof=1) / np.mean(errors)


@pytest.mark.slow
def test_stated_errors_hold_for_correlated_noise_and_would_not_without_the_correlation(monkeypatch):
    # the standard deviation of 12 values has a relative error of 1/sqrt(22) = 0.21: three of them either way
    assert abs(math.log(scatter_over_stated())) < 0.64
    monkeypatch.setattr(uncertainty_module, "_inflation", lambda *_: 1.0)
    assert math.log(scatter_over_stated()) > 0.64
