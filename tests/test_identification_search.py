"""The search of a fit: descents within bounds, starts that find the minimum from the data alone, jumps left out."""

import dataclasses
import math

import numpy as np
import pytest

from thinned import exhaustive_but
from vibrocap.identification.experiments.experiment_design import (
    Motion,
    joined,
    multisine,
    ramp,
    sinusoid,
    synthetic_record,
)
from vibrocap.identification.fit import fit, steady_fit
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.identification.problem.parametrisation import parametrisation
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.problem.samples import data_scales, samples
from vibrocap.identification.search import LONGEST, LOSSES, Loss, SearchStatus, descent, step, warm_descent
from vibrocap.identification.solution import away_from_jumps
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics import catalogue
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential
from vibrocap.quantities.json_text import plain


def prediction_of(law, motion, noise=0.02):
    """(prediction, start made from the data) of a law's own record."""
    record = samples(synthetic_record(law, motion, noise=noise, seed=3))
    chosen = parametrisation(type(law), data_scales([record]))
    return Prediction(chosen.template, chosen.space, (record,), (record.deviation,)), chosen.start


def test_a_descent_finds_the_minimum_that_an_independent_one_finds():
    from scipy.optimize import least_squares

    prediction, start = prediction_of(Exponential(), ramp(0.4, 6.0, 300))
    found = descent(prediction, start)
    other = least_squares(
        lambda u: prediction.errors(u), start, bounds=(prediction.space.low, prediction.space.high), xtol=1e-12
    )
    assert found.status == SearchStatus.CONVERGED
    assert math.isclose(found.cost, other.cost, rel_tol=1e-7)
    again = warm_descent(prediction, found.u + 0.05, found.slopes, Loss(), held=-1, stop=1e-9)
    assert math.isclose(again.cost, found.cost, rel_tol=1e-7)
    held = warm_descent(prediction, found.u + 0.05, found.slopes, Loss(), held=0, stop=1e-9)
    assert held.u[0] == found.u[0] + 0.05
    assert held.cost > found.cost


def test_a_descent_that_begins_off_a_bound_ends_at_it_and_stays_within():
    prediction, start = prediction_of(Exponential(static_coefficient=0.3), ramp(0.4, 6.0, 300))
    j = prediction.space.names.index("decay_rate")
    best = descent(prediction, start)
    coordinates = list(prediction.space.coordinates)
    limit = float(prediction.space.values(best.u)[j]) * 0.5
    coordinates[j] = dataclasses.replace(coordinates[j], high=limit)
    space = dataclasses.replace(prediction.space, coordinates=tuple(coordinates))
    inside = descent(dataclasses.replace(prediction, space=space), start)
    assert math.isclose(space.values(inside.u)[j], limit, rel_tol=1e-12)
    assert inside.cost > best.cost


def test_steps_are_no_longer_than_trusted_keep_the_bounds_and_promise_a_decrease():
    rng = np.random.default_rng(2)
    for _ in range(200):
        p = int(rng.integers(1, 7))
        slopes = rng.standard_normal((30, p)) * 10 ** rng.uniform(-6, 2, p)  # columns of very different lengths
        errors = rng.standard_normal(30)
        u = rng.uniform(-1, 1, p)
        bounds = np.where(rng.random(p) < 0.3, u, -1.5), np.where(rng.random(p) < 0.3, u, 1.5)
        radius = 10 ** rng.uniform(-3, 0)
        move, predicted_reduction = step(u, errors, slopes, Loss(), np.ones(p, bool), bounds, radius)
        assert np.linalg.norm(move) <= radius * math.sqrt(p) * (1 + 1e-6)
        assert np.all((u + move >= bounds[0]) & (u + move <= bounds[1]))
        decrease = 0.5 * errors @ errors - 0.5 * np.sum((errors + slopes @ move) ** 2)
        assert predicted_reduction >= 0
        assert math.isclose(predicted_reduction, decrease, rel_tol=1e-6, abs_tol=1e-9)
    bounds = -np.ones(1), np.ones(1)
    free = step(np.zeros(1), np.array([-1.0]), np.array([[2.0]]), Loss(), np.ones(1, bool), bounds, LONGEST)
    assert math.isclose(free[0][0], 0.5)


