"""Several records in one fit, terms of the sensor, and what is known beforehand: known numbers come back."""

import dataclasses

import numpy as np
import pytest

from vibrocap.arguments import Complaints
from vibrocap.design.search.uncertainty import sampled, uncertain_quantities
from vibrocap.identification.experiments.parameter_samples import Source, chain, posterior
from vibrocap.identification.experiments.term_choice import choose_terms
from vibrocap.identification.fit import fit
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.physics.drives.harmonics import Harmonic
from vibrocap.physics.friction.curves import Coulomb
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import view
from vibrocap.quantities.json_text import json_text
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
    entry = record("a", mass=0.5)
    alone = fit(entry, "coulomb", terms="mass", **QUICK)["mass"]
    mean, deviation = alone.value + 1.5 * alone.standard_error, 0.7 * alone.standard_error
    both = fit(entry, "coulomb", terms="mass", priors={"mass": (mean, deviation)}, **QUICK)
    weights = np.array([alone.standard_error, deviation]) ** -2
    value = float(weights @ [alone.value, mean] / np.sum(weights))
    # the squares about a point beside the data's own are larger, by no more than (1 + 2)/n of themselves
    assert both["mass"].value == pytest.approx(value, abs=0.02 * alone.standard_error)
    assert both["mass"].standard_error == pytest.approx(np.sum(weights) ** -0.5, rel=0.02)
    assert both["mass"].verdict is Verdict.PRIOR
    assert not both.residuals.doubtful


def test_a_prior_that_the_data_contradict_is_doubted():
    fitted = fit(record("a", mass=0.5), "coulomb", terms="mass", priors={"mass": (0.7, 0.01)}, **QUICK)
    assert "prior" in fitted.residuals.kinds
    assert fitted["coulomb_coefficient"].verdict is Verdict.DOUBTED


def test_adhesion_is_told_from_friction_by_the_load():
    records = [record(f"N{load:g}", load=load, seed=k) for k, load in enumerate((5.0, 10.0, 20.0))]
    adhering = [entry.replaced(normal_force=entry.normal_force - 2.0) for entry in records]
    fitted = fit(adhering, "coulomb", terms="adhesion", **QUICK)
    assert 2.0 in fitted["adhesion"]
    assert fitted["adhesion"].high - fitted["adhesion"].low < 0.2
    assert LAW.coulomb_coefficient in fitted["coulomb_coefficient"]


def test_offset_and_gain_differ_between_records_and_are_found_of_an_unseen_one():
    values = [record("a", offset=0.3), record("b", seed=1, gain=1.2, offset=-0.4), record("c", seed=2, gain=0.9)]
    both = ["offset", "gain"]
    fitted = fit(values, "coulomb", terms=both, by_record=both, held_out="c", **QUICK)
    for name, value in {"offset": 0.3, "offset[b]": -0.4, "gain[b]": 1.2}.items():
        assert value in fitted[name], name
        assert fitted[name].determined, name
    assert (fitted["offset"].unit, fitted["gain[b]"].unit) == ("N", "1")
    # what its begin leaves open adds a twentieth to the squares of the noise of 2 %
    assert fitted.held_out_relative_rmse == pytest.approx(0.02, rel=0.15)
    assert 0.6 * 801 < len(fitted.records[-1].time) < 801


def test_a_level_follows_a_condition_or_is_of_each_record():
    def level(temperature):
        return 0.3 - 0.002 * (temperature - 40.0)

    conditions = {f"at{t:g}": {"temperature_C": t} for t in (20.0, 40.0, 60.0)}
    records = [
        record(name, seed=k, friction=level(condition["temperature_C"]), conditions=condition)
        for k, (name, condition) in enumerate(conditions.items())
    ]
    fitted = fit(records, "coulomb", along={"coulomb_coefficient": "temperature_C"}, **QUICK)
    assert -0.002 in fitted["coulomb_coefficient.temperature_C"]
    assert 0.3 in fitted["coulomb_coefficient"]
    result = fit(records, "coulomb", by_record=["coulomb_coefficient"], **QUICK)
    assert level(20.0) in result["coulomb_coefficient"]
    assert level(60.0) in result["coulomb_coefficient[at60]"]


def test_a_ripple_is_found_with_its_wavelength():
    fitted = fit(record("a", wave=(0.1, 0.013)), "coulomb", terms="friction_ripple", **QUICK)
    for name, value in {"length": 0.013, "sine": 0.1, "cosine": 0.0}.items():
        assert value in fitted[f"friction_ripple_{name}"], name
    assert fitted["friction_ripple_length"].high / fitted["friction_ripple_length"].low < 1.02
    assert not fitted.residuals.doubtful


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


# --- what a fit leaves uncertain, as samples -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drawn():
    pytest.importorskip("emcee")
    fitted = fit(record("a", mass=0.5), "coulomb", terms="mass", priors={"mass": (0.5, 0.001)}, **QUICK)
    return fitted, posterior(fitted, samples=400, seed=3)


def test_samples_scatter_as_the_covariance_of_a_linear_fit_says(drawn):
    found, samples = drawn
    assert samples.settled
    for name in ("coulomb_coefficient", "mass"):
        # of so many independent samples: four standard errors of a mean and of a deviation
        error, apart = found[name].standard_error, 4.0 / np.sqrt(samples.effective)
        assert np.mean(samples[name]) == pytest.approx(found[name].value, abs=apart * error)
        assert np.std(samples[name]) == pytest.approx(error, rel=apart / np.sqrt(2.0))
    again = posterior(found, samples=400, seed=3)
    assert np.array_equal(again.values, samples.values)


