"""The step of all lanes: where nothing is looked for, nothing is there; guards of stops as one by one."""

from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from test_ensemble import LANES, ORDER, sliding_lanes
from thinned import exhaustive_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run import ensemble as runs_of

STOPS = {
    "strikes-two-walls": ("drive.amplitude", 1.0, 3.0),
    "strikes-its-stop-and-travels": ("machine.mass_ratio", 0.5, 8.0),
    "pendulum-strikes-its-stops": ("drive.amplitude", 1.0, 3.0),
}


def striking(name, count):
    """(equations, parameters, initial states) of runs of an example with stops."""
    case = vc.read_case(f"examples/{name}.toml")
    recorded, (path, first, last) = equations(case.system), STOPS[name]
    parameters = np.tile(parameter_values(case.system), (count, 1))
    parameters[:, recorded.parameter_paths.index(path)] = np.linspace(first, last, count)
    return recorded, parameters, np.tile([case.initial.get(name, 0.0) for name in case.system.state_names], (count, 1))


def test_a_slide_that_is_not_looked_at_goes_on():
    """Where the bound on a slide lets the search for its end be skipped, the velocity stays on its side."""
    kernel, floats, _, _ = sliding_lanes("lugre")
    draw = np.random.default_rng(6)
    never = np.zeros(LANES, bool)
    counts = np.zeros(3)
    for round_ in range(600):
        zeros = round_ % 3
        series = draw.normal(size=(ORDER + 1, LANES)) * 10 ** draw.uniform(-1.5, 0.5, LANES)
        series *= draw.random(series.shape) < 0.4  # so that a single term decides
        side = draw.choice([-1.0, 1.0], LANES)
        series[:zeros], series[zeros] = 0.0, side * draw.uniform(0.0, 1.0, LANES)
        floats[kernel["VELOCITY_OF"][0] :][: series.size] = series.ravel()
        h = draw.uniform(0.1, 1.0, LANES)
        ahead, change = kernel["ahead_simd"](floats, 0, side, never | (zeros == 1), never | (zeros == 2), h)
        times = np.linspace(0.0, 1.0, 101)[:, None] * h
        velocity = sum(c * times ** (k - zeros) for k, c in enumerate(series) if k >= zeros)
        away = sum(c * times**k for k, c in enumerate(series) if k >= 1)
        assert np.all(np.abs(away) <= change * (1.0 + 1e-12))
        kept = np.all(side * velocity > 0.0, axis=0)
        assert np.all(kept[ahead])
        counts += [np.sum(ahead), np.sum(~kept), np.sum(kept & ~ahead)]
    assert min(counts) > 100


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([1], [*STOPS]))
def test_guards_in_all_lanes_are_those_one_by_one(name):
    """States, works and counts of impacts; over four periods rounding grows to some 1e-13.

    In one run of the pendulum it decides how many of rebounds without end are told apart, 224 or 225.
    """
    given, budget = striking(name, 40), runs_of.Budget(4, 1e-8, 10_000, 10**6, asked=1)
    together = runs_of.ensemble_run(runs_of.EnsembleStart(*given), budget, threads=1)
    with mock.patch.object(runs_of, "lane_count", return_value=1):
        single = runs_of.ensemble_run(runs_of.EnsembleStart(*given), budget, threads=1)
    assert (together.layout.lanes, single.layout.lanes) == (LANES, 1)
    assert np.all(single.finished)
    assert np.allclose(together.state, single.state, rtol=0.0, atol=1e-11)
    same = np.isclose(together.numbers, single.numbers, rtol=1e-11, atol=1e-11, equal_nan=True)
    assert np.sum(~np.all(same, axis=1)) <= (1 if name == "pendulum-strikes-its-stops" else 0)


@pytest.mark.parametrize("name", list(STOPS)[:2])
def test_with_a_stop_most_steps_are_taken_in_all_lanes(name):
    """A change of sign of a guard is no reason to go alone: 3 steps in 100 do, where 17 to 22 did."""
    layout, entry = runs_of.ensemble_kernel(
        striking(name, 1)[0], runs_of.Form(order=ORDER, lanes=LANES, plain=True), False
    )
    kernel, steps = entry.__globals__, []
    simd = kernel["step_simd"]

    def counted(floats, ints, trace, running):
        steps.append((kernel["bits"](running), simd(floats, ints, trace, running)))
        return steps[-1][1]

    budget = runs_of.Budget(16 // LANES, 1e-8, 10_000, 10**6)
    with (
        mock.patch.dict(kernel, step_simd=counted),
        mock.patch.object(runs_of, "ensemble_kernel", return_value=(layout, entry)),
        np.errstate(all="ignore"),
    ):
        runs_of.ensemble_run(
            runs_of.EnsembleStart(*striking(name, LANES)), budget, runs_of.Form(order=ORDER, plain=True), threads=1
        )
    running, plain = (sum(bits.bit_count() for bits in column) for column in zip(*steps, strict=True))
    assert running > 300
    assert plain >= 0.95 * running
