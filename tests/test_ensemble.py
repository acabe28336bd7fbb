"""The ensemble engine: a lane is the same run alone, whoever runs beside it; runs fail alone; lanes are fed."""

import collections
import dataclasses
import functools

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel.arithmetic.plain_vectors import lane_count
from vibrocap.numerics.kernel.codes import ASK_MODES, DONE, TOO_MANY_EVENTS, TOO_MANY_STEPS
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form, MotionStart
from vibrocap.numerics.run.ensemble import ensemble_kernel, ensemble_run, prepared_lanes
from vibrocap.numerics.run.motion import recorded_run

LANES = lane_count()
ORDER, STEPS = 10, RESULT_HEAD.index("taylor_steps")
BUDGET = Budget(6, 1e-8, 10_000, 10**6, window=2)
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}
METHODS = 4.0  # tolerances between steps on slow manifolds in lanes and alone: of the 500 motions below at most 3.5


def drawn(law: str, seed: int):
    """(system, initial state): a capsule drawn at random around the paper's, any amplitude and load."""
    draw = np.random.default_rng([7, seed])
    ratio, stiffness, damping = 10 ** draw.uniform(-1, 1), draw.uniform(0.5, 5), draw.uniform(0.3, 2)
    machine = vc.PendulumCapsule(ratio, stiffness, damping, normal_load=10 ** draw.uniform(-0.5, 0.5))
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


def drawn_runs(law: str, seeds: range):
    """(equations, parameters [runs, parameters], initial states [runs, states]) of the drawn systems."""
    systems, starts = zip(*(drawn(law, seed) for seed in seeds), strict=True)
    return equations(systems[0]), np.array([parameter_values(system) for system in systems]), np.array(starts)


@functools.cache
def together(law: str, seeds: range, threads: int = 1):
    """Results of the drawn systems in one ensemble, measured from the start, words asked for."""
    budget = dataclasses.replace(BUDGET, window=BUDGET.periods, asked=ASK_MODES)
    return ensemble_run(EnsembleStart(*drawn_runs(law, seeds)), budget, Form(order=ORDER), threads=threads)


def alone(law: str, seed: int, shift: float = 0.0):
    """The drawn motion by the recording kernel, from a start shifted by so much."""
    system, start = drawn(law, seed)
    shifted, values = list(start + shift * (start != 0.0)), parameter_values(system)
    return recorded_run(MotionStart(equations(system), values, shifted, system.drive.period), BUDGET, Form(order=ORDER))


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_hundred_lanes_are_their_runs_alone(law):
    """Status and final state, of motions drawn by chance; their measures and sequences: `test_lanes_alone.py`.

    Lanes have polynomials of their own for sin, cos and exp, so rounding differs by an ulp here and there, some 1e-16 a
    step; its effect on the final state is measured: that of a shift of the start by 1e-13, a thousand ulps.
    """
    seeds = range(100)
    results = together(law, seeds)
    sensitive = 0
    for status, final, seed in zip(results.status, results.state, seeds, strict=True):
        single, shifted = alone(law, seed), alone(law, seed, 1e-13)
        assert status == single.status == DONE
        allowed = 1e-12 + 10.0 * np.max(np.abs(single.final - shifted.final))
        sensitive += allowed > 1e-10 and single.implicit_steps == 0
        if law == "lugre":  # a lane and a motion alone do not enter slow manifolds at the same steps
            allowed += METHODS * BUDGET.tolerance
        assert np.max(np.abs(final - single.final)) <= allowed, (law, seed)
        assert allowed < 100 * BUDGET.tolerance, (law, seed)
    assert sensitive <= 0.1 * len(seeds)  # so few motions hang on a decision that a thousand ulps can turn


