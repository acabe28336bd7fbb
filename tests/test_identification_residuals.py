"""What a fit says of its errors: noise of any kind, and data or laws that are wrong."""

import dataclasses
import json

import numpy as np
import pytest

from benchmarks.imperfect_data import CONTACT, KINDS, motion, rates, record
from thinned import exhaustive_but
from vibrocap.identification.fit import fit
from vibrocap.identification.inference.uncertainty import uncertainty
from vibrocap.identification.search import Loss
from vibrocap.quantities.json_text import plain
from vibrocap.records.record import Record

QUICK = {"starts": 1, "start": "relaxed", "intervals": "covariance"}


def told(made, law=CONTACT, **settings):
    """The fit of a record from the true law's start."""
    return fit(made, law, **{**QUICK, **settings})


def test_white_noise_is_called_so():
    one = told(record("white", 1))
    assert one.residuals.white
    assert one.residuals.findings == ()
    assert "as white noise would be" in one.summary()
    assert not one.residuals.doubtful


@pytest.mark.slow
def test_half_a_sample_of_delay_is_found_and_can_be_searched_along():
    """It drove the damping of the bristles to zero, and the levels out of their intervals, without a word."""
    entry = record("delayed", 0)
    one = told(entry)
    assert {"delay", "limit"} <= set(one.residuals.kinds)
    assert one.residuals.doubtful
    assert 0.4 * entry.interval < one.residuals.delay_s < 0.65 * entry.interval
    along = told(entry, terms="delay")
    assert along.relative_rmse < 0.85 * one.relative_rmse
    assert along["delay"].unit == "s"
    assert 0.4 * entry.interval < along["delay"].value < 0.65 * entry.interval
    assert along.residuals.kinds == ()


def test_a_set_valued_law_holds_any_force_at_rest():
    """Samples at reversals and in a pause tell nothing of Coulomb friction; errors there were called a direction."""
    time = np.arange(1201) / 100.0
    velocity = np.where(np.abs(time - 6.0) < 1.25, 0.0, 0.1 * np.cos(2 * np.pi * time))
    velocity[np.abs(velocity) < 1e-12] = 0.0
    moves = velocity != 0.0
    noise = 0.02 * np.random.default_rng(0).standard_normal(len(time))
    entry = Record("pause", time, np.where(moves, 2.0 * np.sign(velocity), np.sin(time)) + noise, velocity=velocity)
    one = told(entry, "coulomb")
    assert one.residuals.findings == ()
    assert np.array_equal(one.records[0].time, time[moves])
    assert one.rmse == pytest.approx(np.std(noise[moves]), rel=0.01)
    assert np.std(entry.force) * np.sqrt(one.unit) == pytest.approx(np.std(noise[moves]), rel=0.01)
    assert "direction" not in told(entry, "dahl").residuals.kinds  # whose bristles hold another force than that


def test_a_swapped_sign_of_the_force_is_said():
    """It was called converged, at 99 %, and nothing else."""
    entry = record("white", 0)
    one = told(entry.replaced(force=-np.asarray(entry.force)), "exponential")
    assert one.residuals.work_ratio < -0.5
    assert "negative work" in one.summary()


def test_held_out_records_that_a_constant_predicts_better_are_said_and_doubt_the_parameters():
    """The second record has its sign turned: the law errs there by twice the force."""
    one, other = record("white", 1), record("white", 2)
    good = told([one, other.replaced(name="same")], "exponential", held_out="same")
    assert "held out" not in good.residuals.kinds
    turned = other.replaced(name="turned", force=-np.asarray(other.force))
    bad = told([one, turned], "exponential", held_out="turned")
    assert bad.held_out_relative_rmse > 1.0
    assert bad.residuals.kinds[0] == "held out"
    assert "(worse than a constant)" in bad.summary().splitlines()[0]
    assert not any(parameter.verdict.value == "determined" for parameter in bad.parameters)


def test_noise_that_grows_with_speed_is_said_and_the_intervals_allow_for_it():
    one = told(record("growing", 0))
    assert "growing" in one.residuals.kinds
    assert not one.residuals.doubtful


def test_errors_that_go_with_direction_are_said_to():
    one = told(record("asymmetric", 0))
    assert one.residuals.shares["direction"] > 0.5
    assert "direction" in one.residuals.kinds
    data = plain(one)
    json.dumps(data, allow_nan=False)
    assert data["residuals"]["shares"]["direction"] > 0.5
    assert {"kind", "text", "amount"} == set(data["residuals"]["findings"][0])


def test_a_coarse_encoder_is_said_with_its_step():
    one = told(record("quantised", 0))
    assert one.residuals.kinds == ("quantisation",)
    assert one.residuals.findings[0].amount == pytest.approx(1e-6, rel=1e-9)


def test_noise_of_the_motion_that_moves_parameters_is_said():
    entry = record("white", 0)
    noise = 3e-7 * np.random.default_rng(1).standard_normal(len(entry))  # m
    one = told(entry.replaced(velocity=None, displacement=motion().displacement + noise))
    assert "noisy motion" in one.residuals.kinds


def test_the_covariance_is_that_of_errors_of_different_sizes():
    """A straight line through errors that grow with |x|: the slope's variance is sum x^2 s^2 / (sum x^2)^2."""
    rng = np.random.default_rng(0)
    x = np.linspace(-1.0, 1.0, 4001)
    size = 0.1 + np.abs(x) ** 2
    slopes = np.stack([np.ones_like(x), x], axis=1)
    errors = size * rng.standard_normal(len(x))
    errors = errors - slopes @ np.linalg.lstsq(slopes, errors, rcond=None)[0]
    found = uncertainty([errors], slopes, np.empty((0, 2)), np.eye(2), Loss())
    true = np.sum(x**2 * size**2) / np.sum(x**2) ** 2
    # the estimate of such a variance scatters by about sqrt(2/m), m about 1000 samples with weight
    assert found.covariance[1, 1] == pytest.approx(true, rel=0.2)
    alike = uncertainty([errors[rng.permutation(len(x))]], slopes, np.empty((0, 2)), np.eye(2), Loss())
    assert alike.covariance[1, 1] < 0.7 * true  # what one size for all would state


@pytest.mark.slow
@pytest.mark.parametrize("kind", exhaustive_but([5], [*KINDS]))
def test_intervals_hold_or_it_is_said_what_is_wrong(kind):
    """Ten records of each kind; the table of docs/identification.md has 100 of each."""
    found = rates(kind, 10, starts=1, law=dataclasses.replace(CONTACT, bristle_damping=200.0), intervals="covariance")
    if kind in ("white", "coloured", "growing"):
        for name, held in found["inside"].items():
            assert sum(held) >= 7, name  # of 10 at 95 %: fewer are 1 in 10^3
    else:
        assert found["doubted"] == 10