def test_draws_have_the_covariance_of_a_normal_density():
    """Of ten coordinates; one has no effect, and its deviation of 1e15 stands for all within its bounds."""
    pytest.importorskip("emcee")

    class Normal(Source):
        def cost(self, table):
            return 0.5 * np.sum((table[:, :-1] @ root) ** 2, axis=1)

    root = np.tril(np.ones((9, 9)))
    spread = np.pad(np.linalg.inv(root @ root.T), (0, 1))
    spread[-1, -1] = 1e30
    ends = np.full(10, 20.0)
    draws, _, settled = chain(Normal(("x",) * 10, np.zeros(10), spread, (-ends, ends), 1.0, np.ones(10)), 800, 1)
    assert settled
    deviations = np.std(draws, axis=0)
    assert np.mean(deviations[:-1] / np.sqrt(np.diag(spread)[:-1])) == pytest.approx(1.0, abs=0.05)
    assert deviations[-1] == pytest.approx(40.0 / np.sqrt(12.0), rel=0.15)


def test_the_bands_are_those_of_the_samples(drawn):
    found, samples = drawn
    curve = samples.friction_curve([-1.0, 1.0], load=10.0)
    assert curve.high[1] - curve.low[1] == pytest.approx(
        10.0 * 3.92 * found["coulomb_coefficient"].standard_error, rel=0.2
    )
    assert curve.middle == pytest.approx(10.0 * found["coulomb_coefficient"].value * np.array([-1.0, 1.0]), rel=0.01)
    band, force = samples.prediction("a"), found.records[0].measured
    assert 0.93 < np.mean((band.low < force) & (force < band.high)) < 0.97


def test_robustness_takes_the_samples_as_they_are(drawn, tmp_path):
    _, samples = drawn
    path = tmp_path / "posterior.json"
    path.write_text(json_text(view(samples)), encoding="utf-8")
    system, complaints = System(Oscillator(), Coulomb(0.3, 0.3), Harmonic()), Complaints()
    shares = np.array([[0.0], [0.5], [1.0]])
    for each in (samples, f"fit:{path}"):
        quantities = uncertain_quantities(system, {"friction": each}, complaints)
        assert not complaints
        values = sampled(quantities, shares)
        assert [*values] == ["friction.coulomb_coefficient"]
        expected = samples["coulomb_coefficient"][[0, 200, 399]]
        assert values["friction.coulomb_coefficient"] == pytest.approx(expected, rel=1e-12)
    uncertain_quantities(system, {"machine": samples}, complaints)
    assert "coulomb" in str(complaints[0])


def test_samples_in_newtons_or_of_a_short_chain_are_refused(drawn, tmp_path):
    """A fit without a load has levels in newtons, which are no coefficients."""
    _, samples = drawn
    system = System(Oscillator(), Coulomb(0.3, 0.3), Harmonic())
    path = tmp_path / "posterior.json"
    for change, words in (
        ({"units": ("N", "kg")}, "without unit in the case, and in N in the fit"),
        ({"settled": False}, "shorter than fifty correlation times"),
    ):
        changed = dataclasses.replace(samples, **change)
        path.write_text(json_text(view(changed)), encoding="utf-8")
        for each in (changed, f"fit:{path}"):
            complaints = Complaints()
            assert uncertain_quantities(system, {"friction": each}, complaints) == ()
            assert words in str(complaints[0])


# --- terms by held-out error -----------------------------------------------------------------------------------------


def test_a_pair_of_terms_is_chosen_where_each_alone_gains_little():
    """Under nearly one sine a mass and a spring almost cancel."""
    time = np.linspace(0.0, 12.0, 1201)
    place = 0.1 * np.sin(3.0 * time) + 0.004 * np.sin(7.0 * time)
    velocity = 0.3 * np.cos(3.0 * time) + 0.028 * np.cos(7.0 * time)
    acceleration = -0.9 * np.sin(3.0 * time) - 0.196 * np.sin(7.0 * time)
    force = 3.0 * np.sign(velocity) + 2.0 * acceleration + 18.0 * place
    force = force + 0.05 * np.random.default_rng(5).standard_normal(len(time))
    entry = Record("a", time, force, velocity=velocity, displacement=place, acceleration=acceleration)
    terms = choose_terms(entry, "coulomb", among=["offset", "mass", "spring", "drag", "delay"], **QUICK)
    assert {*terms.terms} == {"mass", "spring"}
    assert 2.0 in terms.fit["mass"]
    assert 18.0 in terms.fit["spring"]


def test_no_term_is_chosen_where_there_is_none():
    terms = choose_terms([record("a"), record("b", seed=1)], "coulomb", **QUICK)
    assert terms.terms == ()
    assert terms.tried[0].gain < 3.5
    assert "none" in terms.heading


def test_a_ripple_is_chosen_with_what_lies_beside_it():
    terms = choose_terms(record("a", offset=0.2, wave=(0.1, 0.013)), "coulomb", **QUICK)
    assert {*terms.terms} == {"offset", "friction_ripple"}