@pytest.mark.parametrize("law", LAWS)
def test_the_same_bits_in_any_order_and_company(law, monkeypatch):
    """Another order of the runs, a part of them, one alone, two threads that come back for blocks: the same bits."""
    seeds = range(40)
    results = together(law, seeds).numbers
    assert np.array_equal(results[::-1], together(law, seeds[::-1]).numbers)
    assert np.array_equal(results[3:17], together(law, seeds[3:17]).numbers)
    assert np.array_equal(results[5:6], together(law, seeds[5:6]).numbers)
    monkeypatch.setattr("vibrocap.numerics.run.ensemble.BLOCK", 3)
    monkeypatch.setattr(np, "empty", np.zeros)  # so that what nobody writes is not by chance what was there before
    for threads in (1, 2):
        assert np.array_equal(results, together.__wrapped__(law, seeds, threads).numbers)


@pytest.mark.parametrize("law", LAWS)
def test_plain_python_is_the_compiled_kernel(law):
    """The vectors as NumPy arrays take the same steps; within a period rounding has not grown to 1e-11."""
    given = EnsembleStart(*drawn_runs(law, range(8))), dataclasses.replace(BUDGET, periods=1, window=1)
    compiled = ensemble_run(*given, Form(order=ORDER), threads=1)
    with np.errstate(all="ignore"):  # free lanes and lanes that take the other branch are computed along
        plain = ensemble_run(*given, Form(order=ORDER, plain=True), threads=1)
    gathered = len(RESULT_HEAD) + 2 * compiled.state.shape[1]
    assert np.array_equal(plain.head("taylor_steps"), compiled.head("taylor_steps"))
    assert plain.numbers[:, :gathered] == pytest.approx(compiled.numbers[:, :gathered], abs=1e-11)


def test_a_run_that_fails_fails_alone():
    """One lane gets too few events, another too few steps: they stop there, exactly, and the others are not touched."""
    start = EnsembleStart(*drawn_runs("exponential", range(20)))

    def numbers(**limits):
        return ensemble_run(start, dataclasses.replace(BUDGET, **limits), Form(order=ORDER), threads=1).numbers

    ints = numbers()
    limit = int(np.median(ints[:, STEPS]))
    some = numbers(max_steps=limit)
    cut = some[:, 0] == TOO_MANY_STEPS
    assert np.array_equal(cut, ints[:, STEPS] > limit)
    assert 0 < np.count_nonzero(cut) < len(cut)
    assert np.all(some[cut, STEPS] == limit)
    assert np.array_equal(some[~cut], ints[~cut])
    none = numbers(max_events_per_period=1)
    refused = none[:, 0] == TOO_MANY_EVENTS
    assert np.count_nonzero(refused) > 0
    assert np.array_equal(none[~refused], ints[~refused])


def test_a_motion_that_runs_away_says_so():
    """Without stiffness and damping under an enormous drive a state overflows; its neighbours finish."""
    system, start = drawn("exponential", 0)
    wild = system.with_parameters({"drive.amplitude": 1e200})
    parameters = np.array([parameter_values(one) for one in (system, wild, system)])
    begin = EnsembleStart(equations(system), parameters, np.array([start] * 3))
    results = ensemble_run(begin, BUDGET, Form(order=ORDER), threads=1).numbers
    assert list(results[:, 0] == DONE) == [True, False, True]
    assert np.array_equal(results[0], results[2])


def sliding_lanes(law: str, **budget):
    """(functions and places by name, floats, ints, trace) of the plain kernel, the first runs in its lanes."""
    system, parameters, starts = drawn_runs(law, range(LANES))
    layout, entry = ensemble_kernel(system, Form(order=ORDER, lanes=LANES, plain=True), False)
    kernel, (floats, ints) = entry.__globals__, prepared_lanes(layout, dataclasses.replace(BUDGET, **budget), LANES)
    starts[:, kernel["STATE_OF"][0]] = 0.1
    trace = np.zeros((LANES, layout.run_size))
    EnsembleStart(system, parameters, starts).write(trace)
    for lane in range(LANES):
        kernel["begin_run"](floats, ints, trace.ravel(), lane, lane)
    kernel["jet"](floats)
    return kernel, floats, ints, trace.ravel()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("limit", ["max_steps", "max_events_per_period"])
