"""The ensemble engine: a lane is the same run alone, whoever runs beside it; runs fail alone; lanes are fed."""

import dataclasses
import functools

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.equations import equations, parameter_values
from vibrocap.measures.gathered import Gathered
from vibrocap.numerics.ensemble import Budget, ensemble_run
from vibrocap.numerics.lanes import ASK_WORD, DONE, RESULT_HEAD, TOO_MANY_EVENTS, TOO_MANY_STEPS
from vibrocap.numerics.motion import recorded_run

ORDER = 10
BUDGET = Budget(periods=6, window=2, threshold=0.0, tolerance=1e-8, max_events_per_period=10_000, max_steps=10**6)
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}


def drawn(law: str, seed: int):
    """(system, initial state): a capsule drawn at random around the paper's, any amplitude and load."""
    draw = np.random.default_rng([7, seed])
    machine = vc.PendulumCapsule(
        mass_ratio=10 ** draw.uniform(-1, 1),
        stiffness=draw.uniform(0.5, 5),
        damping=draw.uniform(0.3, 2),
        normal_load=10 ** draw.uniform(-0.5, 0.5),
    )
    static = draw.uniform(0.2, 0.6)
    levels = {"static_coefficient": static, "coulomb_coefficient": static * draw.uniform(0.3, 1.0)}
    if law == "exponential":
        friction = vc.Exponential(decay_rate=10 ** draw.uniform(0.5, 1.5), **levels)
    else:
        friction = vc.LuGre(bristle_stiffness=10 ** draw.uniform(1.5, 2.3), **levels)
    drive = vc.Harmonic(amplitude=draw.uniform(0.3, 3.0), frequency=10 ** draw.uniform(-0.3, 0.3))
    system = vc.System(machine, friction, drive)
    start = np.zeros(len(system.state_names))
    start[:2] = draw.uniform(-1, 1, 2)
    start[3] = draw.choice([0.0, draw.uniform(-0.5, 0.5)])
    return system, start


@functools.cache
def together(law: str, seeds: range, threads: int = 1):
    """(layout, results) of the drawn systems in one ensemble, words asked for."""
    systems, starts = zip(*(drawn(law, seed) for seed in seeds), strict=True)
    parameters = np.array([parameter_values(system) for system in systems])
    budget = dataclasses.replace(BUDGET, asked=ASK_WORD)
    return ensemble_run(equations(systems[0]), parameters, np.array(starts), budget, threads, order=ORDER)


def alone(law: str, seed: int, shift: float = 0.0):
    """The drawn motion by the recording kernel, from a start shifted by so much."""
    system, start = drawn(law, seed)
    start = start + shift * (start != 0.0)
    return recorded_run(
        equations(system),
        parameter_values(system),
        list(start),
        system.drive.period,
        BUDGET.periods,
        BUDGET.tolerance,
        BUDGET.max_events_per_period,
        BUDGET.max_steps,
        order=ORDER,
    )


def assert_lane_is_the_run_alone(law: str, seeds: range):
    """Status, steps, final state and word.

    Lanes have polynomials of their own for sin, cos and exp, so rounding differs by an ulp here and there, some 1e-16 a
    step; its effect on the final state is measured: that of a shift of the start by 1e-13, a thousand ulps.
    """
    layout, results = together(law, seeds)
    head, states = len(RESULT_HEAD), layout.states
    ones = np.ones(len(results))
    words = Gathered(drawn(law, 0)[0], layout, results, ones, ones, 0.0).words
    sensitive = 0
    for row, word, seed in zip(results, words, seeds, strict=True):
        single, shifted = alone(law, seed), alone(law, seed, 1e-13)
        assert row[0] == single.status == DONE
        final = row[head + states : head + 2 * states]
        allowed = 1e-12 + 10.0 * np.max(np.abs(single.final - shifted.final))
        if single.implicit_steps > 0:  # their length follows from the difference of two nearly equal results
            allowed += BUDGET.tolerance
        assert np.max(np.abs(final - single.final)) <= allowed, (law, seed)
        assert allowed < 100 * BUDGET.tolerance, (law, seed)
        sensitive += allowed > 1e-10 and single.implicit_steps == 0
        assert word == spelled_from_pieces(single), (law, seed)
    assert sensitive <= 0.1 * len(seeds)  # so few motions hang on a decision that a thousand ulps can turn