def cases(count):
    """Laws and motions of many kinds: (law, motion)."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        law = LuGre(
            bristle_stiffness=100 * 10 ** rng.uniform(-0.5, 1),
            bristle_damping=10 * 10 ** rng.uniform(-2, 0.3),
            viscous_damping=10 ** rng.uniform(-2.5, -0.5),
            static_coefficient=0.15 * rng.uniform(1.1, 3),
            stribeck_velocity=0.1 * 10 ** rng.uniform(-0.7, 0.5),
        )
        size = 10 ** rng.uniform(-2, -0.3)
        yield (
            law,
            (
                sinusoid(size, 10 ** rng.uniform(-0.5, 0.5), 3, 600),
                multisine(size, [1.0, 2.7], 900),
                joined([sinusoid(0.01, 1.0, 2, 300), ramp(0.5, 6.0, 500)], "mix"),
            )[seed % 3],
        )


@pytest.mark.slow
@pytest.mark.parametrize(("count", "most"), exhaustive_but([0], [(8, 1), (30, 2)]))
def test_fits_from_the_data_alone_end_at_the_noise(count, most):
    """Of 30 laws and motions at most 2 may be missed: with the starts of an earlier version it was every fifth."""
    missed = []
    for seed, (law, motion) in enumerate(cases(count)):
        exact = synthetic_record(law, motion)
        record = synthetic_record(law, motion, noise=0.02, seed=seed)
        noise = np.std(record.force - exact.force) / np.std(record.force)
        one = fit(record, "lugre", start="relaxed", intervals="covariance")
        if one.relative_rmse > 1.1 * noise:
            missed.append((seed, one.relative_rmse))
    assert len(missed) <= most, missed


@pytest.mark.slow
def test_samples_beside_jumps_count_in_the_search_and_not_in_the_intervals():
    law = catalogue.law("backlash-lugre")(viscous_damping=0.05, bristle_damping=0.2)
    motion = joined([sinusoid(0.012, 0.4, 2, 400), ramp(1.0, 4.0, 400)], "loops")
    record = synthetic_record(law, motion, noise=0.02, seed=1)
    one = fit(record, "backlash-lugre", start="relaxed", fixed={"stribeck_exponent": 2.0}, intervals="covariance")
    (counts,) = one.problem.prediction.counts
    left_out = np.flatnonzero(~counts)
    assert 4 <= len(left_out) < 0.2 * len(record)
    closed = driven_force(law, motion.time, motion.velocity).internal[:, law.internal.index("engaged")]
    jumps = np.flatnonzero(np.diff(closed))
    assert len(jumps) >= 6
    assert set(jumps.tolist()) | set((jumps + 1).tolist()) <= set(left_out.tolist())
    assert one.relative_rmse < 0.03  # over all samples: the law itself is the one that fits them all
    assert law.gap in one["gap"]
    plain = prediction_of(LuGre(), motion)[0]
    assert away_from_jumps(plain, prediction_of(LuGre(), motion)[1]) is plain


# --- simpler fits, and limits -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def carriage():
    """A positioning axis: a carriage that goes to and fro with rests; its contact is a LuGre one without play."""
    contact = LuGre(
        bristle_stiffness=2e4, bristle_damping=10.0, viscous_damping=20.0, coulomb_coefficient=2.0,
        static_coefficient=2.6, stribeck_velocity=0.01,
    )  # fmt: skip
    time = np.linspace(0.0, 10.0, 1200)
    place = np.array([0.0, 0.05, 0.1, 0.35, 0.45, 0.55, 0.6, 0.85, 0.95, 1.0])
    level = np.array([0.0, 0.0, 0.5, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0])
    velocity = 0.15 * np.interp(time / 5.0 % 1.0, place, level)
    return synthetic_record(contact, Motion("carriage", time, velocity), noise=0.04)


@pytest.mark.slow
def test_play_that_is_not_there_is_not_found(carriage):
    """A gap of millimetres was reported as converged and determined, with two to four times the error of LuGre."""
    plain = fit(carriage, "lugre", starts=2, intervals="covariance")
    play = fit(carriage, "backlash-lugre", starts=2, intervals="covariance")
    assert play.relative_rmse < plain.relative_rmse + 1e-3
    assert play["gap"].high < 1e-3
    assert not play["gap"].determined


def test_bounds_of_ones_own_do_not_end_in_a_worse_minimum(carriage):
    wide = {
        "coulomb_coefficient": (0.5, 4.0), "static_coefficient": (0.5, 6.0), "stribeck_velocity": (1e-4, 1.0),
        "bristle_stiffness": (1e2, 1e6), "bristle_damping": (1e-4, 1e3), "viscous_damping": (0.0, 1e2),
    }  # fmt: skip
    free = fit(carriage, "lugre", starts=1, intervals="covariance")
    bounded = fit(carriage, "lugre", starts=1, bounds=wide, intervals="covariance")
    assert bounded.relative_rmse < free.relative_rmse + 1e-3


def test_a_steady_fit_starts_from_the_laws_that_its_law_contains_too():
    record = synthetic_record(Exponential(), sinusoid(0.1, 1.0, 2, 300), noise=0.02)
    plain = steady_fit(record, "exponential", starts=1, intervals="covariance")
    wider = steady_fit(record, "anisotropic-exponential", starts=1, intervals="covariance")
    assert wider.relative_rmse <= plain.relative_rmse
    space = wider.problem.prediction.space
    begun = [dict(zip(space.names, space.values(start.u), strict=True)) for start in wider.starts]
    (inner,) = [each for each in begun if each["back_ratio"] == 1.0]
    assert inner["static_coefficient"] == pytest.approx(plain["static_coefficient"].value, rel=0.05)


@pytest.mark.parametrize("name", [*catalogue.laws(), "anisotropic-lugre", "backlash-dahl", "anisotropic-stribeck"])
def test_a_law_is_what_its_special_cases_say(name):
    """Driven with noise, a law with the values of a special case has the force of that case's law."""
    law = catalogue.law(name)()
    motion = multisine(0.05, [1.0, 2.7], 300)
    for simpler, values in type(law).special_cases.items():
        own = {k: getattr(law, v) if isinstance(v, str) else v for k, v in values.items()}
        case = dataclasses.replace(law, **own)
        inner = catalogue.law(simpler)
        plain = inner(**{f.name: getattr(case, f.name) for f in dataclasses.fields(inner) if hasattr(case, f.name)})
        found, expected = (driven_force(each, motion.time, motion.velocity).force for each in (case, plain))
        assert np.allclose(found, expected, atol=1e-3 * np.abs(expected).max()), simpler
    if name in ("lugre", "anisotropic-lugre", "backlash-dahl"):
        assert type(law).special_cases


