"""Several records in one fit, terms of the sensor, and what is known beforehand: known numbers come back."""

import numpy as np
import pytest

from vibrocap.identification.fitting.fit import fit
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.physics.friction.coulomb import Coulomb
from vibrocap.records.record import Record

LAW = Coulomb(0.3, 0.3)
QUICK = {"free": ["coulomb_coefficient"], "fixed": {"static_coefficient": 1.0}, "intervals": "covariance", "starts": 1}


def record(
    name,
    *,
    load=10.0,
    seed=0,
    gain=1.0,
    offset=0.0,
    friction=LAW.coulomb_coefficient,
    mass=0.0,
    wave=(0.0, 1.0),
    conditions=None,
):
    """A slider driven by two sinusoids; 2 % of noise. wave: share of the friction that is periodic, and its length."""
    time = np.linspace(0.0, 4.0, 801)
    rates = [(0.1, 2.0, seed), (0.06, 5.3, 2.0 * seed)]
    velocity = sum(a * np.sin(w * time + phase) for a, w, phase in rates)
    acceleration = sum(a * w * np.cos(w * time + phase) for a, w, phase in rates)
    place = sum(-a / w * np.cos(w * time + phase) for a, w, phase in rates)
    ripple = 1.0 + wave[0] * np.sin(2.0 * np.pi * place / wave[1])
    force = gain * (friction * load * np.sign(velocity) * ripple + mass * acceleration + offset)
    force = force + 0.02 * np.std(force) * np.random.default_rng(seed).standard_normal(len(time))
    columns = {"velocity": velocity, "displacement": place, "acceleration": acceleration}
    return Record(name, time, force, **columns, normal_force=load, conditions=conditions or {})


def test_a_prior_counts_as_one_more_measurement():
    made = record("a", mass=0.5)
    alone = fit(made, "coulomb", terms="mass", **QUICK)["mass"]
    mean, deviation = alone.value + 1.5 * alone.standard_error, 0.7 * alone.standard_error
    both = fit(made, "coulomb", terms="mass", priors={"mass": (mean, deviation)}, **QUICK)
    weights = np.array([alone.standard_error, deviation]) ** -2
    value = float(weights @ [alone.value, mean] / np.sum(weights))
    # the squares about a point beside the data's own are larger, by no more than (1 + 2)/n of themselves
    assert both["mass"].value == pytest.approx(value, abs=0.02 * alone.standard_error)
    assert both["mass"].standard_error == pytest.approx(np.sum(weights) ** -0.5, rel=0.02)
    assert both["mass"].verdict is Verdict.PRIOR
    assert not both.residuals.doubtful


def test_a_prior_that_the_data_contradict_is_doubted():
    found = fit(record("a", mass=0.5), "coulomb", terms="mass", priors={"mass": (0.7, 0.01)}, **QUICK)
    assert "prior" in found.residuals.kinds
    assert found["coulomb_coefficient"].verdict is Verdict.DOUBTED


def test_adhesion_is_told_from_friction_by_the_load():
    made = [record(f"N{load:g}", load=load, seed=k) for k, load in enumerate((5.0, 10.0, 20.0))]
    adhering = [each.replaced(normal_force=each.normal_force - 2.0) for each in made]
    found = fit(adhering, "coulomb", terms="adhesion", **QUICK)
    assert 2.0 in found["adhesion"]
    assert found["adhesion"].high - found["adhesion"].low < 0.2
    assert LAW.coulomb_coefficient in found["coulomb_coefficient"]


def test_offset_and_gain_differ_between_records_and_are_found_of_an_unseen_one():
    made = [record("a", offset=0.3), record("b", seed=1, gain=1.2, offset=-0.4), record("c", seed=2, gain=0.9)]
    both = ["offset", "gain"]
    found = fit(made, "coulomb", terms=both, by_record=both, held_out="c", **QUICK)
    for name, value in {"offset": 0.3, "offset[b]": -0.4, "gain[b]": 1.2}.items():
        assert value in found[name], name
        assert found[name].determined, name
    # what its begin leaves open adds a twentieth to the squares of the noise of 2 %
    assert found.held_out_relative_rmse == pytest.approx(0.02, rel=0.15)
    assert 0.6 * 801 < len(found.records[-1].time) < 801


def test_a_level_follows_a_condition_or_is_of_each_record():
    def level(temperature):
        return 0.3 - 0.002 * (temperature - 40.0)

    conditions = {f"at{t:g}": {"temperature_C": t} for t in (20.0, 40.0, 60.0)}
    made = [
        record(name, seed=k, friction=level(each["temperature_C"]), conditions=each)
        for k, (name, each) in enumerate(conditions.items())
    ]
    found = fit(made, "coulomb", along={"coulomb_coefficient": "temperature_C"}, **QUICK)
    assert -0.002 in found["coulomb_coefficient.temperature_C"]
    assert 0.3 in found["coulomb_coefficient"]
    each = fit(made, "coulomb", by_record=["coulomb_coefficient"], **QUICK)
    assert level(20.0) in each["coulomb_coefficient"]
    assert level(60.0) in each["coulomb_coefficient[at60]"]


def test_a_ripple_is_found_with_its_wavelength():
    found = fit(record("a", wave=(0.1, 0.013)), "coulomb", terms="friction_ripple", **QUICK)
    for name, value in {"length": 0.013, "sine": 0.1, "cosine": 0.0}.items():
        assert value in found[f"friction_ripple_{name}"], name
    assert found["friction_ripple_length"].high / found["friction_ripple_length"].low < 1.02
    assert not found.residuals.doubtful


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"priors": {"mass": (1.0, 0.1)}}, "not searched"),
        ({"terms": "mass", "priors": {"mass": (1.0, 0.0)}}, "standard deviation > 0"),
        ({"terms": "gain"}, "name it in by_record"),
        ({"terms": "adhesion"}, "normal forces that differ"),
        ({"by_record": ["offset"]}, "not searched"),
        ({"along": {"coulomb_coefficient": "temperature_C"}}, "no condition 'temperature_C'"),
        ({"along": {"coulomb_coefficient": "load"}}, "the same in all records"),
    ],
)
def test_what_cannot_be_found_is_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        fit([record("a"), record("b", seed=1)], "coulomb", **QUICK, **settings)