def test_a_run_that_fails_leaves_nothing_to_the_next(law, limit):
    """Cut off in any state, at rest, leaving, just turned: the run that gets the lane next is the same as alone."""
    system, parameters, starts = drawn_runs(law, range(24))
    for most in (*range(1, 12), 25, 50, 100):
        budget = dataclasses.replace(BUDGET, **{limit: most})
        results = ensemble_run(EnsembleStart(system, parameters, starts), budget, Form(order=ORDER), threads=1).numbers
        for i, row in enumerate(results):
            one = EnsembleStart(system, parameters[i : i + 1], starts[i : i + 1])
            single = ensemble_run(one, budget, Form(order=ORDER), threads=1).numbers[0]
            upto = len(RESULT_HEAD)  # what comes after means nothing in a run that failed before its window
            assert np.array_equal(row[:upto], single[:upto]), (most, i)


def test_a_side_that_is_not_looked_at_does_not_give_way():
    """Where a stuck contact is looked at towards one side only, its force stays within the limit on the other."""
    kernel, floats, _, _ = sliding_lanes("exponential")
    draw = np.random.default_rng(5)
    every = np.ones(LANES, bool)
    floats[kernel["LIMIT_OF"][0] :][:LANES] = 1.0
    counts = np.zeros(4)
    for _ in range(1600 // LANES):
        series = draw.normal(size=(ORDER, LANES)) * 10 ** draw.uniform(-1.0, 1.5, LANES)
        series *= draw.random(series.shape) < draw.choice([0.3, 1.0])  # so that a single term decides, or many
        series[0] = draw.uniform(-1.0, 1.0, LANES)
        floats[kernel["STICKING_FORCE_OF"][0] :][: series.size] = series.ravel()
        h = draw.uniform(0.1, 1.0, LANES)
        push, sure, stays = kernel["sticking_simd"](floats, 0, every, ~every, h, h)
        times = np.linspace(0.0, 1.0, 101)[:, None] * h
        force = sum(c * times**k for k, c in enumerate(series))
        kept = np.all(-push * force <= 1.0, axis=0)
        assert np.all(kept[sure])
        assert np.all(np.abs(force[:, stays]) <= 1.0)
        counts += [
            np.sum(sure & ~stays),
            np.sum(~kept),
            np.sum(sure & np.any(push * force > 1.0, axis=0)),
            np.sum(stays),
        ]
    assert min(counts) > 20  # all cases occur: plain, in doubt, giving way where it is looked, and beyond doubt


@pytest.mark.parametrize(("law", "least"), [("exponential", 0.99), ("lugre", 0.98)])
def test_most_steps_are_taken_simd(law, least, monkeypatch):
    """Of the standard forms 1 step in 100 is one that a lane takes alone; that is where the speed comes from."""
    kernel, *_ = sliding_lanes(law)
    simd, steps = kernel["step_simd"], []

    def counted(floats, ints, trace, running):
        steps.append((kernel["bits"](running), simd(floats, ints, trace, running)))
        return steps[-1][1]

    monkeypatch.setitem(kernel, "step_simd", counted)
    with np.errstate(all="ignore"):
        budget = dataclasses.replace(BUDGET, periods=1, window=1)
        ensemble_run(EnsembleStart(*drawn_runs(law, range(8))), budget, Form(order=ORDER, plain=True), threads=1)
    running, plain = (sum(bits.bit_count() for bits in column) for column in zip(*steps, strict=True))
    assert plain >= least * running


def test_a_slide_that_starts_with_an_acceleration_is_not_plain():
    """After a drop from static to kinetic friction the velocity has one vanishing coefficient, not two."""
    kernel, floats, _, _ = sliding_lanes("exponential")
    every = np.ones(LANES, bool)
    floats[kernel["VELOCITY_OF"][0] + 2 * LANES :][:LANES] = 1.0
    for acceleration in np.reshape([0.0, 1e-12, -1e-12, 1e-3, -1e-3, 1.0, -1.0, 1e3], (-1, LANES)):
        floats[kernel["VELOCITY_OF"][0] + LANES :][:LANES] = acceleration
        assert np.array_equal(kernel["sticking_simd"](floats, 0, ~every, every, 1.0, 1.0)[1], abs(acceleration) < 1e-6)


def test_a_plain_step_ends_the_decisions():
    """Decisions without advance are counted up to a dozen; after any step they are forgotten."""
    kernel, floats, ints, trace = sliding_lanes("exponential")
    ints[kernel["ZERO_PROGRESS"] :][:LANES] = 5
    plain = kernel["step_simd"](floats, ints, trace, np.ones(LANES, bool))
    assert plain > 0
    assert [5 * (1 - (plain >> lane & 1)) for lane in range(LANES)] == list(ints[kernel["ZERO_PROGRESS"] :][:LANES])


@pytest.mark.plain
def test_a_motion_below_the_tolerance_keeps_its_signs():
    """Bristles under a drive too weak for the tolerance: as many steps as the run alone, and the same motion.

    Alone, steps near rest are damped too, each with an error of up to SHARE/10 = 0.3 % of the velocity.
    """
    for amplitude in (1e-9, 1e-8, 1e-7, 1e-6):
        system = drawn("lugre", 0)[0].with_parameters({"drive.amplitude": amplitude})
        parameters, start = parameter_values(system), np.zeros((1, len(system.state_names)))
        begin = EnsembleStart(equations(system), np.array([parameters]), start)
        results = ensemble_run(begin, BUDGET, Form(order=ORDER), threads=1)
        alone = MotionStart(equations(system), parameters, list(start[0]), system.drive.period)
        single = recorded_run(alone, BUDGET, Form(order=ORDER))
        assert results.head("taylor_steps") == len(single.pieces)
        assert results.state[0] == pytest.approx(single.final, rel=0.0, abs=5e-3 * amplitude)


def test_a_contact_that_comes_to_rest_as_the_period_ends():
    """First it comes to rest, then the period turns: the event belongs to the old one, the window starts at rest."""
    kernel, floats, ints, trace = sliding_lanes("exponential", periods=2, window=1)
    floats[kernel["STEP"]] = 0.01
    kernel["move_to"](floats, ints, 0, 0.01)
    kernel["finish_simd"](floats, ints, trace, 1, 1)
    assert (ints[kernel["PERIOD_COUNT"]], ints[kernel["EVENTS"]]) == (1, 0)
    assert abs(floats[kernel["START_STATE"] + kernel["STATE_OF"][0] * LANES]) < 1e-15


@pytest.mark.slow
def test_single_motions_and_runs_of_an_ensemble_end_alike():
    """The same status, also where events or steps are too many; and no false alarm about works.

    Only on slow manifolds a motion may end in steps that are too few for an ensemble.
    """
    draw, pairs = np.random.default_rng(5), 20
    over = {
        "machine.mass": 10.0 ** draw.uniform(-1.0, 1.0, pairs),
        "machine.belt_speed": draw.choice([0.0, 0.01, 0.3], pairs),
        "drive.amplitude": draw.uniform(0.05, 1.5, pairs),
        "drive.frequency": 10.0 ** draw.uniform(-0.7, 0.5, pairs),
        "initial.position": draw.uniform(-0.5, 0.5, pairs),
    }
    system = vc.System(vc.Oscillator(damping=0.05), vc.LuGre(bristle_stiffness=1e3), vc.Harmonic())
    settings = {"periods": 6, "tolerance": 1e-6, "max_steps": 3000, "max_events_per_period": 16}
    results = vc.ensemble(system, over, measures=["drive_work"], window=6, **settings)
    ends = collections.Counter()
    for run, code in enumerate(results["status"]):
        parameters = {path: float(values[run]) for path, values in over.items()}
        start = {"position": parameters.pop("initial.position")}
        motion = vc.simulate(system.with_parameters(parameters), initial=start, **settings)
        ends[motion.run_status] += 1
        if list(vc.Status)[code] is not motion.run_status:  # alone it went along slow manifolds earlier
            assert (list(vc.Status)[code], motion.run_status) == (vc.Status.TOO_MANY_STEPS, vc.Status.FINISHED)
            assert motion.certificate.implicit_steps > 0
        assert all(verdict.ok for verdict in motion.certificate.verdicts)
    assert 0 < ends[vc.Status.FINISHED] < pairs, ends