@pytest.mark.parametrize("intervals", [pytest.param("profile", marks=pytest.mark.slow), "covariance"])
def test_a_limit_of_the_search_that_is_reached_is_named_and_opens_intervals(intervals):
    """Static friction 40 times the Coulomb level, of which the search allows 20: it was called determined."""
    contact = LuGre(viscous_damping=0.05, bristle_damping=1.0, static_coefficient=6.0, stribeck_velocity=0.02)
    motion = joined([sinusoid(0.004, 2.0, 2, 120), ramp(0.4, 6.0, 200), multisine(0.06, [1.0, 3.1], 200)], "slides")
    one = fit(synthetic_record(contact, motion, noise=0.02), "lugre", starts=2, start="relaxed", intervals=intervals)
    (limit,) = one.limits
    assert (limit.parameter, limit.side, limit.whose) == ("static_coefficient", "high", "search")
    assert set(limit.holds) >= {"static_coefficient", "stribeck_velocity"}
    for name in limit.holds:
        assert not one[name].determined, name
        assert math.isinf(one[name].high) or one[name].low == 0.0, name
    assert one["static_coefficient"].high == math.inf
    assert "static_coefficient is at 20 times coulomb_coefficient" in one.summary()
    assert plain(one)["limits"][0]["text"] == limit.text
    fitted = fit(one.problem.prediction.records[0], LuGre(coulomb_coefficient=0.18), starts=1, start="relaxed",
                bounds={"coulomb_coefficient": (0.17, 0.5)}, intervals=intervals)  # fmt: skip
    assert ("coulomb_coefficient", "low", "given") in [(e.parameter, e.side, e.whose) for e in fitted.limits]
    assert fitted["coulomb_coefficient"].low == 0.0


@pytest.mark.slow
def test_a_limit_that_nothing_pulls_beyond_opens_nothing_else():
    """A contact without a drop: friction at rest stands at the Coulomb level, which is of the law."""
    contact = LuGre(viscous_damping=0.0, bristle_damping=1.0, static_coefficient=0.15)
    motion = joined([sinusoid(0.004, 2.0, 2, 120), ramp(0.4, 6.0, 200)], "slides")
    one = fit(synthetic_record(contact, motion, noise=0.02), contact, starts=1, start="relaxed")
    assert one["coulomb_coefficient"].determined
    assert one["bristle_stiffness"].determined
    assert all(limit.whose == "law" for limit in one.limits)


def test_few_samples_carry_no_intervals():
    """20 samples for seven parameters gave closed intervals and the verdict "determined"."""
    time = np.linspace(0.0, 6.0, 20)
    few = synthetic_record(LuGre(), Motion("few", time, 0.2 * np.sin(2 * time)), noise=0.02)
    one = fit(few, "lugre", starts=1, intervals="covariance")
    assert {one[name].verdict for name in one.free} == {Verdict.TOO_FEW}
    assert all((one[name].low, one[name].high) == (0.0, math.inf) for name in one.free)
    assert "20 samples cannot carry 7 parameters" in one.summary()


@pytest.mark.parametrize("kind", LOSSES)
def test_losses_are_those_of_scipy(kind):
    """Half the sum of losses of errors, and their slope, within the scale and far beyond it."""
    from scipy.optimize import least_squares

    errors, loss = np.array([0.02, -0.6, 0.69, 3.0, -40.0]), Loss(kind, 0.7)
    squares = least_squares(lambda x: errors * x, [1.0], loss=kind, f_scale=0.7, max_nfev=1, method="trf")
    assert squares.x == [1.0] or kind == "linear"
    if kind != "linear":
        assert loss.cost(errors) == pytest.approx(squares.cost, rel=1e-14)
    assert loss.cost(np.stack((errors, 2.0 * errors))) == pytest.approx(
        [loss.cost(errors), loss.cost(2.0 * errors)], rel=1e-14
    )
    for error in errors:
        step = 1e-5 * abs(error)
        rise = (loss.cost(np.array([error + step])) - loss.cost(np.array([error - step]))) / (2.0 * step)
        assert loss.slope(np.array([error]))[0] * error == pytest.approx(rise, rel=1e-8)