def spelled_from_pieces(single) -> str:
    """The word of the last period of a recorded run, read from its pieces."""
    last = single.pieces[single.pieces[:, 0] == BUDGET.periods - 1]
    sides = last[:, 3]
    starts = np.flatnonzero(np.concatenate(([True], sides[1:] != sides[:-1])))
    lengths = np.add.reduceat(last[:, 2], starts)
    letters = [
        {1.0: "F", -1.0: "B", 0.0: "S"}[sides[i]]
        for i, n in zip(starts, lengths, strict=True)
        if n > 1e-12 * sum(lengths)
    ]
    while len(letters) > 1 and letters[-1] == letters[0]:
        letters.pop()
    return "".join(letters)


@pytest.mark.parametrize("law", LAWS)
def test_a_lane_is_the_run_alone(law):
    assert_lane_is_the_run_alone(law, range(40))


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_five_hundred_lanes_are_their_runs_alone(law):
    assert_lane_is_the_run_alone(law, range(500))


@pytest.mark.parametrize("law", LAWS)
def test_the_same_bits_in_any_order_and_company(law):
    """Two threads, another order of the runs, a part of them, one alone: not a bit of a result changes."""
    seeds = range(40)
    _, results = together(law, seeds)
    assert np.array_equal(results, together(law, seeds, threads=2)[1])
    assert np.array_equal(results[::-1], together(law, seeds[::-1])[1])
    assert np.array_equal(results[3:17], together(law, seeds[3:17])[1])
    assert np.array_equal(results[5:6], together(law, seeds[5:6])[1])


@pytest.mark.parametrize("law", LAWS)
def test_plain_python_is_the_compiled_kernel(law):
    """The vectors as NumPy arrays take the same steps; within a period rounding has not grown to 1e-11."""
    systems, starts = zip(*(drawn(law, seed) for seed in range(8)), strict=True)
    parameters = np.array([parameter_values(system) for system in systems])
    budget = dataclasses.replace(BUDGET, periods=1, window=1)
    arguments = (equations(systems[0]), parameters, np.array(starts), budget, 1)
    layout, compiled = ensemble_run(*arguments, order=ORDER)
    with np.errstate(all="ignore"):  # free lanes and lanes that take the other branch are computed along
        _, plain = ensemble_run(*arguments, order=ORDER, plain=True)
    steps = RESULT_HEAD.index("taylor_steps")
    assert np.array_equal(plain[:, steps], compiled[:, steps])
    head, states = len(RESULT_HEAD), layout.states
    assert plain[:, : head + 2 * states] == pytest.approx(compiled[:, : head + 2 * states], abs=1e-11)


def test_a_run_that_fails_fails_alone():
    """One lane gets too few events, another too few steps: they stop there, exactly, and the others are not touched."""
    systems, starts = zip(*(drawn("exponential", seed) for seed in range(20)), strict=True)
    parameters = np.array([parameter_values(system) for system in systems])
    arguments = (equations(systems[0]), parameters, np.array(starts))
    steps = RESULT_HEAD.index("taylor_steps")
    _, whole = ensemble_run(*arguments, BUDGET, 1, order=ORDER)
    limit = int(np.median(whole[:, steps]))
    _, some = ensemble_run(*arguments, dataclasses.replace(BUDGET, max_steps=limit), 1, order=ORDER)
    cut = some[:, 0] == TOO_MANY_STEPS
    assert np.array_equal(cut, whole[:, steps] > limit) or np.array_equal(cut, whole[:, steps] >= limit)
    assert 0 < np.count_nonzero(cut) < len(cut)
    assert np.all(some[cut, steps] == limit)
    assert np.array_equal(some[~cut], whole[~cut])
    _, none = ensemble_run(*arguments, dataclasses.replace(BUDGET, max_events_per_period=1), 1, order=ORDER)
    refused = none[:, 0] == TOO_MANY_EVENTS
    assert np.count_nonzero(refused) > 0
    assert np.array_equal(none[~refused], whole[~refused])


def test_a_motion_that_runs_away_says_so():
    """Without stiffness and damping under an enormous drive a state overflows; its neighbours finish."""
    system, start = drawn("exponential", 0)
    wild = system.with_parameters({"drive.amplitude": 1e200})
    parameters = np.array([parameter_values(one) for one in (system, wild, system)])
    _, results = ensemble_run(equations(system), parameters, np.array([start] * 3), BUDGET, 1, order=ORDER)
    assert results[0, 0] == results[2, 0] == DONE
    assert results[1, 0] != DONE
    assert np.array_equal(results[0], results[2])
